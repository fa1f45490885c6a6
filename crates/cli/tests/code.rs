//! Written code is compiled, tests itself, and holds the equations of motion.

use std::process::Command;

use crate::common::{CRATE, Scratch, text};
use serde_json::Value;

/// The functions of an example as C in the folder `code`, as JSON says.
fn written(place: &Scratch, example: &str, arguments: &str) -> Value {
    let model = format!("{CRATE}/../../examples/{example}/model.toml");
    let output = place.run(&format!("code {model} -o code {arguments} --json"));
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one object")
}

/// Outputs that the test program of a C function prints, a row for each of its points.
fn tested(place: &Scratch, name: &str, n_outputs: usize) -> Vec<Vec<f64>> {
    let mut compiler = Command::new("cc");
    let flags = ["-std=c99", "-O2", "-Wall", "-Wextra", "-pedantic", "-Werror", "-o", name];
    compiler.args(flags).args([format!("{name}.c"), format!("{name}_test.c"), "-lm".to_owned()]);
    let folder = place.path().join("code");
    let output = compiler.current_dir(&folder).output().expect("a C compiler");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let output = Command::new(folder.join(name)).output().expect("the test runs");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let numbers: Vec<f64> =
        text(&output.stdout).lines().map(|line| line.parse().expect("a number")).collect();
    numbers.chunks(n_outputs).map(<[f64]>::to_vec).collect()
}

/// At the same states, the accelerations and multipliers of one function satisfy the terms of the other:
/// M a + Gᵀ λ = f, G a = −γ.
#[test]
fn written_accelerations_satisfy_written_equations_of_motion() {
    for (example, nq, nc) in [("slider-crank", 5, 4), ("five-link", 9, 8), ("governor", 4, 0)] {
        let place = Scratch::new();
        let answer = written(&place, example, "--part dynamics");
        let functions = answer["functions"].as_array().expect("functions");
        let n_outputs = |at: usize| functions[at]["outputs"].as_array().expect("outputs").len();
        let name = example.replace('-', "_");
        let last = functions.len() - 1;
        assert_eq!(n_outputs(last), nq + nc, "{example}");
        let terms = tested(&place, &format!("{name}_terms"), n_outputs(0));
        let solved = tested(&place, &format!("{name}_accelerations"), nq + nc);
        assert_eq!((terms.len(), solved.len()), (3, 3), "{example}");
        for (terms, solved) in terms.iter().zip(&solved) {
            let (mass, rest) = terms.split_at(nq * nq);
            let (force, rest) = rest.split_at(nq);
            let (jacobian, gamma) = rest.split_at(nc * nq);
            let (a, lambda) = solved.split_at(nq);
            let size = force.iter().chain(gamma).fold(1.0, |most: f64, x| most.max(x.abs()));
            for i in 0..nq {
                let inertia: f64 = (0..nq).map(|j| mass[i * nq + j] * a[j]).sum();
                let reaction: f64 = (0..nc).map(|row| jacobian[row * nq + i] * lambda[row]).sum();
                assert!((inertia + reaction - force[i]).abs() < 1e-10 * size, "{example}, row {i}");
            }
            for row in 0..nc {
                let along: f64 = (0..nq).map(|j| jacobian[row * nq + j] * a[j]).sum();
                assert!((along + gamma[row]).abs() < 1e-10 * size, "{example}, constraint {row}");
            }
        }
    }
}

/// Nothing but arithmetic, roots and turns: the same bits as our own evaluation, as the test says itself.
#[test]
fn code_of_linkages_is_the_same_to_the_last_bit() {
    let place = Scratch::new();
    let answer = written(&place, "slider-crank", "--part kinematics");
    let n_outputs = answer["functions"][0]["outputs"].as_array().expect("outputs").len();
    assert_eq!(tested(&place, "slider_crank_kinematics", n_outputs).len(), 3);
    let test = place.path().join("code/slider_crank_kinematics_test.c");
    let test = std::fs::read_to_string(test).expect("the test");
    assert!(test.contains("difference <= 0.0 * fabs"), "{test}");
}

#[test]
fn an_input_is_an_argument_and_files_of_others_are_not_overwritten() {
    let place = Scratch::new();
    let answer = written(&place, "cart-pole", "--input u --lang python");
    let inputs = answer["functions"][0]["inputs"].as_array().expect("inputs");
    assert_eq!(inputs.last().expect("an input")["name"], "u");
    let run = |arguments: &str| {
        let model = format!("{CRATE}/../../examples/cart-pole/model.toml");
        place.run(&format!("code {model} -o code {arguments}"))
    };
    let code = place.path().join("code");
    for entry in std::fs::read_dir(&code).expect("a folder") {
        std::fs::write(entry.expect("a file").path(), "# mine\n").expect("written");
    }
    let refused = run("--lang python");
    assert!(!refused.status.success());
    assert!(text(&refused.stderr).contains("exists"), "{}", text(&refused.stderr));
    assert!(run("--lang python --force").status.success());
    let unknown = run("--lang rust --input nonsense");
    assert!(text(&unknown.stderr).contains("nonsense"), "{}", text(&unknown.stderr));
    assert!(!unknown.status.success());
}

/// A cart with a pole on it: four states, then an angle and a reaction.
#[test]
fn written_linear_equations_pass_their_test() {
    let place = Scratch::new();
    let channels = "--part linear --at start --input u --of pole.angle --of reactions.hinge.fx";
    let answer = written(&place, "cart-pole", channels);
    let function = &answer["functions"][0];
    assert_eq!(function["outputs"].as_array().map(Vec::len), Some(6), "{function}");
    assert_eq!(tested(&place, "cart_pole_linear", 6).len(), 3);
}

/// The outputs that a test program prints, compiled by `compiler` and started by `runner`; its exit status tells that they are
/// those of our own evaluation, up to what the test allows.
fn printed(folder: &std::path::Path, name: &str, compiler: &str, runner: &[&str]) -> String {
    let program = format!("./{name}.{compiler}");
    let flags = ["-std=c99", "-O1", "-Wall", "-Wextra", "-pedantic", "-Werror"];
    // An emulator finds no libraries of the other processor.
    let of_libraries: &[&str] = if runner.is_empty() { &[] } else { &["-static"] };
    let files = [format!("{name}.c"), format!("{name}_test.c")];
    let mut build = Command::new(compiler);
    build
        .args(flags)
        .args(of_libraries)
        .args(["-o", &program])
        .args(files)
        .arg("-lm")
        .current_dir(folder);
    let output = build.output().expect("a C compiler");
    assert!(output.status.success(), "{name}: {}", text(&output.stderr));
    let words = [runner, &[program.as_str()]].concat();
    let mut run = Command::new(words[0]);
    let output = run.args(&words[1..]).current_dir(folder).output().expect("the test runs");
    assert!(output.status.success(), "{name} by {compiler}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// `BKSIM_CODE=1` takes every example, not each eleventh. Another processor is tried where its compiler and an emulator are
/// installed: `gcc-aarch64-linux-gnu`, `libc6-dev-arm64-cross` and `qemu-user`.
#[test]
#[expect(clippy::print_stdout, reason = "it says whether there was an emulator")]
fn code_of_examples_has_no_warnings_and_the_same_bits_on_every_processor() {
    let is_there = |program: &str| {
        Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success())
    };
    let emulator = ["aarch64-linux-gnu-gcc", "qemu-aarch64"];
    let has_emulator = emulator.into_iter().all(is_there);
    let stride = if std::env::var_os("BKSIM_CODE").is_some() { 1 } else { 11 };
    let examples = std::fs::read_dir(format!("{CRATE}/../../examples")).expect("examples");
    let mut examples: Vec<String> = examples
        .map(|entry| entry.expect("an example"))
        .filter(|entry| entry.path().join("model.toml").exists())
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    examples.sort();
    let (mut n_functions, mut n_exact) = (0, 0);
    for example in examples.iter().step_by(stride) {
        for part in ["dynamics", "kinematics"] {
            let place = Scratch::new();
            let model = format!("{CRATE}/../../examples/{example}/model.toml");
            let output = place.run(&format!("code {model} -o code --part {part}"));
            // Outlines that may touch are refused, and say so.
            if !output.status.success() {
                assert!(text(&output.stderr).contains("[Q007]"), "{}", text(&output.stderr));
                continue;
            }
            let folder = place.path().join("code");
            let files = std::fs::read_dir(&folder).expect("a folder");
            let files = files.map(|file| file.expect("a file").file_name());
            let files: Vec<String> =
                files.map(|file| file.to_string_lossy().into_owned()).collect();
            for name in files.iter().filter_map(|file| file.strip_suffix("_test.c")) {
                let own = printed(&folder, name, "cc", &[]);
                let test = std::fs::read_to_string(folder.join(format!("{name}_test.c")));
                let is_exact = test.expect("the test").contains("difference <= 0.0 * fabs");
                if has_emulator {
                    let other = printed(&folder, name, emulator[0], &emulator[1..]);
                    assert!(!is_exact || own == other, "{example}: {name}");
                }
                n_functions += 1;
                n_exact += usize::from(is_exact);
            }
        }
    }
    println!("{n_functions} functions, {n_exact} of them bit for bit, emulator: {has_emulator}");
    assert!(n_functions >= 6 && n_exact * 2 > n_functions, "{n_exact} of {n_functions}");
}

/// A program with a script: whether it is there by what it says to `probe`, and what it says of the script.
fn of_script(
    folder: &std::path::Path,
    program: &str,
    probe: &str,
    arguments: &[&str],
) -> Option<String> {
    let option = if program.contains("octave") { "--eval" } else { "-c" };
    let there = Command::new(program).args([option, probe]).output();
    if !there.is_ok_and(|output| output.status.success()) {
        return None;
    }
    let output = Command::new(program).args(arguments).current_dir(folder).output();
    let output = output.expect("it was there before");
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    Some(text(&output.stdout))
}

/// Every script compares its equations, and those that integrate their motion, with numbers of ours. SymPy is among what the
/// tests need; the others are tried where they are installed, in the Python that `BKSIM_SCRIPTS` names: `casadi`, `jax`,
/// `rumoca`; and Octave.
#[test]
#[expect(clippy::print_stdout, reason = "it says which programs there were")]
fn scripts_of_other_programs_agree_with_their_numbers() {
    let venv = format!("{CRATE}/../../target/venv/bin/python");
    let python = std::env::var("BKSIM_SCRIPTS").unwrap_or(venv);
    let mut tried = Vec::new();
    for (example, id) in [("slider-crank", "slider_crank"), ("cart-pole", "cart_pole")] {
        let place = Scratch::new();
        for language in ["casadi", "jax", "sympy", "matlab", "modelica"] {
            let answer = written(&place, example, &format!("--lang {language}"));
            assert_eq!(answer["functions"][0]["name"], format!("{example}_equations"));
        }
        let folder = place.path().join("code");
        for library in ["sympy", "casadi", "jax"] {
            let (file, probe) = (format!("{id}_{library}.py"), format!("import {library}"));
            let said = of_script(&folder, &python, &probe, &[&file]);
            assert!(library != "sympy" || said.is_some(), "no SymPy in {python}");
            tried.extend(said.map(|said| format!("{library}: {said}")));
        }
        let check = format!("s = {id}(); s.check()");
        let said = of_script(&folder, "octave-cli", "1;", &["--no-gui", "--eval", &check]);
        tried.extend(said.map(|said| format!("octave: {said}")));
        // The model of Modelica fails by its own assertions.
        let run = format!(
            "import rumoca as r; r.Session().load('{id}_test.mo', model='{id}_test').simulate(t=(0, 0.5), \
             config=r.SimConfig(rtol=1e-9, atol=1e-9)); print('simulated')"
        );
        let said = of_script(&folder, &python, "import rumoca", &["-c", &run]);
        tried.extend(said.map(|said| format!("rumoca: {said}")));
    }
    println!("{}", tried.concat());
}

/// The matrices of MATLAB are those of `bksim linearize`.
#[test]
fn matrices_of_matlab_are_those_of_the_linear_equations() {
    let place = Scratch::new();
    let channels = "--part linear --lang matlab --at start --input u --of pole.angle";
    written(&place, "cart-pole", channels);
    let script = std::fs::read_to_string(place.path().join("code/cart_pole_linear.m"));
    let script = script.expect("a script").replace("...\n", "");
    let model = format!("{CRATE}/../../examples/cart-pole/model.toml");
    let output =
        place.run(&format!("linearize {model} --at start --input u --output pole.angle --json"));
    let linear: Value = serde_json::from_slice(&output.stdout).expect("one object");
    for name in ["A", "B", "C", "D"] {
        let start = script.find(&format!("s.{name} = [")).expect("a matrix") + 7;
        let end = start + script[start..].find("];").expect("its end");
        let numbers = script[start..end].split([',', ';']).map(|x| x.trim().parse::<f64>());
        let numbers: Vec<f64> = numbers.collect::<Result<_, _>>().expect("numbers");
        let rows = linear[name].as_array().expect("rows");
        let expected = rows.iter().flat_map(|row| row.as_array().expect("a row"));
        let expected: Vec<f64> = expected.map(|x| x.as_f64().expect("a number")).collect();
        assert_eq!(numbers, expected, "{name}");
    }
    let refused = place.run(&format!("code {model} -o code --lang casadi --part kinematics"));
    assert_eq!(refused.status.code(), Some(2), "{}", text(&refused.stderr));
}
