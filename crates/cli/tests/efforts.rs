//! Shared reactions and efforts on the command line: what joints that yield share, motions from logs, curves of motors.

use std::process::Output;

use crate::common::{Scratch, text};
use serde_json::Value;

/// A parallelogram whose bar is held three times, with a motor that swings it.
const THREE_CRANKS: &str = r#"
[ground.points]
O1 = [0, 0]
O2 = [0.3, 0]
O3 = [0.7, 0]
[bodies]
c1 = { mass = 0.5, inertia = 0.002, com = [0.1, 0], points = { B = [0.2, 0] } }
c2 = { mass = 0.6, inertia = 0.002, com = [0.1, 0], points = { B = [0.2, 0] } }
c3 = { mass = 0.4, inertia = 0.002, com = [0.1, 0], points = { B = [0.2, 0] } }
bar = { mass = 2, inertia = 0.09, com = [0.33, 0], points = { B1 = [0, 0], B2 = [0.3, 0], B3 = [0.7, 0] } }
[joints]
A1 = { type = "revolute", between = ["ground.O1", "c1"] }
A2 = { type = "revolute", between = ["ground.O2", "c2"] }
A3 = { type = "revolute", between = ["ground.O3", "c3"] }
B1 = { type = "revolute", between = ["c1.B", "bar.B1"] }
B2 = { type = "revolute", between = ["c2.B", "bar.B2"] }
B3 = { type = "revolute", between = ["c3.B", "bar.B3"] }
[loads]
weight = { type = "gravity", acceleration = [0, -9.81] }
friction = { type = "torque", joint = "A1", value = "-0.2*A1.rate" }
[initial]
A1 = { angle = 0.4, rate = 0 }
bar = { guess = { angle = 0 } }
[solve]
t_end = 0.5
"#;

fn place() -> Scratch {
    let place = Scratch::new();
    place.write("three.toml", THREE_CRANKS);
    place
}

fn run(place: &Scratch, arguments: &[&str]) -> Output {
    place.bksim().args(arguments).output().expect("the command runs")
}

fn json(place: &Scratch, arguments: &[&str]) -> Value {
    let output = run(place, &[arguments, &["--json"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("an object")
}

#[test]
fn what_joints_share_is_told_with_its_range_and_kept_by_a_log() {
    let place = place();
    let open = json(&place, &["static", "three.toml", "--bound", "A2.fy=100 N"]);
    let open = &open["equilibria"][0]["open"];
    assert_eq!(open["self_stresses"], 1);
    let of = |name: &str| {
        let all = open["components"].as_array().expect("components");
        all.iter().find(|c| c["name"] == name).unwrap_or_else(|| panic!("no {name}"))
    };
    assert!((of("A2.fy")["most"].as_f64().expect("a bound") - 100.0).abs() < 1e-3);
    assert!(of("A3.fy")["least"].as_f64().is_some());

    let springs = ["A1=1e8 N/m", "A2=2e8 N/m", "A3=1e8 N/m"];
    let springs: Vec<&str> = springs.iter().flat_map(|spring| ["--compliance", spring]).collect();
    let shared = json(&place, &[&["static", "three.toml"][..], &springs].concat());
    assert_eq!(shared["equilibria"][0]["open"]["self_stresses"], 0);
    let ran = json(&place, &[&["solve", "three.toml", "-o", "run.mcap"][..], &springs].concat());
    assert_eq!(ran["command"], "solve");
    let rigid = run(&place, &["solve", "three.toml", "-o", "rigid.mcap"]);
    assert!(rigid.status.success());
    let column = |log: &str| text(&run(&place, &["export", log, "reactions.A2.fy"]).stdout);
    assert_ne!(column("run.mcap"), column("rigid.mcap"));

    let wrong = run(&place, &["static", "three.toml", "--compliance", "A9=1 N/m"]);
    assert!(text(&wrong.stderr).contains("Q002"), "{}", text(&wrong.stderr));
}

#[test]
fn the_motion_of_a_log_needs_the_efforts_that_made_it() {
    let place = place();
    assert!(run(&place, &["solve", "three.toml", "-o", "run.mcap"]).status.success());
    // It fell freely: no effort is needed for the same again.
    place.write("motor.csv", "speed,effort\n0,0.5\n1,0.5\n30,0.1\n");
    let found = json(
        &place,
        &["inverse", "three.toml", "--motion", "A1.angle=@run.mcap", "--curve", "A1=@motor.csv"],
    );
    let loads = found["loads"].as_array().expect("loads");
    let peak = |name: &str| {
        let own = loads.iter().find(|load| load["name"] == name).expect("a load");
        own["peak"].as_f64().expect("a number").abs()
    };
    assert!(peak("A1.effort") < 1e-3 * peak("B1.fy"), "{} of {}", peak("A1.effort"), peak("B1.fy"));
    assert_eq!(found["duties"][0]["outside"].as_array().map(Vec::len), Some(0));

    let fast = json(
        &place,
        &[
            "inverse",
            "three.toml",
            "--motion",
            "A1.angle=0.4+20*t",
            "--times",
            "0:0.3 s:31",
            "--curve",
            "A1=@motor.csv",
        ],
    );
    assert!(!fast["duties"][0]["outside"].as_array().expect("times").is_empty());
}

#[test]
fn the_curve_of_a_motor_is_a_table_of_the_model_that_nothing_else_needs() {
    let place = Scratch::new();
    let motor = "[tables.motor]\nunits = [\"rpm\", \"N m\"]\npoints = [[0, 0.5], [10, 0.5], [300, 0.1]]\n\
                 interpolation = \"linear\"\n";
    place.write("three.toml", [THREE_CRANKS, motor].concat());
    let rpm = std::f64::consts::PI / 30.0;
    place.write("motor.csv", format!("0,0.5\n{},0.5\n{},0.1\n", 10.0 * rpm, 300.0 * rpm));
    let duties = |curve: &str| {
        let asked = ["inverse", "three.toml", "--motion", "A1.angle=0.4+20*t", "--curve", curve];
        json(&place, &asked)["duties"][0]["outside"].clone()
    };
    let outside = duties("A1=motor");
    assert!(!outside.as_array().expect("times").is_empty());
    assert_eq!(outside, duties("A1=@motor.csv"));
    for (curve, said) in [("A1=moto", "name one of `motor`"), ("B9=motor", "name one of `A1`")] {
        let asked = ["inverse", "three.toml", "--motion", "A1.angle=0.4+20*t", "--curve", curve];
        let refused = run(&place, &asked);
        assert_eq!(refused.status.code(), Some(1));
        assert!(text(&refused.stderr).contains(said), "{}", text(&refused.stderr));
    }
}

#[test]
fn a_linear_form_is_written_for_numpy_and_matlab_and_in_letters() {
    let place = Scratch::new();
    place.write(
        "rod.toml",
        "[parameters]\nu = 0\n[bodies.rod]\nmass = 2\ninertia = 0.1\ncom = [0.5, 0]\n\
         [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"rod\"]\ncoordinate = \"phi\"\n\
         [loads]\nweight = { type = \"gravity\", acceleration = [9.81, 0] }\n\
         motor = { type = \"torque\", joint = \"A\", value = \"u\" }\n",
    );
    let asked = ["linearize", "rod.toml", "--input", "u", "--output", "A.angle", "--letters"];
    let found = json(&place, &[&asked[..], &["-o", "rod.npz"]].concat());
    assert_eq!(found["letters"]["A"][0][1], "1");
    assert!(found["letters"]["A"][1][0].as_str().expect("letters").contains("cos(phi)"));
    assert!(
        found["letters"]["certificate"]["largest_difference"].as_f64().expect("a number") < 1e-12
    );
    assert!(run(&place, &[&asked[..], &["-o", "rod.mat"]].concat()).status.success());
    for (file, begin) in [("rod.npz", &b"PK\x03\x04"[..]), ("rod.mat", b"MATLAB 5.0")] {
        let bytes = std::fs::read(place.path().join(file)).expect("a file");
        assert!(bytes.starts_with(begin), "{file}");
    }
}

/// The table of `bksim kinematics` is a motion for `bksim inverse`, its columns found by name.
#[test]
fn a_table_of_kinematics_is_a_motion() {
    let place = Scratch::new();
    place.write(
        "rod.toml",
        "[bodies.rod]\nmass = 2\ninertia = 0.5\n[joints.A]\ntype = \"revolute\"\n\
         between = [\"ground\", \"rod\"]\n[drives.motor]\njoint = \"A\"\nmotion = \"0.4*t^3\"\n[solve]\nt_end = 1\n",
    );
    let wrote =
        run(&place, &["kinematics", "rod.toml", "--drive", "t=0:1 s:11", "-o", "motion.csv"]);
    assert!(wrote.status.success(), "{}", text(&wrote.stderr));
    for name in ["rod.angle", "A.angle"] {
        let motion = format!("{name}=@motion.csv");
        let found =
            json(&place, &["inverse", "rod.toml", "--motion", &motion, "--times", "0:1 s:6"]);
        let columns = found["table"]["columns"].as_array().expect("columns");
        let effort =
            columns.iter().position(|c| c["name"].as_str().is_some_and(|n| n.ends_with(".effort")));
        let effort = effort.expect("an effort");
        for row in found["table"]["rows"].as_array().expect("rows") {
            let cell = |k: usize| row[k].as_f64().expect("a number");
            // I φ̈ = 0.5 · 2.4 t, between samples by quintics.
            assert!((cell(effort) - 1.2 * cell(0)).abs() < 1e-9, "{row}");
        }
    }
    place.write("other.csv", "t,rod.angel,z\n0,0,1\n1,1,1\n");
    let refused = run(&place, &["inverse", "rod.toml", "--motion", "rod.angle=@other.csv"]);
    let said = text(&refused.stderr);
    assert!(
        said.contains("has no column `rod.angle`") && said.contains("did you mean `rod.angel`?"),
        "{said}"
    );
}
