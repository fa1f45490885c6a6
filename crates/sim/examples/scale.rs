//! Time and memory of each phase by the number of links.
//!
//! ```text
//! cargo run --release -p bksim-mbs --example scale [chain|windows|windows-relative] [radau] [N …]
//! ```

#![expect(clippy::print_stdout, reason = "an example that prints tables")]

#[path = "../../../tests/support/large.rs"]
mod large;

use std::sync::Arc;

use bksim_dae::Control;
use bksim_mbs::assemble::assemble;
use bksim_model::file::{Source, read};
use bksim_model::{Method, SolveOptions};
use bksim_sim::compiled::compile;
use bksim_sim::formulate::{LazyMotionEquations, formulate};
use bksim_sim::run::{Problem, run};
use bksim_sim::start::start;
use large::{Coordinates, chain, windows};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let which = arguments.first().map_or("chain", String::as_str);
    let text_of: fn(usize) -> String = match which {
        "windows" => |n| windows(n, Coordinates::Absolute),
        "windows-relative" => |n| windows(n, Coordinates::Relative),
        _ => |n| chain(n, Coordinates::Absolute),
    };
    let has_radau = arguments.iter().any(|word| word == "radau");
    let method = if has_radau { Method::Radau } else { Method::Auto };
    let sizes = arguments.iter().skip(1).filter_map(|n| n.parse().ok());
    println!("{which:<17}      N  CPU  milliseconds  MiB in use");
    for n in sizes {
        measure(&text_of(n), n, method);
    }
}

/// One mechanism through all phases.
fn measure(text: &str, n: usize, method: Method) {
    let mut clock = Clock { n, last: cpu_ms() };
    let reading = read(&Source::new(text, "scale"));
    let mut model = reading.model.unwrap_or_else(|| panic!("{:?}", reading.diagnostics));
    clock.lap("read");
    let system = assemble(&model);
    clock.lap("assemble");
    let parameters: Vec<f64> = model.parameters.iter().map(|p| p.value).collect();
    let compiled = compile(&model, &system).expect("compiles");
    clock.lap("compile");
    let equations = formulate(&model, &system, model.solve.formulation).expect("compiles");
    clock.lap("formulate");
    let begin = start(&model, &system, &compiled, &parameters).expect("a start");
    clock.lap("start");
    let t_end = 0.1;
    model.solve = SolveOptions { t_end, every: Some(t_end), method, ..model.solve };
    let observer = &mut |_: &_| Control::Continue;
    let options = &model.solve;
    let equations = Arc::new(equations);
    let equations = LazyMotionEquations::new(Box::new(move || equations));
    let (compiled, equations, start) = (&compiled, &equations, &begin);
    let outputs = &options.outputs;
    let problem = Problem { compiled, equations, start, parameters: &parameters, options, outputs };
    let summary = run(problem, observer, &|| false);
    clock.lap("run");
    let summary = summary.unwrap_or_else(|failure| {
        println!("the run ended at {} s", failure.summary.t);
        failure.summary
    });
    println!("{:<17} {n:6}  {:12}", "steps", summary.stats.n_step);
}

struct Clock {
    n: usize,
    /// CPU time at the end of the last phase, ms.
    last: f64,
}

impl Clock {
    fn lap(&mut self, phase: &str) {
        let now = cpu_ms();
        println!("{phase:<17} {:6}  {:12.1}  {:10.0}", self.n, now - self.last, resident_mib());
        self.last = now;
    }
}

/// CPU time of this thread, which no other work on the machine adds to; zero where the system does
/// not tell.
fn cpu_ms() -> f64 {
    let text = std::fs::read_to_string("/proc/self/schedstat").unwrap_or_default();
    let nanoseconds = text.split_whitespace().next().and_then(|word| word.parse::<f64>().ok());
    1e-6 * nanoseconds.unwrap_or_default()
}

/// Resident memory, zero where the system does not tell.
fn resident_mib() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kib = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    kib.unwrap_or_default() / 1024.0
}
