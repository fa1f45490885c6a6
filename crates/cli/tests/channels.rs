//! `bksim solve --channels own` leaves out what is there for other programs, and nothing else.

use std::collections::BTreeSet;
use std::fs;

use crate::common::{CRATE, Scratch, text};

/// Names of the channels of a log.
fn topics(log: &[u8]) -> BTreeSet<String> {
    let summary = mcap::Summary::read(log).expect("an MCAP file").expect("its summary");
    summary.channels.values().map(|channel| channel.topic.clone()).collect()
}

#[test]
fn a_log_without_the_channels_of_other_programs_has_all_of_its_own() {
    let place = Scratch::new();
    let example = format!("{CRATE}/../../examples/spring-pendulum/model.toml");
    for which in ["all", "own"] {
        let output = place.run(&format!("solve {example} --channels {which} -o {which}.mcap"));
        assert!(output.status.success(), "{}", text(&output.stderr));
        let output = place.run(&format!("export {which}.mcap -o {which}.csv"));
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
    let read = |name: &str| fs::read(place.path().join(name)).expect("a file");
    let [all, own] = ["all.mcap", "own.mcap"].map(read);
    let [all_topics, own_topics] = [topics(&all), topics(&own)];
    assert!(own_topics.is_subset(&all_topics), "{own_topics:?}");
    let left_out: Vec<&str> = all_topics.difference(&own_topics).map(String::as_str).collect();
    assert_eq!(
        left_out,
        ["/joint_states", "/outlines/bob", "/outlines/ground", "/scene", "/spans", "/tf"]
    );
    assert!(2 * own.len() < all.len(), "{} of {} bytes", own.len(), all.len());

    // Every number is there.
    assert!(read("all.csv") == read("own.csv"), "the tables differ");
    let output = place.run("info own.mcap");
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn what_is_no_choice_of_channels_is_refused() {
    let place = Scratch::new();
    let output = place.run("solve model.toml --channels some");
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output.stderr);
    assert!(said.contains("all") && said.contains("own"), "{said}");
}

/// A pendulum in space whose axis is tilted in the ground, its centre of mass off the joint's plane.
const PENDULUM: &str = "\
[ground]
points = { O = { at = [0, 0, 0], rpy = [\"30 deg\", 0, 0] } }
[bodies.rod]
mass = 2
inertia = [0.2, 0.1, 0.15]
com = [0.5, 0, 0.1]
points = { tip = [1, 0, 0.2] }
[joints.A]
type = \"revolute\"
between = [\"ground.O\", \"rod\"]
[loads.gravity]
type = \"gravity\"
acceleration = [0, \"-9.81 m/s^2\", 0]
[initial]
A = { angle = 0.3, rate = 1 }
[solve]
t_end = 1
every = 0.25
";

#[test]
fn what_the_model_can_name_is_exported() {
    let place = Scratch::new();
    place.write("model.toml", PENDULUM);
    let run = |arguments: &str| {
        let output = place.run(arguments);
        assert!(output.status.success(), "{arguments}: {}", text(&output.stderr));
        text(&output.stdout)
    };
    run("solve model.toml -o run.mcap");
    let names = [
        "state.A_angle",
        "rod.vx",
        "rod.px",
        "rod.tip.z",
        "rod.az",
        "reactions.A.fx",
        "reactions.A.fy",
        "reactions.A.fz",
        "reactions.A.fy_joint",
        "reactions.A.mz_joint",
        "reactions.A.force",
    ];
    let table = run(&format!("export run.mcap {}", names.join(" ")));
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some(&*format!("t,{}", names.join(","))));
    let mut n_rows = 0;
    for line in lines {
        let numbers: Vec<f64> =
            line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        let [_, angle, vx, px, tip_z, az, fx, fy, fz, fy_joint, mz_joint, force] = numbers[..]
        else {
            panic!("{line}")
        };
        let near =
            |a: f64, b: f64| assert!((a - b).abs() < 1e-9 * (1.0 + b.abs()), "{line}: {a} for {b}");
        near(px, 2.0 * vx);
        // Rx(30°) of (cos A, sin A, 0.2).
        let (sin, cos) = 30_f64.to_radians().sin_cos();
        near(tip_z, sin * angle.sin() + cos * 0.2);
        near(fz, 2.0 * az);
        near(fy_joint, cos * fy + sin * fz);
        near(mz_joint, 0.0);
        near(force, fx.hypot(fy.hypot(fz)));
        n_rows += 1;
    }
    assert_eq!(n_rows, 5);

    // What nothing is called is misspelt.
    let output = place.run("export run.mcap rod.px rod.tpi.x");
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output.stderr);
    assert!(said.contains("no channel matches `rod.tpi.x`"), "{said}");
    assert!(said.contains("did you mean `rod.tip.x`?"), "{said}");
    // A pattern stands for what the model can name, too.
    let table = run("export run.mcap reactions.*.force rod.tip.v?");
    let first = table.lines().next();
    assert_eq!(first, Some("t,reactions.A.force,rod.tip.vx,rod.tip.vy,rod.tip.vz"));
}
