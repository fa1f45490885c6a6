//! `bksim sheet`: the largest pin forces over all load cases.

use std::collections::BTreeMap;
use std::fs;

use crate::common::{Scratch, text};
use serde_json::Value;

/// A crank that turns evenly and a rod without mass push a block along a guide against a force.
const PUSHER: &str = r#"
[units]
length = "mm"

[parameters]
r = "60 mm"
l = "240 mm"
F = "100 N"

[bodies.crank]
mass = "1 kg"
inertia = "0.01 kg m^2"
points = { A = [0, 0], B = ["r", 0] }

[bodies.rod]
points = { B = [0, 0], C = ["l", 0] }
mass = 0

[bodies.block]
mass = "1 g"

[joints]
A = { type = "revolute", between = ["ground", "crank.A"] }
B = { type = "revolute", between = ["crank.B", "rod.B"] }
C = { type = "revolute", between = ["rod.C", "block"] }
guide = { type = "prismatic", between = ["ground", "block"], axis = [1, 0], coordinate = "x" }

[loads.piece]
type = "force"
on = "block"
vector = ["-F", 0]

[drives.motor]
joint = "A"
motion = "10 deg + 0.36 deg/s*t"

[initial]
guide = { guess = { position = "300 mm" } }

[solve]
t_end = "500 s"
every = "50 s"

[cases.half]
set = { F = "1 kN" }

[cases.full]
title = "full load"
set = { F = "2 kN" }
"#;

fn run(place: &Scratch, arguments: &str) -> String {
    let output = place.run(arguments);
    assert!(output.status.success(), "{arguments}: {}", text(&output.stderr));
    text(&output.stdout)
}

fn pusher() -> Scratch {
    let place = Scratch::new();
    place.write("pusher.toml", PUSHER);
    place
}

/// The rod without mass bears F / cos β, most where the crank is upright: sin β = r / l.
fn largest(force: f64) -> f64 {
    force / (1.0 - (60.0f64 / 240.0).powi(2)).sqrt()
}

#[test]
fn the_largest_force_is_that_of_the_worst_case() {
    let place = pusher();
    let found: Value =
        serde_json::from_str(&run(&place, "sheet pusher.toml --json")).expect("an object");
    let pins = found["pins"].as_array().expect("pins");
    assert_eq!(pins.len(), 4);
    for pin in pins.iter().filter(|pin| pin["joint"] == "B" || pin["joint"] == "C") {
        assert_eq!(pin["case"], "full");
        let force = pin["force"]["value"].as_f64().expect("a force");
        assert!((force - largest(2000.0)).abs() < 1e-3, "{force} for {}", largest(2000.0));
        let angle = pin["largest"]["pose"][0]["value"].as_f64().expect("an angle");
        assert!((angle.to_degrees() - 90.0).abs() < 0.1, "{}", angle.to_degrees());
    }
    let printed = run(&place, "sheet pusher.toml");
    let rows: Vec<&str> = printed.lines().filter(|line| line.starts_with("  full  B ")).collect();
    assert_eq!(rows.len(), 1, "{printed}");
    assert!(rows[0].contains("2065.59"), "{printed}");
    // One case, by its name.
    let found: Value = serde_json::from_str(&run(&place, "sheet pusher.toml --case half --json"))
        .expect("an object");
    assert_eq!(found["cases"].as_array().map(Vec::len), Some(1));
    let force = found["pins"][1]["force"]["value"].as_f64().expect("a force");
    assert!((force - largest(1000.0)).abs() < 1e-3, "{force}");
}

#[test]
fn tables_have_six_digits_and_every_case() {
    let place = pusher();
    run(&place, "sheet pusher.toml -o pins.csv --units mm,deg,N");
    let sheet = fs::read_to_string(place.path().join("pins.csv")).expect("a sheet");
    let lines: Vec<Vec<&str>> = sheet.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(lines[0][..4], ["case", "joint", "force [N]", "fx [N]"]);
    assert_eq!(lines.len(), 1 + 2 * 4);
    let b = lines.iter().find(|row| row[..2] == ["half", "B"]).expect("a row");
    assert_eq!(b[2].parse::<f64>().ok(), Some(1032.8), "{b:?}");
    // The guide bears no force along it: rounding is zero.
    let guide = lines.iter().find(|row| row[..2] == ["full", "guide"]).expect("a row");
    assert_eq!(guide[3], "0", "{guide:?}");
    run(&place, "sheet pusher.toml -o pins.xlsx");
    let book = fs::read(place.path().join("pins.xlsx")).expect("a workbook");
    assert!(book.starts_with(b"PK"));
}

#[test]
fn a_page_shows_the_mechanism_to_scale_with_its_lengths() {
    let place = pusher();
    run(&place, "sheet pusher.toml -o pins.html");
    let page = fs::read_to_string(place.path().join("pins.html")).expect("a page");
    for part in ["scale 1:", ">r = 60<", ">l = 240<", "Load cases", "full load", "2065.59"] {
        assert!(page.contains(part), "{part}");
    }
    // The distance of the ground's pins, which is as large as `l` by chance, has no name.
    let four_bar = r#"
[parameters]
r = "60 mm"
l = "240 mm"
k = "2*r"
[ground]
points = { A = [0, 0], D = ["240 mm", 0] }
[bodies]
crank = { mass = 1, points = { A = [0, 0], B = ["r", 0] } }
rod = { mass = 1, inertia = 0.01, points = { B = ["-l/2", 0], C = ["l/2", 0] } }
rocker = { mass = 1, inertia = 0.01, points = { D = [0, 0], C = [0, "k"] } }
[joints]
A = { type = "revolute", between = ["ground.A", "crank.A"] }
B = { type = "revolute", between = ["crank.B", "rod.B"] }
C = { type = "revolute", between = ["rod.C", "rocker.C"] }
D = { type = "revolute", between = ["ground.D", "rocker.D"] }
[drives]
motor = { joint = "A", motion = "1 rad/s*t" }
[solve]
t_end = "6.3 s"
"#;
    fs::write(place.path().join("bar.toml"), four_bar).expect("a file");
    run(&place, "sheet bar.toml -o bar.html --units mm");
    let page = fs::read_to_string(place.path().join("bar.html")).expect("a page");
    for (part, n) in [(">r = 60<", 1), (">l = 240<", 1), (">240<", 1), (">k = 120<", 1)] {
        let found = page.matches(&format!("{}</text>", part.trim_end_matches('<'))).count();
        // Each with its halo.
        assert_eq!(found, 2 * n, "{part}");
    }
    run(&place, "sheet pusher.toml -o pins.pdf");
    let pdf = fs::read(place.path().join("pins.pdf")).expect("a document");
    assert!(pdf.starts_with(b"%PDF") && pdf.len() > 10_000);
}

#[test]
fn loads_of_a_body_without_mass_are_in_balance() {
    let place = pusher();
    run(&place, "sheet pusher.toml --case full -o rod.inp --body rod --units mm,N --at 100");
    let cards = fs::read_to_string(place.path().join("rod.inp")).expect("cards");
    assert_eq!(cards.matches("*STEP\n").count(), cards.matches("*END STEP").count());
    assert!(cards.matches("*STEP\n").count() >= 2, "{cards}");
    for step in cards.split("*STEP\n").skip(1) {
        let mut sums: BTreeMap<&str, f64> = BTreeMap::new();
        let cards = step.lines().filter(|line| line.starts_with("PIN_"));
        for card in cards {
            let parts: Vec<&str> = card.split(", ").collect();
            *sums.entry(parts[1]).or_default() += parts[2].parse::<f64>().expect("a number");
        }
        // Along the rod alone, the same at both ends.
        assert_eq!(sums.keys().copied().collect::<Vec<_>>(), ["1"], "{step}");
        assert!(sums["1"].abs() < 0.02, "{step}");
    }
    let output = place.run("sheet pusher.toml -o other.inp");
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
    let output = place.run("sheet pusher.toml -o other.inp --body rot");
    assert!(text(&output.stderr).contains("did you mean `rod`"), "{}", text(&output.stderr));
}

/// A bob whose torque leaves its table under one load, and that could touch a wall.
const EARLY: &str = r#"
[tables.curve]
points = [[0, 1], [1, 2]]
units = ["rad", "N m"]

[parameters]
factor = 0.01

[ground]
points = { A = ["1 m", "-1 m"], B = ["1 m", "1 m"] }

[bodies.bob]
mass = "1 kg"
inertia = "0.1 kg m^2"
com = ["0.1 m", 0]
points = { P = ["0.1 m", 0] }

[joints.A]
type = "revolute"
between = ["ground", "bob"]

[loads.push]
type = "torque"
joint = "A"
value = "curve(A.angle)*factor"

[contacts.wall]
between = [{ line = ["ground.A", "ground.B"] }, "bob.P"]

[initial]
A = { angle = 0, rate = 0.1 }

[solve]
t_end = "1 s"

[cases.low]
set = { factor = 0.02 }
[cases.high]
set = { factor = 1 }
"#;

#[test]
fn a_sheet_says_what_it_leaves_out() {
    let place = Scratch::new();
    place.write("bob.toml", EARLY);
    let output = place.run("sheet bob.toml");
    let printed = text(&output.stdout);
    assert!(printed.contains("The run of load case high ended early, at t = 0."), "{printed}");
    assert!(!printed.contains("load case low ended early"), "{printed}");
    assert!(printed.contains("contacts.wall"), "{printed}");
    assert!(place.run("sheet bob.toml -o bob.html").status.success());
    let page = fs::read_to_string(place.path().join("bob.html")).expect("a page");
    assert!(page.contains("ended early") && page.contains("contacts.wall"));
    place.write("pusher.toml", PUSHER);
    let printed = text(&place.run("sheet pusher.toml").stdout);
    assert!(!printed.contains("ended early") && !printed.contains("contacts"), "{printed}");
}

/// A bar that falls from its pin on a support: at rest the support bears what the moments about the pin say.
const RESTING: &str = r#"
[ground]
points = { S = ["1 m", "-0.5 m"], T = ["-1 m", "-0.5 m"] }

[bodies.bar]
mass = "2 kg"
inertia = "0.2 kg m^2"
com = ["0.4 m", 0]
points = { E = ["1 m", 0] }

[joints.A]
type = "revolute"
between = ["ground", "bar"]

[loads.gravity]
type = "gravity"
acceleration = [0, "-10 m/s^2"]

[contacts.floor]
between = [{ line = ["ground.T", "ground.S"] }, "bar.E"]

[initial]
A = { angle = "-pi/6", rate = 0 }

[solve]
t_end = "0.1 s"
"#;

#[test]
fn a_contact_bears_a_force_as_a_pin_does() {
    let place = Scratch::new();
    place.write("bar.toml", RESTING);
    // The weight of 20 N at 0.4 of the distance of the support.
    run(&place, "sheet bar.toml -o bar.csv");
    let csv = fs::read_to_string(place.path().join("bar.csv")).expect("a table");
    let row = |name: &str| -> Vec<String> {
        let line = csv.lines().find(|line| line.starts_with(name)).expect("a row");
        line.split(',').map(str::to_owned).collect()
    };
    assert_eq!(row("contacts.floor")[1..4], ["8", "0", "8"], "{csv}");
    assert_eq!(row("A")[1..4], ["12", "0", "12"], "{csv}");
    run(&place, "sheet bar.toml -o bar.html");
    let page = fs::read_to_string(place.path().join("bar.html")).expect("a page");
    assert!(page.contains("contacts.floor: 8 N"), "no number at the arrow of the contact");
    // In the axes of the bar: weight, pin and contact add to nothing.
    run(&place, "sheet bar.toml -o bar.inp");
    let cards = fs::read_to_string(place.path().join("bar.inp")).expect("cards");
    assert!(!cards.contains("not in balance"), "{cards}");
    assert!(cards.contains("** MASS at 0.4, 0, 0\n** CONTACT_floor at 1, 0, 0\n"), "{cards}");
    let sum = |freedom: &str| -> f64 {
        let step = cards.split("*STEP\n").nth(1).expect("a step");
        let own = step.lines().filter(|line| line.contains(freedom));
        own.map(|line| {
            line.rsplit(", ").next().and_then(|x| x.parse::<f64>().ok()).expect("a number")
        })
        .sum()
    };
    for freedom in [", 1, ", ", 2, "] {
        assert!(sum(freedom).abs() < 2e-4, "{freedom}: {}", sum(freedom));
    }
}
