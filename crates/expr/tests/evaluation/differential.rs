//! Random expressions against two other programs: mpmath computes values, derivatives and series with
//! 60 digits, SymPy differentiates. A few hundred run with the other tests where Python has SymPy; all
//! 5000 by `BKSIM_DIFFERENTIAL=5000 cargo test -p bksim-expr --test expr differential`.

use crate::common::Random;
use bksim_expr::{Expr, Pool, SymbolId};
use serde_json::{Value, json};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Expressions compared where nothing else is asked for.
const N_EXPRESSIONS: usize = 300;
/// Largest number of operations inside of one another.
const DEPTH: usize = 4;
/// Order of series.
const ORDER: u32 = 2;

const NAMES: [&str; 3] = ["x", "y", "z"];
const LEAVES: [&str; 12] =
    ["x", "y", "z", "x", "y", "x", "2", "3", "0.5", "1.25", "pi", "100000000000000000001"];
const ONE: [&str; 17] = [
    "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "ln", "sqrt",
    "abs", "sign", "sin", "cos", "sqrt",
];
const TWO: [&str; 3] = ["atan2", "min", "max"];
const EXPONENTS: [&str; 7] = ["2", "3", "-1", "-2", "0.5", "1/3", "2"];

/// A random expression as text, with every operation in parentheses.
fn expression(random: &mut Random, depth: usize) -> String {
    let mut pick = |from: &[&str]| from[random.below(from.len())].to_owned();
    if depth == 0 {
        return pick(&LEAVES);
    }
    let (one, two, exponent) = (pick(&ONE), pick(&TWO), pick(&EXPONENTS));
    let kind = random.below(12);
    let mut inner = || {
        let depth = random.below(depth);
        expression(random, depth)
    };
    match kind {
        0..=2 => format!("({} + {})", inner(), inner()),
        3 => format!("({} - {})", inner(), inner()),
        4..=5 => format!("({}*{})", inner(), inner()),
        6 => format!("({}/{})", inner(), inner()),
        7 => format!("({})^({exponent})", inner()),
        8 => format!("{two}({}, {})", inner(), inner()),
        9 if depth > 2 => format!("if(lt({}, {}), {}, {})", inner(), inner(), inner(), inner()),
        _ => format!("{one}({})", inner()),
    }
}

/// All that is claimed about one expression.
fn claims(random: &mut Random) -> Option<Value> {
    let pool = Pool::new();
    let symbols: Vec<SymbolId> =
        NAMES.iter().filter_map(|name| pool.symbol_id(pool.symbol(name))).collect();
    let text = expression(random, DEPTH);
    let e = pool.parse(&text).expect("generated text is valid");
    // Multiples of 1/64, so that values are exact in every program.
    let point: Vec<f64> = (0..3).map(|_| (random.below(256) as f64 - 96.5) / 64.0).collect();
    let x = symbols[0];
    let slope = pool.diff(e, x);
    let simple = pool.simplify(e);
    if pool.printed_operations(&[slope, simple]).total() > 3000 {
        return None;
    }
    let cancelled = pool.cancel(&[e]);
    let series = pool.series(e, x, pool.float(point[0]), ORDER);
    let series = (!pool.is_singular(series) && pool.printed_operations(&[series]).total() < 20_000)
        .then(|| pool.to_text(series));
    let at = |e: Expr| {
        let value = |s| symbols.iter().position(|&known| known == s).map(|i| point[i]);
        pool.evaluate(e, &value).ok().filter(|value| value.is_finite())
    };
    let texts = |list: &[Expr]| list.iter().map(|&e| pool.to_text(e)).collect::<Vec<_>>();
    let backward = pool.vjp(&[e], &[pool.one()], &[x])[0];
    Some(json!({
        "text": text, "point": point, "value": at(e), "built": pool.to_text(e),
        "slope": pool.to_text(slope), "backward": pool.to_text(backward),
        "simplified": pool.to_text(simple), "expanded": pool.to_text(pool.expand(e)),
        "cancelled": pool.to_text(cancelled.roots[0]),
        "nonzero": texts(&cancelled.nonzero), "not_negative": texts(&cancelled.not_negative),
        "series": series, "order": ORDER,
    }))
}

/// The interpreter: `BKSIM_PYTHON`, the one of `target/venv`, or the system's; `None`, with a message,
/// where none has SymPy.
fn python() -> Option<PathBuf> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/venv/bin/python");
    let named = std::env::var_os("BKSIM_PYTHON").map(PathBuf::from);
    let candidates = named.into_iter().chain([own, PathBuf::from("python3")]);
    let has_sympy = |python: &PathBuf| {
        let mut command = Command::new(python);
        let output = command.args(["-c", "import sympy, mpmath"]).stderr(Stdio::null()).status();
        output.is_ok_and(|status| status.success())
    };
    let found = candidates.into_iter().find(has_sympy);
    if found.is_none() {
        eprintln!("skipped: no python with sympy, see tests/setup.sh");
    }
    found
}

#[test]
fn other_programs_find_the_same_values() {
    let Some(python) = python() else { return };
    let asked = std::env::var("BKSIM_DIFFERENTIAL").ok().and_then(|n| n.parse().ok());
    let n_expressions: usize = asked.unwrap_or(N_EXPRESSIONS);
    let mut random = Random(20);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/differential.py");
    let mut child = Command::new(python)
        .arg(script)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the interpreter ran before");
    let mut input = child.stdin.take().expect("it is piped");
    let lines = (0..n_expressions).filter_map(|_| claims(&mut random));
    let lines: Vec<String> = lines.map(|claims| format!("{claims}\n")).collect();
    let writer = std::thread::spawn(move || {
        for line in lines {
            input.write_all(line.as_bytes()).expect("the script reads all lines");
        }
    });
    let output = child.wait_with_output().expect("the script ends");
    writer.join().expect("all lines are written");
    let report = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{report}");
    // Most expressions have a value somewhere, or nothing would be compared.
    let last: Value = serde_json::from_str(report.lines().last().unwrap_or("{}")).expect("JSON");
    eprintln!("{last}");
    for (kind, least) in
        [("value", 3), ("slope", 4), ("simplified", 3), ("sympy", 6), ("series", 6)]
    {
        let n_compared = last[kind].as_u64().unwrap_or(0);
        assert!(n_compared > n_expressions as u64 / least, "{kind}: {n_compared} compared");
    }
}
