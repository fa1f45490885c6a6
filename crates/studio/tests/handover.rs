//! The two programs together: `bksim` finds `bksim-studio` in its folder.
#![cfg(unix)]

use std::env;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{CRATE, PROGRAM, Scratch, text};

/// The main command in the folder of the studio; built where nobody has yet, which tests of the
/// whole workspace have.
fn bksim() -> PathBuf {
    let program = Path::new(PROGRAM).with_file_name("bksim");
    if !program.exists() {
        let folder = program.parent().and_then(Path::parent).expect("the target directory");
        let status = Command::new(env!("CARGO"))
            .args(["build", "-p", "bksim-cli", "--target-dir"])
            .arg(folder)
            .current_dir(CRATE)
            .status();
        assert!(status.expect("cargo starts").success(), "bksim is not built");
    }
    program
}

#[test]
fn the_main_command_does_all_that_the_studio_does() {
    let place = Scratch::new();
    let model = format!("{CRATE}/../../examples/parallelogram/model.toml");
    // By a link, too.
    symlink(bksim(), place.path().join("linked")).expect("a link");
    for program in [bksim(), place.path().join("linked")] {
        for command in [
            &format!("solve {model} --t-end 0.2 -o run.mcap --force"),
            "plot run.mcap -o run.svg --force",
            "page run.mcap -o run.html --force",
            "export run.mcap -o run.parquet --force",
            "render run.mcap -o picture.svg --force",
        ] {
            let output = Command::new(&program)
                .args(command.split_whitespace())
                .current_dir(place.path())
                .output()
                .expect("bksim starts");
            assert!(output.status.success(), "{command}: {}", text(&output.stderr));
        }
    }
    let table = fs::read(place.path().join("run.parquet")).expect("a table");
    assert!(table.starts_with(b"PAR1"));
}

#[test]
fn both_programs_have_one_command_line() {
    let commands = ["--help", "plot --help", "solve --help", "plto", "view", "--version"];
    for arguments in commands {
        let [own, main] = [PathBuf::from(PROGRAM), bksim()].map(|program| {
            let output = Command::new(program).args(arguments.split(' ')).output();
            let output = output.expect("it starts");
            (output.status.code(), text(&output.stdout), text(&output.stderr))
        });
        assert_eq!(own, main, "{arguments}");
    }
}
