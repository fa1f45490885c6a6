//! A run that is stopped from outside leaves a log that can be read.
#![cfg(unix)]

mod common;

use std::collections::BTreeSet;
use std::fs;
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use common::{Scratch, text};

/// A pendulum that swings for days, and is sampled every millisecond.
const LONG: &str = include_str!("../../../tests/fixtures/long-pendulum.toml");

/// Starts the run and waits until its log grows.
fn started(place: &Scratch) -> Child {
    start(place, LONG, &[])
}

fn start(place: &Scratch, model: &str, options: &[&str]) -> Child {
    place.write("long.toml", model);
    let child = place
        .bksim()
        .args(["solve", "long.toml"])
        .args(options)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("bksim starts");
    let begun = Instant::now();
    let size = || fs::metadata(place.path().join("long.mcap")).map_or(0, |file| file.len());
    while size() < 100_000 {
        assert!(begun.elapsed() < Duration::from_secs(20), "nothing is logged");
        sleep(Duration::from_millis(20));
    }
    child
}

/// Waits for its end, and ends it where that does not come.
fn ended_soon(mut child: Child) -> Output {
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(10) {
        if child.try_wait().expect("a state").is_some() {
            return child.wait_with_output().expect("an end");
        }
        sleep(Duration::from_millis(5));
    }
    child.kill().expect("an end");
    child.wait_with_output().expect("an end")
}

fn signal(child: &Child, name: &str) {
    let kill = Command::new("kill").args([name, &child.id().to_string()]).status();
    assert!(kill.expect("kill starts").success());
}

#[test]
fn an_export_that_is_interrupted_leaves_nothing_behind() {
    let place = Scratch::new();
    // A log of ten thousand seconds, as its run was stopped after some of them.
    let solving = start(&place, LONG, &[]);
    sleep(Duration::from_secs(2));
    signal(&solving, "-INT");
    ended_soon(solving);
    for name in ["-INT", "-TERM", "-HUP"] {
        let child = place.bksim().args(["export", "long.mcap", "-o", "long.csv"]).spawn();
        let child = child.expect("bksim starts");
        let begun = Instant::now();
        let files = || -> Vec<String> {
            let entries = fs::read_dir(place.path()).expect("the directory");
            let name = |entry: fs::DirEntry| entry.file_name().to_string_lossy().into_owned();
            entries.map(|entry| name(entry.expect("an entry"))).collect()
        };
        while !files().iter().any(|name| name.contains(".csv.")) {
            assert!(begun.elapsed() < Duration::from_secs(10), "no file is begun");
        }
        signal(&child, name);
        let output = ended_soon(child);
        assert!(!output.status.success(), "{name}: it was exported before");
        let mut left = files();
        left.sort();
        assert_eq!(left, ["long.mcap", "long.toml"], "{name}");
    }
}

/// Times of all samples of the log, and what its export says.
fn samples(place: &Scratch) -> (Vec<f64>, String) {
    let output = place.run("export long.mcap state.A_angle");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let table = text(&output.stdout);
    let time = |line: &str| line.split(',').next().and_then(|t| t.parse().ok());
    (table.lines().filter_map(time).collect(), text(&output.stderr))
}

#[test]
fn signals_close_the_log_at_once() {
    for (name, status, word) in [("-INT", 130, "interrupted"), ("-TERM", 143, "terminated")] {
        let place = Scratch::new();
        let child = started(&place);
        let begun = Instant::now();
        signal(&child, name);
        let output = child.wait_with_output().expect("an end");
        // Milliseconds on an idle machine; the bound leaves room for a busy one.
        assert!(begun.elapsed() < Duration::from_secs(5), "{:?}", begun.elapsed());
        assert_eq!(output.status.code(), Some(status), "{}", text(&output.stderr));
        let report = text(&output.stdout);
        assert!(report.starts_with(&format!("long: {word} at t = ")), "{report}");

        // Whole: nothing to warn of, no sample is missing, and the last is where the run stopped.
        let (times, warning) = samples(&place);
        assert_eq!(warning, "");
        let reached = report.split_whitespace().nth(5).and_then(|t| t.parse::<f64>().ok());
        let (last, reached) = (times[times.len() - 1], reached.expect("a time"));
        assert!((last - reached).abs() < 1e-8 * last, "{last} in {report}");
        let on_grid = &times[..times.len() - 1];
        assert!(on_grid.iter().enumerate().all(|(k, t)| (t - 1e-3 * k as f64).abs() < 1e-9));
        let beyond = last - on_grid[on_grid.len() - 1];
        assert!(beyond > 0.0 && beyond < 1.001e-3, "the last sample is {beyond} s on");
    }
}

#[test]
fn a_step_with_thousands_of_millions_of_samples_is_left_at_once() {
    for (name, status) in [("-INT", 130), ("-TERM", 143)] {
        let place = Scratch::new();
        let child = start(&place, LONG, &["--t-end", "1e-3", "--every", "1e-12"]);
        let begun = Instant::now();
        signal(&child, name);
        let output = ended_soon(child);
        // A fifth of a second on an idle machine; the bound leaves room for a busy one.
        assert!(begun.elapsed() < Duration::from_secs(2), "{:?}", begun.elapsed());
        assert_eq!(output.status.code(), Some(status), "{}", text(&output.stderr));
        let (times, warning) = samples(&place);
        assert_eq!(warning, "");
        assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
        let info = place.run("info long.mcap");
        assert!(text(&info.stdout).contains("resumable"), "{}", text(&info.stdout));
    }
}

#[test]
fn more_samples_than_a_disk_holds_are_refused_with_their_size() {
    let place = Scratch::new();
    place.write("long.toml", LONG);
    for (every, words) in [
        ("1e-12", "makes 1.0e13 samples from t = 0 s to 10 s"),
        ("1e-320", "samples from t = 0 s to 10 s"),
    ] {
        let output = place.run(&format!("solve long.toml --t-end 10 --every {every}"));
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("S020") && said.contains(words) && said.contains(" TB"), "{said}");
    }
    assert_eq!(fs::read_dir(place.path()).expect("a folder").count(), 1, "nothing was written");
}

#[test]
fn an_interrupted_run_is_resumed_as_if_undisturbed() {
    let place = Scratch::new();
    let child = start(&place, &LONG.replace("1e6 s", "300 s"), &[]);
    signal(&child, "-INT");
    let output = child.wait_with_output().expect("an end");
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    let done = |arguments: &str| {
        let output = place.run(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments}: {}", text(&output.stderr));
        output.stdout
    };

    // Every channel of every sample, to the last bit.
    done("solve long.toml -o whole.mcap");
    done("solve --resume long.mcap");
    let whole = done("export whole.mcap");
    assert!(text(&whole).lines().count() > 300_000);
    assert!(done("export long-resumed.mcap") == whole, "other samples");

    // In the place of the first part, when that is wished.
    let output = place.run("solve --resume long.mcap -o long.mcap");
    assert_eq!(output.status.code(), Some(4), "{}", text(&output.stderr));
    done("solve --resume long.mcap -o long.mcap --force");
    assert!(done("export long.mcap") == whole, "other samples");
    let files = fs::read_dir(place.path()).expect("the directory").count();
    assert_eq!(files, 4, "something is left over");

    for (arguments, status, words) in [
        ("solve --resume long.mcap --force", 1, "its run has reached its end, t = 300 s"),
        ("solve --resume long.toml", 1, "not an MCAP file"),
        ("solve --resume none.mcap", 4, "there is no such file"),
        ("solve --resume long.mcap --rtol 1e-8", 2, "cannot be used with"),
    ] {
        let output = place.run(arguments);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{arguments}: {said}");
        assert!(said.contains(words), "{arguments}: {said}");
    }
    let bytes = fs::read(place.path().join("whole.mcap")).expect("the log");
    place.write("cut.mcap", &bytes[..bytes.len() / 2]);
    done("solve --resume cut.mcap");
    assert!(done("export cut-resumed.mcap") == whole, "other samples");
    place.write("cut.mcap", &bytes[..40_000]);
    let output = place.run("solve --resume cut.mcap --force");
    assert_eq!(output.status.code(), Some(1));
    let said = text(&output.stderr);
    assert!(said.contains("was cut off before its run ended"), "{said}");
}

#[test]
fn a_resumed_log_has_the_channels_of_its_first_part() {
    let place = Scratch::new();
    let child = start(&place, &LONG.replace("1e6 s", "600 s"), &["--channels", "own"]);
    signal(&child, "-INT");
    let output = child.wait_with_output().expect("an end");
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    let output = place.run("solve --resume long.mcap");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let topics = |name: &str| {
        let log = fs::read(place.path().join(name)).expect("a log");
        let summary = mcap::Summary::read(&log).expect("an MCAP file").expect("its summary");
        let topics = summary.channels.values().map(|channel| channel.topic.clone());
        topics.collect::<BTreeSet<String>>()
    };
    let first = topics("long.mcap");
    assert!(!first.contains("/tf") && first.contains("/state"), "{first:?}");
    assert_eq!(topics("long-resumed.mcap"), first);
}
