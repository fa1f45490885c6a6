//! A run that leaves a table of measured values.

use crate::codes;
use crate::fault::values::FaultInstant;
use bksim_expr::{Expr, SymbolId};
use bksim_mbs::signal::signal_values;
use bksim_model::JointId;
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
    let pool = &model.pool;
    let signals = signal_values(model, &system.kinematics);
    let value = at.value();
    // A curve may call tables with its parameter, which each joint that follows it has at another value.
    let on_curves: Vec<(SymbolId, Expr)> = (0..model.joints.len())
        .flat_map(|idx| {
            let kind = &model.joints[idx].kind;
            let curves = [kind.curve(), kind.second_curve()].into_iter().flatten();
            let positions = match kind.curve() {
                Some(_) => system.kinematics.joint_positions(model, JointId(idx)),
                None => Vec::new(),
            };
            let parameter = |curve: bksim_model::CurveId| model.curves[curve.0].parameter;
            curves.map(parameter).zip(positions).collect::<Vec<_>>()
        })
        .collect();
    model.table_calls.iter().find_map(|call| {
        let argument = pool.substitute(call.argument, &signals);
        let of_curves = on_curves.iter().filter(|(p, _)| pool.depends_on(argument, *p));
        let of_curves = of_curves.map(|&place| pool.substitute(argument, &[place]));
        let mut values =
            [argument].into_iter().chain(of_curves).filter_map(|x| pool.evaluate(x, &value).ok());
        let [first, last] = call.range;
        let near = AT_END * (last - first);
        let end = values
            .find_map(|x| [first, last].into_iter().find(|end| (x - end).abs() <= near))?;
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
            .help(
                "add rows, or write `extrapolate = \"constant\"` or `\"linear\"` in the table; give a cam \
                 law more `turns`",
            );
        Some(fault)
    })
}
