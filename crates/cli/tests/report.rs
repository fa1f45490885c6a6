//! `bksim report` against closed forms, and tables in the reader's units.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fs;

use crate::common::{CRATE, Scratch, text};
use serde_json::Value;

fn run(place: &Scratch, arguments: &str) -> String {
    let output = place.run(arguments);
    assert!(output.status.success(), "{arguments}: {}", text(&output.stderr));
    text(&output.stdout)
}

fn report(place: &Scratch, arguments: &str) -> Value {
    serde_json::from_str(&run(place, &format!("report {arguments} --json"))).expect("one object")
}

fn close(found: &Value, expected: f64, within: f64, of: &str) {
    let found = found.as_f64().expect(of);
    let size = expected.abs().max(1.0);
    assert!((found - expected).abs() <= within * size, "{of}: {found} is not {expected}");
}

/// The part of a report with this name.
fn part<'v>(of: &'v Value, list: &str, key: &str, name: &str) -> &'v Value {
    let mut parts = of[list].as_array().expect(list).iter();
    parts.find(|part| part[key] == name).unwrap_or_else(|| panic!("{name} in {of}"))
}

#[test]
fn a_quick_return_has_the_time_ratio_of_its_crank_angles() {
    let place = Scratch::new();
    let model = fs::read_to_string(format!("{CRATE}/../../examples/quick-return/model.toml"));
    let model =
        model.expect("an example").replace("rtol = 1e-6\natol = 1e-8", "rtol = 1e-9\natol = 1e-9");
    assert!(model.contains("rtol = 1e-9"));
    place.write("quick.toml", model);
    let found = report(&place, "quick.toml");
    // The link turns back where the crank is square to it: sin φ = r/e.
    let phi = (0.1f64 / 0.25).asin();
    let link = part(&found, "motions", "name", "O.angle");
    close(&link["least"]["value"], FRAC_PI_2 - phi, 1e-9, "least angle");
    close(&link["largest"]["value"], FRAC_PI_2 + phi, 1e-9, "largest angle");
    close(&link["stroke"], 2.0 * phi, 1e-9, "stroke");
    // Norton, eq. 3.1: the crank turns α = π + 2φ on the way forth, β = 2π − α back, in 2 s each turn.
    let (alpha, beta) = (PI + 2.0 * phi, PI - 2.0 * phi);
    close(&link["time_ratio"]["value"], alpha / beta, 1e-8, "time ratio");
    let [forward, back] =
        ["forward", "back"].map(|key| link["time_ratio"][key].as_f64().expect(key));
    assert!((forward.max(back) - alpha / PI).abs() < 1e-8 && (forward + back - 2.0).abs() < 1e-8);
    // The crank turns on: it has a stroke, and no time ratio.
    let crank = part(&found, "motions", "name", "C.angle");
    close(&crank["stroke"], 2.0 * TAU, 1e-9, "two turns");
    assert_eq!(crank["time_ratio"], Value::Null);
    close(&crank["rate"]["value"], PI, 1e-9, "30 rpm");
}

const PENDULUM: &str = r#"
[units]
length = "mm"
angle = "deg"

[bodies.bob]
mass = "2 kg"
inertia = 0
com = [0, "-500 mm"]
points = { tip = [0, "-500 mm"] }

[joints.A]
type = "revolute"
between = ["ground", "bob"]

[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]

[initial]
A = { angle = "90 deg" }

[outputs]
lift = "bob.tip.y + 500 mm"
pull = "hypot(reactions.A.fx, reactions.A.fy)"

[solve]
t_end = "3 s"
rtol = 1e-11
atol = 1e-11
"#;

#[test]
fn a_pendulum_that_falls_from_the_horizontal_pulls_with_three_times_its_weight() {
    let place = Scratch::new();
    place.write("swing.toml", PENDULUM);
    let found = report(&place, "swing.toml");
    let (m, g, l) = (2.0f64, 9.81f64, 0.5f64);
    let speed = (2.0 * g * l).sqrt();
    let tip = part(&found, "points", "name", "bob.tip");
    close(&tip["speed"]["value"], speed, 1e-9, "speed at the lowest point");
    close(&tip["acceleration"]["value"], 2.0 * g, 1e-9, "v²/l");
    let pin = part(&found, "reactions", "joint", "A");
    close(&pin["force"]["value"], 3.0 * m * g, 1e-8, "3 m g");
    assert_eq!(pin["unique"], true);
    let swing = part(&found, "motions", "name", "A.angle");
    close(&swing["least"]["value"], -FRAC_PI_2, 1e-8, "as far on the other side");
    close(&swing["time_ratio"]["value"], 1.0, 1e-7, "as long forth as back");
    // A quarter of the period: K(sin 45°) √(l/g), Gauss's constant by the arithmetic-geometric mean.
    let (mut a, mut b) = (1.0f64, 0.5f64.sqrt());
    for _ in 0..6 {
        (a, b) = (f64::midpoint(a, b), (a * b).sqrt());
    }
    let half = PI / a * (l / g).sqrt();
    close(&swing["time_ratio"]["forward"], half, 1e-7, "half a period");
    let lift = part(&found, "outputs", "name", "lift");
    assert_eq!(lift["unit"], "m");
    close(&lift["largest"]["value"], l, 1e-9, "as high as at the start");
    assert!(lift["least"]["value"].as_f64().expect("a height").abs() < 1e-12);
    let pull = part(&found, "outputs", "name", "pull");
    close(&pull["largest"]["value"], 3.0 * m * g, 1e-8, "3 m g");
    assert_eq!(pull["rms"], pin["force_rms"]);
    let energy = &found["energy"];
    close(&energy["kinetic"]["value"], m * g * l, 1e-8, "m g l");
    let [first, last] = ["total_start", "total_end"].map(|key| energy[key].as_f64().expect(key));
    assert!((first - last).abs() < 1e-8);

    // In the units of the model, in others, and as Markdown.
    let words = run(&place, "report swing.toml");
    for expected in ["A.angle", "-90 deg", "3132.09195 mm/s", "58.86 N", "9.81 J", "0 N*mm"] {
        assert!(words.contains(expected), "{expected} in {words}");
    }
    let words = run(&place, "report swing.toml --in cm,rpm --format markdown");
    // The first digits of the largest rate.
    let rate = format!("{:.7}", 60.0 / TAU * speed / l);
    let rate = rate.trim_end_matches('0');
    for expected in ["| A.angle |", "313.209195 cm/s", rate, "## Energies"] {
        assert!(words.contains(expected), "{expected} in {words}");
    }
    let refused = place.run("report swing.toml --in mm,degg");
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("did you mean `deg`?"), "{}", text(&refused.stderr));
}

#[test]
fn efforts_of_a_drive_are_those_of_its_motion() {
    let place = Scratch::new();
    let rotor = |motion: &str, t_end: f64| {
        format!(
            "[bodies.rotor]\nmass = \"1 kg\"\ninertia = \"0.2 kg m^2\"\n\
             [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"rotor\"]\n\
             [drives.motor]\njoint = \"A\"\nmotion = \"{motion}\"\n\
             [solve]\nt_end = \"{t_end} s\"\n"
        )
    };
    // φ = a sin(ω t) over one period: the effort is −I a ω² sin(ω t).
    place.write("sine.toml", rotor("0.5 rad*sin(2*pi rad/s*t)", 1.0));
    let found = report(&place, "sine.toml");
    let motor = part(&found, "drives", "name", "motor");
    let peak = 0.2 * 0.5 * TAU * TAU;
    let size = |value: &Value| value.as_f64().expect("a number").abs();
    assert!((size(&motor["peak"]["value"]) - peak).abs() < 1e-7, "{motor}");
    close(&motor["rms"], peak / 2f64.sqrt(), 1e-6, "root mean square");
    // P = −½ I a² ω³ sin(2 ω t), whose mean is zero.
    assert!((size(&motor["power"]["value"]) - 0.5 * peak * 0.5 * TAU).abs() < 1e-7, "{motor}");
    close(&motor["mean_power"], 0.0, 1e-6, "mean power");

    // φ = ½ α t²: a constant effort, whose work is the kinetic energy.
    place.write("even.toml", rotor("0.5*3 rad/s^2*t^2", 2.0));
    let found = report(&place, "even.toml");
    let motor = part(&found, "drives", "name", "motor");
    close(&motor["rms"], 0.6, 1e-8, "I α");
    close(&motor["peak"]["value"], 0.6, 1e-8, "I α, in the direction of the motion");
    close(&motor["power"]["value"], 0.6 * 6.0, 1e-8, "power at the end");
    close(&motor["mean_power"], 0.6 * 3.0, 1e-8, "mean power");
    close(&found["energy"]["work"], 0.5 * 0.2 * 36.0, 1e-8, "work");
    close(&found["energy"]["total_end"], 0.5 * 0.2 * 36.0, 1e-8, "kinetic energy");
}

#[test]
fn a_report_on_a_run_that_ended_early_exits_as_the_run_does() {
    let place = Scratch::new();
    let model = fs::read_to_string(format!("{CRATE}/tests/faults/models/cart.toml"));
    let model = model.expect("a model").replace("-3 N", "3 N*sqrt(0.5 - t/(1 s))");
    place.write("early.toml", model);
    let run = place.run("solve early.toml");
    assert_eq!(run.status.code(), Some(3), "{}", text(&run.stderr));
    for arguments in ["report early.mcap", "report early.toml", "report early.mcap -o r.json"] {
        let output = place.run(arguments);
        assert_eq!(output.status.code(), Some(3), "{arguments}: {}", text(&output.stderr));
    }
    let body = text(&place.run("report early.mcap --json").stdout);
    let body: Value = serde_json::from_str(&body).expect("one object");
    assert_eq!(body["complete"], false);
}

#[test]
fn tables_are_in_the_units_that_are_asked_for() {
    let place = Scratch::new();
    place.write("swing.toml", PENDULUM);
    run(&place, "solve swing.toml --t-end 0.1 --every 0.05");
    let table = |arguments: &str| -> Vec<Vec<String>> {
        let csv = run(&place, &format!("export swing.mcap {arguments}"));
        csv.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
    };
    let plain = table("A.angle bob.tip.y bob.tip.vy");
    let shown = table("A.angle:deg bob.tip.y bob.tip.vy --in mm,ms");
    assert_eq!(plain[0], ["t", "A.angle", "bob.tip.y", "bob.tip.vy"]);
    assert_eq!(shown[0], ["t [ms]", "A.angle [deg]", "bob.tip.y [mm]", "bob.tip.vy [mm/ms]"]);
    for (plain, shown) in plain.iter().zip(&shown).skip(1) {
        let number = |cell: &String| cell.parse::<f64>().expect("a number");
        for (column, factor) in [1e3, 180.0 / PI, 1e3, 1.0].into_iter().enumerate() {
            let (plain, shown) = (number(&plain[column]), number(&shown[column]));
            assert!((plain * factor - shown).abs() <= 1e-14 * shown.abs(), "{plain} {shown}");
        }
    }
    assert_eq!(table("A.angle --in model")[0], ["t", "A.angle [deg]"]);
    for (arguments, expected) in [
        ("A.angle:mm", "`A.angle` is in rad, not in mm"),
        ("A.angle:furlong", "is no unit"),
        ("A.angle --in parsec", "is no unit"),
    ] {
        let refused = place.run(&format!("export swing.mcap {arguments}"));
        assert_eq!(refused.status.code(), Some(2), "{arguments}");
        assert!(text(&refused.stderr).contains(expected), "{}", text(&refused.stderr));
    }
}

#[test]
fn every_example_is_in_the_program() {
    let place = Scratch::new();
    let list = run(&place, "new --list");
    let mut n_models = 0;
    for entry in fs::read_dir(format!("{CRATE}/../../examples")).expect("examples") {
        let folder = entry.expect("an entry").path();
        let name = folder.file_name().and_then(|name| name.to_str()).expect("a name").to_owned();
        let Ok(model) = fs::read(folder.join("model.toml")) else { continue };
        n_models += 1;
        assert!(list.contains(&name), "{name} in {list}");
        run(&place, &format!("new my_{name} --template {name}"));
        assert_eq!(fs::read(place.path().join(format!("my_{name}.toml"))).expect("a model"), model);
    }
    assert!(n_models > 10);
    run(&place, "new drawn --template four-bar --drawing");
    run(&place, "check drawn.toml");
    let refused = place.run("new other --template fourbar");
    assert!(
        text(&refused.stderr).contains("did you mean `four-bar`?"),
        "{}",
        text(&refused.stderr)
    );
    let refused = place.run("new drawn --template four-bar --drawing");
    assert!(text(&refused.stderr).contains("exists already"), "{}", text(&refused.stderr));
}

#[test]
fn shells_and_readers_of_manuals_know_every_command() {
    let place = Scratch::new();
    let help = run(&place, "--help");
    let (commands, _) = help.split_once("Options:").expect("a list of commands");
    // Headings of groups and the usage begin at the margin.
    let commands = commands.lines().filter(|line| line.starts_with("  "));
    let commands: Vec<&str> = commands.filter_map(|line| line.split_whitespace().next()).collect();
    assert!(commands.len() > 25);
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = run(&place, &format!("completions {shell}"));
        for command in &commands {
            assert!(script.contains(command), "{command} for {shell}");
        }
    }
    run(&place, "man -o pages");
    for command in commands.iter().filter(|command| **command != "help") {
        let page = place.path().join(format!("pages/bksim-{command}.1"));
        assert!(fs::read_to_string(page).expect(command).contains(".SH"), "{command}");
    }
    assert!(run(&place, "man cad list").contains("bksim"));
    assert_eq!(place.run("man nonsense").status.code(), Some(2));
}

#[test]
fn a_singular_pose_in_between_makes_no_largest_reaction() {
    // A door that swings through three singular poses.
    let model = include_str!("../../../tests/fixtures/swinging-door.toml");
    let place = Scratch::new();
    place.write("door.toml", model);
    let found = report(&place, "door.toml");
    for joint in ["rail", "P", "Q"] {
        let reaction = part(&found, "reactions", "joint", joint);
        let [force, rms] = [&reaction["force"]["value"], &reaction["force_rms"]]
            .map(|x| x.as_f64().expect("a number"));
        // A few times the weights of 618 N, with a peak that is one of the motion.
        assert!((100.0..3000.0).contains(&force), "{joint}: {force} N");
        assert!((0.1..1.0).contains(&(rms / force)), "{joint}: {rms} of {force} N");
    }
}

/// A bob of 2 kg that falls from the level bears 3 m g upwards where it is lowest.
#[test]
fn the_largest_pin_force_has_its_direction_and_pose() {
    let place = Scratch::new();
    place.write(
        "swing.toml",
        "[bodies.bob]\nmass = 2\ninertia = 0\ncom = [0, -0.5]\n[joints.A]\ntype = \"revolute\"\n\
         between = [\"ground\", \"bob\"]\n[loads.g]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n\
         [initial]\nA = { angle = \"90 deg\" }\n[solve]\nt_end = 0.6\nrtol = 1e-10\natol = 1e-10\n",
    );
    let output = place.run("report swing.toml -o pins.csv --units deg,kN");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let sheet = std::fs::read_to_string(place.path().join("pins.csv")).expect("a sheet");
    let mut lines = sheet.lines();
    let heads = lines.next().expect("a heading");
    assert!(heads.starts_with("joint,force [kN],fx [kN],fy [kN],fz [kN],"), "{heads}");
    assert!(heads.ends_with("direction [deg],t [s],A.angle [deg]"), "{heads}");
    let cells: Vec<&str> = lines.next().expect("a row").split(',').collect();
    let number = |k: usize| cells[k].parse::<f64>().expect("a number");
    let near = |k: usize, expected: f64, within: f64| {
        assert!((number(k) - expected).abs() < within, "{k}: {} for {expected}", cells[k]);
    };
    near(1, 0.05886, 1e-9);
    near(3, 0.05886, 1e-9);
    near(8, 90.0, 1e-2);
    near(10, 0.0, 1e-2);
}

/// A bob that falls from the level presses with 3 m g where it is lowest.
const CASES: &str = r#"
[parameters]
load = "1 kg"
g = "9.81 m/s^2"

[bodies.bob]
mass = "1 kg + load"
inertia = 0
com = [0, "-0.5 m"]

[joints.A]
type = "revolute"
between = ["ground", "bob"]

[loads.gravity]
type = "gravity"
acceleration = [0, "-g"]

[initial]
A = { angle = "90 deg" }

[solve]
t_end = "0.6 s"
rtol = 1e-10
atol = 1e-10

[cases.full]
title = "full load"
set = { load = "9 kg" }

[cases.moon]
set = { "loads.gravity.acceleration.1" = "-1.62 m/s^2", solve.t_end = "1.5 s" }

[cases.low]
set = { A.angle = "60 deg", initial.A.rate = "0 rad/s" }
"#;

/// The largest force of the pin in N, of a report.
fn pin(place: &Scratch, arguments: &str) -> f64 {
    let found = report(place, arguments);
    part(&found, "reactions", "joint", "A")["force"]["value"].as_f64().expect("a force")
}

#[test]
fn a_load_case_changes_parameters_loads_and_the_start() {
    let place = Scratch::new();
    place.write("swing.toml", CASES);
    // 3 m g from the level, (3 - 2 cos 60°) m g from 60°.
    let expected =
        [("", 6.0 * 9.81), ("full", 30.0 * 9.81), ("moon", 6.0 * 1.62), ("low", 4.0 * 9.81)];
    for (case, force) in expected {
        let chosen = if case.is_empty() { String::new() } else { format!(" --case {case}") };
        let found = pin(&place, &format!("swing.toml{chosen}"));
        assert!((found - force).abs() < 1e-6 * force, "{case}: {found} for {force}");
    }
    // What is set goes over the case, and a log is that of its case.
    let found = pin(&place, "swing.toml --case full --set load=4");
    assert!((found - 15.0 * 9.81).abs() < 1e-4, "{found}");
    run(&place, "solve swing.toml --case full");
    let found = pin(&place, "swing-full.mcap");
    assert!((found - 30.0 * 9.81).abs() < 1e-4, "{found}");
}

#[test]
fn all_load_cases_are_done_one_after_the_other() {
    let place = Scratch::new();
    place.write("swing.toml", CASES);
    let printed = run(&place, "report swing.toml --cases -o pins.csv");
    assert_eq!(printed.lines().next(), Some("case `full`, full load"));
    for (case, force) in [("full", 294.3), ("moon", 9.72), ("low", 39.24)] {
        let sheet = fs::read_to_string(place.path().join(format!("pins-{case}.csv")));
        let sheet = sheet.expect("a sheet of the case");
        let row = sheet.lines().nth(1).expect("a joint").split(',').nth(1).expect("a force");
        let found: f64 = row.parse().expect("a number");
        assert!((found - force).abs() < 1e-4 * force, "{case}: {found}");
    }
    let printed = run(&place, "report swing.toml --cases --json");
    let objects = serde_json::Deserializer::from_str(&printed).into_iter::<Value>();
    let cases: Vec<Value> =
        objects.map(|object| object.expect("an object")["case"].clone()).collect();
    assert_eq!(cases, ["full", "moon", "low"]);
    // Neither a model without cases nor a log has any.
    place.write("plain.toml", CASES.split("[cases").next().expect("a model"));
    let output = place.run("report plain.toml --cases");
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("has no load cases"), "{}", text(&output.stderr));
}

/// A wheel that turns evenly against a steady torque: no instant is that of its largest rate or effort.
#[test]
fn what_is_steady_has_no_instant() {
    let place = Scratch::new();
    let wheel = "[bodies.wheel]\nmass = 1\ninertia = 0.3\n[joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"wheel\"]\n\
                 [drives.motor]\njoint = \"A\"\nmotion = \"25.13*t\"\n\
                 [loads.brake]\ntype = \"torque\"\non = \"wheel\"\nvalue = \"-416.67\"\n[solve]\nt_end = 1\n";
    place.write("wheel.toml", wheel);
    let said = run(&place, "report wheel.toml");
    let rate = said.lines().find(|line| line.contains("25.13 rad/s")).expect("a rate");
    assert!(!rate.contains(" s "), "{rate}");
    let effort = said.lines().find(|line| line.contains("416.67 N*m")).expect("an effort");
    assert!(!effort.contains(" s "), "{effort}");
    let found = report(&place, "wheel.toml");
    assert_eq!(found["drives"][0]["peak"]["t"], 0.0, "{found}");
}
