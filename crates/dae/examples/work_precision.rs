//! Work and precision on the published mechanisms: digits reached and work done, by tolerance and
//! order.
//!
//! ```text
//! cargo run --release -p bksim-dae --example work_precision [all|pendulum|…] [index3|index2|ggl]
//! ```

#![expect(clippy::print_stdout, reason = "an example that prints tables")]

#[path = "../tests/common/mod.rs"]
mod common;

use bksim_dae::{Control, Order, Settings, Stages, Stats, Tolerance, solve};
use common::mechanism::{Form, Formulated, Mechanism};
use common::problems::{Andrews, CarAxis, Pendulum, SliderCrank};
use common::reference::Reference;
use common::{Differentiated, digits};

const ORDERS: [Order; 4] = [
    Order::Fixed(Stages::Three),
    Order::Fixed(Stages::Five),
    Order::Fixed(Stages::Seven),
    Order::Auto,
];

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let wanted = args.get(1).map_or("all", String::as_str);
    let form = match args.get(2).map(String::as_str) {
        Some("index2") => Form::Index2,
        Some("index3") => Form::Index3,
        _ => Form::Ggl,
    };
    for name in ["pendulum", "caraxis", "andrews", "slidercrank"] {
        if wanted == "all" || wanted == name {
            tables(name, form);
        }
    }
}

fn tables(name: &str, form: Form) {
    let data = || Reference::load(name);
    let mut initial = ["a", "lam"].map(|part| data().initial(part));
    let [q, v] = match name {
        "slidercrank" => SliderCrank { data: data() }.initial().into(),
        _ => ["q", "v"].map(|part| data().initial(part)),
    };
    // The data's multipliers of the car axis have the opposite sign.
    let sign = if name == "caraxis" { -1.0 } else { 1.0 };
    initial[1].iter_mut().for_each(|x| *x *= sign);
    let [a, lambda] = initial;
    let initial = [q, v, a, lambda];
    for order in ORDERS {
        println!("{name} {form:?} {order:?}");
        for exponent in 3..=12 {
            let settings = (form, order, exponent);
            match name {
                "pendulum" => row(Pendulum::from(&data()), &initial, &data(), settings),
                "caraxis" => row(CarAxis { data: data() }, &initial, &data(), settings),
                "andrews" => row(Andrews { data: data() }, &initial, &data(), settings),
                _ => row(SliderCrank { data: data() }, &initial, &data(), settings),
            }
        }
    }
}

/// One run at `10^-exponent`; "work" weighs the counters as flops of a small mechanism do.
fn row<M: Mechanism>(
    mechanism: M,
    initial: &[Vec<f64>; 4],
    data: &Reference,
    (form, order, exponent): (Form, Order, i32),
) {
    let tolerance = 10f64.powi(-exponent);
    let nq = mechanism.nq();
    let formulated = Formulated { mechanism, form };
    let start = formulated.start(initial.clone());
    let settings = Settings {
        rtol: tolerance,
        atol: Tolerance::Scalar(tolerance),
        order,
        max_steps: 50_000,
        ..Settings::default()
    };
    let (mut work, mut before, mut by_stages) = (0.0, Stats::default(), [0; 8]);
    let system = Differentiated::sparse(formulated);
    let result = solve(system, start, data.t_end(), settings, &mut |step| {
        let now = *step.stats();
        let matrices = (2 * step.n_stages() - 1) as f64;
        work += (now.n_residual - before.n_residual) as f64
            + 8.0 * (now.n_jacobian - before.n_jacobian) as f64
            + 2.0 * matrices * (now.n_factor - before.n_factor) as f64
            + 0.3 * matrices * (now.n_solve - before.n_solve) as f64;
        before = now;
        by_stages[step.n_stages()] += 1;
        Control::Continue
    });
    match result {
        Ok(end) => println!(
            "1e-{exponent:<2} digits q {:4.1} v {:4.1}, work {work:6.0}, steps with 3, 5, 7 stages \
             {} {} {}, {}",
            digits(&end.y[..nq], &data.end("q")),
            digits(&end.y[nq..2 * nq], &data.end("v")),
            by_stages[3],
            by_stages[5],
            by_stages[7],
            end.stats,
        ),
        Err(error) => println!("1e-{exponent:<2} {error}"),
    }
}
