//! Signals of loads and drives as expressions of the motion.

use bksim_expr::{Expr, Number, SymbolId};
use bksim_model::{Measure, Model, Signal};

use crate::folding::short;
use crate::kinematics::Kinematics;

/// Each signal symbol with the measure it stands for, as an expression; positions at the start among them.
pub fn signal_values(model: &Model, kinematics: &Kinematics) -> Vec<(SymbolId, Expr)> {
    let value = |signal: &Signal| {
        (signal.symbol, short(&model.pool, kinematics.measure(model, signal.measure)))
    };
    let mut values: Vec<_> = model.signals.iter().map(value).collect();
    if !model.at_start.is_empty() {
        values.extend(values_at_start(model, kinematics, &model.at_start));
    }
    values.extend(model.uncounted.iter().map(|&count| (count, model.pool.zero())));
    values
}

/// The positions that these signals measure where the start puts the mechanism.
pub(crate) fn values_at_start(
    model: &Model,
    kinematics: &Kinematics,
    signals: &[Signal],
) -> Vec<(SymbolId, Expr)> {
    let (pool, start) = (&model.pool, coordinates_at_start(model, kinematics));
    let value = |signal: &Signal| {
        let measured = kinematics.measure(model, signal.measure);
        (signal.symbol, short(pool, pool.substitute(measured, &start)))
    };
    signals.iter().map(value).collect()
}

/// The coordinates where the start puts them, as far as that is stated, guessed or prescribed: else zero.
pub fn coordinates_at_start(model: &Model, kinematics: &Kinematics) -> Vec<(SymbolId, Expr)> {
    let pool = &model.pool;
    let mut start: Vec<(SymbolId, Expr)> =
        kinematics.coordinates.iter().map(|c| (c.q, pool.zero())).collect();
    let positions = model.initial.iter().filter(|initial| !initial.measure.is_velocity());
    for initial in positions {
        let measured = short(pool, kinematics.measure(model, initial.measure));
        let Some(symbol) = pool.symbol_id(measured) else { continue };
        if let Some((_, value)) = start.iter_mut().find(|(q, _)| *q == symbol) {
            *value = initial.value;
        }
    }
    // What a drive prescribes is stated, too.
    let begin = pool.number(Number::float(model.solve.t_start));
    for drive in &model.drives {
        let measure = Measure::JointPosition(drive.joint, drive.motion_idx);
        let measured = short(pool, kinematics.measure(model, measure));
        let Some(symbol) = pool.symbol_id(measured) else { continue };
        if let Some((_, value)) = start.iter_mut().find(|(q, _)| *q == symbol) {
            *value = pool.substitute(drive.motion, &[(model.time, begin)]);
        }
    }
    start
}
