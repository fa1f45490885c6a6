//! Solvers in C move as bksim does; units are run by an importer of others, FMPy.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use bksim_fmu::{Core, Platform, Request, Unit, Version, archive, solver};
use bksim_sim::Mechanism;
use tempfile::TempDir;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

fn text_of(path: &str) -> String {
    let path = Path::new(ROOT).join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn core_of(text: &str, name: &str, request: &Request) -> Core {
    let mut mechanism =
        Mechanism::from_toml(text, name).unwrap_or_else(|error| panic!("{error:?}"));
    Core::of(&mut mechanism, request).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Compiles files in a folder.
fn compile(folder: &Path, arguments: &[&str]) {
    compile_by("cc", folder, arguments);
}

fn compile_by(compiler: &str, folder: &Path, arguments: &[&str]) {
    let flags =
        ["-std=c99", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-pedantic", "-Werror"];
    let mut compiler = Command::new(compiler);
    let output = compiler.current_dir(folder).args(flags).args(arguments).arg("-lm").output();
    let output = output.expect("a C compiler");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// The header, source and test of a solver, in a folder.
fn written(text: &str, name: &str) -> (TempDir, String) {
    let solver = solver(&core_of(text, name, &Request::default()));
    let folder = tempfile::tempdir().expect("a folder");
    let files = [("h", &solver.header), ("c", &solver.source)];
    for (ending, text) in files {
        fs::write(folder.path().join(format!("{}.{ending}", solver.name)), text).expect("written");
    }
    fs::write(folder.path().join("test.c"), &solver.test).expect("written");
    (folder, solver.name)
}

/// Compiles and runs the test of a solver; returns how many coordinates it compared.
fn n_compared(text: &str, name: &str) -> usize {
    let (folder, solver) = written(text, name);
    compile(folder.path(), &[&format!("{solver}.c"), "test.c", "-o", "test"]);
    let output = Command::new(folder.path().join("test")).output().expect("the test runs");
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).lines().count()
}

/// Loops, conditions that repeat others, stops, kinks, friction by forces and by reactions, clocks.
#[test]
fn solvers_in_c_move_as_bksim_does() {
    for (name, n) in [
        ("examples/slider-crank/model", 15),
        ("tests/fixtures/bennett", 9),
        ("tests/fixtures/block-on-belt", 6),
        ("tests/fixtures/kinks-and-contacts", 6),
        ("tests/fixtures/oblique-slider", 9),
        ("tests/fixtures/elements/encoder-quantised", 3),
        ("tests/fixtures/elements/wedge", 18),
    ] {
        assert_eq!(n_compared(&text_of(&format!("{name}.toml")), "model"), n, "{name}");
    }
}

/// A processor of another kind: its compiler, what that is told besides, and the program that stands in for it.
struct Board {
    compiler: &'static str,
    flags: &'static [&'static str],
    emulator: &'static [&'static str],
}

const BOARDS: [Board; 2] = [
    Board { compiler: "aarch64-linux-gnu-gcc", flags: &["-static"], emulator: &["qemu-aarch64"] },
    Board {
        compiler: "arm-none-eabi-gcc",
        flags: &[
            "-mcpu=cortex-m4",
            "-mthumb",
            "-mfloat-abi=hard",
            "-mfpu=fpv4-sp-d16",
            "--specs=rdimon.specs",
            "-nostartfiles",
            concat!("-T", env!("CARGO_MANIFEST_DIR"), "/tests/board/board.ld"),
            concat!(env!("CARGO_MANIFEST_DIR"), "/tests/board/start.c"),
        ],
        emulator: &[
            "qemu-system-arm",
            "-machine",
            "mps2-an386",
            "-nographic",
            "-semihosting-config",
            "enable=on,target=native",
            "-kernel",
        ],
    },
];

/// Tests of solvers pass on a Cortex-A and on a Cortex-M4, where Debian's `gcc-aarch64-linux-gnu`, `libc6-dev-arm64-cross`
/// and `qemu-user`, or `gcc-arm-none-eabi`, `libnewlib-arm-none-eabi` and `qemu-system-arm`, are installed.
#[test]
#[expect(clippy::print_stdout, reason = "it says which processors were tried")]
fn solvers_in_c_move_so_on_other_processors() {
    let is_there = |program: &str| Command::new(program).arg("--version").output().is_ok();
    for board in BOARDS {
        if !is_there(board.compiler) || !is_there(board.emulator[0]) {
            println!("without {} or {}", board.compiler, board.emulator[0]);
            continue;
        }
        let mut n_numbers = 0;
        // Loops; a rope that only pulls, without contacts; stops with friction.
        for model in [
            "examples/slider-crank/model.toml",
            "examples/block-and-tackle/model.toml",
            "tests/fixtures/kinks-and-contacts.toml",
        ] {
            let (folder, solver) = written(&text_of(model), "model");
            let files = [&format!("{solver}.c"), "test.c", "-o", "test"];
            compile_by(board.compiler, folder.path(), &[board.flags, &files].concat());
            let mut run = Command::new(board.emulator[0]);
            run.current_dir(folder.path()).args(&board.emulator[1..]).arg("test");
            let output = run.output().expect("it runs");
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{model} by {}: {said}", board.compiler);
            n_numbers += String::from_utf8_lossy(&output.stdout).lines().count();
        }
        assert!(n_numbers > 20, "{n_numbers} numbers");
    }
}

/// Steps of one size, explicit and implicit, with another length set before the start.
#[test]
fn steps_of_one_size_follow_values_that_are_set() {
    let (folder, solver) = written(&pendulum(""), "pendulum");
    let program = r#"
#include "pendulum_solver.h"
#include <stdio.h>
static pendulum_solver_model m;
int main(void) {
    int method, k;
    for (method = 0; method < 2; method++) {
        pendulum_solver_init(&m);
        m.s.method = method;
        pendulum_solver_set(&m, PENDULUM_SOLVER_VALUE_l, 0.5);
        if (pendulum_solver_start(&m)) return 1;
        for (k = 0; k < 200; k++) {
            if (pendulum_solver_step(&m, 0.005)) return 2;
        }
        printf("%.17g %.17g\n", m.s.q[0], pendulum_solver_time(&m));
    }
    return 0;
}
"#;
    fs::write(folder.path().join("own.c"), program).expect("written");
    compile(folder.path(), &[&format!("{solver}.c"), "own.c", "-o", "own"]);
    let output = Command::new(folder.path().join("own")).output().expect("it runs");
    assert!(output.status.success(), "{:?}", output.status);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let numbers: Vec<f64> =
        said.split_whitespace().map(|word| word.parse().expect("a number")).collect();
    // By bksim, with the length written into the model.
    let other =
        Mechanism::from_toml(&pendulum("").replace("l = \"1 m\"", "l = \"0.5 m\""), "other");
    let motion = other.expect("a model").solve().expect("a motion");
    let expected = motion.samples.last().expect("samples").q[0];
    assert_eq!(numbers.len(), 4);
    for pair in numbers.chunks(2) {
        assert!((pair[0] - expected).abs() < 1e-6, "{} instead of {expected}", pair[0]);
        assert!((pair[1] - 1.0).abs() < 1e-12, "{}", pair[1]);
    }
    assert!((numbers[0] - numbers[2]).abs() > 0.0, "two methods, one result");
}

fn pendulum(more: &str) -> String {
    format!(
        "[parameters]\nl = \"1 m\"\n{more}[bodies.bob]\nmass = \"2 kg\"\ninertia = 0\ncom = [0, \"-l\"]\n\
         [joints.pin]\ntype = \"revolute\"\nbetween = [\"ground\", \"bob\"]\n\
         [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n\
         [initial]\npin = {{ angle = \"30 deg\", rate = 0 }}\n[solve]\nt_end = \"1 s\"\n"
    )
}

/// A unit as a file, with its program.
fn unit_file(folder: &Path, core: Core, version: Version) -> PathBuf {
    let unit = Unit::new(core, version);
    fs::write(folder.join("unit.c"), &unit.source).expect("written");
    compile(folder, &["-fPIC", "-shared", "-fvisibility=hidden", "unit.c", "-o", "unit.so"]);
    let program = fs::read(folder.join("unit.so")).expect("a program");
    let platform = Platform::of(std::env::consts::ARCH, std::env::consts::OS).expect("a platform");
    let path =
        folder.join(format!("{}{}.fmu", unit.core.identifier, u8::from(version == Version::Three)));
    fs::write(&path, archive(&unit.files(Some((platform, program))))).expect("written");
    path
}

/// Valid descriptions; model exchange and co-simulation against closed forms and against values of many digits; states
/// saved, derivatives, events.
#[test]
fn an_importer_of_others_runs_units() {
    let own = Path::new(ROOT).join("target/venv/bin/python");
    let python = std::env::var_os("BKSIM_PYTHON").map_or(own, PathBuf::from);
    let folder = tempfile::tempdir().expect("a folder");
    let mut files = Vec::new();
    let crank = text_of("examples/slider-crank/model.toml");
    let outputs = ["theta1", "theta1_dot", "x3", "x3_dot", "theta2"].map(str::to_owned).to_vec();
    let request = Request { inputs: Vec::new(), outputs };
    let crank = core_of(&crank, "slider_crank", &request);
    files.push(unit_file(folder.path(), crank, Version::Three));
    let ball = core_of(&text_of("tests/fixtures/falling-ball.toml"), "ball", &Request::default());
    files.push(unit_file(folder.path(), ball, Version::Two));
    let rattle =
        core_of(&text_of("examples/gear-rattle/model.toml"), "rattle", &Request::default());
    files.push(unit_file(folder.path(), rattle, Version::Three));
    for version in [Version::Three, Version::Two] {
        let pushed = pendulum("u = \"0 N m\"\n")
            + "[loads.motor]\ntype = \"torque\"\njoint = \"pin\"\nvalue = \"u\"\n";
        let request = Request { inputs: vec!["u".to_owned()], outputs: Vec::new() };
        files.push(unit_file(folder.path(), core_of(&pushed, "pendulum", &request), version));
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/units.py");
    let output = Command::new(python).arg(script).args(&files).output().expect("Python");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(said.lines().count(), files.len(), "{said}");
}

#[test]
fn the_same_model_gives_the_same_bytes() {
    let unit = || {
        let core = core_of(&pendulum(""), "pendulum", &Request::default());
        archive(&Unit::new(core, Version::Three).files(None))
    };
    let bytes = unit();
    assert_eq!(bytes, unit());
    assert!(bytes.starts_with(b"PK\x03\x04"), "a ZIP file");
}

#[test]
fn inputs_and_outputs_that_there_are_not_are_refused() {
    let refused = |inputs: &[&str], outputs: &[&str]| {
        let mut mechanism = Mechanism::from_toml(&pendulum(""), "pendulum").expect("a model");
        let [inputs, outputs] =
            [inputs, outputs].map(|names| names.iter().map(ToString::to_string).collect());
        Core::of(&mut mechanism, &Request { inputs, outputs }).err().expect("a fault").diagnostics()
    };
    assert!(refused(&["motor"], &[])[0].message.contains("motor"));
    assert!(refused(&[], &["pin.speed"])[0].message.contains("pin.speed"));
    // A length is more than a part of loads.
    assert!(refused(&["l"], &[])[0].message.contains('l'));
}
