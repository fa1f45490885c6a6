//! Positions, limits and assemblies of linkages without masses, against a textbook's numbers.

use std::collections::BTreeMap;

use crate::common::{CRATE, Scratch, text};
use serde_json::Value;

/// A four-bar of 40, 120, 80 and 100 mm on two pins of the ground; R. L. Norton, *Design of Machinery*,
/// computes such linkages in chapters 4, 6 and 7.
pub(super) const FOUR_BAR: &str = r#"
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

pub(super) const SLIDER_CRANK: &str = r#"
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

pub(super) fn json(place: &Scratch, arguments: &[&str]) -> Value {
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

/// A rod that stands on a torsion spring.
const ROD: &str = r#"
[parameters]
k = "3 N m/rad"
[bodies.rod]
mass = 1
inertia = 0.1
com = [0, 0.4]
[joints.A]
type = "revolute"
between = ["ground", "rod"]
[loads.g]
type = "gravity"
acceleration = [0, -9.81]
[loads.s]
type = "torsion"
joint = "A"
stiffness = "k"
damping = 0.1
[io]
input = ["A"]
output = ["A.angle"]
[solve]
t_end = 1
"#;

#[test]
fn equilibria_over_a_parameter_are_told_and_written() {
    let place = Scratch::new();
    place.write("rod.toml", ROD);
    let over = ["static", "rod.toml", "--over", "k=3:5 N m/rad:5", "-o", "over.csv"];
    let answer = json(&place, &over);
    let branches = answer["branches"].as_array().expect("branches");
    let points = branches.iter().flat_map(|branch| branch["points"].as_array().expect("points"));
    let crossing: Vec<f64> = points
        .filter(|point| point["name"] == "B1")
        .map(|point| point["value"].as_f64().expect("a number"))
        .collect();
    assert_eq!(crossing.len(), 2, "on both branches: {answer}");
    assert!(crossing.iter().all(|value| (value - 9.81 * 0.4).abs() < 1e-7), "{crossing:?}");
    let table = std::fs::read_to_string(place.path().join("over.csv")).expect("a table");
    assert!(table.starts_with("branch,kind,k,stability,stiffness,A.angle"), "{table}");
    let output = place.run("static rod.toml --over k=3:5 --solve k");
    assert_eq!(output.status.code(), Some(2), "one or the other");
}

/// A tailgate that its weight opens onto a stop.
#[test]
fn rests_on_stops_are_told_and_what_lies_beyond_is_left_out() {
    let place = Scratch::new();
    place.write(
        "tailgate.toml",
        "[bodies.tailgate]\nmass = 10\ninertia = 1\ncom = [0.5, 0]\n\
         [joints]\nhinge = { type = \"revolute\", between = [\"ground\", \"tailgate\"] }\n\
         [loads]\ngravity = { type = \"gravity\", acceleration = [0, -10] }\n\
         top = { type = \"stop\", joint = \"hinge\", min = \"-60 deg\", max = \"30 deg\" }\n",
    );
    let output = place.run("static tailgate.toml -o rests.csv");
    let report = text(&output.stdout);
    for line in [
        "tailgate: 1 equilibrium, there are no others on this assembly",
        "2 poses in balance are left out: stop `top` lies before them",
        "stop `top` (min), which bears 25 N*m",
        "stop `top` (max)",
    ] {
        assert!(report.contains(line), "{line}: {report}");
    }
    let table = std::fs::read_to_string(place.path().join("rests.csv")).expect("a table");
    assert!(table.lines().next().is_some_and(|heads| heads.ends_with(",top.min")), "{table}");

    let answer = json(&place, &["static", "tailgate.toml"]);
    let bearing = &answer["equilibria"][0]["bearing"][0];
    assert_eq!([&bearing["stop"], &bearing["limit"], &bearing["unit"]], ["top", "min", "N*m"]);
    assert!((bearing["effort"].as_f64().expect("a number") - 25.0).abs() < 1e-9, "{bearing}");
    let left_out = answer["left_out"].as_array().expect("poses");
    assert_eq!(left_out.len(), 2);
    assert!(left_out.iter().all(|pose| pose["beyond"][0]["stop"] == "top"), "{answer}");
}

#[test]
fn an_instant_is_a_state_to_be_linear_about() {
    let place = Scratch::new();
    place.write("rod.toml", format!("{ROD}[initial]\nA = {{ rate = 1 }}\n"));
    let answer = json(&place, &["linearize", "rod.toml", "--at", "t=0.5 s"]);
    let start = json(&place, &["linearize", "rod.toml", "--at", "start"]);
    assert_ne!(answer["pose"]["A.angle"], start["pose"]["A.angle"], "{answer}");
    let output = place.run("linearize rod.toml --at later");
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("an instant of the run, such as `t=1 s`"));
}

#[test]
fn inputs_and_outputs_of_the_model_are_those_of_a_response() {
    let place = Scratch::new();
    place.write("rod.toml", ROD.replace("3 N m/rad", "6 N m/rad"));
    let answer = json(&place, &["bode", "rod.toml", "--omega", "0.1:10 rad/s:3"]);
    let transfer = &answer["transfers"][0];
    assert_eq!([&transfer["input"], &transfer["output"]], ["A", "A.angle"]);
    let (inertia, stiffness) = (0.1 + 0.16, 6.0 - 9.81 * 0.4);
    for (k, w) in [0.1f64, 1.0, 10.0].into_iter().enumerate() {
        let expected = 1.0 / (stiffness - inertia * w * w).hypot(0.1 * w);
        let gain = transfer["gain"][k].as_f64().expect("a number");
        assert!((gain - expected).abs() < 1e-9 * expected, "{gain} for {expected}");
    }
}

/// The exit status says whether a run keeps to its tolerances.
#[test]
fn a_run_that_is_not_what_it_promises_fails() {
    let place = Scratch::new();
    place.write("rod.toml", format!("{ROD}rtol = 1e-8\n[initial]\nA = {{ angle = 0.5 }}\n"));
    let good = place.run("verify rod.toml");
    assert_eq!(good.status.code(), Some(0), "{}", text(&good.stdout));
    let coarse =
        format!("{ROD}rtol = 1e-10\natol = 1e-12\nstep = 0.1\n[initial]\nA = {{ angle = 0.5 }}\n");
    place.write("rod.toml", coarse);
    let bad = place.run("verify rod.toml");
    assert_eq!(bad.status.code(), Some(1), "{}", text(&bad.stdout));
    assert!(text(&bad.stdout).contains("beyond what the tolerances allow"));
}

#[test]
fn a_four_bar_is_counted_joint_by_joint() {
    let place = Scratch::new();
    place.write("linkage.toml", FOUR_BAR);
    let answer = json(&place, &["doctor", "linkage.toml"]);
    assert_eq!(answer["count"]["mobility"], 1);
    assert_eq!(answer["joints"].as_array().map(Vec::len), Some(4));
    let report = text(&place.run("doctor linkage.toml").stdout);
    assert!(report.contains("3 bodies") && report.contains("free motion 1"), "{report}");
}

#[test]
fn assemblies_of_a_four_bar_are_proved() {
    let place = Scratch::new();
    place.write("linkage.toml", FOUR_BAR);
    let answer = json(&place, &["kinematics", "linkage.toml", "--assemblies"]);
    assert_eq!(answer["proof"]["n"], 2, "{answer}");
    assert_eq!(answer["proof"]["dyads"][0]["kind"], "RRR");
}

/// An assembly that the model holds: runs and tables begin in it, and what passes over into the other one is told.
#[test]
fn an_assembly_is_held_and_motions_that_leave_it_are_told() {
    let place = Scratch::new();
    place.write("open.toml", format!("{FOUR_BAR}assembly = \"A-B-C-D open\"\n"));
    place.write("crossed.toml", format!("{FOUR_BAR}assembly = 2\n"));
    let angle = |model: &str| {
        let all = json(&place, &["kinematics", model, "--drive", "crank.angle=40 deg"]);
        let columns = all["table"]["columns"].as_array().expect("columns");
        let at = columns.iter().position(|c| c["name"] == "rocker.angle").expect("the rocker");
        all["table"]["rows"][0][at].as_f64().expect("a number").to_degrees()
    };
    assert_printed(angle("open.toml"), 57.3249);
    assert_printed(angle("crossed.toml"), -98.0050);
    let all = json(&place, &["kinematics", "crossed.toml", "--assemblies"]);
    assert_eq!(all["held_number"], 2);
    assert_eq!(all["assemblies"][1]["name"], "A-B-C-D crossed");

    // The rocker as the drive turns back at its limit, and there the crank and the coupler are in line.
    let text = FOUR_BAR.replace("A = { angle = \"40 deg\" }", "D = { angle = \"100 deg\" }");
    place.write("rocker.toml", format!("{text}assembly = 1\n"));
    let drive = ["--drive", "D.angle=100:135 deg:36", "--through"];
    let all = json(&place, &[&["kinematics", "rocker.toml"], &drive[..]].concat());
    let warning = &all["diagnostics"][0];
    assert_eq!(warning["code"], "R019", "{warning}");
    let message = warning["message"].as_str().expect("a message");
    assert!(message.contains("joint `B`") && message.contains("128.682"), "{message}");
}

#[test]
fn rates_below_zero_are_written_as_others() {
    let model = format!("{FOUR_BAR}rocker = {{ guess = {{ angle = \"57 deg\" }} }}\n");
    let of = |rate: &str| {
        let asked = ["--drive", "A.angle=40 deg", "--rate", rate, "--acceleration", "-1.5e-3"];
        first_row(&model, &asked)["rocker.rate"]
    };
    let forward = of("25 rad/s");
    assert_printed(forward, 6.9980);
    for rate in ["-25 rad/s", "-2.5e+1", "-25"] {
        assert!((of(rate) + forward).abs() < 1e-12, "{rate}");
    }
}

#[test]
fn frequencies_in_hertz_are_cycles_and_begin_above_zero() {
    let place = Scratch::new();
    place.write("rod.toml", ROD);
    let bode = |omega: &str| {
        let asked = ["bode", "rod.toml", "--input", "A", "--output", "A.angle", "--omega", omega];
        place.bksim().args(asked).arg("--json").output().expect("bksim starts")
    };
    let of =
        |omega: &str| -> Value { serde_json::from_slice(&bode(omega).stdout).expect("one object") };
    let (cycles, angles) = (of("0.5:5 Hz:3"), of("3.141592653589793:31.41592653589793 rad/s:3"));
    assert_eq!(cycles["transfers"], angles["transfers"]);
    assert!(cycles["transfers"][0]["gain"].is_array(), "{cycles}");
    let refused = bode("0:100 rad/s:5");
    assert_eq!(refused.status.code(), Some(1));
    assert!(text(&refused.stdout).contains("above zero"), "{}", text(&refused.stdout));
}

#[test]
fn a_number_of_a_run_is_differentiated_by_all_quantities() {
    let place = Scratch::new();
    place.write("rod.toml", format!("{ROD}[initial]\nA = {{ angle = \"0.5 rad\" }}\n"));
    let asked = ["gradient", "rod.toml", "--of", "A_angle", "--value", "rms", "-o", "gradient.csv"];
    let answer = json(&place, &asked);
    assert_eq!([&answer["goal"]["name"], &answer["goal"]["take"]], ["A_angle", "rms"]);
    let gradient = answer["gradient"].as_array().expect("derivatives");
    let names: Vec<&Value> = gradient.iter().map(|one| &one["name"]).collect();
    assert_eq!(names, ["k", "A.angle"]);
    assert_eq!(gradient[0]["derivative_unit"], "rad/(N m)");
    let table = std::fs::read_to_string(place.path().join("gradient.csv")).expect("a table");
    let heads: Vec<&str> =
        table.lines().map(|line| line.split(',').next().expect("a name")).collect();
    assert_eq!(heads, ["quantity", "k", "A.angle"], "{table}");

    let report = text(&place.run("gradient rod.toml --of state.A_angle --by k --t-end 0.5").stdout);
    for part in ["last of A_angle = ", "by 1 %", "rad/(N m)", " forward, "] {
        assert!(report.contains(part), "{part}: {report}");
    }
    let unknown = text(&place.run("gradient rod.toml --of A_angel").stderr);
    assert!(unknown.contains("error[Q002]"), "{unknown}");
    assert!(unknown.contains("did you mean `A_angle`?"), "{unknown}");
    let unknown = text(&place.run("gradient rod.toml --of A_angle --by kk").stderr);
    assert!(unknown.contains("error[S012]"), "{unknown}");
}
