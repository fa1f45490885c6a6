//! The cost of a run: Andrews' squeezer with residual and Jacobian written by hand, so that the
//! integrator's own work shows. Digits, counters and CPU time by tolerance.
//!
//! ```text
//! cargo run --release -p bksim-dae --example andrews [auto|3|5|7] [exponent of rtol]
//! ```

#![expect(clippy::print_stdout, reason = "an example that prints tables")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use bksim_dae::{Control, Order, Outcome, Settings, Stages, Start, Tolerance, solve};
use common::by_hand::AndrewsByHand;
use common::digits;
use common::mechanism::{Form, Formulated};
use common::problems::Andrews;
use common::reference::Reference;

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let order = match args.get(1).map(String::as_str) {
        Some("3") => Order::Fixed(Stages::Three),
        Some("5") => Order::Fixed(Stages::Five),
        Some("7") => Order::Fixed(Stages::Seven),
        _ => Order::Auto,
    };
    let data = Reference::load("andrews");
    let mechanism = Andrews { data: Reference::load("andrews") };
    let initial = ["q", "v", "a", "lam"].map(|part| data.initial(part));
    let start = Formulated { mechanism, form: Form::Index2 }.start(initial);
    let run = |exponent| run(&data, &start, order, exponent);
    match args.get(2).and_then(|text| text.parse::<i32>().ok()) {
        // Once, to be counted by instruction.
        Some(exponent) => print(exponent, &run(exponent), 0.0, &data),
        None => (3..=12).for_each(|exponent| {
            let n_runs = 20;
            let begin = Instant::now();
            let ends: Vec<_> = (0..n_runs).map(|_| run(exponent)).collect();
            let time = begin.elapsed().as_secs_f64() / f64::from(n_runs);
            print(exponent, &ends[0], time, &data);
        }),
    }
}

fn run(data: &Reference, start: &Start, order: Order, exponent: i32) -> Outcome {
    let tolerance = 10f64.powi(-exponent);
    let settings = Settings {
        rtol: tolerance,
        atol: Tolerance::Scalar(tolerance),
        order,
        ..Settings::default()
    };
    let system = AndrewsByHand::from(data);
    solve(system, start.clone(), data.t_end(), settings, &mut |_| Control::Continue)
        .expect("the run ends")
}

fn print(exponent: i32, end: &Outcome, time: f64, data: &Reference) {
    println!(
        "1e-{exponent:<2} digits q {:4.1} v {:4.1} λ {:4.1}, {:.3} ms, {}",
        digits(&end.y[..7], &data.end("q")),
        digits(&end.y[7..14], &data.end("v")),
        digits(&end.y[14..20], &data.end("lam")),
        1e3 * time,
        end.stats,
    );
}
