//! Poles of three angles in sequence: at a second angle of ±90° the axes of the first and of the third
//! are one, and some angular velocities have no rates.

use crate::codes;
use crate::run::Failure;
use bksim_mbs::kinematics::{Coordinate, CoordinateKind, Owner};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::message::short;

/// Cosine of the second angle below which a run that stops is said to have met the pole.
const NEAR: f64 = 0.03;

/// The fault of a run that stopped where three angles are at their pole; `cause` is what stopped it.
pub(super) fn at_pole(
    model: &Model,
    system: &SymbolicSystem,
    failure: &Failure,
    cause: &str,
) -> Option<Diagnostic> {
    let three = angles_at_pole(system, &failure.last.q)?;
    let [(_, first), (second_idx, second), (_, third)] = three;
    let (owner, span, key) = match second.owner {
        Owner::Joint(joint, _) => {
            let joint = &model.joints[joint.0];
            (format!("joint `{}`", joint.name), &joint.span, "coordinate")
        }
        Owner::Body(body, _) | Owner::Quaternion(body, _) => {
            let body = &model.bodies[body.0];
            (format!("body `{}`", body.name), &body.span, "coordinates")
        }
    };
    let angle = failure.last.q[second_idx].to_degrees();
    let message = format!(
        "the angles of {owner} are at their pole, where the run stopped at t = {} s",
        short(failure.summary.t)
    );
    let names = format!("`{}`, `{}` and `{}`", first.name, second.name, third.name);
    Some(
        Diagnostic::error(codes::ANGLE_POLE, message)
            .at(span.clone(), format!("turns by {names}"))
            .note(format!(
                "`{}` = {} deg: at ±90 deg the axes of the other two are one, and rates have no bound",
                second.name,
                short(angle)
            ))
            .note(cause.to_owned())
            .help(format!(
                "leave out the names in `{key}`, and loads and drives that use single angles: then it \
                 turns without a pole; else turn the frames of the points so that the motion keeps away"
            )),
    )
}

/// Three angles of one owner, the second of which is near ±90°, with their indices.
fn angles_at_pole<'s>(
    system: &'s SymbolicSystem,
    q: &[f64],
) -> Option<[(usize, &'s Coordinate); 3]> {
    let angles: Vec<(usize, &Coordinate)> = system
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
    angles.windows(3).find_map(|three| {
        let three @ [(_, first), (second_idx, second), (_, third)] =
            <[_; 3]>::try_from(three).ok()?;
        let is_one = same_owner(first.owner, second.owner) && same_owner(second.owner, third.owner);
        (is_one && q[second_idx].cos().abs() < NEAR).then_some(three)
    })
}
