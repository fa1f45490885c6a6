//! `bksim expr`: what each operation prints, and where a fault is shown.

use std::io::Write;
use std::process::{Output, Stdio};

use crate::common::{Scratch, text};
use serde_json::Value;

fn run(arguments: &[&str]) -> Output {
    Scratch::new().bksim().arg("expr").args(arguments).output().expect("bksim starts")
}

/// The lines printed by a command that succeeds.
fn check(arguments: &[&str], expected: &[&str]) {
    let output = run(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    let printed = text(&output.stdout);
    let lines: Vec<&str> = printed.lines().map(str::trim).collect();
    assert_eq!(lines, expected, "{arguments:?}");
}

#[test]
fn operations_follow_one_another_in_a_fixed_order() {
    check(&["a*x + x*b"], &["a*x + b*x"]);
    check(&["-x"], &["-x"]);
    check(&["sin(a)*cos(b) + cos(a)*sin(b)", "--simplify"], &["sin(a + b)"]);
    check(&["(a + b)*(a - b)", "--expand"], &["a^2 - b^2"]);
    check(&["x^4", "--diff", "x", "--diff", "x"], &["12*x^2"]);
    check(&["--diff", "x", "x*y", "--substitute", "y=z+1"], &["z + 1"]);
    check(&["exp(x)", "--series", "x=0", "--order", "2"], &["0.5*x^2 + x + 1"]);
    check(&["m*a + c*v = f", "--solve", "a"], &["a = -(c*v - f)/m", "where  m is not zero"]);
    check(&["2*x - 6", "--solve", "x"], &["x = 3"]);
    check(&["sqrt(x^2 + y^2)", "--at", "x=3", "--at", "y=2*2"], &["sqrt(x^2 + y^2)", "value  5"]);
    check(&["2*x", "--at", "x=25 mm"], &["2*x", "value  0.05"]);
}

#[test]
fn every_notation_is_written() {
    let e = "theta1_dot^2/2";
    check(&[e, "--latex"], &[r"\frac{1}{2} \, \dot{\theta}_{1}^{2}"]);
    check(&[e, "--format", "typst"], &["frac(1, 2) thin dot(theta)_(1)^(2)"]);
    check(&[e, "--format", "unicode"], &["0.5·θ\u{307}₁²"]);
    let output = run(&[e, "--format", "mathml"]);
    let math = format!("<math>{}</math>", text(&output.stdout));
    roxmltree::Document::parse(&math).expect("well-formed");
}

#[test]
fn counts_and_certificates_are_printed() {
    let output = run(&["sin(a)^2 + cos(a)^2 + x*x", "--simplify", "--count", "--certificate"]);
    let printed = text(&output.stdout);
    let lines: Vec<&str> = printed.lines().map(str::trim).collect();
    assert_eq!(lines[0], "x^2 + 1");
    assert_eq!(lines[1], "before       3 multiply, 2 add, 0 divide, 2 call; 7 written out");
    assert_eq!(lines[2], "after        1 multiply, 1 add, 0 divide, 0 call; 2 written out");
    assert!(lines[3].starts_with("certificate  equal at 8 random points: within "), "{printed}");
}

#[test]
fn faults_are_shown_where_they_are() {
    let output = run(&["2*(a + sinn(b))"]);
    assert_eq!(output.status.code(), Some(1));
    let shown = text(&output.stderr);
    assert!(shown.contains("expression:1:8"), "{shown}");
    assert!(shown.contains("^^^^ unknown function `sinn`"), "{shown}");
    let output = run(&["a = 2*", "--solve", "a"]);
    assert!(text(&output.stderr).contains("expression:1:7"), "{}", text(&output.stderr));
    for (arguments, status) in [
        (&["x +"][..], 1),
        (&["x^2 - 1", "--solve", "x"], 1),
        (&["y", "--solve", "x"], 1),
        (&["a = b"], 1),
        (&["x", "--diff", "2"], 2),
        (&["x", "--at", "y=1"], 2),
        (&["x", "--at", "x=z"], 2),
        (&["x", "--series", "x=("], 2),
        (&["sin(x)/x", "--series", "x=0"], 2),
        (&["x", "--substitute", "x"], 2),
        (&[], 2),
    ] {
        let output = run(arguments);
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {}", text(&output.stderr));
        assert_eq!(text(&output.stdout), "", "{arguments:?}");
    }
}

#[test]
fn a_solution_has_no_value_where_it_does_not_hold() {
    let output = run(&["m*a = F", "--solve", "a", "--at", "m=0", "--at", "F=1"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("`m` is zero"), "{}", text(&output.stderr));
}

#[test]
fn a_symbol_that_does_not_occur_is_a_warning() {
    let output = run(&["x", "--diff", "y"]);
    assert_eq!(text(&output.stdout).trim(), "0");
    assert!(text(&output.stderr).contains("`y` does not occur"), "{}", text(&output.stderr));
}

#[test]
fn standard_input_is_read_for_a_dash_and_json_is_one_object() {
    let mut child = Scratch::new()
        .bksim()
        .args(["expr", "-", "--expand", "--certificate", "--json"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("bksim starts");
    child.stdin.take().expect("a pipe").write_all(b"a*(b + c)\n").expect("written");
    let output = child.wait_with_output().expect("bksim ends");
    let object: Value = serde_json::from_slice(&output.stdout).expect("one object");
    assert_eq!(object["result"], "a*b + a*c");
    assert_eq!(object["operations"]["after"]["shared"]["total"], 3);
    assert_eq!(object["certificate"]["equal"], true);
}

#[test]
fn a_long_expression_is_no_trouble() {
    let mut child = Scratch::new()
        .bksim()
        .args(["expr", "-", "--diff", "x", "--count"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("bksim starts");
    let long: Vec<String> = (0..100_000).map(|i| format!("sin(a{i}*x) + ")).collect();
    child
        .stdin
        .take()
        .expect("a pipe")
        .write_all(format!("{}1", long.concat()).as_bytes())
        .expect("written");
    let output = child.wait_with_output().expect("bksim ends");
    assert!(output.status.success());
    assert!(text(&output.stdout).contains("100000 call"), "{}", output.stdout.len());
}

#[test]
fn a_result_too_long_to_write_is_refused() {
    let mut arguments = vec!["exp(sin(x)*cos(x^2))/sqrt(1 + x^2)"];
    arguments.extend(["--diff", "x"].repeat(40));
    let output = run(&arguments);
    let shown = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{shown}");
    assert!(shown.contains("operations written out"), "{shown}");
}
