//! Why a motion has no efforts, in the author's terms.

use bksim_mbs::constraint::Source;
use bksim_mbs::contact::Penetration;
use bksim_model::diagnostic::{Diagnostic, Rejected, Span};
use bksim_model::message::{listed, short};
use bksim_model::{GROUND, JointId, Measure, Model, Surface, motion_words};
use bksim_sim::fault::diagnose_start;
use bksim_sim::start::StartError;
use nalgebra::DMatrix;

use crate::PoseQuantity;
use crate::codes;
use crate::effort_channels::Channel;
use crate::effort_contacts::EffortContact;
use crate::error::AnalysisError;
use crate::loaded::Loaded;

fn refused(fault: Diagnostic) -> AnalysisError {
    Rejected(vec![fault]).into()
}

/// A motion that goes through a stop at `t`.
pub(crate) fn through_stop(
    model: &Model,
    limit: &Penetration,
    t: f64,
    times: &[f64],
) -> AnalysisError {
    let load = &model.loads[limit.load.0];
    let name = &load.name;
    let first = times.first().copied().unwrap_or(t);
    let fault = if t == first {
        let message = format!("the motion begins beyond the stop `{name}`");
        let help = format!("begin within the `{}` of the stop, or move it", limit.direction);
        Diagnostic::error(codes::THROUGH_STOP, message).help(help)
    } else {
        let message = format!("the motion goes through the stop `{name}` at t = {} s", short(t));
        // A little before, in few digits.
        let end = first + 0.99 * (t - first);
        let help = format!(
            "end the times before: `--times \"{}:{} s:{}\"`, or let the motion turn back there",
            short(first),
            short(end),
            times.len().max(2)
        );
        Diagnostic::error(codes::THROUGH_STOP, message).help(help)
    };
    let label = format!("its `{}` is passed", limit.direction);
    refused(fault.at(load.span.clone(), label).note("no effort moves a body through a stop"))
}

/// A stop that the motion needs, which would have to pull from `t` on, or a rope, which would have to push.
pub(crate) fn stop_lets_go(contact: &EffortContact, t: f64, first: f64) -> AnalysisError {
    let EffortContact { name, span, is_rope, .. } = contact;
    let (message, label) = if *is_rope {
        (format!("the rope `{name}` would have to push at t = {} s", short(t)), "only pulls")
    } else {
        (format!("the stop `{name}` would have to pull at t = {} s", short(t)), "only pushes")
    };
    let end = short(first + 0.99 * (t - first));
    let help = match (*is_rope, t == first) {
        (true, true) => {
            "pull it taut by a spring or a load, or prescribe the motion of the body that it moves"
                .to_owned()
        }
        (true, false) => format!(
            "end the times before: `--times \"{}:{end} s:101\"`, or pull the rope taut by a spring or a load",
            short(first)
        ),
        (false, true) => {
            "press the bodies together by a spring or a load, or prescribe the motion of the body that the stop moves".to_owned()
        }
        (false, false) => format!(
            "end the times before: `--times \"{}:{end} s:101\"`, or press the bodies together by a stronger spring",
            short(first)
        ),
    };
    let fault = Diagnostic::error(codes::STOP_LETS_GO, message)
        .at(span.clone(), label)
        .note("from there on the motion of the body that it moves is free, so that no motion is given")
        .help(help);
    refused(fault)
}

/// Friction that no efforts are in balance with at `t`, or that drives what it should brake.
pub(crate) fn friction_jams((name, span): (&str, &Span), t: f64, drives: bool) -> AnalysisError {
    let (message, label) = if drives {
        let what = "gives a force along the motion";
        (format!("the friction `{name}` {what} at t = {} s", short(t)), "drives while it slides")
    } else {
        let what = "grows faster with the reactions than they can with it";
        (format!("the friction `{name}` {what} at t = {} s", short(t)), "jams")
    };
    let fault = Diagnostic::error(codes::FRICTION_JAMS, message)
        .at(span.clone(), label)
        .note("with such a coefficient the joint locks itself: no force moves it in this sense")
        .help("lower `mu`, or let the motion go the other way");
    refused(fault)
}

/// Friction that follows a multiplier whose row others could take the place of.
pub(crate) fn shared_reaction(loaded: &Loaded, row: usize) -> AnalysisError {
    let (model, mechanism) = (loaded.model(), &loaded.mechanism);
    let joint = match loaded.system().constraints[row].source {
        Source::Coupling(own) => model.loads.iter().find_map(|load| match load.kind.coulomb()? {
            Surface::Teeth { coupling, .. } if coupling == own => {
                load.kind.joint_motion().map(|(joint, _)| joint)
            }
            _ => None,
        }),
        source => source.joint(model),
    };
    let error = StartError::SharedReaction { joint: joint.unwrap_or(JointId(0)) };
    refused(diagnose_start(model, &mechanism.system, &mechanism.compiled, &error))
}

/// A motion that the actuators cannot meet at `t`, whose free motions `free` are columns of coordinates.
pub(crate) fn no_actuator(
    (loaded, channels): (&Loaded, &[Channel]),
    (t, q): (f64, &[f64]),
    free: &DMatrix<f64>,
    missing: &[String],
) -> Result<AnalysisError, AnalysisError> {
    let own: Vec<&Channel> = channels.iter().filter(|c| c.drive_idx.is_some()).collect();
    let suggested = suggested(loaded, &own, q, free)?;
    let names: Vec<&str> = missing.iter().map(String::as_str).collect();
    let message = match own.len() {
        0 => format!("no actuator works on the motion of {}", listed(&names)),
        _ => format!(
            "no efforts of {} meet the motion of {}",
            listed(&own.iter().map(|c| c.name.as_str()).collect::<Vec<_>>()),
            listed(&names)
        ),
    };
    let kept = own.iter().map(|channel| channel.name.clone());
    let all: Vec<String> = kept.chain(suggested).map(|name| format!("--actuator {name}")).collect();
    let fault =
        Diagnostic::error(codes::NO_ACTUATOR, format!("{message}, first at t = {} s", short(t)))
            .note("joints of bearings, welds and guides give no effort along their own motions")
            .help(format!("let joints move it: add `{}`", all.join(" ")));
    Ok(refused(fault))
}

/// Joints whose efforts work on all that the actuators `own` leave alone, those on the ground first.
fn suggested(
    loaded: &Loaded,
    own: &[&Channel],
    q: &[f64],
    free: &DMatrix<f64>,
) -> Result<Vec<String>, AnalysisError> {
    let model = loaded.model();
    let mut candidates: Vec<(String, Measure)> =
        own.iter().map(|channel| (channel.name.clone(), channel.measure)).collect();
    let on_ground = |joint: &bksim_model::Joint| {
        joint.predecessor.body == GROUND || joint.successor.body == GROUND
    };
    for is_on_ground in [true, false] {
        let joints = model.joints.iter().enumerate();
        for (idx, joint) in joints.filter(|(_, joint)| on_ground(joint) == is_on_ground) {
            let motions = joint.kind.motions();
            for motion_idx in 0..motions.len() {
                let measure = Measure::JointPosition(JointId(idx), motion_idx);
                if own.iter().any(|channel| channel.measure == measure) {
                    continue;
                }
                let [word, ..] = motion_words(motions, motion_idx);
                let name = match motions.len() {
                    1 => joint.name.clone(),
                    _ => format!("{}.{word}", joint.name),
                };
                candidates.push((name, measure));
            }
        }
    }
    let quantity = |(name, measure): &(String, Measure)| PoseQuantity {
        names: [name.clone(), String::new(), String::new()],
        unit: measure.fixed_unit(model),
        value: loaded.system().kinematics.measure(model, *measure),
    };
    let quantities: Vec<PoseQuantity> = candidates.iter().map(quantity).collect();
    let gradients = loaded.scalars(&quantities)?.gradients(loaded.t, q);

    // The first ones that together work on every free motion.
    let (mut rank, mut chosen) = (0, Vec::new());
    let mut rows = DMatrix::<f64>::zeros(0, free.ncols());
    for (k, gradient) in gradients.iter().enumerate() {
        let along = DMatrix::from_fn(1, free.ncols(), |_, column| {
            (0..free.nrows()).map(|i| gradient[i] * free[(i, column)]).sum::<f64>()
        });
        let length = along.norm();
        if length == 0.0 {
            continue;
        }
        let n = rows.nrows();
        let mut more = rows.clone().insert_row(n, 0.0);
        more.set_row(n, &(along / length).row(0));
        let found = crate::rows::rank(&more);
        if found > rank {
            (rank, rows) = (found, more);
            if k >= own.len() {
                chosen.push(candidates[k].0.clone());
            }
        }
    }
    Ok(chosen)
}
