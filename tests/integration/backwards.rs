//! Runs back in time: from the end of a run to its start.

use crate::support::large::{Coordinates, windows};
use crate::support::{derive, model};
use bksim::dae::Control;
use bksim::model::Method;
use bksim::sim::run::Sample;

#[test]
fn forwards_and_backwards_returns_to_the_start() {
    for method in [Method::Auto, Method::Explicit, Method::Radau] {
        let mut model = model(&windows(1, Coordinates::Relative));
        (model.solve.t_start, model.solve.t_end, model.solve.every) = (0.25, 0.75, Some(0.05));
        (model.solve.rtol, model.solve.atol, model.solve.method) = (1e-8, 1e-10, method);
        let mut mechanism = derive(model);
        let motion = mechanism.solve().expect("a motion");
        let there = motion.samples.last().expect("samples");

        // The same motion from its other end.
        let mut start = motion.start.clone();
        start.t = there.t;
        start.q.clone_from(&there.q);
        start.v.clone_from(&there.v);
        start.a.clone_from(&there.a);
        start.lambda.clone_from(&there.lambda);
        let solve = &mut mechanism.model.solve;
        (solve.t_start, solve.t_end) = (solve.t_end, solve.t_start);
        let simulation = mechanism.simulation().expect("equations");
        let mut back: Vec<Sample> = Vec::new();
        let mut keep = |sample: &Sample| {
            back.push(sample.clone());
            Control::Continue
        };
        let summary = simulation.run(&start, &mut keep, &|| false).expect("a run");
        assert!(summary.reached_end, "{method:?}");
        assert_eq!(back.len(), motion.samples.len(), "{method:?}");
        let moved = (there.q[0] - motion.samples[0].q[0]).abs();
        assert!(moved > 0.1, "{moved}");
        for (there, here) in motion.samples.iter().rev().zip(&back) {
            assert!((there.t - here.t).abs() < 1e-12, "{} against {}", here.t, there.t);
            let pairs = there.q.iter().chain(&there.v).zip(here.q.iter().chain(&here.v));
            let error = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(error < 1e-6, "{method:?}: off by {error:.1e} at t = {}", here.t);
        }
    }
}

#[test]
fn what_switches_is_not_passed_backwards() {
    let text = r#"
[bodies.block]
mass = "1 kg"
[joints.guide]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
[solve]
t_end = "-1 s"
"#;
    derive(model(text)).solve().expect("a motion");
    let stop = "[loads.bumper]\ntype = \"stop\"\njoint = \"guide\"\nmax = \"0.5 m\"\n";
    let friction = "[loads.rub]\ntype = \"friction\"\njoint = \"guide\"\nforce = \"1 N\"\n";
    let kink = "[loads.kink]\ntype = \"force\"\non = \"block\"\n\
                vector = [\"1 N/m*abs(guide.position)\", 0]\n";
    for load in [stop, friction, kink] {
        let refused = derive(model(&format!("{text}{load}"))).solve().expect_err(load).to_string();
        let message = "[S008] the run goes back in time, from 0 s to -1 s, but something switches";
        assert_eq!(refused, message);
    }
}
