//! Machine code changes how fast a run is, and nothing else.

use bksim_dae::System;
use bksim_mbs::assemble::assemble;
use bksim_model::file::{Source, read};
use bksim_model::{Jit, Model};
use bksim_sim::formulate::formulate;

fn model(jit: &str) -> Model {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/slider-crank/model.toml");
    let text = std::fs::read_to_string(path).expect("an example");
    let text = text.replace("[solve]", &format!("[solve]\njit = \"{jit}\""));
    let reading = read(&Source::new(&text, "slider-crank"));
    reading.model.unwrap_or_else(|| panic!("{:?}", reading.diagnostics))
}

/// Residuals and Jacobians along a line of states, as bits.
fn values(model: &Model) -> Vec<u64> {
    let system = assemble(model);
    let equations = formulate(model, &system, model.solve.formulation).expect("compiles");
    let parameters: Vec<f64> = model.parameters.iter().map(|p| p.value).collect();
    let mut motion = equations.at(&parameters, &[]);
    let (n, n_entries) = (equations.n(), motion.pattern().entries().count());
    let (mut residual, mut dy, mut dydot) =
        (vec![0.0; n], vec![0.0; n_entries], vec![0.0; n_entries]);
    let mut bits = Vec::new();
    for step in 0..50 {
        let state = |scale: f64| -> Vec<f64> {
            (0..n).map(|i| scale * (f64::from(step) + 1.0) + 0.1 * i as f64).collect()
        };
        let (y, ydot) = (state(0.07), state(-0.3));
        motion.residual(0.1, &y, &ydot, &mut residual).expect("finite");
        motion.jacobian(0.1, &y, &ydot, &mut dy, &mut dydot).expect("finite");
        let numbers = residual.iter().chain(&dy).chain(&dydot);
        bits.extend(numbers.map(|number| number.to_bits()));
    }
    bits
}

#[test]
fn the_setting_is_read_and_no_bit_depends_on_it() {
    let [auto, on, off] = ["auto", "on", "off"].map(model);
    assert_eq!([auto.solve.jit, on.solve.jit, off.solve.jit], [Jit::Auto, Jit::On, Jit::Off]);
    let interpreted = values(&off);
    assert!(values(&on) == interpreted, "machine code and interpreter differ");
    assert!(values(&auto) == interpreted, "the automatic choice changes values");
}
