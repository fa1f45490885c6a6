//! Positions, limits and assemblies of linkages without masses, against a textbook's numbers.

mod common;

use std::collections::BTreeMap;

use common::{CRATE, Scratch, text};
use serde_json::Value;

/// A four-bar of 40, 120, 80 and 100 mm on two pins of the ground; R. L. Norton, *Design of Machinery*,
/// computes such linkages in chapters 4, 6 and 7.
const FOUR_BAR: &str = r#"
[ground.points]
O2 = [0, 0]
O4 = ["100 mm", 0]
[bodies.crank]
points = { A = [0, 0], B = ["40 mm", 0] }
[bodies.coupler]
points = { B = [0, 0], C = ["120 mm", 0] }
[bodies.rocker]
points = { D = [0, 0], C = ["80 mm", 0] }
[joints.A]
type = "revolute"
between = ["ground.O2", "crank.A"]
[joints.B]
type = "revolute"
between = ["crank.B", "coupler.B"]
[joints.C]
type = "revolute"
between = ["coupler.C", "rocker.C"]
[joints.D]
type = "revolute"
between = ["ground.O4", "rocker.D"]
[initial]
A = { angle = "40 deg" }
"#;

const SLIDER_CRANK: &str = r#"
[ground.points]
guide = [0, "-20 mm"]
[bodies.crank]
points = { A = [0, 0], B = ["40 mm", 0] }
[bodies.rod]
points = { B = [0, 0], C = ["120 mm", 0] }
[bodies.slider]
[joints.A]
type = "revolute"
between = ["ground", "crank.A"]
[joints.B]
type = "revolute"
between = ["crank.B", "rod.B"]
[joints.C]
type = "revolute"
between = ["rod.C", "slider"]
[joints.S]
type = "prismatic"
between = ["ground.guide", "slider"]
axis = [1, 0]
[initial]
A = { angle = "60 deg" }
S = { guess = { position = "120 mm" } }
"#;

fn json(place: &Scratch, arguments: &[&str]) -> Value {
    let output = place.bksim().args(arguments).arg("--json").output().expect("bksim starts");
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one object")
}

/// The first row of a table over a range, by column.
fn first_row(model: &str, drive: &[&str]) -> BTreeMap<String, f64> {
    let place = Scratch::new();
    place.write("linkage.toml", model);
    let answer = json(&place, &[&["kinematics", "linkage.toml"], drive].concat());
    let columns = answer["table"]["columns"].as_array().expect("columns");
    let row = answer["table"]["rows"][0].as_array().expect("a row");
    let name = |column: &Value| column["name"].as_str().expect("a name").to_owned();
    let value = |cell: &Value| cell.as_f64().expect("a number");
    columns.iter().map(name).zip(row.iter().map(value)).collect()
}

#[track_caller]
fn assert_printed(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 0.5001e-4, "{found} for {expected}");
}

#[test]
fn a_four_bar_moves_as_in_the_textbook_in_both_assemblies() {
    let drive = [
        "--drive",
        "A.angle=40 deg:41 deg:2",
        "--rate",
        "25 rad/s",
        "--acceleration",
        "15 rad/s^2",
    ];
    let open = [20.2979, 57.3249, -4.1209, 6.9980, 296.0892, 470.1335];
    let crossed = [-60.9780, -98.0050, -9.2588, -20.3777, 597.6224, 423.5781];
    for (guess, expected) in [("57 deg", open), ("-98 deg", crossed)] {
        let model = format!("{FOUR_BAR}rocker = {{ guess = {{ angle = \"{guess}\" }} }}\n");
        let row = first_row(&model, &drive);
        for (k, quantity) in ["angle", "rate", "acceleration"].into_iter().enumerate() {
            for (i, body) in ["coupler", "rocker"].into_iter().enumerate() {
                let found = row[&format!("{body}.{quantity}")];
                let found = if k == 0 { found.to_degrees() } else { found };
                assert_printed(found, expected[2 * k + i]);
            }
        }
    }
}

#[test]
fn an_offset_slider_crank_stands_where_the_textbook_has_it() {
    let row = first_row(SLIDER_CRANK, &["--drive", "A.angle=60 deg:61 deg:2"]);
    // The textbook measures the rod from the slider.
    assert_printed(row["rod.angle"].to_degrees() + 180.0, 152.9131);
    assert_printed(1000.0 * row["S.position"], 126.8380);
}

#[test]
fn the_rocker_turns_back_where_crank_and_coupler_are_in_line() {
    let place = Scratch::new();
    place.write(
        "linkage.toml",
        format!("{FOUR_BAR}rocker = {{ guess = {{ angle = \"57 deg\" }} }}\n"),
    );
    let output = place.run("kinematics linkage.toml --limits");
    let report = text(&output.stdout);
    let line =
        |name: &str| report.lines().find(|line| line.trim_start().starts_with(name)).expect(name);
    for number in ["54.9003678 deg", "128.682187 deg"] {
        assert!(line("rocker.angle").contains(number), "{report}");
    }
    for number in ["26.3843297 deg", "86.4166783 deg"] {
        assert!(line("C.angle").contains(number), "{report}");
    }
    assert!(report.contains("A.angle = 24.146848 deg"), "{report}");
    assert!(!report.contains("e-1"), "rounding is no result: {report}");
}

/// The drawing alone, without the model file that has its masses.
#[test]
fn a_drawing_without_masses_has_its_assemblies() {
    let place = Scratch::new();
    let drawing = std::fs::read(format!("{CRATE}/../../examples/four-bar/drawing.dxf"));
    place.write("four-bar.dxf", drawing.expect("a drawing"));
    let refused = text(&place.run("check four-bar.dxf").stderr);
    assert!(refused.contains("error[D043]: body `crank` has no mass"), "{refused}");
    let answer = json(&place, &["kinematics", "four-bar.dxf", "--assemblies"]);
    assert_eq!(answer["assemblies"].as_array().map(Vec::len), Some(2), "{answer}");
}

#[test]
fn other_questions_ask_for_masses() {
    let place = Scratch::new();
    place.write("linkage.toml", FOUR_BAR);
    for command in ["solve", "static", "modes"] {
        let output = place.run(&format!("{command} linkage.toml"));
        assert!(!output.status.success());
        assert!(
            text(&output.stderr).contains("error[M006]: body `crank` has no `mass`"),
            "{command}"
        );
    }
}
