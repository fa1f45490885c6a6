//! All loads of one body as steps of CalculiX: `*CLOAD` cards at the instants of the largest forces.
//!
//! The cards are about a body that is cut free, in its own axes: reactions of joints, weight, applied loads, contacts and, by
//! d'Alembert, its inertia, each at a node set of its own. Together they are in balance, and a file whose loads are not says so.

use std::fmt::Write as _;

use bksim::Mechanism;
use bksim::model::{BodyId, GROUND, Model};
use bksim::report::six_digits;
use bksim::sim::free_body::{FreeBody, Origin};
use bksim::sim::pose::Pose;
use bksim::sim::run::Sample;
use bksim::sim::wrenches::WrenchAt;
use bksim_cli::args::sheet::Sheet;
use bksim_cli::exit::Failure;
use bksim_cli::output::number;
use bksim_cli::source::logged::unplayable;

use super::{CaseRun, Runs};

/// Part of the largest load that the sum of all may be and still be rounding.
const BALANCED: f64 = 1e-6;

/// Everything on a body, by node set.
struct Body {
    free: FreeBody,
    /// The node set of each part that acts on it.
    sets: Vec<String>,
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
        let free = FreeBody::compile(mechanism, BodyId(body))?;
        let sets = free.origins().map(|origin| set_of(&mechanism.model, origin)).collect();
        Ok(Self { free, sets })
    }

    /// The loads at a sample, in world axes, by node set.
    fn at(&mut self, sample: &Sample, modes: &[f64]) -> Vec<(String, WrenchAt)> {
        let mut found: Vec<(String, WrenchAt)> = Vec::new();
        for (set, wrench) in self.sets.iter().zip(self.free.at(sample, modes)) {
            match found.iter_mut().find(|(known, _)| known == set) {
                // Weight and inertia act in one point.
                Some((_, sum)) => *sum = WrenchAt::sum(&[*sum, wrench], 1),
                None => found.push((set.clone(), wrench)),
            }
        }
        found
    }
}

/// The node set of what acts on a body.
fn set_of(model: &Model, origin: Origin) -> String {
    match (origin, origin.named(model)) {
        (Origin::Inertia, _) => "MASS".to_owned(),
        (Origin::Joint(_), (_, name)) => format!("PIN_{name}"),
        _ if origin.is_gravity(model) => "MASS".to_owned(),
        (_, (kind, name)) => format!("{}_{name}", kind.to_uppercase()),
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
