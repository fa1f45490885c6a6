//! A run that leaves a table of measured values.

use crate::codes;
use crate::fault::values::FaultInstant;
use bksim_mbs::signal::signal_values;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::message::short;

/// An argument this near to the end of a table, in lengths of the table, is at it.
const AT_END: f64 = 1e-6;

/// The table whose end the argument has reached.
pub(super) fn table_left(at: &FaultInstant<'_>) -> Option<Diagnostic> {
    let FaultInstant { model, system, t, .. } = at;
    if model.table_calls.is_empty() {
        return None;
    }
    let signals = signal_values(model, &system.kinematics);
    let value = at.value();
    model.table_calls.iter().find_map(|call| {
        let argument = model.pool.substitute(call.argument, &signals);
        let x = model.pool.evaluate(argument, &value).ok()?;
        let [first, last] = call.range;
        let near = AT_END * (last - first);
        let end = [first, last].into_iter().find(|end| (x - end).abs() <= near)?;
        let unit = if call.unit.is_empty() { String::new() } else { format!(" {}", call.unit) };
        let message = format!(
            "the argument of table `{}` leaves it at t = {} s: {}{unit} is its {} row",
            call.table,
            short(*t),
            short(end),
            if end == first { "first" } else { "last" },
        );
        let fault = Diagnostic::error(codes::TABLE_LEFT, message)
            .at(call.span.clone(), "no value beyond the table")
            .help("add rows, or write `extrapolate = \"constant\"` or `\"linear\"` in the table");
        Some(fault)
    })
}
