//! Efforts against friction and stops: those of a run, and ranges at rest.

use crate::support::{difference, model};
use bksim_analysis::{Actuators, AnalysisError, Inverse, Motion, Part, Range, exported, inverse};
use bksim_dae::Control;
use bksim_mbs::constraint::Source as RowSource;
use bksim_model::file::{Source, read};
use bksim_model::{Model, Outputs};
use bksim_sim::Mechanism;
use bksim_sim::run::{Observer, Sample, StateSensitivity};

#[derive(Default)]
struct Samples(Vec<Sample>);

impl Observer for Samples {
    fn sample(&mut self, sample: &Sample, _: &[StateSensitivity]) -> Control {
        // Where a run has an event the later sample goes on.
        if self.0.last().is_some_and(|last| last.t == sample.t) {
            self.0.pop();
        }
        self.0.push(sample.clone());
        Control::Continue
    }
}

/// Efforts of all drives and reactions of all joints in a run at these times, under the names of columns.
fn of_run(model: Model, times: &Range) -> Vec<(String, Vec<f64>)> {
    let mechanism = Mechanism::derive(model, Vec::new()).expect("equations");
    let mut simulation = mechanism.simulation().expect("a simulation");
    let mut options = simulation.options().clone();
    (options.t_end, options.outputs) = (times.to, Outputs::Times(times.values()));
    simulation.set_options(&options);
    let mut samples = Samples::default();
    let start = simulation.start().expect("a start");
    simulation.run(&start, &mut samples, &|| false).expect("a run");
    let samples: Vec<Sample> =
        samples.0.into_iter().filter(|s| times.values().contains(&s.t)).collect();
    assert_eq!(samples.len(), times.n);
    let mut columns = Vec::new();
    for (k, drive) in mechanism.model.drives.iter().enumerate() {
        let rows = mechanism.system.constraints.iter();
        let row = rows.clone().position(|r| matches!(r.source, RowSource::Drive(id) if id.0 == k));
        let row = row.expect("a row of the drive");
        let own = samples.iter().map(|sample| sample.lambda[row]).collect();
        columns.push((format!("{}.effort", drive.name), own));
    }
    for (k, joint) in mechanism.model.joints.iter().enumerate() {
        for (component, word) in ["fx", "fy", "fz", "mx", "my", "mz"].into_iter().enumerate() {
            let own = samples.iter().map(|sample| sample.reactions[k][component]).collect();
            columns.push((format!("{}.{word}", joint.name), own));
        }
    }
    columns
}

/// Compares the efforts of a model's drives, and its reactions, with those of its run, to this part of the largest of their unit.
pub(super) fn needs_what_a_run_takes(text: &str, times: &Range) -> Inverse {
    let found = inverse(model(text), &[], times, &Actuators::default());
    let found = found.unwrap_or_else(|fault| panic!("{text}: {:?}", fault.diagnostics()));
    let run = of_run(model(text), times);
    for is_effort in [true, false] {
        let own: Vec<_> =
            run.iter().filter(|(name, _)| name.ends_with(".effort") == is_effort).collect();
        let size = own.iter().flat_map(|(_, of)| of).fold(0.0, |most: f64, x| most.max(x.abs()));
        for (name, expected) in own {
            let Some(values) = found.table.column(name) else { continue };
            for (k, (a, b)) in values.iter().zip(expected).enumerate() {
                // Beside what is rounding where nothing is borne.
                let off = (a - b).abs();
                assert!(off < 1e-8 * size + 1e-12, "{name} at row {k}: {a} instead of {b}");
            }
        }
    }
    found
}

pub(super) fn column(found: &Inverse, name: &str) -> Vec<f64> {
    found.table.column(name).unwrap_or_else(|| panic!("no {name} in {:?}", found.table.columns))
}

pub(super) fn refusal(found: Result<Inverse, AnalysisError>) -> (String, String, String) {
    let fault = found.expect_err("a refusal").diagnostics()[0].clone();
    (fault.code.0.to_owned(), fault.message, fault.help.unwrap_or_default())
}

/// A slider-crank whose block, pins and crank rub.
const SLIDER_CRANK: &str = r#"
    [bodies.crank]
    mass = "0 kg"
    points = { O = [0, 0], A = [0.2, 0] }
    [bodies.rod]
    mass = "0.5 kg"
    com = [0.1, 0]
    inertia = "0.5 kg*(0.2 m)^2/12"
    points = { A = [0, 0], B = [0.2, 0] }
    [bodies.block]
    mass = "0.1 kg"
    [joints]
    O = { type = "revolute", between = ["ground", "crank.O"] }
    A = { type = "revolute", between = ["crank.A", "rod.A"] }
    B = { type = "revolute", between = ["rod.B", "block"] }
    guide = { type = "prismatic", between = ["ground", "block"], axis = [1, 0] }
    [loads]
    gravity = { type = "gravity", acceleration = [0, "-9.81 m/s^2"] }
    rub = { type = "friction", joint = "guide", mu = 0.15 }
    [initial]
    O = { angle = "45 deg" }
    guide = { guess = { position = "0.28 m" } }
    [drives.motor]
    joint = "O"
    motion = "45 deg + 60 rpm*t"
    "#;

#[test]
fn a_rubbing_block_takes_what_its_guide_bears() {
    let times = Range { from: 0.0, to: 0.1, n: 11 };
    let found = needs_what_a_run_takes(SLIDER_CRANK, &times);
    let first = |name: &str| column(&found, name)[0];
    assert!((first("motor.effort") - 1.475_923_67).abs() < 1e-8, "{}", first("motor.effort"));
    assert!((first("guide.fy") + 0.558_428_179).abs() < 1e-9, "{}", first("guide.fy"));
}

#[test]
fn friction_of_every_kind_is_that_of_a_run() {
    let pins = "\n[loads.rub_A]\ntype = \"friction\"\njoint = \"A\"\nmu = 0.1\nradius = \"8 mm\"\n\
                [loads.rub_O]\ntype = \"friction\"\njoint = \"O\"\ntorque = \"0.2 N m\"\nstatic = \"0.3 N m\"\n";
    let times = Range { from: 0.003, to: 0.4, n: 17 };
    // A longer rod, so that nothing jams.
    let long = SLIDER_CRANK.replace("com = [0.1, 0]", "com = [0.25, 0]");
    let long = long.replace("B = [0.2, 0]", "B = [0.5, 0]").replace("\"0.28 m\"", "\"0.6 m\"");
    needs_what_a_run_takes(&format!("{long}{pins}"), &times);

    // Both ends of a sleeve.
    let sleeve = long.replace("mu = 0.15 }", "mu = 0.15, static = 0.2, length = \"60 mm\" }");
    needs_what_a_run_takes(&sleeve, &times);

    // A screw, lifted and lowered.
    let jack = r#"
        [bodies.screw]
        mass = "0.9 kg"
        inertia = ["8e-3 kg m^2", "8e-3 kg m^2", "1e-3 kg m^2"]
        [joints.thread]
        type = "screw"
        between = ["ground", "screw"]
        axis = [0, 0, 1]
        lead = "4 mm"
        [loads]
        weight = { type = "force", on = "screw", vector = [0, 0, "-8 kN"] }
        rub = { type = "friction", joint = "thread", mu = 0.12, radius = "10 mm" }
        [drives.handle]
        joint = "thread"
        motion = "2 rad*sin(3 rad/s*t)"
        "#;
    let found = needs_what_a_run_takes(jack, &Range { from: 0.01, to: 1.9, n: 12 });
    // F r tan(ρ ± φ) but for the inertia, by the angles of friction and lead.
    let (lead, friction) = ((0.004_f64 / (std::f64::consts::TAU * 0.01)).atan(), 0.12_f64.atan());
    let up = 8000.0 * 0.01 * (friction + lead).tan();
    let down = -8000.0 * 0.01 * (friction - lead).tan();
    let efforts = column(&found, "handle.effort");
    let rates = column(&found, "handle.rate");
    for (effort, rate) in efforts.iter().zip(&rates) {
        let expected = if *rate > 0.0 { up } else { down };
        assert!((effort - expected).abs() < 0.05, "{effort} instead of {expected}");
    }

    // Teeth, a bead on a track, and a slider on a carrier.
    let gears = r#"
        [bodies]
        one = { mass = 1, inertia = 0.01 }
        two = { mass = 2, inertia = 0.04 }
        [ground.points]
        W = [0.3, 0]
        [joints]
        A = { type = "revolute", between = ["ground", "one"] }
        B = { type = "revolute", between = ["ground.W", "two"] }
        [couplings.mesh]
        type = "gear"
        between = ["A", "B"]
        teeth = [20, 40]
        [loads]
        drag = { type = "torque", on = "two", vector = [0, 0, "-3 N m - 0.2 N m s/rad*B.rate"] }
        rub = { type = "friction", coupling = "mesh", mu = 0.08 }
        [drives.motor]
        joint = "A"
        motion = "4 rad*sin(2 rad/s*t)"
        "#;
    needs_what_a_run_takes(gears, &Range { from: 0.02, to: 2.0, n: 15 });
}

/// A block that is moved evenly, held, and moved on, with 5 N of friction.
fn block(motion: &str, loads: &str) -> String {
    format!(
        "[bodies.block]\nmass = \"2 kg\"\n[joints.S]\ntype = \"prismatic\"\nbetween = [\"ground\", \"block\"]\n\
         axis = [1, 0]\n[drives.motor]\njoint = \"S\"\nmotion = \"{motion}\"\n[loads]\n\
         rub = {{ type = \"friction\", joint = \"S\", force = \"5 N\", static = \"6 N\" }}\n{loads}\n"
    )
}

pub(super) fn efforts(text: &str, times: &Range) -> Inverse {
    inverse(model(text), &[], times, &Actuators::default()).expect("efforts")
}

#[test]
fn friction_of_a_joint_at_rest_is_a_range_of_the_effort() {
    let moved = efforts(&block("0.1 m/s*t", ""), &Range { from: 0.0, to: 1.0, n: 3 });
    assert!(column(&moved, "motor.effort").iter().all(|effort| (effort - 5.0).abs() < 1e-12));
    assert!(moved.open.is_empty() && moved.table.column("motor.effort_min").is_none());

    // It moves for a second, and rests.
    let times = Range { from: 0.0, to: 2.0, n: 5 };
    let slope = "push = { type = \"force\", on = \"block\", vector = [\"-10 N\", 0] }";
    let rests = efforts(&block("if(t < 1 s, 0.1 m/s*t, 0.1 m)", slope), &times);
    let [effort, least, most] =
        ["effort", "effort_min", "effort_max"].map(|word| column(&rests, &format!("motor.{word}")));
    for k in [0, 1] {
        for value in [effort[k], least[k], most[k]] {
            assert!((value - 15.0).abs() < 1e-12, "{value}");
        }
    }
    for k in [3, 4] {
        // 10 N less or more than 6 N; the smallest of these is shown.
        for (value, expected) in [(effort[k], 4.0), (least[k], 4.0), (most[k], 16.0)] {
            assert!((value - expected).abs() < 1e-7, "{value} instead of {expected}");
        }
    }
    assert_eq!(rests.open, ["rub"]);

    // Without a load it needs none.
    let held = efforts(&block("0.1 m", ""), &Range { from: 0.0, to: 1.0, n: 2 });
    let ends =
        ["effort", "effort_min", "effort_max"].map(|w| column(&held, &format!("motor.{w}"))[0]);
    for (value, expected) in ends.into_iter().zip([0.0, -6.0, 6.0]) {
        assert!((value - expected).abs() < 1e-7, "{value} instead of {expected}");
    }
}

#[test]
fn a_start_from_rest_slides_in_the_sense_of_its_acceleration() {
    let found = efforts(&block("0.5 m/s^2*t^2", ""), &Range { from: 0.0, to: 1.0, n: 3 });
    assert!(column(&found, "motor.effort").iter().all(|effort| (effort - 7.0).abs() < 1e-12));
}

#[test]
fn friction_at_rest_by_reactions_bounds_the_effort_by_what_the_guide_bears() {
    // A block on a slope of 30° under its weight and an effort at an angle to its guide: a rod that pushes it.
    let text = SLIDER_CRANK.replace("45 deg + 60 rpm*t", "45 deg");
    let text = text.replace("mu = 0.15", "mu = 0.4");
    let found = efforts(&text, &Range { from: 0.0, to: 1.0, n: 2 });
    let [effort, least, most] = ["effort", "effort_min", "effort_max"]
        .map(|word| column(&found, &format!("motor.{word}"))[0]);
    // By hand: the rod at −45° has its weight W/2 at each end and a force S along it; with the force H of the friction on the
    // block, S cos 45° = H, and the guide bears N = m g + W/2 − S sin 45° = m g + W/2 − H.
    let (weight, block) = (0.5 * 9.81, 0.1 * 9.81);
    let bears = |h: f64| block + 0.5 * weight - h;
    // |H| = μ N: H = μ N, or H = −μ N.
    let one = 0.4 * (block + 0.5 * weight) / 1.4;
    let other = -0.4 * (block + 0.5 * weight) / 0.6;
    assert!((0.4 * bears(one) - one).abs() < 1e-12 && (0.4 * bears(other) + other).abs() < 1e-12);
    // The crank holds the pin A against W/2 down and the rod's force.
    let (arm, root) = (0.2, 0.5_f64.sqrt());
    let torque = |h: f64| arm * (root * 0.5 * weight + root * h + root * h);
    let mut ends = [torque(one), torque(other)];
    ends.sort_by(f64::total_cmp);
    for (value, expected) in [(least, ends[0]), (most, ends[1])] {
        assert!((value - expected).abs() < 1e-7, "{value} instead of {expected}; effort {effort}");
    }
    assert!(least <= effort + 1e-9 && effort <= most + 1e-9);
    let run = of_run(model(&text), &Range { from: 0.0, to: 1.0, n: 2 });
    let of_run = run[0].1[0];
    assert!(least - 1e-9 <= of_run && of_run <= most + 1e-9, "{of_run}");
}

#[test]
fn a_joint_without_an_actuator_may_be_held_by_its_friction() {
    let arm = |torque: &str| {
        model(&format!(
            "[bodies]\nupper = {{ mass = 2, inertia = 0.05, com = [0.25, 0], points = {{ E = [0.5, 0] }} }}\n\
             fore = {{ mass = 1, inertia = 0.02, com = [0.2, 0] }}\n[joints]\n\
             A = {{ type = \"revolute\", between = [\"ground\", \"upper\"] }}\n\
             B = {{ type = \"revolute\", between = [\"upper.E\", \"fore\"] }}\n[loads]\n\
             weight = {{ type = \"gravity\", acceleration = [0, -9.81] }}\n\
             rub = {{ type = \"friction\", joint = \"B\", torque = \"{torque}\" }}\n\
             [drives]\nA = {{ joint = \"A\", motion = \"1 rad/s*t\" }}\nB = {{ joint = \"B\", motion = \"0 rad\" }}\n"
        ))
    };
    let times = Range { from: 0.0, to: 1.0, n: 5 };
    let actuators = Actuators { named: vec!["A".to_owned()], ..Actuators::default() };
    let found = inverse(arm("5 N m"), &[], &times, &actuators).expect("friction holds the joint");
    let both = inverse(arm("0 N m"), &[], &times, &Actuators::default()).expect("two motors");
    let off = difference(&column(&found, "A.effort"), &column(&both, "A.effort"), false);
    assert!(off < 1e-9, "{off}");
    // Too little of it is no actuator.
    let (code, message, help) = refusal(inverse(arm("1 N m"), &[], &times, &actuators));
    assert_eq!(code, "Q016");
    assert!(message.contains("`A`") && message.contains("`B`"), "{message}");
    assert!(help.contains("--actuator A --actuator B"), "{help}");
}

#[test]
fn examples_need_what_their_runs_take() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let mut compared = Vec::new();
    let mut folders: Vec<_> = std::fs::read_dir(folder).expect("examples").flatten().collect();
    folders.sort_by_key(std::fs::DirEntry::path);
    for entry in folders {
        let name = entry.file_name().to_string_lossy().into_owned();
        let Ok(text) = std::fs::read_to_string(entry.path().join("model.toml")) else { continue };
        if !text.contains("[drives") {
            continue;
        }
        let reading = read(&Source::new(&text, &name));
        let Some(own) = reading.model else { continue };
        let end = own.solve.t_start + 0.3 * (own.solve.t_end - own.solve.t_start);
        let times = Range { from: own.solve.t_start, to: end, n: 3 };
        // Of some, only a part of the motion is driven.
        match inverse(own, &[], &times, &Actuators::default()) {
            Ok(_) => {
                needs_what_a_run_takes(&text, &times);
                compared.push(name);
            }
            Err(fault) => eprintln!("{name}: {fault}"),
        }
    }
    assert!(compared.len() >= 15, "{compared:?}");
}

/// A jack that is raised evenly, its saddle held against turning: F r tan(λ + ρ), with the angle of the lead tan λ = p/2πr and of
/// friction tan ρ = μ (Shigley, §8-2), for the car, the saddle and the screw. Without the saddle's motion it is asked for by name.
#[test]
fn a_screw_jack_takes_the_torque_of_its_lead_and_its_friction() {
    let text = include_str!("../../../../examples/screw-jack/model.toml");
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with("hand")).collect();
    let without_hand = lines.join("\n");
    let asked = |motions: &[(&str, &str)]| {
        let jack = model(&without_hand);
        let motions: Vec<Motion> = motions
            .iter()
            .map(|(name, law)| Motion::formula(&jack, name, law).expect("a motion"))
            .collect();
        let times = Range { from: 0.0, to: 1.0, n: 3 };
        let actuators = Actuators { named: vec!["thread".to_owned()], ..Actuators::default() };
        inverse(jack, &motions, &times, &actuators)
    };
    let force = 8000.0 + 1.2 * 9.81;
    let lead = 4.0 / (std::f64::consts::PI * 20.0);
    for (sense, torque) in [
        (1.0, force * 0.01 * (lead + 0.12) / (1.0 - 0.12 * lead)),
        (-1.0, force * 0.01 * (lead - 0.12) / (1.0 + 0.12 * lead)),
    ] {
        let (turn, back) = (format!("{}*t", 0.5 * sense), format!("{}*t", -0.5 * sense));
        let found = asked(&[("thread.angle", &turn), ("swivel.angle", &back)]).expect("efforts");
        for effort in found.table.column("thread.effort").expect("an effort") {
            assert!((effort - torque).abs() < 1e-9 * torque.abs(), "{effort} N m for {torque} N m");
        }
    }
    let Err(AnalysisError::NMotions { n_free: 2, n_prescribed: 1, left, open }) =
        asked(&[("thread.angle", "0.5*t")])
    else {
        panic!("one motion for two");
    };
    assert_eq!((left, open), (vec!["swivel.angle".to_owned()], vec![]));
}

/// An output without a value somewhere along the motion is an error with its name and place.
#[test]
fn a_table_of_efforts_has_numbers_or_an_error() {
    let text = "[bodies]\ncart = { mass = 1 }\n\
         [joints]\nS = { type = \"prismatic\", between = [\"ground\", \"cart\"], axis = [1, 0] }\n\
         [outputs]\nratio = \"1/(S.position/(1 m) - 0.5)\"\n\
         [drives]\nfeed = { joint = \"S\", motion = \"1 m/s*t\" }\n[solve]\nt_end = 1\n";
    let times = Range { from: 0.0, to: 1.0, n: 3 };
    let Err(AnalysisError::NoNumber { name, place, value }) =
        inverse(model(text), &[], &times, &Actuators::default())
    else {
        panic!("a number");
    };
    assert_eq!((name.as_str(), place.as_str()), ("outputs.ratio", "at t = 0.5 s"));
    assert!(value.is_infinite(), "{value}");
    let before = Range { from: 0.0, to: 0.4, n: 3 };
    assert!(inverse(model(text), &[], &before, &Actuators::default()).is_ok());
}

/// A pendulum above its rubbing pin: (I + m l²) θ̈ = m g l sin θ − μ r/√(1 + μ²) |N|, N from the acceleration of its centre.
#[test]
fn code_of_friction_by_a_reaction_holds_where_the_motion_does() {
    let pendulum = model(
        r#"
        [bodies.arm]
        mass = 2.0
        inertia = 0.05
        points = { tip = [0, -0.3] }

        [joints.pin]
        type = "revolute"
        between = ["ground", "arm.tip"]

        [loads.gravity]
        type = "gravity"
        acceleration = [0, -9.81]

        [loads.rub]
        type = "friction"
        joint = "pin"
        mu = 0.2
        radius = 0.02

        [initial]
        pin = { angle = 1.0471975511965976, rate = 2.0 }
        "#,
    );
    let mechanism = Mechanism::derive(pendulum, Vec::new()).expect("a mechanism");
    let start = mechanism.start().expect("a start");
    let functions = exported(&mechanism, Part::Dynamics, &[]).expect("code");
    let terms = &functions[0];
    assert!(terms.signature.outputs.iter().any(|output| output.name == "f_lambda[0,1]"));
    // Its two forces are arguments, and the mode says that it slides towards larger angles.
    let modes = start.parameters_with_modes(&mechanism.parameters);
    let state = [&[start.t][..], &start.q, &start.v, &start.lambda[..2]].concat();
    let mut out = vec![0.0; terms.tape.n_outputs()];
    terms.tape.evaluate(&mut terms.tape.workspace(&modes), &state, &mut out);
    let (mass, rest) = out.split_at(9);
    let (force, rest) = rest.split_at(3);
    let jacobian = &rest[..9];
    let (a, lambda) = (&start.a, &start.lambda);
    for i in 0..3 {
        let inertia: f64 = (0..3).map(|j| mass[3 * i + j] * a[j]).sum();
        let reaction: f64 = (0..3).map(|row| jacobian[3 * row + i] * lambda[row]).sum();
        assert!((inertia + reaction - force[i]).abs() < 1e-12, "row {i}: {inertia} {reaction}");
    }
    let sum: f64 = jacobian[6..].iter().map(|entry| entry.abs()).sum();
    assert!(sum == 0.0, "it does not stick");

    // The same by hand.
    let (m, l, g, theta, omega) = (2.0, 0.3, 9.81, start.q[2], start.v[2]);
    let (sin, cos) = (theta.sin(), theta.cos());
    let [x, y] = [-l * cos, -l * sin].map(|arm| arm * start.a[2]);
    let centre = [x + l * sin * omega * omega, y - l * cos * omega * omega];
    let reaction = (m * centre[0]).hypot(m * (centre[1] + g));
    let rubbing = 0.2 * 0.02 / 1.04_f64.sqrt() * reaction;
    let expected = (m * g * l * sin - rubbing) / (0.05 + m * l * l);
    assert!((a[2] - expected).abs() < 1e-12 * expected.abs(), "{} {expected}", a[2]);
}
