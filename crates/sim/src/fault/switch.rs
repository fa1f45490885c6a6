//! Faults of what switches: chatter, contacts that exclude each other, drives that jump.

use super::words::unit_of;
use crate::codes;
use crate::evaluator::Energy;
use crate::hybrid::NoConsistentModes;
use crate::run::{NoSensitivity, Sample, Undefined};
use bksim_mbs::constraint::Source;
use bksim_mbs::modes::switches_of;
use bksim_mbs::signal::signal_values;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::diagnostic::{Diagnostic, Span};
use bksim_model::message::{listed, short};
use bksim_model::{
    Base, BodyId, CouplingId, HeldChange, Joint, Load, LoadId, Measure, Model, MotionKind, Place,
    Round,
};

/// Energies beyond this, J, are on their way beyond all numbers.
const LARGEST: f64 = 1e100;

/// The diagnostic of an instant without consistent modes.
pub(super) fn no_consistent_modes(
    model: &Model,
    system: &SymbolicSystem,
    fault: &NoConsistentModes,
    t: f64,
) -> Diagnostic {
    match fault {
        NoConsistentModes::Chatter { kink } => chatter(model, system, *kink, t),
        NoConsistentModes::Contacts { contacts } => {
            let mut loads: Vec<LoadId> =
                contacts.iter().map(|&k| system.contacts[k].load).collect();
            loads.dedup();
            match jamming(model) {
                Some(load) if loads.is_empty() => jams(load, t),
                _ => contacts_exclude(model, &loads, t),
            }
        }
        NoConsistentModes::Paradox { contact, has_several } => {
            paradox(model, system.contacts[*contact].load, *has_several, t)
        }
        NoConsistentModes::Signal { signal } => without_value(model, *signal, t),
        NoConsistentModes::Endless { signal } => changes_without_end(model, *signal, t),
        NoConsistentModes::Jump { row, by } => jump(model, system, *row, *by, t),
    }
}

/// The fault of a motion that has no derivatives from an instant on.
pub(super) fn no_sensitivity(model: &Model, fault: &NoSensitivity) -> Diagnostic {
    let t = short(fault.t);
    let fault_of = |message: String| Diagnostic::error(codes::NO_SENSITIVITY, message);
    match fault.why {
        Undefined::Touching(Some(LoadId(load))) => {
            let load = &model.loads[load];
            let message =
                format!("`{}` is only touched at t = {t} s: for other values it is not", load.name);
            fault_of(message)
                .at(load.span.clone(), "reached without an impact")
                .help("end the run before it, or let the motion miss the stop or hit it")
        }
        Undefined::Touching(None) => {
            fault_of(format!("an expression only reaches its kink at t = {t} s"))
                .help("end the run before it, or let the motion pass the kink")
        }
        Undefined::Together => fault_of(format!(
            "several things switch at once at t = {t} s, and apart for other values"
        ))
        .help("move one of them a little, so that they come one after the other"),
        Undefined::Singular => {
            fault_of(format!("the derivatives of the motion have no bound at t = {t} s"))
                .help("end the run before the singular pose there")
        }
        Undefined::Shared => fault_of(
            "joints that repeat each other share the reactions: they have no gradient".to_owned(),
        )
        .help("let the goal depend on the motion, or leave out the joints that repeat others"),
        Undefined::Room => fault_of(format!(
            "the motion until t = {t} s takes more room than there is to go back along it"
        ))
        .help("end the run earlier, or take the derivatives forward, by few parameters at a time"),
    }
}

/// Bodies that slide where the friction turns them so that they press the more: Painlevé's paradox.
fn paradox(model: &Model, load: LoadId, has_several: bool, t: f64) -> Diagnostic {
    let name = &model.loads[load.0].name;
    let message = format!(
        "the bodies and the friction of contact `{name}` have no unique motion at t = {} s",
        short(t)
    );
    let which = if has_several {
        "two motions fit: one in which the bodies part, and one in which they go on sliding"
    } else {
        "no force fits: the more the bodies press, the more their friction presses them together"
    };
    Diagnostic::error(codes::PARADOX, message)
        .at(model.loads[load.0].span.clone(), "these slide, and their friction turns them towards each other")
        .note(format!("Painlevé's paradox of rigid bodies with dry friction; {which}"))
        .help("make `mu` smaller, let the body slide the other way, or put a spring between it and its mass")
}

/// The first friction that follows a reaction.
fn jamming(model: &Model) -> Option<&Load> {
    model.loads.iter().find(|load| load.kind.coulomb().is_some())
}

/// The fault of a run that ends where a joint jams, its numbers being as they should up to there.
pub(super) fn jammed(model: &Model, last: &Sample) -> Option<Diagnostic> {
    let Energy { kinetic, potential, .. } = last.energy;
    let load = jamming(model).filter(|_| kinetic.abs().max(potential.abs()) < LARGEST)?;
    Some(jams(load, last.t))
}

/// A motion that would have to end at once: the friction grows with the reaction, and that with the friction.
fn jams(load: &Load, t: f64) -> Diagnostic {
    let message = format!(
        "friction `{}` brakes more than any motion can bear at t = {} s",
        load.name,
        short(t)
    );
    Diagnostic::error(codes::JAMS, message)
        .at(load.span.clone(), "the joint jams while it moves")
        .note("the load on the surfaces grows with the friction, and the friction with the load, without end")
        .help("make the guide longer, bring the forces nearer to it, or make `mu` smaller")
}

/// A signal without a finite value at a tick, or where a condition latches it.
fn without_value(model: &Model, signal: usize, t: f64) -> Diagnostic {
    let signal = &model.held[signal];
    let occasion = match signal.change {
        HeldChange::Tick { .. } => "at the tick",
        HeldChange::Event { .. } | HeldChange::HalfTurn { .. } => "where it is latched,",
    };
    let message =
        format!("signal `{}` has no finite value {occasion} at t = {} s", signal.name, short(t));
    Diagnostic::error(codes::NO_SIGNAL, message)
        .at(signal.span.clone(), "this has no finite value there")
        .help("keep what it uses away from there, or write a law that has a value there")
}

/// Latched signals that set off one another without end.
fn changes_without_end(model: &Model, signal: usize, t: f64) -> Diagnostic {
    let signal = &model.held[signal];
    let message = format!("signal `{}` changes without end at t = {} s", signal.name, short(t));
    Diagnostic::error(codes::ENDLESS, message)
        .at(signal.span.clone(), "its conditions come to hold again and again")
        .note("each change of a latched signal makes another condition hold, at the same instant")
        .help("let the conditions leave a range between them, in which the signal stays as it is")
}

/// A joint that starts where a stop does not let it be.
pub(super) fn beyond_stop(model: &Model, load: LoadId, by: f64) -> Diagnostic {
    let load = &model.loads[load.0];
    if let Some(teeth) = load.teeth() {
        let unit = if teeth.effort == MotionKind::Rotation { "rad" } else { "m" };
        let message =
            format!("the teeth of `{}` overlap by {} {unit} at the start", teeth.name, short(by));
        return Diagnostic::error(codes::BEYOND_STOP, message)
            .at(load.span.clone(), "these teeth")
            .help(
                "write another `phase`, or start one of its joints so that both flanks have room",
            );
    }
    if load.is_coupling() {
        let message = format!("rope `{}` is {} m too short at the start", load.name, short(by));
        return Diagnostic::error(codes::BEYOND_STOP, message)
            .at(load.span.clone(), "this rope")
            .help("start nearer, or write a larger `length`");
    }
    if let Some((contact, place)) = load.kind.touch() {
        let place = &model.contacts[contact.0].places[place];
        // A curve may have been taken at another place.
        let lifts = |joint: &Joint| joint.name == load.name && joint.kind.lifts().is_some();
        let elsewhere = if model.joints.iter().any(lifts) {
            format!(", or guess in `[initial]` for `{}` where on the curve they touch", load.name)
        } else {
            String::new()
        };
        let message = format!(
            "the outlines of contact `{}` overlap by {} m at the start",
            load.name,
            short(overlap(model, place, by))
        );
        return Diagnostic::error(codes::OVERLAP, message)
            .at(load.span.clone(), "these outlines")
            .help(format!(
                "move the start of one of the bodies until they touch or are apart{elsewhere}"
            ));
    }
    let unit = load.kind.joint_motion().map_or("", |(joint, motion_idx)| {
        unit_of(model, Measure::JointPosition(joint, motion_idx))
    });
    let message = format!("the start is beyond stop `{}` by {} {unit}", load.name, short(by));
    Diagnostic::error(codes::BEYOND_STOP, message)
        .at(load.span.clone(), "this stop")
        .help("start between its limits, or widen them")
}

/// How far the outlines of a place overlap, m. Two circles are `by` apart in squares, (d² − r²)/2r.
fn overlap(model: &Model, place: &Place, by: f64) -> f64 {
    let of = |symbol| {
        let known = model.parameters.iter().find(|parameter| parameter.symbol == symbol);
        known.map(|parameter| parameter.value)
    };
    let radius = |round: &Round| model.pool.evaluate(round.radius, &of).unwrap_or(f64::NAN);
    let own = radius(&place.mover);
    match &place.base {
        Base::Ring(ring) => {
            let room = radius(ring) - own;
            (room * room + 2.0 * room * by).sqrt() - room
        }
        Base::Round { round, .. } => {
            let sum = radius(round) + own;
            sum - (sum * sum - 2.0 * sum * by).max(0.0).sqrt()
        }
        Base::Edge { .. } | Base::Curve { .. } | Base::Plane(_) => by,
    }
}

fn chatter(model: &Model, system: &SymbolicSystem, kink: usize, t: f64) -> Diagnostic {
    let function = system.switches[kink].function;
    let owner = owner_of(model, system, kink);
    let who = match &owner {
        Some((name, _)) => name.clone(),
        None => "a load".to_owned(),
    };
    let message = format!("{who} switches forth and back without end at t = {} s", short(t));
    let fault = Diagnostic::error(codes::CHATTER, message)
        .note(format!("it switches where `{}` is zero", model.pool.to_text(function)))
        .help(
            "for dry friction use a load of type \"friction\"; else make the expression continuous \
             where it switches",
        );
    match owner {
        Some((_, span)) => fault.at(span, "both branches lead back to the switch"),
        None => fault,
    }
}

/// The load or drive in whose expression a switch is, and its place.
fn owner_of(model: &Model, system: &SymbolicSystem, kink: usize) -> Option<(String, Span)> {
    let pool = &model.pool;
    let function = system.switches[kink].function;
    let signals = signal_values(model, &system.kinematics);
    let of_loads = model.loads.iter().map(|load| {
        let named = (format!("load `{}`", load.name), load.span.clone());
        (named, load.kind.expressions())
    });
    let of_drives = model.drives.iter().map(|drive| {
        let named = (format!("drive `{}`", drive.name), drive.span.clone());
        (named, vec![drive.motion])
    });
    let of_latches = model.held.iter().map(|signal| {
        let named = (format!("signal `{}`", signal.name), signal.span.clone());
        (named, signal.rows().iter().map(|row| row.condition).collect())
    });
    of_loads.chain(of_drives).chain(of_latches).find_map(|(named, expressions)| {
        let resolved: Vec<_> =
            expressions.iter().map(|&e| pool.simplify(pool.substitute(e, &signals))).collect();
        let (_, switches) = switches_of(model, system, &resolved);
        let is_it = |u| u == function || u == pool.neg(function);
        switches.iter().any(|switch| is_it(switch.function)).then_some(named)
    })
}

fn contacts_exclude(model: &Model, loads: &[LoadId], t: f64) -> Diagnostic {
    let names: Vec<&str> = loads.iter().map(|load| model.loads[load.0].name.as_str()).collect();
    let message =
        format!("no motion fits the contacts of {} at t = {} s", listed(&names), short(t));
    let fault = Diagnostic::error(codes::NO_CONTACTS, message)
        .help("leave room between the stops, or drive by a force instead of a motion");
    match loads.first() {
        Some(load) => fault.at(model.loads[load.0].span.clone(), "neither holds nor parts"),
        None => fault,
    }
}

fn jump(model: &Model, system: &SymbolicSystem, row: usize, by: f64, t: f64) -> Diagnostic {
    let (who, span, unit) = match system.constraints[row].source {
        Source::Drive(drive) => {
            let drive = &model.drives[drive.0];
            let unit = unit_of(model, Measure::JointPosition(drive.joint, drive.motion_idx));
            (format!("drive `{}`", drive.name), drive.span.clone(), unit)
        }
        Source::Quaternion(BodyId(body)) => {
            let body = &model.bodies[body];
            (format!("body `{}`", body.name), body.span.clone(), "")
        }
        Source::Coupling(CouplingId(coupling)) => {
            let coupling = &model.couplings[coupling];
            let unit = match coupling.effort {
                MotionKind::Translation => "m",
                MotionKind::Rotation => "rad",
            };
            (format!("coupling `{}`", coupling.name), coupling.span.clone(), unit)
        }
        Source::Joint(joint) => {
            let joint = &model.joints[joint.0];
            let unit = if system.constraints[row].direction == "angle" { "rad" } else { "m" };
            (format!("joint `{}`", joint.name), joint.span.clone(), unit)
        }
        Source::Stop(load) | Source::Friction(load) => {
            let load = &model.loads[load.0];
            (format!("load `{}`", load.name), load.span.clone(), "m")
        }
    };
    let message = format!("{who} jumps by {} {unit} at t = {} s", short(by), short(t));
    Diagnostic::error(codes::DRIVE_JUMPS, message)
        .at(span, "its position is not continuous")
        .help("let the branches meet where they switch")
}
