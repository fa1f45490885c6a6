//! Units of what a start consists of: lengths are measured by the mechanism, angles modulo 2π.

use std::f64::consts::TAU;

use bksim_expr::{Expr, SymbolId, Tape, TapeError};
use bksim_mbs::constraint::{Constraint, Source};
use bksim_mbs::coordinate::{Coordinate, CoordinateKind};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{Initial, Measure, Model, MotionKind, Vector};

/// Kinds of the coordinates, constraint rows and initial values of a model, and its links' lengths.
#[derive(Clone, Debug)]
pub(super) struct Units {
    /// Whether each coordinate is an angle.
    pub(super) is_turn: Vec<bool>,
    /// Whether each coordinate is a length.
    pub(super) is_length: Vec<bool>,
    /// The first coordinates of quaternions, of which each has four.
    pub(super) quaternions: Vec<usize>,
    /// Whether each constraint row is an angle, which may be off by whole turns.
    pub(super) is_row_angle: Vec<bool>,
    /// Whether each constraint row is a length.
    pub(super) is_row_length: Vec<bool>,
    /// Whether each initial value is an angle.
    pub(super) is_initial_angle: Vec<bool>,
    /// Whether each initial value is a length.
    pub(super) is_initial_length: Vec<bool>,
    /// Squared distances of the points of each body that joints meet in, and of the ends of links.
    lengths: Tape,
}

impl Units {
    pub(super) fn of(
        model: &Model,
        system: &SymbolicSystem,
        parameters: &[SymbolId],
    ) -> Result<Self, TapeError> {
        let is_row_angle = |row: &Constraint| match row.source {
            Source::Drive(id) => {
                let drive = &model.drives[id.0];
                is_angle(model, Measure::JointPosition(drive.joint, drive.motion_idx))
            }
            _ => row.direction == "angle",
        };
        let is_row_length = |row: &Constraint| match row.source {
            Source::Quaternion(_) => false,
            Source::Coupling(_) => row.effort == MotionKind::Translation,
            _ => !is_row_angle(row),
        };
        // A coupling tells one turn from the next.
        let coupled = system.constraints.iter().filter(|c| matches!(c.source, Source::Coupling(_)));
        let coupled: Vec<Expr> = coupled.map(|c| c.expression).collect();
        let coupled = system.kinematics.coordinates_in(&model.pool, &coupled);
        let is_turn = |(i, c): (usize, &Coordinate)| {
            c.kind == CoordinateKind::Angle && coupled.binary_search(&i).is_err()
        };
        let is_initial_angle = |initial: &Initial| is_angle(model, initial.measure);
        let is_initial_length = |initial: &Initial| initial.measure.unit(model) == "m";
        let (coordinates, rows) = (system.coordinates().iter(), system.constraints.iter());
        Ok(Self {
            is_turn: coordinates.clone().enumerate().map(is_turn).collect(),
            is_length: coordinates.map(|c| c.kind == CoordinateKind::Length).collect(),
            quaternions: system.kinematics.turnings.iter().map(|turning| turning.first).collect(),
            is_row_angle: rows.clone().map(is_row_angle).collect(),
            is_row_length: rows.map(is_row_length).collect(),
            is_initial_angle: model.initial.iter().map(is_initial_angle).collect(),
            is_initial_length: model.initial.iter().map(is_initial_length).collect(),
            lengths: Tape::compile(&model.pool, &squared_lengths(model), &[], parameters)?,
        })
    }

    /// The longest link, m; one metre where nothing has a length.
    pub(super) fn longest_link(&self, parameters: &[f64]) -> f64 {
        let mut squares = vec![0.0; self.lengths.n_outputs()];
        self.lengths.evaluate(&mut self.lengths.workspace(parameters), &[], &mut squares);
        let longest = squares.into_iter().filter(|s| s.is_finite()).fold(0.0, f64::max).sqrt();
        if longest > 0.0 { longest } else { 1.0 }
    }
}

/// True if a measure of positions is an angle.
fn is_angle(model: &Model, measure: Measure) -> bool {
    measure.unit(model) == "rad"
}

/// From the first joint of each body to its others, and from end to end of each link.
fn squared_lengths(model: &Model) -> Vec<Expr> {
    let pool = &model.pool;
    let square = |a: &Vector, b: &Vector| {
        let difference = bksim_mbs::spatial::sub(pool, a, b);
        bksim_mbs::spatial::dot(pool, &difference, &difference)
    };
    let mut first: Vec<Option<Vector>> = vec![None; model.bodies.len()];
    let mut squares = Vec::new();
    for joint in &model.joints {
        for anchor in [joint.predecessor, joint.successor] {
            let here = match anchor.point {
                Some(point) => model.bodies[anchor.body.0].points[point.0].position,
                None => bksim_mbs::spatial::zero(pool),
            };
            match &first[anchor.body.0] {
                Some(there) => squares.push(square(there, &here)),
                None => first[anchor.body.0] = Some(here),
            }
        }
        if let Some(length) = joint.kind.link_length() {
            // Lengths that change with time, as they are at the start.
            let t_start = pool.float(model.solve.t_start);
            let length = pool.substitute(length, &[(model.time, t_start)]);
            squares.push(pool.mul(length, length));
        }
    }
    squares
}

/// Angle in (−π, π].
pub(super) fn wrapped(angle: f64) -> f64 {
    // Most are so small: no turn is to be found.
    const SMALL: f64 = 3.0;
    if angle.abs() <= SMALL { angle } else { angle - TAU * whole_turns(angle) }
}

/// How many turns an angle is from the nearest one in (−π, π].
pub(super) fn whole_turns(angle: f64) -> f64 {
    (angle / TAU).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_turns_are_taken_off_angles_alone() {
        for angle in [-3.1, -3.0, -1.0, 0.0, 2.9, 3.0, 3.1] {
            assert_eq!(wrapped(angle), angle);
            for n in [-2.0, -1.0, 1.0, 3.0] {
                let off = wrapped(angle + n * TAU) - angle;
                assert!(off.abs() < 1e-14, "{angle} and {n} turns: off by {off:e}");
            }
        }
    }
}
