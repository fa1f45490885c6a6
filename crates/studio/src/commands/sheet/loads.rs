//! Pin forces of one body as steps of CalculiX: `*CLOAD` cards at the instants of the largest forces.
//!
//! The cards are about a body that is cut free, in its own axes: forces and moments of its joints, turned into these. Its
//! weight, other loads and its inertia are not among them.

use std::fmt::Write as _;

use bksim::report::six_digits;
use bksim_cli::args::sheet::Sheet;
use bksim_cli::exit::Failure;
use bksim_cli::source::logged::unplayable;

use super::{CaseRun, Runs};

/// The text of the file.
pub(super) fn of(runs: &mut Runs, args: &Sheet) -> Result<String, Failure> {
    let body = body(runs, args)?;
    let model = &runs.cases[0].show.playback().mechanism().model;
    let name = model.bodies[body].name.clone();
    let joints: Vec<usize> = (0..model.joints.len())
        .filter(|&idx| {
            let joint = &model.joints[idx];
            joint.predecessor.body.0 == body || joint.successor.body.0 == body
        })
        .collect();
    let (force, moment) = (runs.units.of("N"), runs.units.of("N*m"));
    let mut out = format!(
        "** Loads of `{name}` in the axes of its own frame, forces in {}, moments in {}.\n\
         ** The node set PIN_A, of one node with six freedoms that the surface of the pin is tied to, bears joint `A`.\n\
         ** Its weight, other loads on it and its inertia are not among these loads.\n",
        force.unit, moment.unit
    );
    for case in &mut runs.cases {
        for (t, why) in instants(case, &joints, args)? {
            let unreplayed = |e| unplayable(&args.run.input, "reported", &e);
            let reactions = case.show.seek(t).map_err(unreplayed)?.reactions.clone();
            let pose = case.show.poses()[body];
            let mechanism = case.show.playback().mechanism();
            let model = &mechanism.model;
            let of_case =
                if case.name.is_empty() { String::new() } else { format!(", case {}", case.name) };
            // Writing to a text does not fail.
            let _ = write!(
                out,
                "**\n** t = {} s{of_case}: {why}\n*STEP\n*STATIC\n*CLOAD, OP=NEW\n",
                six_digits(t, t.abs().max(1e-9))
            );
            let size = |r: &[f64]| r[0].hypot(r[1]).hypot(r[2]);
            let of_body = joints.iter().map(|&joint| &reactions[joint]);
            let scales = [
                of_body.clone().map(|r| size(&r[..3])).fold(0.0, f64::max),
                of_body.map(|r| size(&r[3..])).fold(0.0, f64::max),
            ];
            for &joint in &joints {
                // A reaction is that on the second body.
                let sign = if model.joints[joint].successor.body.0 == body { 1.0 } else { -1.0 };
                let r = reactions[joint].map(|x| sign * x);
                let halves = [[r[0], r[1], r[2]], [r[3], r[4], r[5]]];
                for (half, (world, unit)) in halves.into_iter().zip([&force, &moment]).enumerate() {
                    for axis in 0..3 {
                        let own: f64 =
                            (0..3).map(|i| pose.r_world_from_body[i][axis] * world[i]).sum();
                        let floor =
                            if half == 0 { scales[0] } else { scales[1].max(1e-9 * scales[0]) };
                        let value = six_digits(unit.of_si(own), unit.of_si(floor));
                        if value != 0.0 {
                            let freedom = 3 * half + axis + 1;
                            let _ = writeln!(
                                out,
                                "PIN_{}, {freedom}, {value}",
                                model.joints[joint].name
                            );
                        }
                    }
                }
            }
            out += "*END STEP\n";
        }
    }
    Ok(out)
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
fn instants(case: &CaseRun, joints: &[usize], args: &Sheet) -> Result<Vec<(f64, String)>, Failure> {
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
    for &joint in joints {
        let one = &case.report.reactions[joint];
        let why = format!("largest force of joint {}", one.name);
        match found.iter_mut().find(|(t, _)| (t - one.force.t).abs() <= near) {
            Some((_, known)) => *known = format!("{known}, {why}"),
            None => found.push((one.force.t, why)),
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(found)
}
