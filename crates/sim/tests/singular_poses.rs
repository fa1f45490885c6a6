//! Singular poses that runs pass: every one is noticed by every method at every tolerance, at its instant, and no other.

use bksim_model::Method;
use bksim_sim::Mechanism;

const METHODS: [Method; 3] = [Method::Auto, Method::Explicit, Method::Radau];
const TOLERANCES: [f64; 8] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10, 1e-12];

/// Times of the singular poses of a run.
fn poses(text: &str, t_end: f64, method: Method, rtol: f64) -> Vec<f64> {
    let mut mechanism = Mechanism::from_toml(text, "model").unwrap_or_else(|e| panic!("{e}"));
    let solve = &mut mechanism.model.solve;
    (solve.t_end, solve.every, solve.method) = (t_end, Some(t_end / 10.0), method);
    (solve.rtol, solve.atol) = (rtol, rtol);
    let motion = mechanism.solve().unwrap_or_else(|e| panic!("{method:?} at {rtol:e}: {e}"));
    motion.summary.singular_poses.iter().map(|pose| pose.t).collect()
}

/// Two equal cranks and a coupler as long as their distance, without gravity: ω stays, and all lies in line twice a turn.
fn parallelogram(rate: f64) -> String {
    format!(
        "[ground]\npoints = {{ O = [0, 0], C = [\"2 m\", 0] }}\n\
         [bodies.left]\nmass = 1\ncom = [0.5, 0]\ninertia = 0.1\npoints = {{ A = [1, 0] }}\n\
         [bodies.top]\nmass = 2\ncom = [1, 0]\ninertia = 0.4\npoints = {{ B = [2, 0] }}\n\
         [bodies.right]\nmass = 1\ncom = [0.5, 0]\ninertia = 0.1\npoints = {{ B = [1, 0] }}\n\
         [joints.O]\ntype = \"revolute\"\nbetween = [\"ground.O\", \"left\"]\n\
         [joints.A]\ntype = \"revolute\"\nbetween = [\"left.A\", \"top\"]\n\
         [joints.B]\ntype = \"revolute\"\nbetween = [\"top.B\", \"right.B\"]\n\
         [joints.C]\ntype = \"revolute\"\nbetween = [\"ground.C\", \"right\"]\n\
         [initial]\nO = {{ angle = 1, rate = {rate:?} }}\nC = {{ guess = {{ angle = 1 }} }}\n"
    )
}

#[test]
fn every_pose_of_a_parallelogram_is_noticed_by_every_method_at_every_tolerance() {
    for rate in [0.7, 3.0, 40.0] {
        let t_end = 33.0 / rate;
        let expected: Vec<f64> = (1..)
            .map(|k| (f64::from(k) * std::f64::consts::PI - 1.0) / rate)
            .take_while(|t| *t < t_end)
            .collect();
        for (method, rtol) in METHODS.into_iter().flat_map(|m| TOLERANCES.map(|rtol| (m, rtol))) {
            let found = poses(&parallelogram(rate), t_end, method, rtol);
            let what =
                format!("{method:?} at {rate} rad/s and {rtol:e}: {found:?} for {expected:?}");
            assert_eq!(found.len(), expected.len(), "{what}");
            for (found, expected) in found.iter().zip(&expected) {
                assert!((found - expected).abs() * rate < 0.02_f64.max(30.0 * rtol), "{what}");
            }
        }
    }
}

#[test]
fn a_fast_slider_crank_has_no_singular_pose() {
    let text = include_str!("../../../examples/slider-crank/model.toml");
    for rate in [10.0, 150.0, 3000.0] {
        let text = text.replace(
            "A = { angle = 0, rate = 0 }",
            &format!("A = {{ angle = 0, rate = \"{rate:?} rad/s\" }}"),
        );
        assert!(text.contains("rad/s\" }"), "the start has been replaced");
        for (method, rtol) in METHODS.into_iter().flat_map(|m| TOLERANCES.map(|rtol| (m, rtol))) {
            let found = poses(&text, 60.0 / rate, method, rtol);
            assert!(found.is_empty(), "{method:?} at {rate} rad/s and {rtol:e}: {found:?}");
        }
    }
}
