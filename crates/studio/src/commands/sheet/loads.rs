//! All loads of one body as steps of CalculiX: `*CLOAD` cards at the instants of the largest forces.
//!
//! The cards are about a body that is cut free, in its own axes: reactions of joints, weight, applied loads, contacts and, by
//! d'Alembert, its inertia, each at a node set of its own. Together they are in balance, and a file whose loads are not says so.

use std::fmt::Write as _;

use bksim::model::{BodyId, GROUND, JointId, LoadKind, Model};
use bksim::report::six_digits;
use bksim::sim::pose::Pose;
use bksim::sim::run::Sample;
use bksim::sim::wrenches::{WrenchAt, Wrenches};
use bksim::{Mechanism, mbs::acting, mbs::force::Wrench, mbs::power::Actor};
use bksim_cli::args::sheet::Sheet;
use bksim_cli::exit::Failure;
use bksim_cli::output::number;
use bksim_cli::source::logged::unplayable;

use super::{CaseRun, Runs};

/// Part of the largest load that the sum of all may be and still be rounding.
const BALANCED: f64 = 1e-6;

/// Loads at one node set.
struct Set {
    name: String,
    /// Wrenches that are added there; those that decide where it is come first.
    wrenches: Vec<Wrench>,
    n_points: usize,
    /// The joint whose reaction it is, with its sign on the body.
    joint: Option<(usize, f64)>,
}

/// Everything on a body, compiled.
struct Body {
    sets: Vec<Set>,
    wrenches: Wrenches,
}

/// The text of the file.
pub(super) fn of(runs: &mut Runs, args: &Sheet) -> Result<String, Failure> {
    let body = body(runs, args)?;
    let model = &runs.cases[0].show.playback().mechanism().model;
    let name = model.bodies[body].name.clone();
    let joints = model.joints.iter().map(|joint| [joint.predecessor.body, joint.successor.body]);
    let contacts = model.contacts.iter().map(|contact| {
        let place = contact.places.first();
        place.map_or([GROUND; 2], |of| [of.mover.center.body, of.base.anchor().body])
    });
    let bearings: Vec<usize> = joints
        .chain(contacts)
        .enumerate()
        .filter(|(_, bodies)| bodies.contains(&BodyId(body)))
        .map(|(idx, _)| idx)
        .collect();
    if model.bodies[body].flexible.is_some() {
        let message = format!("loads of `{name}`, a body that bends, are not written");
        let help = "its bending moments are in `bksim export`; model it as a rigid body for loads of its own mesh";
        return Err(Failure::usage(message, help));
    }
    let (force, moment, length) = (runs.units.of("N"), runs.units.of("N*m"), runs.units.of("m"));
    let mut out = format!(
        "** Loads of `{name}` in the axes of its own frame, forces in {}, moments in {}, places in {}.\n\
         ** Each node set is one node with six freedoms, tied to the surface that bears the load: PIN_A joint `A`, MASS the centre\n\
         ** of mass with weight and inertia (d'Alembert), LOAD, DRIVE, COUPLING, CONTACT, BELT, ROPE what is called so.\n",
        force.unit, moment.unit, length.unit
    );
    for case in &mut runs.cases {
        let unmade = |e: &dyn std::fmt::Display| {
            let message = format!("the loads cannot be computed: {e}");
            Failure::file(&args.run.input, message, None)
        };
        let mut all = Body::of(case.show.playback().mechanism(), body).map_err(|e| unmade(&e))?;
        for (t, why) in instants(case, &bearings, args)? {
            let unreplayed = |e| unplayable(&args.run.input, "reported", &e);
            case.show.seek(t).map_err(unreplayed)?;
            let playback = case.show.playback();
            let pose = playback.poses()[body];
            let loads = all.at(playback.sample(), playback.modes());
            let of_case =
                if case.name.is_empty() { String::new() } else { format!(", case {}", case.name) };
            // Writing to a text does not fail.
            let _ =
                writeln!(out, "**\n** t = {} s{of_case}: {why}", six_digits(t, t.abs().max(1e-9)));
            let size = |v: [f64; 3]| v[0].hypot(v[1]).hypot(v[2]);
            let arm = loads.iter().map(|(_, w)| size(own(&pose, arm_of(&pose, w.point))));
            let reach = arm.fold(0.0, f64::max);
            let largest = loads.iter().map(|(_, w)| size(w.force)).fold(0.0, f64::max);
            let turning = loads.iter().map(|(_, w)| size(w.moment)).fold(0.0, f64::max);
            // A moment that is rounding next to the forces and their arms is none.
            let scales = [largest, turning.max(1e-4 * largest * reach), reach];
            let wrenches: Vec<WrenchAt> = loads.iter().map(|(_, w)| *w).collect();
            let left = WrenchAt::sum(&wrenches, wrenches.len());
            if size(left.force) > BALANCED * largest
                || size(left.moment) > BALANCED * turning.max(largest * reach)
            {
                let _ = writeln!(
                    out,
                    "** These loads are not in balance: a force of {} {} is missing, a moment of {} {}.",
                    number(six_digits(force.of_si(size(left.force)), force.of_si(largest))),
                    force.unit,
                    number(six_digits(moment.of_si(size(left.moment)), moment.of_si(scales[1]))),
                    moment.unit
                );
            }
            // A torque is the same at any place.
            for (name, w) in loads.iter().filter(|(_, w)| size(w.force) > 0.0) {
                let place = own(&pose, arm_of(&pose, w.point)).map(|x| {
                    number(six_digits(length.of_si(x), length.of_si(scales[2].max(1e-9))))
                });
                let _ = writeln!(out, "** {name} at {}", place.join(", "));
            }
            out += "*STEP\n*STATIC\n*CLOAD, OP=NEW\n";
            for (name, w) in &loads {
                let halves = [(w.force, &force, scales[0]), (w.moment, &moment, scales[1])];
                for (half, (world, unit, scale)) in halves.into_iter().enumerate() {
                    for (axis, x) in own(&pose, world).into_iter().enumerate() {
                        let value = six_digits(unit.of_si(x), unit.of_si(scale));
                        if value != 0.0 {
                            let _ = writeln!(out, "{name}, {}, {value}", 3 * half + axis + 1);
                        }
                    }
                }
            }
            out += "*END STEP\n";
        }
    }
    Ok(out)
}

/// A vector of the world in the axes of a body.
fn own(pose: &Pose, world: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| (0..3).map(|i| pose.r_world_from_body[i][axis] * world[i]).sum())
}

/// From the origin of a body to a point of the world.
fn arm_of(pose: &Pose, point: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| point[i] - pose.origin[i])
}

impl Body {
    fn of(mechanism: &Mechanism, body: usize) -> Result<Self, bksim::expr::TapeError> {
        let Mechanism { model, system, .. } = mechanism;
        let mut sets: Vec<Set> = Vec::new();
        for (idx, joint) in model.joints.iter().enumerate() {
            let sign = if joint.successor.body.0 == body { 1.0 } else { -1.0 };
            if sign > 0.0 || joint.predecessor.body.0 == body {
                let wrenches = vec![acting::point_of(model, system, JointId(idx))];
                let (name, joint) = (format!("PIN_{}", joint.name), Some((idx, sign)));
                sets.push(Set { name, wrenches, n_points: 1, joint });
            }
        }
        let wrenches = vec![acting::inertia(model, system, BodyId(body))];
        sets.push(Set { name: "MASS".to_owned(), wrenches, n_points: 1, joint: None });
        for acting::Acting { actor, wrench } in acting::acting(model, system) {
            if wrench.body.0 != body {
                continue;
            }
            let (name, is_place) = set_of(model, actor);
            if let Some(set) = sets.iter_mut().find(|set| set.name == name) {
                let at = if is_place { set.n_points } else { set.wrenches.len() };
                set.wrenches.insert(at, wrench);
                set.n_points += usize::from(is_place);
            } else {
                let (wrenches, n_points) = (vec![wrench], usize::from(is_place));
                sets.push(Set { name, wrenches, n_points, joint: None });
            }
        }
        let all: Vec<Wrench> = sets.iter().flat_map(|set| set.wrenches.clone()).collect();
        Ok(Self { sets, wrenches: Wrenches::compile(mechanism, &all)? })
    }

    /// The loads at a sample, in world axes, by node set.
    fn at(&mut self, sample: &Sample, modes: &[f64]) -> Vec<(String, WrenchAt)> {
        let all = self.wrenches.at(sample, modes);
        let mut rest = &all[..];
        let of_set = |set: &Set| {
            let (own, others) = rest.split_at(set.wrenches.len());
            rest = others;
            let mut sum = WrenchAt::sum(own, set.n_points);
            if let Some((joint, sign)) = set.joint {
                let [fx, fy, fz, mx, my, mz] = sample.reactions[joint].map(|x| sign * x);
                (sum.force, sum.moment) = ([fx, fy, fz], [mx, my, mz]);
            }
            (set.name.clone(), sum)
        };
        self.sets.iter().map(of_set).collect()
    }
}

/// The node set of what acts on a body, and true if its wrenches have the place where they act: gravity acts in the centre of
/// mass, friction along a line.
fn set_of(model: &Model, actor: Actor) -> (String, bool) {
    let (kind, name) = actor.named(model);
    let Actor::Load(load) = actor else {
        return (format!("{}_{name}", kind.to_uppercase()), true);
    };
    let load = &model.loads[load.0];
    match (&load.kind, load.contact()) {
        (LoadKind::Gravity { .. }, _) => ("MASS".to_owned(), false),
        (kind, Some(contact)) => {
            let is_place = matches!(kind, LoadKind::Touch { .. });
            (format!("CONTACT_{}", model.contacts[contact.0].name), is_place)
        }
        _ => (format!("LOAD_{name}"), true),
    }
}

/// The body that is asked for, or the only one that moves.
fn body(runs: &Runs, args: &Sheet) -> Result<usize, Failure> {
    let bodies = &runs.cases[0].show.playback().mechanism().model.bodies;
    let names: Vec<&str> = bodies.iter().skip(1).map(|body| body.name.as_str()).collect();
    match &args.body {
        Some(name) => bodies.iter().position(|body| body.name == *name).ok_or_else(|| {
            let help = bksim::model::file::suggest(name, &names);
            Failure::usage(format!("the model has no body `{name}`"), &help)
        }),
        None if names.len() == 1 => Ok(1),
        None => {
            let help = format!("choose one with --body: {}", names.join(", "));
            Err(Failure::usage("the loads of an .inp file are those of one body", &help))
        }
    }
}

/// The instants of a case: those that are asked for, and where a force on the body is largest, each with the reason.
fn instants(
    case: &CaseRun,
    bearings: &[usize],
    args: &Sheet,
) -> Result<Vec<(f64, String)>, Failure> {
    let [first, last] = case.report.span;
    let mut found: Vec<(f64, String)> = Vec::new();
    for &t in &args.at {
        if !(first.min(last)..=first.max(last)).contains(&t) {
            let help = format!("the motion goes from {first} s to {last} s");
            return Err(Failure::usage(format!("`--at {t}` is outside of the motion"), &help));
        }
        found.push((t, "as asked for".to_owned()));
    }
    let near = 1e-6 * (last - first).abs();
    for &bearing in bearings {
        let one = &case.report.reactions[bearing];
        let why = format!("largest force of {}", one.name);
        match found.iter_mut().find(|(t, _)| (t - one.force.t).abs() <= near) {
            Some((_, known)) => *known = format!("{known}, {why}"),
            None => found.push((one.force.t, why)),
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(found)
}
