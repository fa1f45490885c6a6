//! Machine code changes how fast a run is, and nothing else.

use bksim_dae::{Control, System};
use bksim_mbs::assemble::assemble;
use bksim_model::file::{Source, read};
use bksim_model::{Jit, Model};
use bksim_sim::Mechanism;
use bksim_sim::formulate::formulate;
use bksim_sim::run::Sample;

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

/// Samples of a run by explicit steps, as bits, and its counters of steps and evaluations.
fn run(example: &str, jit: &str) -> (Vec<Vec<u64>>, [usize; 2]) {
    run_file(&format!("examples/{example}/model.toml"), &format!("jit = \"{jit}\""))
}

/// Samples of a model with more lines under `[solve]`.
fn run_file(path: &str, options: &str) -> (Vec<Vec<u64>>, [usize; 2]) {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let text = std::fs::read_to_string(format!("{root}/{path}")).expect("a model file");
    let text = text.replace("[solve]", &format!("[solve]\n{options}"));
    let mut mechanism = Mechanism::from_toml(&text, path).expect("a model");
    mechanism.model.solve.method = bksim_model::Method::Explicit;
    let start = mechanism.start().expect("a start");
    let mut samples = Vec::new();
    let mut keep = |sample: &Sample| {
        let Sample { q, v, a, lambda, reactions, signals, energy, .. } = sample;
        let parts = [q, v, a, lambda, signals, reactions.as_flattened()];
        let alone = [sample.work, energy.kinetic, energy.potential, energy.power];
        let residuals = sample.position_residual.iter().chain(&sample.velocity_residual);
        let numbers = parts.into_iter().flatten().chain(&alone).chain(residuals);
        samples.push(numbers.map(|x| x.to_bits()).collect());
        Control::Continue
    };
    let simulation = mechanism.simulation().expect("compiles");
    let stats = simulation.run(&start, &mut keep, &|| false).expect("it runs").stats;
    (samples, [stats.n_step, stats.n_residual])
}

#[test]
fn whole_steps_as_one_function_give_the_bits_of_their_stages() {
    // Constraints and none; drives in time, springs, stops, friction, a singular pose; in the plane and in space.
    let examples = [
        "slider-crank",
        "five-link",
        "four-bar",
        "spring-pendulum",
        "quarter-car",
        "winch",
        "gyroscope",
        "parallelogram",
        "spatial-four-bar",
    ];
    for example in examples {
        let [stages, whole] = ["off", "on"].map(|jit| run(example, jit));
        assert!(stages.0.len() > 10, "{example} has samples");
        assert!(stages == whole, "{example} differs");
    }
}

/// Steps so long that their gap takes several steps of Newton's method, by a function of its own.
#[test]
fn gaps_of_long_steps_are_closed_with_the_bits_of_projection() {
    let at = |jit: &str| {
        let options = format!("jit = \"{jit}\"\nrtol = 1e-2\natol = 1e-2\nevery = 0.1");
        run_file("crates/bench/models/pendulum.toml", &options)
    };
    assert!(at("off") == at("on"));
}
