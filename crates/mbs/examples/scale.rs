//! Time and memory of each phase by the number of links.
//!
//! ```text
//! cargo run --release -p bksim-mbs --example scale [chain|windows|windows-relative] [N …]
//! ```

#![expect(clippy::print_stdout, reason = "an example that prints tables")]

#[path = "../../../tests/support/large.rs"]
mod large;

use std::time::Instant;

use bksim_dae::Control;
use bksim_mbs::assemble::assemble;
use bksim_mbs::compile::compile;
use bksim_mbs::file::{Source, read};
use bksim_mbs::formulate::formulate;
use bksim_mbs::run::run;
use bksim_mbs::start::start;
use large::{Coordinates, chain, windows};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let which = arguments.first().map_or("chain", String::as_str);
    let text_of: fn(usize) -> String = match which {
        "windows" => |n| windows(n, Coordinates::Absolute),
        "windows-relative" => |n| windows(n, Coordinates::Relative),
        _ => |n| chain(n, Coordinates::Absolute),
    };
    let sizes = arguments.iter().skip(1).filter_map(|n| n.parse().ok());
    println!("{which:<17}      N  milliseconds  MiB in use");
    for n in sizes {
        measure(&text_of(n), n);
    }
}

/// One mechanism through all phases.
fn measure(text: &str, n: usize) {
    let mut clock = Clock { n, last: Instant::now() };
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
    model.solve.t_end = 0.1;
    model.solve.every = Some(0.1);
    let observer = &mut |_: &_| Control::Continue;
    let options = &model.solve;
    let summary = run(&compiled, &equations, &begin, &parameters, options, observer, &|| false);
    let summary = summary.expect("a run");
    clock.lap("run");
    println!("{:<17} {n:6}  {:12}", "steps", summary.stats.n_step);
}

struct Clock {
    n: usize,
    last: Instant,
}

impl Clock {
    fn lap(&mut self, phase: &str) {
        let elapsed = self.last.elapsed();
        println!(
            "{phase:<17} {:6}  {:12.1}  {:10.0}",
            self.n,
            1e3 * elapsed.as_secs_f64(),
            resident_mib()
        );
        self.last = Instant::now();
    }
}

/// Resident memory where the system tells, else zero.
fn resident_mib() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kib = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    kib.unwrap_or_default() / 1024.0
}
