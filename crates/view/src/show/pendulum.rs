//! A pendulum that swings, for tests.

use super::Show;
use bksim::solved::solve;

/// A pendulum released at rest from an angle, such as `30 deg`, and its motion until `t_end`.
pub(crate) fn pendulum(angle: &str, t_end: &str) -> Show {
    let text = format!(
        r#"
        [bodies.bob]
        mass = "2 kg"
        com = [0, "-0.5 m"]
        [joints.A]
        type = "revolute"
        between = ["ground", "bob"]
        [loads.gravity]
        type = "gravity"
        acceleration = [0, "-9.81 m/s^2"]
        [initial]
        A = {{ angle = "{angle}" }}
        [solve]
        t_end = "{t_end}"
        "#
    );
    let mechanism = bksim::Mechanism::from_toml(&text, "pendulum").expect("a model");
    Show::new(solve(mechanism, &text, &|_| true).expect("a motion").playback)
}
