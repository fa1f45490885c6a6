//! Drives whose rate jumps: motions with a corner, which no finite force follows.

use super::words::unit_of;
use crate::codes;
use bksim_expr::SymbolId;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::message::short;
use bksim_model::{Drive, Measure, Model};

/// Instants at which a rate is looked at.
const N_INSTANTS: u32 = 400;
/// A difference so many times those around it may be a jump.
const STANDS_OUT: f64 = 4.0;
/// Halvings of an interval around a jump.
const N_HALVINGS: usize = 40;
/// A smaller part of the largest rate is no jump.
const LEAST: f64 = 1e-3;
/// This part of the run after its start is not looked at: a corner at the start is none of the motion.
const AT_START: f64 = 1e-9;

/// The warning of the first drive whose rate jumps in the time of the run.
pub(super) fn rate_jumps(model: &Model) -> Option<Diagnostic> {
    model.drives.iter().find_map(|drive| {
        let [t, before, after] = jump(model, drive)?;
        let unit = unit_of(model, Measure::JointPosition(drive.joint, drive.motion_idx));
        let message = format!(
            "the rate of drive `{}` jumps from {} {unit}/s to {} {unit}/s at t = {} s",
            drive.name,
            short(before),
            short(after),
            short(t)
        );
        Some(
            Diagnostic::warning(codes::RATE_JUMPS, message)
                .at(drive.span.clone(), "a motion with a corner")
                .note("no finite force does that: the run passes it as an impact")
                .help("let the rate change in some time, as between `0.5*a*t^2` and `v*t`, or leave it if an impact is meant"),
        )
    })
}

/// The first jump of the rate of a drive: its instant, and the rates before and after it.
fn jump(model: &Model, drive: &Drive) -> Option<[f64; 3]> {
    let (from, to) = (model.solve.t_start, model.solve.t_end);
    let rate = model.pool.diff(drive.motion, model.time);
    let rate = model.pool.simplify(rate);
    // Smooth laws are left alone.
    if !model.pool.symbols_of(rate).contains(&model.time) || !has_branches(model, drive) {
        return None;
    }
    let at = |t: f64| {
        let value = |symbol: SymbolId| {
            let known = model.parameters.iter().find(|p| p.symbol == symbol).map(|p| p.value);
            known.or_else(|| (symbol == model.time).then_some(t))
        };
        model.pool.evaluate(rate, &value).ok().filter(|x| x.is_finite())
    };
    let after_start = (AT_START * (to - from)).max(4.0 * f64::EPSILON * from.abs());
    let mut instants: Vec<f64> = (0..=N_INSTANTS)
        .map(|i| from + (to - from) * f64::from(i) / f64::from(N_INSTANTS))
        .collect();
    instants[0] = from + after_start;
    let rates: Vec<f64> = instants.iter().map(|&t| at(t)).collect::<Option<_>>()?;
    let largest = rates.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let differences: Vec<f64> = rates.windows(2).map(|two| (two[1] - two[0]).abs()).collect();
    (0..differences.len()).find_map(|i| {
        let near = [i.checked_sub(2), i.checked_sub(1), Some(i + 1), Some(i + 2)];
        let near = near.into_iter().flatten().filter_map(|k| differences.get(k));
        let around = near.fold(0.0, |a: f64, b| a.max(*b));
        if differences[i] <= STANDS_OUT * around || differences[i] <= LEAST * largest {
            return None;
        }
        // It stays where the interval shrinks, if it is one.
        let (mut low, mut high) = ((instants[i], rates[i]), (instants[i + 1], rates[i + 1]));
        for _ in 0..N_HALVINGS {
            let t = 0.5 * (low.0 + high.0);
            let middle = (t, at(t)?);
            if (middle.1 - low.1).abs() > (high.1 - middle.1).abs() {
                high = middle;
            } else {
                low = middle;
            }
        }
        let is_jump = (high.1 - low.1).abs() > LEAST * largest;
        is_jump.then_some([high.0, low.1, high.1])
    })
}

/// True of a motion with branches: what switches, or a table.
fn has_branches(model: &Model, drive: &Drive) -> bool {
    let text = model.pool.to_text(drive.motion);
    let switches = ["if(", "min(", "max(", "abs(", "sign(", "floor("];
    let is_of_table = model.measured.iter().any(|table| text.contains(&format!("{}(", table.name)));
    is_of_table || switches.iter().any(|name| text.contains(name))
}
