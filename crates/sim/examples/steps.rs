//! Steps, CPU time of a run and its correct digits by tolerance, against the same run at the tightest one.
//!
//! ```text
//! cargo run --release -p bksim-sim --example steps crates/bench/models/pendulum.toml [METHOD] [EXPONENT …]
//! ```
//!
//! With one exponent the model runs once and no digits are found, so that its instructions can be counted:
//!
//! ```text
//! valgrind --tool=callgrind target/release/examples/steps crates/bench/models/andrews.toml radau 6
//! ```

#![expect(clippy::print_stdout, reason = "an example that prints a table")]

use std::time::Instant;

use bksim_dae::Control;
use bksim_dae::Stats;
use bksim_model::file::{Source, read};
use bksim_model::{Jit, Method};
use bksim_sim::Mechanism;
use bksim_sim::run::Sample;

/// Runs of which the fastest counts.
const RUNS: usize = 50;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let path = arguments.first().expect("a model file");
    let text = std::fs::read_to_string(path).expect("a readable file");
    let method = match arguments.get(1).map(String::as_str) {
        Some("radau") => Method::Radau,
        Some("explicit") => Method::Explicit,
        _ => Method::Auto,
    };
    let exponents: Vec<i32> =
        arguments.iter().skip(1).filter_map(|word| word.parse().ok()).collect();
    let runs = if exponents.len() == 1 { 1 } else { RUNS };
    // One tolerance alone is a run whose instructions are counted.
    let reference = if runs == 1 { Vec::new() } else { measure(&text, method, 1e-13, 1).3 };
    println!("tolerance  steps  evaluations  microseconds  digits");
    for exponent in if exponents.is_empty() { (2..=12).collect() } else { exponents } {
        let (n_step, n_residual, us, q) = measure(&text, method, 10f64.powi(-exponent), runs);
        let gap = |(a, b): (&f64, &f64)| (a - b).abs() / b.abs().max(1.0);
        let error = q.iter().zip(&reference).map(gap).fold(0.0, f64::max);
        let digits = if reference.is_empty() { f64::NAN } else { -error.log10() };
        println!("{exponent:9}  {n_step:5}  {n_residual:11}  {us:12.1}  {digits:6.2}");
    }
}

/// Steps, evaluations, microseconds of the fastest run, and the coordinates at the end.
fn measure(
    text: &str,
    method: Method,
    tolerance: f64,
    runs: usize,
) -> (usize, usize, f64, Vec<f64>) {
    // Options are those that the equations are compiled with.
    let mut model = read(&Source::new(text, "steps")).model.expect("a model");
    let solve = &mut model.solve;
    (solve.rtol, solve.atol, solve.jit, solve.method) = (tolerance, tolerance, Jit::On, method);
    solve.every = Some(solve.t_end - solve.t_start);
    let mechanism = Mechanism::derive(model, Vec::new()).expect("equations");
    let start = mechanism.start().expect("a start");
    let simulation = mechanism.simulation().expect("compiles");
    let mut last = Sample::default();
    let mut best = f64::INFINITY;
    let mut stats = Stats::default();
    for _ in 0..runs {
        let begin = Instant::now();
        let mut keep = |sample: &Sample| {
            last.clone_from(sample);
            Control::Continue
        };
        let summary = simulation.run(&start, &mut keep, &|| false).expect("the run ends");
        best = best.min(1e6 * begin.elapsed().as_secs_f64());
        stats = summary.stats;
    }
    (stats.n_step, stats.n_residual, best, last.q.clone())
}
