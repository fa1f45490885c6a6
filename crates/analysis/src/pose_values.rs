//! [`PoseValues`]: columns of a table of positions that have no rates next to them: orientations in space, signals, outputs.
//!
//! Angles about fixed axes have infinite rates where the pitch is ±90°, so next to them are the angular velocity and the
//! angular acceleration.

use bksim_expr::{Expr, SymbolId, Tape, TapeError, Workspace};
use bksim_mbs::coordinate::CoordinateKind;
use bksim_mbs::signal::signal_values;
use bksim_model::{Measure, NamedSignal, Space};

use crate::positions::Positions;
use crate::table::Column;

/// Words of a body in space.
const WORDS: [&str; 9] = ["roll", "pitch", "yaw", "wx", "wy", "wz", "alx", "aly", "alz"];

/// Numbers that follow from positions, rates and accelerations.
pub(crate) struct PoseValues {
    pub(crate) columns: Vec<Column>,
    tape: Tape,
    space: Workspace,
}

impl PoseValues {
    /// Orientations of all bodies in space, and those of `signals` that follow from the motion alone.
    pub(crate) fn of(positions: &Positions, signals: &[NamedSignal]) -> Result<Self, TapeError> {
        let (model, system) = (positions.model(), positions.system());
        let (pool, kinematics) = (&model.pool, &system.kinematics);
        let coordinates = system.coordinates();
        let inputs: Vec<SymbolId> = std::iter::once(model.time)
            .chain(coordinates.iter().map(|c| c.q))
            .chain(coordinates.iter().map(|c| c.v))
            .chain(coordinates.iter().map(|c| c.a))
            .collect();
        let parameters = system.parameters(model);
        let is_spatial = model.space == Space::Spatial;
        let bodies = model.bodies.iter().skip(1).filter(|_| is_spatial);
        let words = bodies.flat_map(|body| WORDS.map(|word| format!("{}.{word}", body.name)));
        let mut found: Vec<(Column, Expr)> = words
            .filter_map(|name| {
                let measure = Measure::named(model, &name)?;
                let unit = measure.unit(model).to_owned();
                Some((Column::new(name, unit), kinematics.measure(model, measure)))
            })
            .collect();
        // Neither states nor forces are those of a position.
        let states = coordinates.iter().filter(|c| c.kind == CoordinateKind::Integral);
        let states: Vec<SymbolId> = states.flat_map(|c| [c.q, c.v, c.a]).collect();
        let values = signal_values(model, kinematics);
        for signal in signals {
            let value = pool.substitute(signal.value, &values);
            let is_of_state = states.iter().any(|&state| pool.depends_on(value, state));
            if !is_of_state && Tape::compile(pool, &[value], &inputs, &parameters).is_ok() {
                let topic = if signal.is_output { "outputs" } else { "signals" };
                let name = format!("{topic}.{}", signal.name);
                found.push((Column::new(name, signal.unit.clone()), value));
            }
        }
        let (columns, values): (Vec<Column>, Vec<Expr>) = found.into_iter().unzip();
        let tape = Tape::compile(pool, &values, &inputs, &parameters)?;
        Ok(Self { columns, space: tape.workspace(&positions.mechanism.parameters), tape })
    }

    /// Values of all columns at a time, s, with positions, velocities and accelerations of the coordinates.
    pub(crate) fn at(&mut self, t: f64, [q, v, a]: [&[f64]; 3]) -> Vec<f64> {
        let inputs = [&[t], q, v, a].concat();
        let mut values = vec![0.0; self.tape.n_outputs()];
        self.tape.evaluate(&mut self.space, &inputs, &mut values);
        values
    }
}
