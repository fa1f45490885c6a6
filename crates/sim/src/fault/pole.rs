//! Poles of three angles in sequence: at a second angle of ±90° the axes of the first and of the third
//! are one, and some angular velocities have no rates.

use crate::codes;
use crate::run::{Failure, NearPole};
use crate::start::Conflict;
use bksim_mbs::coordinate::Owner;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::message::short;
use bksim_model::{Measure, Model, MotionKind};

/// The fault of a run that stopped where three angles are at their pole; `cause` is what stopped it.
pub(super) fn at_pole(
    model: &Model,
    system: &SymbolicSystem,
    failure: &Failure,
    cause: &str,
) -> Option<Diagnostic> {
    let near = near(system, &failure.last.q)?;
    let owner = owner(model, system, near[1]);
    let message = format!(
        "the angles of {owner} are at their pole, where the run stopped at t = {} s",
        short(failure.summary.t)
    );
    let fault = Diagnostic::error(codes::ANGLE_POLE, message);
    Some(explained(fault, model, system, near, failure.last.q[near[1]]).note(cause.to_owned()))
}

/// The fault of a start at the pole of three angles, where motions of `coordinates` have no inertia.
pub(super) fn at_start(
    model: &Model,
    system: &SymbolicSystem,
    coordinates: &[usize],
    q: &[f64],
) -> Option<Diagnostic> {
    let near = near(system, q)?;
    // The turns about the two axes that are one undo each other.
    let [first, _, third] = near;
    if ![first, third].iter().all(|coordinate| coordinates.contains(coordinate)) {
        return None;
    }
    let owner = owner(model, system, near[1]);
    let message = format!("the angles of {owner} are at their pole at the start");
    let fault = Diagnostic::error(codes::ANGLE_POLE, message);
    Some(explained(fault, model, system, near, q[near[1]]))
}

/// The fault of three angles of a joint that are stated at their pole, where the first and the third cannot be told
/// apart.
pub(super) fn stated(model: &Model, conflicts: &[Conflict]) -> Option<Diagnostic> {
    let at_pole = |conflict: &&Conflict| {
        let Measure::JointPosition(joint, motion) = model.initial[conflict.initial_idx].measure
        else {
            return false;
        };
        let kinds = model.joints[joint.0].kind.motions();
        let turns = (0..kinds.len()).filter(|&k| kinds[k] == MotionKind::Rotation);
        let turns: Vec<usize> = turns.collect();
        turns.len() == 3 && turns[1] == motion && conflict.stated.cos().abs() < NearPole::NEAR
    };
    let second = conflicts.iter().find(at_pole)?;
    let initial = &model.initial[second.initial_idx];
    let Measure::JointPosition(joint, _) = initial.measure else { return None };
    let joint = &model.joints[joint.0];
    let body = &model.bodies[joint.successor.body.0].name;
    let message = format!("the angles of joint `{}` are stated at their pole", joint.name);
    let degrees = short(second.stated.to_degrees());
    Some(
        Diagnostic::error(codes::ANGLE_POLE, message)
            .at(initial.span.clone(), format!("{degrees} deg"))
            .note("at 90 deg the axes of the other two angles are one, so that they cannot be told apart")
            .help(format!(
                "state the orientation of `{body}` in place of these angles, for example \
                 `{body} = {{ rpy = [0, \"90 deg\", 0] }}`, or turn the frames of the points"
            )),
    )
}

/// The warning about a run that has passed near the pole of three angles.
pub(super) fn near_pole(model: &Model, system: &SymbolicSystem, pole: &NearPole) -> Diagnostic {
    let NearPole { t, coordinate_idx: second, cosine } = *pole;
    let owner = owner(model, system, second);
    let message = format!("the angles of {owner} come near their pole at t = {} s", short(t));
    let fault = Diagnostic::warning(codes::ANGLE_POLE, message);
    explained(fault, model, system, [second - 1, second, second + 1], cosine.acos())
}

/// "joint `ball`".
fn owner(model: &Model, system: &SymbolicSystem, coordinate_idx: usize) -> String {
    match system.coordinates()[coordinate_idx].owner {
        Owner::Joint(joint, _) => format!("joint `{}`", model.joints[joint.0].name),
        Owner::Body(body, _) | Owner::Quaternion(body, _) => {
            format!("body `{}`", model.bodies[body.0].name)
        }
        Owner::State(state) => format!("state `{}`", model.states[state.0].name),
    }
}

/// The fault with its place, the pole in words, and the cure.
fn explained(
    fault: Diagnostic,
    model: &Model,
    system: &SymbolicSystem,
    three: [usize; 3],
    angle: f64,
) -> Diagnostic {
    let [first, second, third] = three.map(|i| system.coordinates()[i].name.as_str());
    let span = match system.coordinates()[three[1]].owner {
        Owner::Joint(joint, _) => &model.joints[joint.0].span,
        Owner::Body(body, _) | Owner::Quaternion(body, _) => &model.bodies[body.0].span,
        Owner::State(state) => &model.states[state.0].span,
    };
    let [note, help] = words(system, three, angle);
    fault
        .at(span.clone(), format!("turns by `{first}`, `{second}` and `{third}`"))
        .note(note)
        .help(help)
}

/// The note and the cure of three angles that are near their pole at positions `q`; `None` where none are.
pub(super) fn reason(system: &SymbolicSystem, q: &[f64]) -> Option<[String; 2]> {
    let three = near(system, q)?;
    Some(words(system, three, q[three[1]]))
}

fn near(system: &SymbolicSystem, q: &[f64]) -> Option<[usize; 3]> {
    let sequences = system.kinematics.sequences();
    sequences.into_iter().find(|three| q[three[1]].cos().abs() < NearPole::NEAR)
}

fn words(system: &SymbolicSystem, three: [usize; 3], angle: f64) -> [String; 2] {
    let second = &system.coordinates()[three[1]];
    let key = if matches!(second.owner, Owner::Joint(..)) { "coordinate" } else { "coordinates" };
    [
        format!(
            "`{}` is {} deg there: at 90 deg the axes of the other two are one, and their rates have no \
             bound",
            second.name,
            short(angle.cos().abs().acos().to_degrees())
        ),
        format!(
            "leave out the names in `{key}`, and drives and loads that use single angles: then it turns \
             without a pole; else turn the frames of the points so that the motion keeps away"
        ),
    ]
}
