//! Every example is read without fault, solves to its end and keeps its constraints and its energy.

use crate::support::{derive, example, example_names, solve};
use bksim::Mechanism;
use bksim::expr::Tape;

/// Largest distance of a named point from the origin of its body: the size of the mechanism, m.
fn size(mechanism: &Mechanism) -> f64 {
    let model = &mechanism.model;
    let points = model.bodies.iter().flat_map(|body| body.points.iter());
    let components: Vec<_> = points.flat_map(|point| point.position).collect();
    let symbols: Vec<_> = model.parameters.iter().map(|p| p.symbol).collect();
    let tape = Tape::compile(&model.pool, &components, &[], &symbols).expect("only parameters");
    let mut values = vec![0.0; components.len()];
    tape.evaluate(&mut tape.workspace(&mechanism.parameters), &[], &mut values);
    values.iter().fold(0.0, |size: f64, value| size.max(value.abs()))
}

#[test]
fn every_example_solves_to_its_end_and_keeps_constraints_and_energy() {
    let names = example_names();
    assert!(names.len() >= 6, "examples: {names:?}");
    for name in names {
        let mechanism = derive(example(&name));
        let motion = solve(&mechanism);
        let summary = &motion.summary;
        let length = size(&mechanism);
        let [_, position] = summary.position_residual;
        let [_, velocity] = summary.velocity_residual;
        // Of links without mass there is only the rounding of the drive's work, J.
        let scale = summary.energy.scale.max(1e-7);
        let energy = summary.energy.worst_error / scale;
        assert!(summary.reached_end, "{name} stopped at t = {}", summary.t);
        assert!(position <= 1e-10 * length, "{name}: position residual {position:.1e} m");
        assert!(velocity <= 1e-8, "{name}: velocity residual {velocity:.1e} m/s");
        assert!(energy <= 1e-6, "{name}: energy off by {energy:.1e} of its scale");
        let numbers = motion.samples.iter().flat_map(|s| [&s.q, &s.v, &s.a, &s.lambda]);
        assert!(numbers.flatten().all(|x| x.is_finite()), "{name}: a sample is not finite");
    }
}
