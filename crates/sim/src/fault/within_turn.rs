//! Angles that are read within ±180°: those of joints in space that are cut, which are no coordinates and count no
//! turns.

use std::f64::consts::{PI, TAU};

use crate::codes;
use crate::start::Conflict;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::message::short;
use bksim_model::{JointId, Measure, Model, motion_words};

/// Warnings about loads and expressions that go by such an angle of a joint that the author has cut.
pub fn diagnose_turns(model: &Model, system: &SymbolicSystem) -> Vec<Diagnostic> {
    let mut found: Vec<((JointId, usize), Vec<String>)> = Vec::new();
    for (angle, user) in users(model) {
        let (JointId(joint_idx), motion_idx) = angle;
        let is_cut = model.joints[joint_idx].cut == Some(true);
        if !(is_cut && system.kinematics.is_within_turn(model, angle.0, motion_idx)) {
            continue;
        }
        match found.iter_mut().find(|(known, _)| *known == angle) {
            Some((_, all)) if all.contains(&user) => (),
            Some((_, all)) => all.push(user),
            None => found.push((angle, vec![user])),
        }
    }
    let warning = |((joint, motion_idx), users): ((JointId, usize), Vec<String>)| {
        let of = &model.joints[joint.0];
        let [word, ..] = motion_words(of.kind.motions(), motion_idx);
        let name = format!("{}.{word}", of.name);
        let verb = if users.len() == 1 { "goes" } else { "go" };
        let message = format!("{} {verb} by `{name}`, which jumps at ±180 deg", users.join(", "));
        Diagnostic::warning(codes::ANGLE_JUMPS, message)
            .at(of.span.clone(), "cut: its angle is no coordinate")
            .note("in space only the coordinate of a joint that is not cut counts its turns")
            .help(format!(
                "leave out `cut = true`, so that the loop is closed in another joint; nothing needs to be done \
                 where `{name}` stays within ±180 deg"
            ))
    };
    found.into_iter().map(warning).collect()
}

/// Angles of joints that something goes by, with its name.
fn users(model: &Model) -> Vec<((JointId, usize), String)> {
    let mut users = Vec::new();
    for load in &model.loads {
        let angle = load.position_it_follows(&model.pool);
        users.extend(angle.map(|angle| (angle, format!("load `{}`", load.name))));
    }
    for signal in &model.signals {
        if let Measure::JointPosition(joint, motion_idx) = signal.measure {
            users.push(((joint, motion_idx), "an expression".to_owned()));
        }
    }
    users
}

/// The fault of such an angle that is stated beyond ±180°.
pub(super) fn stated(
    model: &Model,
    system: &SymbolicSystem,
    conflicts: &[Conflict],
) -> Option<Diagnostic> {
    let beyond = |conflict: &&Conflict| match model.initial[conflict.initial_idx].measure {
        Measure::JointPosition(joint, motion_idx) => {
            conflict.stated.abs() > PI * (1.0 + 1e-9)
                && system.kinematics.is_within_turn(model, joint, motion_idx)
        }
        _ => false,
    };
    let conflict = conflicts.iter().find(beyond)?;
    let initial = &model.initial[conflict.initial_idx];
    let Measure::JointPosition(joint, motion_idx) = initial.measure else { return None };
    let joint = &model.joints[joint.0];
    let [word, ..] = motion_words(joint.kind.motions(), motion_idx);
    let turns = (conflict.stated / TAU).round();
    let [stated, within] =
        [conflict.stated, conflict.stated - TAU * turns].map(|x| short(x.to_degrees()));
    let message = format!("`{}` is stated beyond ±180 deg, within which it is read", initial.name);
    Some(
        Diagnostic::error(codes::STATED_POSITIONS, message)
            .at(initial.span.clone(), format!("{stated} deg"))
            .note(format!(
                "joint `{}` is cut: its angle is no coordinate and counts no turns",
                joint.name
            ))
            .help(format!("write `{word} = \"{within} deg\"`, which is the same position")),
    )
}
