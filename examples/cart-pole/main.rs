//! A pole kept upright on its cart by a controller that acts a thousand times a second.
//!
//! Run it with `cargo run --release --example cart-pole`.

use std::error::Error;
use std::io::{self, Write};
use std::time::Instant;

use bksim::Mechanism;

/// The cart and the pole; its parameter `u` is the force of the motor.
const MODEL: &str = include_str!("model.toml");

/// Gains of x, θ, ẋ and θ̇: they place the poles of the linearised motion at −2 ± i and −4 ± i per second.
const GAINS: [f64; 4] = [-6.065_239_55, 53.615_493_03, -7.706_422_02, 13.537_614_68];

/// Period of the controller, s.
const PERIOD: f64 = 1e-3;

fn main() -> Result<(), Box<dyn Error>> {
    let begun = Instant::now();
    let n_periods = report(&mut io::stdout().lock())?;
    let each = begun.elapsed().as_secs_f64() / f64::from(n_periods);
    eprintln!(
        "{n_periods} periods, {:.1} µs each, the equations and the table included",
        1e6 * each
    );
    Ok(())
}

/// Runs and prints the table; returns the number of periods.
pub(crate) fn report(out: &mut dyn Write) -> Result<u32, Box<dyn Error>> {
    let simulation = Mechanism::from_toml(MODEL, "cart-pole")?.simulation()?;
    let mut run = simulation.begin()?;
    let n_periods = 5000;
    writeln!(out, "{:>6}  {:>10}  {:>10}  {:>10}", "t, s", "x, m", "theta, rad", "u, N")?;
    for k in 1..=n_periods {
        // The controller reads the state and sets the force, which acts until the next period.
        let state = run.state();
        let state = [state.q[0], state.q[1], state.v[0], state.v[1]];
        let u: f64 = -GAINS.iter().zip(state).map(|(gain, value)| gain * value).sum::<f64>();
        run.set_input("u", u)?;

        // A try of what comes in a tenth of a second, from which the run returns.
        if k == 1 {
            let here = run.save();
            run.advance_to(0.1)?;
            run.restore(&here)?;
        }
        if k % 500 == 1 {
            let [x, theta, ..] = state;
            writeln!(out, "{:>6.3}  {x:>10.6}  {theta:>10.6}  {u:>10.6}", run.t())?;
        }
        run.advance_to(PERIOD * f64::from(k))?;
    }
    Ok(n_periods)
}
