//! Every kind of load against a motion known in closed form, in relative and absolute coordinates.

use crate::support::{Probe, Within, close, derive, model, signal, solve};
use bksim::model::CoordinatePolicy;

/// A mechanism, a measure in relative and in absolute coordinates, and its value by hand.
struct Case {
    what: &'static str,
    text: &'static str,
    relative: &'static str,
    absolute: &'static str,
    value: fn(f64) -> f64,
}

/// A flywheel of 0.5 kg m² on the ground, and a second of 0.2 kg m² on the first.
const WHEELS: &str = include_str!("../fixtures/two-wheels.toml");

/// Two sliders of 2 kg and 3 kg on one line, 1 m apart.
const SLIDERS: &str = include_str!("../fixtures/two-sliders.toml");

const CASES: [Case; 10] = [
    Case {
        what: "a force that follows its body turns it evenly faster",
        text: "[loads.F]\ntype = \"force\"\non = \"one.P\"\naxes = \"body\"\nvector = [\"7 N\", \"5 N\"]",
        relative: "A_angle",
        absolute: "one_angle",
        value: |t| 0.5 * (5.0 * 0.4 / 0.5) * t * t,
    },
    Case {
        what: "a torque between two bodies turns the one",
        text: "[loads.M]\ntype = \"torque\"\non = \"two\"\nfrom = \"one\"\nvalue = \"3 N m\"",
        relative: "A_angle + B_angle",
        absolute: "two_angle",
        value: |t| 0.5 * (3.0 / 0.2) * t * t,
    },
    Case {
        what: "and turns the other back",
        text: "[loads.M]\ntype = \"torque\"\njoint = \"B\"\nvalue = \"3 N m\"",
        relative: "A_angle",
        absolute: "one_angle",
        value: |t| -0.5 * (3.0 / 0.5) * t * t,
    },
    Case {
        what: "a torque of time",
        text: "[loads.M]\ntype = \"torque\"\non = \"one\"\nvalue = \"2 N m * sin(3 rad/s * t)\"",
        relative: "A_angle",
        absolute: "one_angle",
        value: |t| 2.0 / 0.5 * (t / 3.0 - (3.0 * t).sin() / 9.0),
    },
    Case {
        what: "a torque of the rate: a brake",
        text: "[loads.M]\ntype = \"torque\"\non = \"one\"\nvalue = \"1 N m - 0.5 N m s * A.rate\"",
        relative: "A_angle",
        absolute: "one_angle",
        value: |t| 2.0 * (t - 1.0 + (-t).exp()),
    },
    Case {
        what: "a torsion spring swings a wheel",
        text: "[loads.K]\ntype = \"torsion\"\njoint = \"A\"\nstiffness = \"8 N m\"\nangle = \"0.5 rad\"",
        relative: "A_angle",
        absolute: "one_angle",
        value: |t| 0.5 * (1.0 - (4.0 * t).cos()),
    },
    Case {
        what: "a force between two points pushes them apart",
        text: "[loads.F]\ntype = \"force\"\nbetween = [\"one\", \"two\"]\nvalue = \"6 N\"",
        relative: "B_position",
        absolute: "two_x",
        value: |t| 1.0 + 0.5 * 2.0 * t * t,
    },
    Case {
        what: "and the other the other way",
        text: "[loads.F]\ntype = \"force\"\nbetween = [\"one\", \"two\"]\nvalue = \"6 N\"",
        relative: "A_position",
        absolute: "one_x",
        value: |t| -0.5 * 3.0 * t * t,
    },
    Case {
        // Reduced mass 1.2 kg, ω = √(k/μ) = 5; 0.2 m shorter than unloaded.
        what: "a spring between two sliders",
        text: "[loads.S]\ntype = \"spring\"\nbetween = [\"one\", \"two\"]\nstiffness = \"30 N/m\"\nlength = \"1.2 m\"",
        relative: "B_position - A_position",
        absolute: "two_x - one_x",
        value: |t| 1.2 - 0.2 * (5.0 * t).cos(),
    },
    Case {
        // A push of 3 N on the second slider; c/μ = 2 per second.
        what: "a damper between two sliders",
        text: "[loads.D]\ntype = \"damper\"\nbetween = [\"one\", \"two\"]\ndamping = \"2.4 N s/m\"\n\
               [loads.F]\ntype = \"force\"\non = \"two\"\nvector = [\"3 N\", 0]",
        relative: "B_position - A_position",
        absolute: "two_x - one_x",
        // Relative motion: s″ = F/3 − c s′/μ.
        value: |t| 1.0 + 0.5 * (t - 0.5 * (1.0 - (-2.0 * t).exp())),
    },
];

#[test]
fn every_load_moves_as_its_closed_form() {
    for case in &CASES {
        let base = if case.relative.contains("position") { SLIDERS } else { WHEELS };
        let text = format!("{base}\n{}\n", case.text);
        for (policy, measure) in [
            (CoordinatePolicy::Relative, case.relative),
            (CoordinatePolicy::Absolute, case.absolute),
        ] {
            let mut model = model(&text);
            model.coordinates = policy;
            (model.solve.rtol, model.solve.atol) = (1e-10, 1e-11);
            (model.solve.t_end, model.solve.every) = (1.0, Some(0.05));
            let mechanism = derive(model);
            let probe = Probe::new(&mechanism, &[measure]);
            let motion = solve(&mechanism);
            for sample in &motion.samples {
                let what = format!("{}, {policy:?}, t = {:.2}", case.what, sample.t);
                let within = Within { relative: 1e-9, absolute: 1e-9 };
                close(&what, probe.at(sample)[0][0], (case.value)(sample.t), within);
            }
            let balance = &motion.summary.energy;
            let error = balance.worst_error / balance.scale;
            assert!(error < 1e-9, "{}, {policy:?}: energy off by {error:.1e}", case.what);
        }
    }
}

/// A spring with a damper and a force between two points, in the results of their own motion.
#[test]
fn springs_and_forces_between_points_are_results_by_name() {
    let text = "[ground]\npoints = { O = [0, 0] }\n[bodies.bob]\nmass = 2\n\
                [joints.S]\ntype = \"prismatic\"\nbetween = [\"ground.O\", \"bob\"]\naxis = [1, 0]\n\
                [loads.strut]\ntype = \"spring\"\nbetween = [\"ground.O\", \"bob\"]\n\
                stiffness = 50\nlength = \"0.4 m\"\ndamping = 3\n\
                [loads.push]\ntype = \"force\"\nbetween = [\"ground.O\", \"bob\"]\nvalue = \"4*cos(t/(1 s))\"\n\
                [initial]\nS = { position = 0.5, velocity = 0.2 }\n\
                [outputs]\nforce = \"loads.strut.force\"\nlength = \"loads.strut.length\"\n\
                rate = \"loads.strut.rate\"\npush = \"loads.push.force\"\n[solve]\nt_end = 0.5\nevery = 0.25\n";
    let mechanism = derive(model(text));
    let within = Within { relative: 1e-12, absolute: 1e-12 };
    for sample in &solve(&mechanism).samples {
        let [x, v] = [sample.q[0], sample.v[0]];
        let value = |name| signal(&mechanism, sample, name);
        close("force", value("force"), 50.0 * (x - 0.4) + 3.0 * v, within);
        close("length", value("length"), x, within);
        close("rate", value("rate"), v, within);
        close("push", value("push"), -4.0 * sample.t.cos(), within);
    }
}
