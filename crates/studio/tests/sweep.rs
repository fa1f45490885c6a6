//! `bksim sweep` as a process: what it prints, how it ends, and that it goes on where it was killed.

use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use crate::common::{CRATE, Scratch, text};

const PENDULUM: &str = include_str!("../../../tests/fixtures/swept-pendulum.toml");

fn place(model: &str) -> Scratch {
    let place = Scratch::new();
    place.write("swing.toml", model);
    place
}

#[test]
fn a_grid_becomes_a_table_and_faults_are_counted() {
    let place = place(PENDULUM);
    let run = |more: &[&str]| {
        let mut args = vec!["sweep", "swing.toml", "--set", "l=0.5:1.5:5", "--set", "m=-1,1"];
        args.extend(more);
        place.bksim().args(args).output().expect("bksim runs")
    };
    let first = run(&["--json"]);
    let object: serde_json::Value = serde_json::from_slice(&first.stdout).expect("JSON");
    assert_eq!(first.status.code(), Some(0), "{}", text(&first.stderr));
    let numbers = ["cases", "done", "failed"].map(|key| object[key].as_u64());
    assert_eq!(numbers, [Some(10), Some(5), Some(5)]);
    assert_eq!(object["faults"][0]["first_case"], 0);
    assert_eq!(object["outputs"][0]["name"], "final(state.phi)");
    assert!(place.path().join("swing.parquet").exists());

    // The picture of a grid has lines of equal height, and dots where there is no answer.
    let plotted = place.bksim().args(["plot", "swing.parquet", "-o", "map.svg"]).output();
    assert_eq!(plotted.expect("bksim runs").status.code(), Some(0));
    let picture = fs::read_to_string(place.path().join("map.svg")).expect("a picture");
    let dots = picture.split("<title>no answer</title>").nth(1).expect("dots");
    let path = dots.split('"').nth(1).expect("a path");
    assert_eq!(path.matches("h0").count(), 5, "as many as masses below zero: {path}");

    // A table of the same model is replaced, and one of another is not, unless that is asked for.
    assert_eq!(run(&[]).status.code(), Some(0));
    let whole = fs::read(place.path().join("swing.parquet")).expect("a table");
    place.write("swing.parquet", b"PAR1 of some other program PAR1");
    assert_eq!(run(&[]).status.code(), Some(4));
    let again = run(&["--force"]);
    assert_eq!(again.status.code(), Some(0), "{}", text(&again.stderr));
    assert!(text(&again.stdout).contains("5 of 10 cases done"), "{}", text(&again.stdout));
    assert!(text(&again.stderr).contains("5 of 10 cases failed"), "{}", text(&again.stderr));
    assert!(fs::read(place.path().join("swing.parquet")).expect("a table") == whole);
}

#[test]
fn the_only_input_explains_everything_and_columns_answer_to_short_names() {
    let place = place(&format!("{PENDULUM}\n[outputs]\nheight = \"bob.y\"\n"));
    let mut sweep = place.bksim();
    sweep.args(["sweep", "swing.toml", "--set", "l=0.5:1.5:5", "--keep", "max(height)"]);
    sweep.args(["--keep", "max(energy.kinetic)", "-o", "t.parquet", "--log-cases"]);
    let output = sweep.arg("largest max(kinetic)").output().expect("bksim runs");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(place.path().join("t-4.mcap").exists(), "{}", text(&output.stdout));

    let output = place.bksim().args(["plot", "t.parquet", "max(height)", "--json"]).output();
    let object: serde_json::Value =
        serde_json::from_slice(&output.expect("bksim runs").stdout).expect("JSON");
    assert_eq!(object["outputs"][0]["name"], "max(outputs.height)");
    assert_eq!(object["outputs"][0]["influences"][0]["share"], 1.0);
    let output = place.bksim().args(["plot", "t.parquet", "max(hight)"]).output();
    let said = text(&output.expect("bksim runs").stderr);
    assert!(said.contains("one of `max(outputs.height)`, `max(energy.kinetic)`"), "{said}");
}

#[test]
fn trials_from_a_table_vary_values_by_their_path_and_are_drawn() {
    let place = place(PENDULUM);
    let said = |line: &str| {
        let output = place.run(line);
        assert_eq!(output.status.code(), Some(0), "{line}: {}", text(&output.stderr));
        text(&output.stdout)
    };
    // The period grows with the length alone; a longer com by its path is a longer pendulum.
    place.write("trials.csv", "l [mm]; m\n500; 1\n1000; 2\n1500; 1\n2000; 2\n2500; 3\n");
    let keep = ["--keep", "first(phi < 0 rad)"];
    let mut sweep = place.bksim();
    sweep.args(["sweep", "swing.toml", "--cases", "trials.csv", "-o", "trials.parquet"]).args(keep);
    let output = sweep.output().expect("bksim runs");
    assert!(text(&output.stdout).contains("5 of 5 cases done"), "{}", text(&output.stderr));
    said("plot trials.parquet -o trials.svg");
    let drawn = fs::read_to_string(place.path().join("trials.svg")).expect("a picture");
    assert!(drawn.contains("first(phi &lt; 0 rad)"), "its output is named");

    let json = |line: &str| -> serde_json::Value {
        serde_json::from_str(&said(&format!("{line} --json"))).expect("JSON")
    };
    let plotted = json("plot trials.parquet");
    assert_eq!(plotted["outputs"][0]["influences"][0]["rank_correlation"], 1.0);

    // A quarter of a period after the start, to second order in the angle.
    let com = "sweep swing.toml --set bob.com.1=-0.5:-0.5001:2 --set phi=0.01,0.02rad --pairs -o com.parquet";
    let mut sweep = place.bksim();
    sweep.args(com.split(' ')).args(["--keep", "first(phi < 0 rad)", "--every", "0.001"]);
    let output = sweep.output().expect("bksim runs");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let quarter = json("plot com.parquet")["outputs"][0]["smallest"].as_f64().expect("a time");
    let expected = 0.5 * std::f64::consts::PI * (0.5f64 / 9.81).sqrt();
    assert!((quarter - expected).abs() < 1e-4 * expected, "{quarter} for {expected}");

    // By itself, too, and a path that leads nowhere is told.
    said("solve swing.toml --set bob.com.1=-0.5 -o short.mcap");
    let lost = place.run("solve swing.toml --set bob.masss=2 -o lost.mcap");
    assert_eq!(lost.status.code(), Some(1));
    assert!(text(&lost.stderr).contains("bob.masss"), "{}", text(&lost.stderr));
}

#[test]
fn a_table_is_written_under_no_other_name() {
    let place = place(PENDULUM);
    for name in ["s.xlsx", "s.pdf", "s.mcap"] {
        let output = place.run(&format!("sweep swing.toml --set l=1,2 -o {name}"));
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{name}: {said}");
        assert!(said.contains("this command writes PARQUET"), "{said}");
        assert!(!place.path().join(name).exists(), "{name}");
    }
}

#[test]
fn faults_of_the_command_line_name_what_to_write() {
    let place = place(PENDULUM);
    let run = |args: &[&str]| {
        let output = place.bksim().args(["sweep", "swing.toml"]).args(args).output();
        let output = output.expect("bksim runs");
        assert!(!place.path().join("swing.parquet").exists(), "{args:?}");
        (output.status.code(), text(&output.stderr))
    };
    for (args, status, code, hint) in [
        (&["--set", "l=0.8:1.2:0"] as &[&str], 1, "P001", "at least 2"),
        (&["--set", "q=0.8:1.2:3"], 1, "P002", "`l`"),
        (&["--set", "l=1,2", "--set", "l=3,4"], 1, "P003", "once"),
        (&["--set", "l=1:2:99999", "--set", "m=1:2:99999"], 1, "P004", "cases"),
        (&["--set", "l=1,2", "--keep", "max(state.ph)"], 1, "P005", "state.phi"),
        (&["--set", "l=1:2:3", "--lhs", "5"], 1, "P001", "count"),
        (&["--set", "l=1"], 2, "", "varies"),
        (&["--set", "l=1,2", "--lhs", "5", "--sobol", "5"], 2, "", "--sobol"),
        (&["--set", "m=-1,-2"], 1, "M040", "mass"),
    ] {
        let (found, message) = run(args);
        assert_eq!(found, Some(status), "{args:?}: {message}");
        assert!(message.contains(code) && message.contains(hint), "{args:?}: {message}");
    }
    let explained = place.bksim().args(["explain", "p001"]).output().expect("bksim runs");
    assert!(text(&explained.stdout).starts_with("# P001"));
}

/// Many cases that take their time.
const LONG: [&str; 8] =
    ["sweep", "swing.toml", "--set", "l=0.5:1.5:2000", "--t-end", "5", "-o", "t.parquet"];

/// Starts a sweep, waits for its first parts and ends it with a signal.
#[cfg(unix)]
fn interrupted(place: &Scratch, more: &[&str], signal: &str) -> std::process::Output {
    use std::process::{Command, Stdio};
    let mut command = place.bksim();
    command.args(LONG).args(more).stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = command.spawn().expect("bksim starts");
    let begun = Instant::now();
    let parts = place.path().join("t.parquet.parts");
    let n_parts = || {
        let entries = fs::read_dir(&parts).into_iter().flatten().flatten();
        entries.filter(|entry| entry.path().extension().is_some_and(|e| e == "parquet")).count()
    };
    while n_parts() < 3 {
        assert!(begun.elapsed() < Duration::from_mins(1), "no parts are written");
        std::thread::sleep(Duration::from_millis(5));
    }
    let id = child.id().to_string();
    Command::new("kill").args([signal, &id]).status().expect("a signal is sent");
    child.wait_with_output().expect("it ends")
}

#[cfg(unix)]
#[test]
fn interrupted_and_killed_sweeps_go_on_to_the_same_table() {
    // One folder: a table names the file of its model, folder included.
    let place = place(PENDULUM);
    let table = place.path().join("t.parquet");
    let whole = place.bksim().args(LONG).output().expect("bksim runs");
    assert_eq!(whole.status.code(), Some(0), "{}", text(&whole.stderr));
    let whole = fs::read(&table).expect("a table");

    for (signal, status) in [("-INT", Some(130)), ("-TERM", Some(143)), ("-KILL", None)] {
        fs::remove_file(&table).expect("the table of before");
        let ended = interrupted(&place, &[], signal);
        assert_eq!(ended.status.code(), status, "{signal}: {}", text(&ended.stderr));
        assert!(!table.exists(), "{signal}");
        if status.is_some() {
            assert!(text(&ended.stderr).contains("--resume"), "{}", text(&ended.stderr));
        }
        // Without a word about it nothing is lost.
        let refused = place.bksim().args(LONG).output().expect("bksim runs");
        assert_eq!(refused.status.code(), Some(1), "{signal}");
        assert!(text(&refused.stderr).contains("P006"), "{}", text(&refused.stderr));
        let resumed = place.bksim().args(LONG).args(["--resume", "--json", "-j", "1"]).output();
        let resumed = resumed.expect("bksim runs");
        let object: serde_json::Value = serde_json::from_slice(&resumed.stdout).expect("JSON");
        assert!(object["resumed"].as_u64() >= Some(3 * 16), "{signal}: {object}");
        assert_eq!(object["done"], 2000, "{signal}");
        assert!(fs::read(&table).expect("a table") == whole, "{signal}: the table differs");

        // Now that it is there, only --force replaces it.
        let again = place.bksim().args(LONG).arg("--resume").output().expect("bksim runs");
        assert_eq!(again.status.code(), Some(4), "{signal}: {}", text(&again.stderr));
        assert!(text(&again.stderr).contains("`t.parquet` exists ("), "{}", text(&again.stderr));
    }
}

#[test]
fn a_name_that_ends_in_csv_is_a_table_of_text_with_the_same_rows() {
    let place = Scratch::new();
    let model = fs::read(format!("{CRATE}/../../examples/four-bar/model.toml"));
    place.write("model.toml", model.expect("an example"));
    let command = "sweep model.toml --set b=0.01,0.3,0.35 --t-end 0.1 -o s.csv";
    for _ in 0..2 {
        let swept = place.run(command);
        assert!(swept.status.success(), "{}", text(&swept.stderr));
    }
    let table = fs::read_to_string(place.path().join("s.csv")).expect("a table");
    let lines: Vec<&str> = table.lines().collect();
    assert!(lines.len() == 4 && lines[0].starts_with("case,b,"), "{table}");
    // A coupler of 10 mm does not reach.
    assert!(lines[1].starts_with("0,0.01,") && lines[1].contains(",no start,"), "{table}");
    assert!(lines[2].starts_with("1,0.3,") && lines[2].contains(",done,"), "{table}");
    assert!(!place.path().join("s.csv.parts").exists());
    place.write("s.csv", table.replace("done", "fine").replace("case", "number"));
    assert_eq!(place.run(command).status.code(), Some(4));
    assert_eq!(place.run("sweep model.toml --set b=0.3,0.35 -o s.xlsx").status.code(), Some(2));
}

#[test]
fn samples_without_axes_lie_between_the_ranges_that_the_model_states() {
    let place = Scratch::new();
    let model = fs::read_to_string(format!("{CRATE}/../../examples/four-bar/model.toml"));
    let ranges = "\n[ranges]\na = [\"80 mm\", \"120 mm\"]\nrod = [\"0.28 m\", \"0.32 m\"]\n";
    let model =
        model.expect("an example").replace("[parameters]\n", "[parameters]\nrod = \"0.3 m\"\n");
    place.write("model.toml", model.replace("b = \"0.3 m\"", "b = \"rod\"") + ranges);
    let table = |more: &str| {
        let swept =
            place.run(&format!("sweep model.toml --sobol 8 --t-end 0.01 -o s.csv --force {more}"));
        assert!(swept.status.success(), "{}", text(&swept.stderr));
        fs::read_to_string(place.path().join("s.csv")).expect("a table")
    };
    let whole = table("");
    assert!(whole.starts_with("case,a,rod,"), "{whole}");
    let numbers = |column: usize| -> Vec<f64> {
        let cells = whole.lines().skip(1).filter_map(|line| line.split(',').nth(column));
        cells.filter_map(|cell| cell.parse().ok()).collect()
    };
    // Columns are in SI.
    for (column, [low, high]) in [(1, [0.08, 0.12]), (2, [0.28, 0.32])] {
        let values = numbers(column);
        assert!(values.len() == 8 && values.iter().all(|x| (low..=high).contains(x)), "{values:?}");
        let half = f64::midpoint(low, high);
        assert!(values.iter().any(|x| *x < half) && values.iter().any(|x| *x > half), "{values:?}");
    }
    // A quantity with one value does not vary; a grid needs its values.
    assert!(table("--set a=0.1m").starts_with("case,rod,"));
    let refused = place.run("sweep model.toml");
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("`[ranges]`"), "{}", text(&refused.stderr));
}

#[test]
fn chosen_cases_are_logged_as_solve_logs_them() {
    let place = place(PENDULUM);
    let sweep = |chosen: &str, more: &[&str]| {
        let mut bksim = place.bksim();
        bksim.args(["sweep", "swing.toml", "--set", "l=0.5:2:4", "--set", "m=-1,1"]);
        bksim.args([
            "--set",
            "phi=0.5,0.6 rad",
            "--keep",
            "max(energy.kinetic)",
            "-o",
            "t.parquet",
        ]);
        bksim.args(["--log-cases", chosen]).args(more).output().expect("bksim runs")
    };
    let logs = |folder: &str| {
        let files = fs::read_dir(place.path().join(folder)).expect("a folder");
        let paths = files.map(|file| file.expect("a file").path());
        let is_log = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "mcap");
        let name = |path: PathBuf| path.file_name().expect("a name").display().to_string();
        let mut logs: Vec<String> = paths.filter(is_log).map(name).collect();
        logs.sort();
        logs
    };

    // By comparison: masses of -1 kg are refused, and long pendulums fall deeper.
    for (chosen, folder, expected) in [
        ("6,7,8-9", "numbers", &["t-6.mcap", "t-7.mcap"][..]),
        ("largest max(energy.kinetic)", "largest", &["t-15.mcap"]),
        ("max(energy.kinetic) > 1 mJ and l < 700 mm", "where", &["t-2.mcap", "t-3.mcap"]),
        ("failed", "failed", &[]),
    ] {
        let swept = sweep(chosen, &["--logs", folder]);
        assert_eq!(swept.status.code(), Some(0), "{chosen}: {}", text(&swept.stderr));
        assert_eq!(logs(folder), expected, "{chosen}");
    }
    // Each is the log of a single run with these values.
    let mut bksim = place.bksim();
    bksim.args(["solve", "swing.toml", "--set", "l=1", "--set", "m=1", "-o", "one.mcap"]);
    let solved = bksim.args(["--set", "initial.phi=0.6 rad"]).output().expect("bksim runs");
    assert!(solved.status.success(), "{}", text(&solved.stderr));
    let table = |log: &str| place.run(&format!("export {log}")).stdout;
    assert!(!table("one.mcap").is_empty());
    assert!(table("one.mcap") == table("numbers/t-7.mcap"));
    // Again: one's own logs are replaced, and a file of somebody else is not.
    let again = sweep("3", &["--logs", "where"]);
    assert_eq!(again.status.code(), Some(0), "{}", text(&again.stderr));
    place.write("where/t-3.mcap", "mine");
    assert_eq!(sweep("3", &["--logs", "where"]).status.code(), Some(4));

    for (chosen, word) in [
        ("16", "numbers 0 to 15"),
        ("l > 1 kg", "`l` is in m"),
        ("ll > 1", "no column `ll`: one of `l`"),
        ("deepest", "write numbers of cases"),
    ] {
        let swept = sweep(chosen, &[]);
        assert_eq!(swept.status.code(), Some(2), "{chosen}: {}", text(&swept.stderr));
        assert!(text(&swept.stderr).contains(word), "{chosen}: {}", text(&swept.stderr));
    }
}

#[test]
fn joints_yield_in_rows_and_in_the_logs_of_cases() {
    let place = place(include_str!("../../../tests/fixtures/beam-on-three-pins.toml"));
    let swept = |more: &[&str]| {
        let mut bksim = place.bksim();
        bksim.args(["sweep", "swing.toml", "--set", "m=5,7 kg", "--keep", "final(reactions.B.fy)"]);
        bksim.args(["-o", "t.csv", "--force"]);
        let swept = bksim.args(more).output().expect("bksim runs");
        assert_eq!(swept.status.code(), Some(0), "{}", text(&swept.stderr));
        let table = fs::read_to_string(place.path().join("t.csv")).expect("a table");
        let last = table.lines().last().expect("a row").split(',').nth(2).expect("a number");
        last.parse::<f64>().expect("a number")
    };
    let springs =
        ["--compliance", "A=1e8 N/m", "--compliance", "B=3e8 N/m", "--compliance", "C=1e8 N/m"];
    let rigid = swept(&[]);
    let yielding = swept(&[&springs[..], &["--log-cases", "1"]].concat());
    assert!((yielding - rigid).abs() > 1.0, "{yielding} beside {rigid}");
    let logged = place.run("export t-1.mcap reactions.B.fy").stdout;
    let logged = text(&logged).lines().last().expect("a row").rsplit(',').next().map(str::to_owned);
    assert_eq!(logged.and_then(|value| value.parse().ok()), Some(yielding));
}

#[test]
fn tables_are_in_si_and_answers_of_design_in_units() {
    let place = place(PENDULUM);
    let run =
        |arguments: &str| place.bksim().args(arguments.split(' ')).output().expect("bksim runs");
    let refused = run("sweep swing.toml --set l=0.5:1.5:2 --units mm");
    assert_eq!(refused.status.code(), Some(2));
    let said = text(&refused.stderr);
    assert!(said.contains("the table of a sweep is in SI units"), "{said}");
    assert!(!place.path().join("swing.parquet").exists());

    let bar = r#"
[parameters]
b = "200 mm"
[bodies.bar]
mass = 1
inertia = 1
points = { A = [0, 0], B = ["b", 0] }
[joints.A]
type = "revolute"
between = ["ground", "bar.A"]
[initial]
A = { angle = "30 deg" }
[optimize]
maximize = "bar.B.x"
vary = { b = ["150 mm", "250 mm"] }
over = "A.angle=30:40 deg:2"
[tolerance]
of = "bar.B.x"
at = { "A.angle" = "30 deg" }
limits = { b = "±0.1 mm" }
samples = 1000
"#;
    place.write("bar.toml", bar);
    let said = |arguments: &str| {
        let output = run(arguments);
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let found = said("tolerance bar.toml --units mm,deg");
    for part in ["At A.angle = 30 deg", "173.205081 mm", "-0.1 to 0.1 mm"] {
        assert!(found.contains(part), "{part}: {found}");
    }
    let plain = said("tolerance bar.toml");
    assert!(plain.contains("0.173205081 m\n"), "{plain}");
    let found = said("optimize bar.toml --units mm --maximize max(bar.B.x)");
    for part in ["200 mm", "250 mm", "mm per mm"] {
        assert!(found.contains(part), "{part}: {found}");
    }
}
