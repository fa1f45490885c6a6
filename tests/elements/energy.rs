//! Energy audits: the work of every load, belt and drive by itself, and what becomes of it.

use crate::support::elements::reference;
use crate::support::{Measures, Within, at, close, derive, elements, example_text, model, solve};
use bksim::report::{Report, report};
use bksim::solved;
use serde_json::Value;

/// The report of a run of a model.
fn audited(text: &str) -> Report {
    let solved = solved::solve(derive(model(text)), text, &|_| true);
    let mut solved = solved.unwrap_or_else(|e| panic!("{e}"));
    assert!(solved.fault.is_none(), "{:?}", solved.fault);
    report(&mut solved.playback).expect("a report")
}

/// Work and stored energy of a part.
fn part(report: &Report, name: &str) -> [f64; 2] {
    let found = report.work.iter().find(|part| part.name == name);
    let found = found.unwrap_or_else(|| panic!("no `{name}` in {:?}", report.work));
    [found.work, found.stored]
}

/// The works of all parts and impacts are the change of the energy, and without impacts the work of the run; the largest
/// work is the scale.
fn is_closed(what: &str, report: &Report, within: f64) {
    let sum: f64 = report.work.iter().map(|part| part.work).sum();
    let scale = report.work.iter().fold(0.0, |most: f64, part| most.max(part.work.abs()));
    let absolute = |within: f64| Within { relative: 0.0, absolute: within * scale };
    let [first, last] = report.energy.total;
    let impacts: Vec<f64> =
        report.work.iter().filter(|part| part.kind == "impact").map(|part| part.work).collect();
    close(what, sum - impacts.iter().sum::<f64>(), report.energy.work, absolute(1e-12));
    close(what, sum, last - first, absolute(within));
}

/// The gas does ∮ F dx over the table, the brake takes its torque times both turns of the crank.
#[test]
fn a_single_cylinder_engine() {
    let found = audited(&elements::text("engine"));
    let data = reference("elements/engine_gas_table");
    let table: Vec<[f64; 2]> = data["model"]["table_deg_N"]
        .as_array()
        .expect("rows")
        .iter()
        .map(|row| [0, 1].map(|k: usize| row[k].as_f64().expect("a number")))
        .collect();
    let turned = found.motions.iter().find(|motion| motion.name == "O.angle");
    let turned = turned.expect("the crank").stroke();

    // Simpson's rule between the rows: the force is straight there.
    let (r, l) = (0.04_f64, 0.14_f64);
    let slope = |phi: f64| {
        let (sin, cos) = phi.sin_cos();
        -r * sin - r * r * sin * cos / (l * l - r * r * sin * sin).sqrt()
    };
    let mut gas = 0.0;
    for rows in table.windows(2) {
        let [from, to] = [rows[0], rows[1]].map(|row| row[0].to_radians());
        let to_end = turned.min(to);
        let force = |phi: f64| rows[0][1] + (rows[1][1] - rows[0][1]) * (phi - from) / (to - from);
        let n = 200;
        let h = (to_end - from) / f64::from(n);
        let at = |k: i32| -force(from + h * f64::from(k)) * slope(from + h * f64::from(k));
        gas += (0..n / 2)
            .map(|k| (at(2 * k) + 4.0 * at(2 * k + 1) + at(2 * k + 2)) * h / 3.0)
            .sum::<f64>();
    }
    assert!(gas > 90.0, "{gas} J");
    let within = Within { relative: 1e-9, absolute: 1e-9 };
    close("gas", part(&found, "gas")[0], gas, within);
    close("brake", part(&found, "brake")[0], -18.0 * turned, within);
    is_closed("engine", &found, 1e-9);
}

/// The example with the dimensions of Modelica's Engine1b: the speed at the end is that of an integration of the crank
/// alone, by SciPy's DOP853 to 1e-12 with the same tables, 137.0896418; with the polynomials that they are taken
/// from it is 137.0899.
#[test]
fn the_engine_of_another_library() {
    let text = example_text("engine");
    let found = audited(&text);
    is_closed("engine", &found, 1e-8);
    let gas = part(&found, "gas")[0];
    let [first, last] = found.energy.total;
    close("gas", gas, last - first, Within { relative: 1e-8, absolute: 0.0 });
    let rate = found.motions.iter().find(|motion| motion.name == "O.angle").expect("the crank");
    close("turned", rate.limits[1].value, 42.600_595_88, Within { relative: 0.0, absolute: 1e-6 });

    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let last = motion.samples.last().expect("the end");
    let speed = Measures::new(&mechanism, &["O.rate"]).at(last)[0];
    close("speed", speed, 137.089_641_84, Within { relative: 0.0, absolute: 1e-5 });
}

/// Motor, clutch, brake and work piece of a press: the piece takes its force times its way.
#[test]
fn an_eccentric_press() {
    let found = audited(&example_text("eccentric-press"));
    is_closed("press", &found, 1e-7);
    close("piece", part(&found, "piece")[0], -2250.0, Within { relative: 1e-7, absolute: 0.0 });
    // What slides takes energy.
    for friction in ["clutch_clutch", "clutch_brake"] {
        assert!(part(&found, friction)[0] < -1.0, "{:?}", found.work);
    }
    let motor = part(&found, "motor_drive")[0];
    assert!(motor > 15e3, "{motor} J");
}

/// A ball falls, bounces and comes to rest: an impact at the speed u takes ½ m u² (1 − ε²), and all of them the height.
#[test]
fn a_ball_that_bounces() {
    let text = "[bodies.ball]\nmass = 2\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"ball\"]\n\
         axis = [0, 1]\n[loads.weight]\ntype = \"gravity\"\nacceleration = [0, -10]\n\
         [loads.floor]\ntype = \"stop\"\njoint = \"S\"\nmin = 0\nrestitution = 0.6\n\
         [initial]\nS = { position = 0.8, velocity = 0 }\n\
         [solve]\nt_end = 1\nrtol = 1e-11\natol = 1e-12\n";
    let lost = |t_end: &str| {
        let found = audited(&text.replace("t_end = 1", t_end));
        is_closed(t_end, &found, 1e-10);
        part(&found, "impacts")[0]
    };
    let within = Within { relative: 0.0, absolute: 1e-8 };
    // It falls for 0.4 s, then flies for 0.48 s.
    close("one impact", lost("t_end = 0.7"), -16.0 * (1.0 - 0.36), within);
    close("two impacts", lost("t_end = 1"), -16.0 * (1.0 - 0.36_f64.powi(2)), within);
    close("at rest", lost("t_end = 3"), -16.0, within);
    // A run without impacts has no such row.
    let found = audited(&text.replace("t_end = 1", "t_end = 0.3"));
    assert!(found.work.iter().all(|part| part.kind != "impact"), "{:?}", found.work);
}

/// A valve that floats lands on its cam, whose drive takes part in the impact; the ram of a press runs into a stop.
#[test]
fn impacts_of_machines() {
    let found = audited(&example_text("valve-train"));
    assert!(part(&found, "impacts")[0] != 0.0, "{:?}", found.work);
    is_closed("valve train", &found, 1e-6);

    let block =
        "[loads.block]\ntype = \"stop\"\njoint = \"guide\"\nmin = \"h - r - l\"\n\n[solve]\n";
    let pressed = example_text("eccentric-press").replace("[solve]\n", block);
    let pressed = pressed.replace("t_end = \"5 s\"", "t_end = \"3.3 s\"");
    let found = audited(&pressed);
    assert!(part(&found, "impacts")[0] < -1.0, "{:?}", found.work);
    is_closed("a press that is stopped", &found, 1e-7);
}

/// A block of 2 kg on a spring with a damper, pushed, with dry friction, and pulled by a drive: every work in closed
/// form or by the others.
#[test]
fn every_kind_of_part_has_its_own_work() {
    // x = 0.3 m/s t for a second, against k x, c v, F and the push.
    let text = "[bodies.block]\nmass = 2\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"block\"]\n\
         axis = [0.6, 0.8]\n[drives.pull]\njoint = \"S\"\nmotion = \"0.3*t\"\n\
         [loads.spring]\ntype = \"spring\"\njoint = \"S\"\nstiffness = 50\nlength = 0\ndamping = 4\n\
         [loads.push]\ntype = \"force\"\non = \"block\"\nvector = [\"5 N/s*t\", 0]\n\
         [loads.weight]\ntype = \"gravity\"\nacceleration = [0, -10]\n\
         [loads.rub]\ntype = \"friction\"\njoint = \"S\"\nforce = 3\n\
         [solve]\nt_end = 1\nrtol = 1e-11\natol = 1e-12\n";
    let found = audited(text);
    let within = Within { relative: 0.0, absolute: 1e-10 };
    let expected = [
        ("spring", [-4.0 * 0.09, 0.5 * 50.0 * 0.09]),
        ("push", [0.6 * 0.3 * 5.0 * 0.5, 0.0]),
        ("weight", [0.0, 2.0 * 10.0 * 0.8 * 0.3]),
        ("rub", [-3.0 * 0.3, 0.0]),
    ];
    for (name, both) in expected {
        let [work, stored] = part(&found, name);
        close(name, work, both[0], within);
        close(name, stored, both[1], within);
    }
    let stored: f64 = expected.iter().map(|(_, [_, stored])| stored).sum();
    let others: f64 = expected.iter().map(|(_, [work, _])| work).sum();
    close("pull", part(&found, "pull")[0], stored - others, within);
    is_closed("block", &found, 1e-10);
    // A block that slides to rest loses all to friction.
    let free = text
        .replace("[drives.pull]\njoint = \"S\"\nmotion = \"0.3*t\"\n", "")
        .replace("stiffness = 50\n", "stiffness = 0.0001\n")
        .replace("5 N/s*t", "0 N")
        + "[initial]\nS = { position = 0, velocity = 1 }\n";
    let found = audited(&free.replace("acceleration = [0, -10]", "acceleration = [0, -0.1]"));
    is_closed("a block that comes to rest", &found, 1e-9);
    assert!(part(&found, "rub")[0] < -0.5, "{:?}", found.work);
}

/// Belts that stretch, controllers with ticks, contacts, friction by reactions: the parts' works are the whole.
#[test]
fn the_works_of_parts_are_the_work_of_the_run() {
    for name in ["winch", "belt-drive", "screw-jack", "quarter-car", "governor"] {
        let found = audited(&example_text(name));
        let sum: f64 = found.work.iter().map(|part| part.work).sum();
        let scale = found.work.iter().fold(found.energy.kinetic.value, |most: f64, part| {
            most.max(part.work.abs()).max(part.stored.abs())
        });
        let within = Within { relative: 0.0, absolute: 1e-10 * scale };
        close(name, sum, found.energy.work, within);
        assert!(!found.work.is_empty(), "{name}");
    }
    let belt = audited(&example_text("belt-drive"));
    assert!(belt.work.iter().any(|part| part.kind != "load"), "{:?}", belt.work);
    let rows: Vec<Value> = bksim::report::json_of(&belt)["work"].as_array().expect("rows").clone();
    assert_eq!(rows.len(), belt.work.len());
}

/// Rotors in joints keep the energy, and move alike where their joint is in the tree and where it is cut.
#[test]
fn rotors_of_joints_keep_the_energy() {
    let arm = |axis: &str, cut: bool| {
        let cut = if cut { "cut = true\n" } else { "" };
        format!(
            "space = \"spatial\"\n[bodies.upper]\nmass = 2\ncom = [0.3, 0, 0]\ninertia = [0.02, 0.1, 0.1]\n\
             points = {{ B = [0.6, 0, 0] }}\n[bodies.lower]\nmass = 1\ncom = [0.2, 0.05, 0]\n\
             inertia = [0.01, 0.03, 0.03]\n[joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"upper\"]\n\
             axis = [0, 1, 0]\narmature = 0.4\n[joints.B]\ntype = \"revolute\"\n\
             between = [\"upper.B\", \"lower\"]\naxis = {axis}\narmature = \"0.05 kg m^2\"\n{cut}\
             [loads.weight]\ntype = \"gravity\"\nacceleration = [0, 0, -9.81]\n\
             [solve]\nt_end = 1\nrtol = 1e-10\natol = 1e-11\n"
        )
    };
    for axis in ["[0, 1, 0]", "[0.3, 0.8, 0.5]"] {
        let [whole, cut] = [false, true].map(|cut| audited(&arm(axis, cut)));
        for (what, found) in [("in the tree", &whole), ("cut", &cut)] {
            let [first, last] = found.energy.total;
            close(what, last, first, Within { relative: 0.0, absolute: 1e-8 });
        }
        let within = Within { relative: 1e-7, absolute: 0.0 };
        close(
            "largest kinetic energy",
            cut.energy.kinetic.value,
            whole.energy.kinetic.value,
            within,
        );
    }
    // Of a block on a slope only the rotor's inertia counts, not its weight: a = m g/(m + a).
    let block = "[bodies.block]\nmass = 2\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"block\"]\n\
         axis = [0, -1]\narmature = \"3 kg\"\n[loads.weight]\ntype = \"gravity\"\nacceleration = [0, -10]\n\
         [solve]\nt_end = 1\n";
    let found = audited(block);
    // v = 4 m/s, and half of 5 kg v².
    let within = Within { relative: 1e-9, absolute: 0.0 };
    close("kinetic energy", found.energy.kinetic.value, 40.0, within);
}

/// A pendulum of 1 kg, 0.5 m from its pin, that a drive turns.
fn driven_pendulum(motion: &str, end: &str) -> String {
    format!(
        "[bodies]\nbob = {{ mass = 1, inertia = 0.02, com = [0.5, 0] }}\n\
         [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"bob\"] }}\n\
         [loads]\ngravity = {{ type = \"gravity\", acceleration = [0, -9.81] }}\n\
         drag = {{ type = \"torque\", joint = \"A\", value = \"-0.1 N m s/rad*A.rate\" }}\n\
         [drives]\nmotor = {{ joint = \"A\", motion = \"{motion}\" }}\n[solve]\nt_end = \"{end}\"\n"
    )
}

/// Where a drive leaves nothing free, steps grow until the weight turns many times in one of them; the work is that of the
/// whole way all the same, at every sample: T = I w²/2, V = m g s sin A, and the drag takes ∫ 0.1 w² dt.
#[test]
fn the_work_of_a_drive_is_that_of_its_whole_way() {
    // Angle, rate, and what the drag has taken.
    type Law = fn(f64) -> [f64; 3];
    let even: Law = |t| [50.0 * t, 50.0, 0.1 * 2500.0 * t];
    let swing: Law = |t| {
        let taken = 0.1 * 32_400.0 * (0.5 * t + (4.0 * t).sin() / 8.0);
        [90.0 * (2.0 * t).sin(), 180.0 * (2.0 * t).cos(), taken]
    };
    for method in ["explicit", "radau"] {
        for (motion, law) in [("50 rad/s*t", even), ("90 rad*sin(2 rad/s*t)", swing)] {
            let text = driven_pendulum(motion, "1 s") + &format!("method = \"{method}\"\n");
            let run = solve(&derive(model(&text)));
            let energy = |t: f64| {
                let [angle, rate, _] = law(t);
                0.5 * 0.27 * rate * rate + 9.81 * 0.5 * angle.sin()
            };
            // The drag goes out, and as much comes in.
            let scale = law(1.0)[2];
            let found = run.summary.energy.scale;
            assert!(
                (scale..10.0 * scale).contains(&found),
                "{found} J in and out, {scale} J of drag"
            );
            for sample in &run.samples {
                let work = energy(sample.t) - energy(0.0);
                let within = Within { relative: 0.0, absolute: 2e-6 * scale };
                close(&format!("{motion}, {method}, t = {}", sample.t), sample.work, work, within);
            }
            let error = run.summary.energy.worst_error;
            assert!(error < 2e-6 * scale, "{motion}, {method}: {error} J of {scale} J");
        }
    }
}

/// A drive that sets off and stops at once does ½ m v² at each corner, and m a v between.
#[test]
fn the_work_of_a_drive_goes_past_its_corners() {
    let text = "[bodies]\nslide = { mass = 2 }\n\
         [joints]\nS = { type = \"prismatic\", between = [\"ground\", \"slide\"], axis = [1, 0] }\n\
         [loads]\nbrake = { type = \"force\", joint = \"S\", value = \"-3 N*sign(S.velocity)\" }\n\
         [drives]\nfeed = { joint = \"S\", motion = \"if(t < 0.3 s, 0 m, if(t < 0.8 s, 2 m/s*(t - 0.3 s), 1 m))\" }\n\
         [solve]\nt_end = 1\n";
    let run = solve(&derive(model(text)));
    let energy = run.summary.energy;
    let within = Within { relative: 1e-9, absolute: 1e-9 };
    // Up with 4 J and down again: the drive takes back what it gave, and the brake what lies between.
    close("work at the end", energy.work, 0.0, within);
    close("while it moves", at(&run, 0.6).work, 4.0, within);
    assert!(energy.worst_error < 1e-9, "{energy:?}");
}

/// A drive against a damper without masses: 10 kJ go in and out, and what rounding leaves of them is no fault.
#[test]
fn what_goes_through_a_mechanism_without_masses_is_the_scale_of_its_balance() {
    let text = "[bodies]\nslide = { mass = 0 }\n\
         [joints]\nS = { type = \"prismatic\", between = [\"ground\", \"slide\"], axis = [1, 0] }\n\
         [loads]\ndamper = { type = \"damper\", joint = \"S\", damping = \"1e4 N s/m\" }\n\
         [drives]\nfeed = { joint = \"S\", motion = \"0.1 m*sin(10 rad/s*t)\" }\n\
         [solve]\nt_end = 2\n";
    for method in ["auto", "radau"] {
        let mechanism = derive(model(&(text.to_owned() + &format!("method = \"{method}\"\n"))));
        let run = solve(&mechanism);
        let options = &mechanism.model.solve;
        let energy = run.summary.energy;
        // ∫ c x′² dt, by samples.
        let through = 1e4 * 0.5 * (2.0 + (40.0_f64).sin() / 20.0);
        close("through", energy.scale, through, Within { relative: 1e-3, absolute: 0.0 });
        let promised = run.summary.promised_energy_error(options);
        assert!(energy.worst_error < promised, "{method}: {energy:?}, {promised} J");
    }
}
