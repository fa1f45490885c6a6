//! Generated code is compiled, run and held against our own evaluation.

use bksim_expr::{CodegenError, Pool, Program, Quantity, Signature, SymbolId, Tape};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Every operation, constant outputs, and names that are keywords or no identifiers.
const OUTPUTS: [&str; 9] = [
    "sin(x)*cos(lambda) + tan(x/3)*k^2 - 3",
    "asin(x/2) + acos(lambda/2) - atan(x) + atan2(x, -lambda)",
    "sinh(x) - cosh(x)/tanh(lambda) + exp(-x*m)*ln(lambda) + sqrt(x + k)",
    "abs(x - lambda)*sign(lambda - x) + min(x, lambda)^3 - max(x, m)/k",
    "if(lt(x, lambda), x^lambda, lambda^(-2)) + le(x, 1) - gt(x, k)*ge(m, x)",
    "-(x*k)",
    "x",
    "-2.5",
    "1/(m*k) - pi + x^0.3 + if(gt(x, 1), 1, 2)",
];

fn tape(texts: &[&str]) -> (Tape, Signature) {
    let pool = Pool::new();
    let id = |name: &str| -> SymbolId { pool.symbol_id(pool.symbol(name)).expect("a symbol") };
    let (inputs, parameters) = (["x", "lambda"], ["m", "k", "unused"]);
    let (input_ids, parameter_ids) = (inputs.map(id), parameters.map(id));
    let outputs: Vec<_> = texts.iter().map(|text| pool.parse(text).expect("valid")).collect();
    let tape = Tape::compile(&pool, &outputs, &input_ids, &parameter_ids).expect("bound");
    let signature = Signature {
        name: "all operations".to_owned(),
        inputs: inputs.map(|name| Quantity::new(name, "rad")).to_vec(),
        parameters: parameters.map(|name| Quantity::new(name, "kg*m^2")).to_vec(),
        outputs: (0..texts.len()).map(|i| Quantity::new(&format!("y{i} */"), "")).collect(),
    };
    (tape, signature)
}

/// A fresh folder for the files of one test.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&path).expect("the target folder is writable");
    path
}

/// Runs a command; `None`, with a message, where the tool is missing.
fn run(command: &mut Command) -> Option<Output> {
    match command.output() {
        Ok(output) => Some(output),
        Err(fault) => {
            eprintln!("skipped: {} does not run: {fault}", command.get_program().display());
            None
        }
    }
}

fn check_success(output: &Output, code: &str) {
    let text = String::from_utf8_lossy(&output.stderr);
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}\n{printed}\n{code}");
}

/// Numbers, one per line, equal the outputs at all test points.
fn check_numbers(program: &Program, printed: &[u8]) {
    let printed = String::from_utf8_lossy(printed);
    let found: Vec<f64> = printed.lines().map(|line| line.parse().expect("a number")).collect();
    let expected: Vec<f64> =
        program.test_points().iter().flat_map(|point| point.outputs.clone()).collect();
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found - expected).abs() <= 1e-14 * expected.abs(), "{found} is not {expected}");
    }
}

#[test]
fn c_code_compiles_without_warnings_and_agrees() {
    let (tape, signature) = tape(&OUTPUTS);
    let program = tape.program(&signature).expect("fits");
    let code = program.to_c();
    let folder = folder("c");
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("written");
    write("all_operations.h", &code.header);
    write("all_operations.c", &code.source);
    write("test.c", &code.test);
    let flags = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-O2"];
    let mut compiler = Command::new("cc");
    compiler.args(flags).args(["all_operations.c", "test.c", "-o", "test", "-lm"]);
    let Some(output) = run(compiler.current_dir(&folder)) else { return };
    check_success(&output, &code.source);
    let Some(output) = run(&mut Command::new(folder.join("test"))) else { return };
    check_success(&output, &code.source);
    check_numbers(&program, &output.stdout);
}

#[test]
fn rust_code_needs_core_alone_and_agrees() {
    let (tape, signature) = tape(&OUTPUTS);
    let program = tape.program(&signature).expect("fits");
    let code = program.to_rust();
    let folder = folder("rust");
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("written");
    write("generated.rs", &code);
    write("lib.rs", "#![no_std]\n#![deny(warnings)]\npub mod generated;\n");
    let compile = |arguments: &[&str]| {
        run(Command::new("rustc").args(["--edition", "2024"]).args(arguments).current_dir(&folder))
    };
    let Some(output) = compile(&["--crate-type", "lib", "lib.rs"]) else { return };
    check_success(&output, &code);
    let Some(output) = compile(&["--test", "lib.rs", "-o", "test"]) else { return };
    check_success(&output, &code);
    let Some(output) = run(&mut Command::new(folder.join("test"))) else { return };
    check_success(&output, &code);
    assert!(String::from_utf8_lossy(&output.stdout).contains("1 passed"));
}

#[test]
fn python_code_broadcasts_and_agrees() {
    let (tape, signature) = tape(&OUTPUTS);
    let code = tape.program(&signature).expect("fits").to_python();
    let path = folder("python").join("generated.py");
    std::fs::write(&path, &code).expect("written");
    let Some(output) = run(Command::new("python3").args(["-c", "import numpy"])) else { return };
    if !output.status.success() {
        eprintln!("skipped: python3 has no numpy");
        return;
    }
    let Some(output) = run(Command::new("python3").arg(&path)) else { return };
    check_success(&output, &code);
}

/// A reader of the JSON form that knows nothing of tapes.
fn evaluate_json(tape: &Value, test: &Value) -> Vec<f64> {
    let numbers = |value: &Value| -> Vec<f64> {
        let list = value.as_array().expect("a list").iter();
        list.map(|v| v.as_f64().expect("finite")).collect()
    };
    let mut registers = numbers(&tape["constants"]);
    registers.extend(numbers(&test["parameters"]));
    registers.extend(numbers(&test["inputs"]));
    for instruction in tape["instructions"].as_array().expect("a list") {
        let operand = |i: usize| {
            instruction[i]
                .as_u64()
                .map_or(f64::NAN, |r| registers[usize::try_from(r).expect("small")])
        };
        let (a, b) = (operand(1), operand(2));
        registers.push(match instruction[0].as_str().expect("a name") {
            "add" => a + b,
            "subtract" => a - b,
            "multiply" => a * b,
            "divide" => a / b,
            "negate" => -a,
            other => panic!("unexpected instruction {other}"),
        });
    }
    let outputs = tape["outputs"].as_array().expect("a list").iter();
    outputs
        .map(|o| registers[usize::try_from(o["register"].as_u64().expect("one")).expect("small")])
        .collect()
}

#[test]
fn json_holds_all_that_is_needed_to_evaluate() {
    let (tape, signature) = tape(&["x*k - lambda/(m + 2)", "-(x + 1/3)", "x^2*m + m*k"]);
    let json = tape.program(&signature).expect("fits").to_json();
    let value: Value = serde_json::from_str(&json).expect("valid JSON");
    assert_eq!(value["inputs"][1]["name"], "lambda");
    assert_eq!(value["parameters"][0]["unit"], "kg*m^2");
    assert_eq!(value["n_prologue"].as_u64(), Some((tape.len() - tape.operation_count()) as u64));
    for test in value["tests"].as_array().expect("a list") {
        let expected: Vec<f64> = test["outputs"]
            .as_array()
            .expect("a list")
            .iter()
            .map(|v| v.as_f64().expect("finite"))
            .collect();
        assert_eq!(evaluate_json(&value, test), expected);
    }
}

/// Arguments may be missing, and values infinite.
#[test]
fn constant_functions_compile_too() {
    let pool = Pool::new();
    let outputs = ["1/0", "-1/0", "0/0", "7"].map(|text| pool.parse(text).expect("valid"));
    let tape = Tape::compile(&pool, &outputs, &[], &[]).expect("bound");
    let outputs = ["a", "b", "c", "d"].map(|name| Quantity::new(name, "")).to_vec();
    let signature =
        Signature { name: "constants".to_owned(), inputs: vec![], parameters: vec![], outputs };
    let program = tape.program(&signature).expect("fits");
    let (code, folder) = (program.to_c(), folder("constants"));
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("written");
    write("constants.h", &code.header);
    write("constants.c", &code.source);
    write("test.c", &code.test);
    write("constants.rs", &program.to_rust());
    let flags = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror"];
    let mut compiler = Command::new("cc");
    compiler.args(flags).args(["constants.c", "test.c", "-o", "test", "-lm"]);
    if let Some(output) = run(compiler.current_dir(&folder)) {
        check_success(&output, &code.source);
        check_success(&run(&mut Command::new(folder.join("test"))).expect("runs"), &code.test);
    }
    let mut compiler = Command::new("rustc");
    compiler.args(["--edition", "2024", "--test", "constants.rs", "-o", "rust"]);
    if let Some(output) = run(compiler.current_dir(&folder)) {
        check_success(&output, &program.to_rust());
        check_success(&run(&mut Command::new(folder.join("rust"))).expect("runs"), "constants.rs");
    }
}

#[test]
fn a_signature_must_fit_the_tape() {
    let (tape, mut signature) = tape(&["x"]);
    signature.inputs.pop();
    let fault = tape.program(&signature).expect_err("an input has no name");
    assert_eq!(fault, CodegenError::WrongCount { what: "inputs", expected: 2, found: 1 });
}

#[test]
fn tests_allow_more_where_outputs_change_more_than_inputs() {
    let tolerance = |text: &str| {
        let (tape, signature) = tape(&[text]);
        let python = tape.program(&signature).expect("names").to_python();
        let after = python.split("rtol=").nth(1).expect("a tolerance").to_owned();
        after.split(')').next().and_then(|number| number.parse::<f64>().ok()).expect("a number")
    };
    assert_eq!(tolerance("sin(x)*lambda + 2"), 1e-14);
    // A relative change of x is 400 x times as large there.
    assert!(tolerance("exp(400*x)") > 1e-14);
}
