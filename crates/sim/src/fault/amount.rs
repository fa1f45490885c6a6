//! A run that would never end, and a log that no disk holds: refused before it begins.

use bksim_model::diagnostic::Diagnostic;
use bksim_model::message::short;
use bksim_model::{ClockId, MOST_OUTPUTS, Model, SolveOptions};

use crate::codes;
use crate::compiled::CompiledSystem;

/// The fault of a run with too many samples or fixed steps.
pub(super) fn too_much(options: &SolveOptions, compiled: &CompiledSystem) -> Diagnostic {
    let (key, interval, n) = options.too_many().unwrap_or(("every", 0.0, f64::INFINITY));
    let what = if key == "step" { "steps" } else { "samples" };
    let [from, to] = [options.t_start, options.t_end].map(short);
    let message = format!(
        "`{key}` = {interval:e} s makes {n:.1e} {what} from t = {from} s to {to} s: more than {MOST_OUTPUTS:e}"
    );
    let mut fault = Diagnostic::error(codes::TOO_MUCH, message);
    if let Some((_, span)) = options.spans.iter().find(|(stated, _)| stated == key) {
        fault = fault.at(span.clone(), "too small for this span of time");
    }
    if key == "every" {
        // Positions, velocities, accelerations, multipliers and reactions; time and energies besides.
        let n_numbers = 3 * compiled.nq() + compiled.nc() + 6 * compiled.joints.len() + 4;
        #[expect(clippy::cast_precision_loss, reason = "told to two digits")]
        let terabytes = 8e-12 * n_numbers as f64 * n;
        let note =
            format!("a log of them would hold {terabytes:.1e} TB: {n_numbers} numbers a sample");
        fault = fault.note(note);
    }
    // What a run has where nothing is said.
    let usual = short((options.t_end - options.t_start).abs() / 500.0);
    fault.help(format!("write for example `{key} = \"{usual} s\"`, or end earlier"))
}

/// The fault of a clock that ticks too often.
pub(super) fn too_many_ticks(model: &Model, clock: ClockId, every: f64) -> Diagnostic {
    let clock = &model.clocks[clock.0];
    let [from, to] = [model.solve.t_start, model.solve.t_end].map(short);
    let message = format!(
        "clock `{}` ticks every {every:e} s, from t = {from} s to {to} s more than {MOST_OUTPUTS:e} times",
        clock.name
    );
    Diagnostic::error(codes::TOO_MUCH, message)
        .at(clock.span.clone(), "too fast for this span of time")
        .help("give `every` its unit, such as \"2 ms\", or end earlier")
}
