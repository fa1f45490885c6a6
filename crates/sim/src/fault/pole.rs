//! Poles of three angles in sequence: at a second angle of ±90° the axes of the first and of the third
//! are one, and some angular velocities have no rates.

use bksim_mbs::kinematics::{Coordinate, CoordinateKind, Owner};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::message::short;

/// Cosine of the second angle below which a run that stops is said to have met the pole.
const NEAR: f64 = 0.03;

/// Says which three angles are at their pole in the pose `q`.
pub(super) fn pole_note(system: &SymbolicSystem, q: &[f64]) -> Option<String> {
    let turns: Vec<(usize, &Coordinate)> = system
        .coordinates()
        .iter()
        .enumerate()
        .filter(|(_, c)| c.kind == CoordinateKind::Angle)
        .collect();
    let same_owner = |a: Owner, b: Owner| match (a, b) {
        (Owner::Joint(a, _), Owner::Joint(b, _)) => a == b,
        (Owner::Body(a, _), Owner::Body(b, _)) => a == b,
        _ => false,
    };
    turns.windows(3).find_map(|three| {
        let [(_, first), (second_idx, second), (_, third)] = *three else { return None };
        let is_one = same_owner(first.owner, second.owner) && same_owner(second.owner, third.owner);
        let angle = q[second_idx];
        (is_one && angle.cos().abs() < NEAR).then(|| {
            format!(
                "`{}` = {} deg is near the pole of the angles `{}`, `{}` and `{}`, at ±90 deg: turn the \
                 frames of the joint so that the motion keeps away from it",
                second.name,
                short(angle.to_degrees()),
                first.name,
                second.name,
                third.name
            )
        })
    })
}
