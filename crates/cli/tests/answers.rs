//! Answers as they are printed: their state, their units, the files that they go into.

use crate::common::{Scratch, text};
use crate::questions::{FOUR_BAR, SLIDER_CRANK, json};
use serde_json::Value;

/// A bob that starts one degree from upright, in millimetres and degrees.
const UPRIGHT: &str = r#"
[units]
length = "mm"
angle = "deg"
[parameters]
u = "0 N m"
[bodies.bob]
mass = "1 kg"
inertia = 0
com = [0, 1000]
[joints.A]
type = "revolute"
between = ["ground", "bob"]
coordinate = "phi"
[loads]
gravity = { type = "gravity", acceleration = [0, "-9.81 m/s^2"] }
motor = { type = "torque", on = "bob", value = "u" }
[io]
input = ["u"]
output = ["A.angle"]
[initial]
A = { angle = 1 }
"#;

#[test]
fn every_answer_about_a_state_names_it_first() {
    let place = Scratch::new();
    place.write("up.toml", UPRIGHT);
    let named = "about the equilibrium nearest to the start: phi = 0 deg, unstable; 1 other";
    for command in ["linearize", "modes", "bode"] {
        let output = place.run(&format!("{command} up.toml"));
        let report = text(&output.stdout);
        assert!(report.lines().next().expect("a line").ends_with(named), "{report}");
        assert!(report.contains("others, by number for `--at`: 2: phi = "), "{report}");
        let answer = json(&place, &[command, "up.toml"]);
        let state = &answer["state"];
        assert_eq!((&state["stability"], &state["number"]), (&"unstable".into(), &1.into()));
        assert_eq!(state["coordinates"][0]["unit"], "deg", "{state}");
        let other = &state["others"][0];
        assert_eq!((&other["stability"], &other["number"]), (&"stable".into(), &2.into()));
        let angle = other["coordinates"][0]["value"].as_f64().expect("an angle");
        assert!((angle.abs() - 180.0).abs() < 1e-9, "{other}");
        for at in ["2", "stable"] {
            let answer = json(&place, &[command, "up.toml", "--at", at]);
            assert_eq!(answer["state"]["stability"], "stable", "{command} --at {at}");
        }
    }
    for (language, file) in
        [("c", "up_linear.h"), ("python", "up_linear.py"), ("json", "up_linear.json")]
    {
        let output = place.run(&format!("code up.toml --part linear --lang {language} -o code"));
        assert!(output.status.success(), "{}", text(&output.stderr));
        let code = std::fs::read_to_string(place.path().join("code").join(file)).expect("code");
        assert!(code.contains(&format!("Linear {named}.")), "{code}");
    }
    let refused = place.run("modes up.toml --at 3");
    assert!(text(&refused.stderr).contains("there is no equilibrium 3, of 2"));
}

#[test]
fn a_range_that_ends_says_where_in_the_unit_that_was_asked_for() {
    let place = Scratch::new();
    // The rocker that drives turns back at 54.9003678 deg.
    place.write(
        "linkage.toml",
        format!("{FOUR_BAR}rocker = {{ guess = {{ angle = \"57 deg\" }} }}\n"),
    );
    for (range, end) in [
        ("rocker.angle=57:50 deg:8", "rocker.angle = 54.9003678 deg"),
        ("rocker.angle=1:0.9:3", "rocker.angle = 0.958192179 (SI)"),
    ] {
        let mut command = place.bksim();
        command.args(["kinematics", "linkage.toml", "--drive", range]);
        let warning = text(&command.output().expect("bksim starts").stderr);
        assert!(
            warning.contains(&format!("goes no further than {end}: a dead point")),
            "{warning}"
        );
    }
}

#[test]
fn a_range_from_a_branch_point_needs_a_branch() {
    let place = Scratch::new();
    let flat = FOUR_BAR
        .replace("[\"120 mm\", 0]", "[\"100 mm\", 0]")
        .replace("[\"80 mm\", 0]", "[\"40 mm\", 0]");
    place.write("flat.toml", flat.replace("\"40 deg\"", "0"));
    let drive = ["kinematics", "flat.toml", "--drive", "A.angle=0:350 deg:36"];
    let output = place.bksim().args(drive).output().expect("bksim starts");
    assert!(!output.status.success());
    let fault = text(&output.stderr);
    assert!(fault.contains("error[Q021]") && fault.contains("branch 1: A.angle 1"), "{fault}");
    let answer = json(&place, &[&drive[..], &["--branch", "1"]].concat());
    assert_eq!(answer["table"]["rows"].as_array().map(Vec::len), Some(36));
}

#[test]
fn answers_are_in_the_units_that_are_asked_for() {
    let place = Scratch::new();
    place.write("crank.toml", SLIDER_CRANK);
    let run = |arguments: &[&str]| {
        let output = place.bksim().args(arguments).output().expect("bksim starts");
        assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
        text(&output.stdout)
    };
    let drive = ["kinematics", "crank.toml", "--drive", "A.angle=0:90 deg:2", "-o"];
    run(&[&drive[..], &["si.csv"]].concat());
    run(&[&drive[..], &["mm.csv", "--units", "mm,deg"]].concat());
    let read = |name: &str| std::fs::read_to_string(place.path().join(name)).expect("a table");
    let [si, shown] = ["si.csv", "mm.csv"].map(read);
    let cells = |table: &str, line: usize| {
        let line = table.lines().nth(line).expect("a line");
        line.split(',').map(str::to_owned).collect::<Vec<String>>()
    };
    let heads = cells(&shown, 0);
    for (k, name) in cells(&si, 0).iter().enumerate() {
        let factor = match name.as_str() {
            "A.angle" => 180.0 / std::f64::consts::PI,
            "slider.x" => 1000.0,
            _ => continue,
        };
        let unit = if name == "A.angle" { "deg" } else { "mm" };
        assert_eq!(heads[k], format!("{name} [{unit}]"));
        let [own, other] =
            [&si, &shown].map(|table| cells(table, 2)[k].parse::<f64>().expect("a number"));
        assert!((own * factor - other).abs() < 1e-9 * other.abs(), "{name}: {own}, {other}");
    }
    // Text follows them, and the model's own.
    let limits = ["kinematics", "crank.toml", "--limits"];
    assert!(run(&[&limits[..], &["--units", "mm,rad"]].concat()).contains(" mm"));
    place.write(
        "crank.toml",
        format!("[units]\nlength = \"mm\"\n{}", SLIDER_CRANK.replace("\"-20 mm\"", "-20")),
    );
    assert!(run(&limits).contains(" mm"));
}

#[test]
fn a_text_goes_into_a_file_and_replaces_none() {
    let place = Scratch::new();
    place.write("four.toml", FOUR_BAR);
    let run = |arguments: &str| place.run(arguments);
    let printed = text(&run("check four.toml").stdout);
    assert!(run("check four.toml -o check.txt").status.success());
    let read = |name: &str| std::fs::read_to_string(place.path().join(name)).expect("a file");
    assert_eq!(read("check.txt"), printed);
    let refused = run("check four.toml -o check.txt");
    assert_eq!(refused.status.code(), Some(4), "{}", text(&refused.stderr));
    assert!(run("check four.toml -o check.txt --force --json").status.success());
    let object: Value = serde_json::from_str(&read("check.txt")).expect("an object");
    assert_eq!(object["command"], "check");
    // The model itself is never replaced.
    assert!(!run("expand four.toml -o four.toml --force").status.success());
    assert_eq!(read("four.toml"), FOUR_BAR);
}

/// The help of a command in a language.
fn help(command: &[&str], language: &str) -> String {
    let place = Scratch::new();
    let mut bksim = place.bksim();
    let output = bksim.args(["--lang", language]).args(command).arg("--help").output();
    let output = output.expect("bksim starts");
    assert_eq!(output.status.code(), Some(0), "{command:?}");
    text(&output.stdout)
}

#[test]
fn no_line_of_the_vietnamese_help_is_english() {
    let mut commands: Vec<Vec<String>> = vec![Vec::new()];
    let mut n_lines = 0;
    while let Some(command) = commands.pop() {
        let words: Vec<&str> = command.iter().map(String::as_str).collect();
        // Examples are command lines.
        let [english, vietnamese] = ["en", "vi"].map(|language| {
            let help = help(&words, language);
            let end = help.find("\nExamples:").or_else(|| help.find("\nVí dụ:"));
            help[..end.unwrap_or(help.len())].to_owned()
        });
        let is_text = |line: &&str| {
            let words = line
                .split_whitespace()
                .filter(|word| word.len() > 1 && word.chars().all(|c| c.is_ascii_lowercase()));
            !line.starts_with("Usage:") && !line.contains("bksim completions ") && words.count() > 2
        };
        let lines: Vec<&str> = vietnamese.lines().map(str::trim).collect();
        for line in english.lines().map(str::trim).filter(is_text) {
            n_lines += 1;
            assert!(!lines.contains(&line), "docs/vi/help.toml lacks, for {words:?}: {line}");
        }
        // The commands of the list, and those below `cad`.
        let named =
            english.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
        let named = named.filter_map(|line| line.split_whitespace().next());
        let named = named
            .filter(|name| !name.starts_with(['-', '<', '[']) && !["help", "bksim"].contains(name));
        let below =
            named.map(|name| words.iter().copied().chain([name]).map(str::to_owned).collect());
        commands.extend(below);
    }
    assert!(n_lines > 400, "{n_lines} lines");
}

/// The model of an example.
fn example_text(name: &str) -> String {
    let examples = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    std::fs::read_to_string(examples.join(name).join("model.toml")).expect("an example")
}

/// Words of an answer that are no names of the model: lower-case words of three letters or more.
fn words_of(cell: &str, model: &str) -> usize {
    let is_word = |word: &&str| word.len() > 2 && word.chars().all(|c| c.is_ascii_lowercase());
    // Units, options, and names of ways in which joints close.
    let known = "deg rad mcap auto radau toml atol rtol open crossed left right ahead behind turns transmission";
    let is_known = |word: &&str| known.split(' ').any(|own| own == *word);
    let words = cell.split(|c: char| !c.is_alphanumeric() && !"_.`".contains(c));
    words.filter(is_word).filter(|word| !is_known(word) && !model.contains(*word)).count()
}

#[test]
fn no_heading_of_a_vietnamese_answer_is_english() {
    let place = Scratch::new();
    for example in ["four-bar", "slider-crank", "five-link"] {
        let model = example_text(example);
        place.write("m.toml", &model);
        let (mut n_cells, mut missing) = (0, Vec::new());
        for command in [
            "check m.toml",
            "solve m.toml -o m.mcap --force",
            "doctor m.toml",
            "static m.toml",
            "modes m.toml",
            "kinematics m.toml --limits",
            "kinematics m.toml --assemblies",
            "report m.mcap",
            "verify m.toml",
        ] {
            let output = place.run(&format!("{command} --lang en"));
            if !output.status.success() {
                continue;
            }
            let vietnamese = text(&place.run(&format!("{command} --lang vi")).stdout);
            let english = text(&output.stdout);
            assert_eq!(english.lines().count(), vietnamese.lines().count(), "{vietnamese}");
            let cells = |answer: &str| -> Vec<Vec<String>> {
                let of_line = |line: &str| {
                    let cells = line.split("  ").map(str::trim).filter(|cell| !cell.is_empty());
                    cells.map(str::to_owned).collect()
                };
                answer.lines().map(of_line).collect()
            };
            for (own, other) in cells(&english).iter().zip(cells(&vietnamese)) {
                for cell in own.iter().filter(|cell| words_of(cell, &model) > 0) {
                    n_cells += 1;
                    if other.contains(cell) {
                        missing.push(format!("`{cell}` of {command}"));
                    }
                }
            }
        }
        assert!(missing.is_empty(), "docs/vi/answers.toml lacks {missing:#?}");
        assert!(n_cells > 60, "{n_cells} texts of {example}");
    }
}

/// Starts and derivatives are in the units of the model, or in those that are asked for.
#[test]
fn starts_and_derivatives_are_in_units() {
    let place = Scratch::new();
    place.write("up.toml", UPRIGHT);
    let said = |arguments: &str| {
        let output = place.run(arguments);
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let row = |report: &str, of: &str| -> Vec<String> {
        let line = report.lines().find(|line| line.trim_start().starts_with(of));
        line.unwrap_or_default().split_whitespace().map(str::to_owned).collect()
    };
    let own = row(&said("assemble up.toml"), "phi ");
    assert_eq!(
        (own[1].as_str(), &own[4..]),
        ("1", &["deg,", "deg/s,", "deg/s²"].map(str::to_owned)[..])
    );
    let si = row(&said("assemble up.toml --units si"), "phi ");
    assert_eq!((si[1].as_str(), si[4].as_str()), ("0.0174532925", "rad,"));
    let stated = row(&said("assemble up.toml"), "A.angle");
    assert_eq!(stated[1..3], ["1", "1"].map(str::to_owned));

    // By the angle in degrees, and in radians.
    let slope = |units: &str| -> f64 {
        let report = said(&format!("gradient up.toml --of A.rate --by A.angle --t-end 0.1{units}"));
        let row = row(&report, "A.angle");
        row[3].parse().expect("a number")
    };
    let [own, si] = [slope(""), slope(" --units si")];
    assert!((own - si).abs() < 1e-8 * si.abs(), "rates and angles in degrees: {own} and {si}");
    let newtons = |units: &str| -> f64 {
        let report = said(&format!("gradient up.toml --of A.angle --by u --t-end 0.1{units}"));
        row(&report, "u ")[4].parse().expect("a number")
    };
    let [own, si] = [newtons(" --units deg"), newtons(" --units si")];
    assert!((own - si.to_degrees()).abs() < 1e-8 * own.abs(), "{own} and {si}");
}

/// A drive that stands still holds what it drives, and the pin bears the weight.
#[test]
fn reactions_in_equilibria_are_printed() {
    let place = Scratch::new();
    let arm = r#"
[bodies.arm]
mass = 2
com = [0.5, 0]
[joints.A]
type = "revolute"
between = ["ground", "arm"]
[loads.gravity]
type = "gravity"
acceleration = [0, -9.81]
"#;
    place.write("free.toml", arm);
    place.write("held.toml", format!("{arm}[drives.hold]\njoint = \"A\"\nmotion = 0\n"));
    let held = text(&place.run("static held.toml").stdout);
    assert!(held.contains("held by the drives") && held.contains("19.62 N"), "{held}");
    // Free, it hangs or stands upright: two equilibria, each with its reactions.
    let free = text(&place.run("static free.toml").stdout);
    assert_eq!(free.matches("19.62 N").count(), 2, "{free}");
    assert!(free.contains("reactions in equilibrium 2") && !free.contains("held by"), "{free}");
}
