//! Commands of the studio: handed on to the program in the folder of `bksim`, or refused in one
//! sentence where that is missing. The program is a script here, so that it need not be built.
#![cfg(unix)]

use std::fs;
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::process::{Command, Stdio};

use crate::common::{PROGRAM, Scratch, text};

/// A copy of `bksim` that has no other program in its folder.
fn alone() -> Scratch {
    let place = Scratch::new();
    install(&place, PROGRAM, "bksim");
    place
}

/// Copies a program there by another process: had this one the file open for writing while a thread
/// starts something, the copy would be busy until that has begun.
fn install(place: &Scratch, from: &str, name: &str) {
    let copied = Command::new("cp").arg(from).arg(name).current_dir(place.path()).status();
    assert!(copied.expect("cp starts").success(), "{name} is not copied");
}

/// The copy, with arguments separated by blanks.
fn bksim(place: &Scratch, arguments: &str) -> Command {
    let mut command = Command::new(place.path().join("bksim"));
    command.current_dir(place.path()).env("NO_COLOR", "1").args(arguments.split_whitespace());
    command
}

/// Puts a program of the studio there.
fn add_studio(place: &Scratch, script: &str) {
    place.write("script", format!("#!/bin/sh\n{script}"));
    let script = place.path().join("script");
    fs::set_permissions(script, fs::Permissions::from_mode(0o755)).expect("a program");
    install(place, "script", "bksim-studio");
}

const COMMANDS: [&str; 6] = [
    "view model.toml",
    "render model.toml -o a.png",
    "page a.mcap",
    "plot a.mcap --json",
    "sweep model.toml --set l=1,2",
    "export a.mcap -o a.parquet",
];

#[test]
fn without_the_studio_one_sentence_says_how_to_have_it() {
    let place = alone();
    for command in COMMANDS {
        let output = bksim(&place, command).output().expect("bksim starts");
        assert_eq!(output.status.code(), Some(4), "{command}");
        let said = text(&output.stderr) + &text(&output.stdout);
        for words in ["`bksim-studio`, which is not", "`cargo build -p bksim-studio`"] {
            assert!(said.contains(words), "{command}: {said}");
        }
    }
    let said = bksim(&place, "plot a.mcap").output().expect("bksim starts").stderr;
    let first = "error: `bksim plot` needs the program `bksim-studio`, which is not in the folder \
                 of `bksim`\n";
    assert!(text(&said).starts_with(first), "{}", text(&said));
    let output = bksim(&place, "plot a.mcap --json").output().expect("bksim starts");
    let object: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one object");
    assert_eq!(object["command"], "plot");
    assert_eq!(object["exit_status"], 4);
}

#[test]
fn arguments_streams_and_status_are_handed_on() {
    let place = alone();
    add_studio(&place, "for word; do echo \"<$word>\"; done\ncat\necho told >&2\nexit 3\n");
    let mut command = bksim(&place, "plot --json");
    command.args(["a b.mcap", "state.*"]);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("bksim starts");
    child.stdin.take().expect("piped").write_all(b"given\n").expect("written");
    let output = child.wait_with_output().expect("an end");
    assert_eq!(output.status.code(), Some(3));
    assert_eq!(text(&output.stdout), "<plot>\n<--json>\n<a b.mcap>\n<state.*>\ngiven\n");
    assert_eq!(text(&output.stderr), "told\n");
}

#[test]
fn every_command_of_the_studio_and_no_other_is_handed_on() {
    let place = alone();
    add_studio(&place, "echo \"handed on: $*\"\n");
    for command in COMMANDS {
        let output = bksim(&place, command).output().expect("bksim starts");
        assert_eq!(text(&output.stdout), format!("handed on: {command}\n"));
    }
    for command in ["export a.mcap -o a.csv", "info a.mcap", "explain", "--help", "plot --nonsense"]
    {
        let output = bksim(&place, command).output().expect("bksim starts");
        assert!(!text(&output.stdout).contains("handed on"), "{command}");
    }
}

#[test]
fn the_studio_takes_the_place_of_the_process_so_that_signals_reach_it() {
    let place = alone();
    add_studio(&place, "echo $$\n");
    let child = bksim(&place, "page a.mcap").stdout(Stdio::piped()).spawn().expect("bksim starts");
    let id = child.id();
    let output = child.wait_with_output().expect("an end");
    assert_eq!(text(&output.stdout), format!("{id}\n"));
}

#[test]
fn a_studio_that_cannot_be_started_is_a_fault() {
    let place = alone();
    place.write("bksim-studio", "no program");
    let output = bksim(&place, "page a.mcap").output().expect("bksim starts");
    assert_eq!(output.status.code(), Some(4));
    let said = text(&output.stderr);
    assert!(said.contains("`bksim-studio`, which cannot be started: "), "{said}");
    assert!(!said.contains("os error"), "{said}");
}

#[test]
fn without_a_desktop_no_layer_of_mesa_asks_for_one() {
    let place = alone();
    add_studio(&place, "echo \"${NODEVICE_SELECT-unset}\"\n");
    let said = |variables: &[&str]| {
        let mut command = bksim(&place, "render model.toml -o a.png");
        for name in ["XDG_RUNTIME_DIR", "WAYLAND_DISPLAY", "DISPLAY", "NODEVICE_SELECT"] {
            command.env_remove(name);
        }
        command.envs(variables.iter().map(|name| (name, "/tmp")));
        text(&command.output().expect("bksim starts").stdout)
    };
    assert_eq!(said(&[]), "1\n");
    for desktop in ["XDG_RUNTIME_DIR", "WAYLAND_DISPLAY", "DISPLAY"] {
        assert_eq!(said(&[desktop]), "unset\n", "{desktop}");
    }
}
