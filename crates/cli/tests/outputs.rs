//! Files that are written: none is lost, none is corrupt, and two commands that want the same one hear of
//! each other.
#![cfg(unix)]

mod common;

use std::fs;
use std::os::unix::fs::symlink;
use std::process::{Command, Stdio};

use common::{CRATE, PROGRAM, Scratch, text};

/// A pendulum, with many samples.
const LONG: &str = include_str!("../../../tests/fixtures/long-pendulum.toml");

#[test]
fn of_eight_runs_that_want_one_new_log_each_gets_it_or_is_refused() {
    let model = format!("{CRATE}/../../examples/four-bar/model.toml");
    for force in [false, true] {
        let place = Scratch::new();
        let start = || {
            let mut command = place.bksim();
            command.args(["solve", &model, "-o", "run.mcap"]).args(force.then_some("--force"));
            command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("bksim starts")
        };
        let children: Vec<_> = (0..8).map(|_| start()).collect();
        let ended: Vec<_> =
            children.into_iter().map(|child| child.wait_with_output().expect("an end")).collect();
        let n_done = ended.iter().filter(|output| output.status.code() == Some(0)).count();
        // One that begins when another one has ended replaces its log.
        assert!(n_done >= 1, "{n_done} logs are written");
        for output in ended.iter().filter(|output| output.status.code() != Some(0)) {
            let said = text(&output.stderr);
            assert_eq!(output.status.code(), Some(4), "{said}");
            assert!(said.contains("`run.mcap` exists"), "{said}");
        }
        // Whoever has written it, it is whole, and nothing else is left.
        let table = place.run("export run.mcap");
        assert_eq!(text(&table.stderr), "");
        assert_eq!(fs::read_dir(place.path()).expect("a folder").count(), 1);
    }
}

#[test]
fn a_full_disk_is_told_by_every_command_that_writes() {
    let place = Scratch::new();
    let folder = format!("{CRATE}/../../examples/four-bar");
    assert!(place.run(&format!("solve {folder}/model.toml -o run.mcap")).status.success());
    for arguments in [
        format!("solve {folder}/model.toml -o /dev/full --force"),
        "cad template -o /dev/full --force".to_owned(),
        format!("cad from-toml {folder}/model.toml -o /dev/full --force"),
    ] {
        let output = place.run(&arguments);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(4), "{arguments}: {said}");
        assert!(said.contains("No space left on device"), "{arguments}: {said}");
    }
    // Whatever is printed, too.
    for arguments in ["info run.mcap", "export run.mcap", "explain", "explain --json"] {
        let full = fs::File::options().write(true).open("/dev/full").expect("a device");
        let mut command = place.bksim();
        let output = command.args(arguments.split(' ')).stdout(full).output().expect("an end");
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(4), "{arguments}: {said}");
        assert!(said.contains("`standard output` cannot be written"), "{arguments}: {said}");
    }
}

#[test]
fn a_reader_that_goes_away_is_no_fault() {
    let place = Scratch::new();
    let folder = format!("{CRATE}/../../examples/four-bar");
    assert!(place.run(&format!("solve {folder}/model.toml -o run.mcap")).status.success());
    for arguments in ["info run.mcap", "export run.mcap", "explain", "explain --json"] {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let mut command = place.bksim();
        let output = command.args(arguments.split(' ')).stdout(writer).output().expect("an end");
        assert_eq!(output.status.code(), Some(0), "{arguments}: {}", text(&output.stderr));
        assert_eq!(text(&output.stderr), "", "{arguments}");
    }
}

#[test]
fn a_log_that_may_not_grow_tells_what_can_be_read() {
    let place = Scratch::new();
    place.write("long.toml", LONG);
    // In units of 512 bytes.
    let command = format!("ulimit -f 2000; exec {PROGRAM} solve long.toml");
    let mut shell = Command::new("sh");
    shell.args(["-c", &command]).current_dir(place.path()).env("NO_COLOR", "1");
    let output = shell.output().expect("a shell");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{said}");
    let (_, told) = said.split_once("samples up to t = ").expect(&said);
    let told: f64 = told.split(' ').next().expect("a time").parse().expect(&said);

    let table = place.run("export long.mcap state.A_angle");
    let table = text(&table.stdout);
    let last = table.lines().last().expect("samples").split(',').next().expect("a time");
    assert_eq!(last.parse::<f64>(), Ok(told), "{said}");
    assert!(told > 0.0, "{said}");
}

#[test]
fn a_log_is_never_written_over_its_model() {
    let place = Scratch::new();
    place.write("long.toml", LONG);
    let at = |name: &str| place.path().join(name);
    fs::hard_link(at("long.toml"), at("hard.mcap")).expect("a link");
    symlink(at("long.toml"), at("soft.mcap")).expect("a link");
    for name in ["long.toml", "hard.mcap", "soft.mcap"] {
        let output = place.run(&format!("solve long.toml --t-end 1 --force -o {name}"));
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(4), "{said}");
        assert!(said.contains("is the model itself and would be overwritten"), "{said}");
    }
    assert_eq!(fs::read_to_string(at("long.toml")).expect("a model"), LONG);
}

#[test]
fn a_log_that_is_replaced_stays_until_the_new_one_is_whole() {
    let place = Scratch::new();
    place.write("long.toml", LONG);
    assert!(place.run("solve long.toml --t-end 1").status.success());
    let before = fs::read(place.path().join("long.mcap")).expect("a log");
    let command = format!("ulimit -f 2000; exec {PROGRAM} solve long.toml --force");
    let mut shell = Command::new("sh");
    let output = shell.args(["-c", &command]).current_dir(place.path()).output().expect("a shell");
    assert_eq!(output.status.code(), Some(4), "{}", text(&output.stderr));
    assert_eq!(fs::read(place.path().join("long.mcap")).expect("a log"), before);
}
