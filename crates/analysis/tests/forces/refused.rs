//! Motions for which there are no efforts, and what is said of them.

use super::rubbing::refusal;
use crate::support::model;
use bksim_analysis::{Actuators, Motion, Range, inverse};

#[test]
fn pins_give_no_efforts_and_actuators_are_named() {
    let hands = r#"
        [bodies]
        upper = { mass = 2, inertia = 0.05, com = [0.25, 0], points = { E = [0.5, 0] } }
        fore = { mass = 1, inertia = 0.02, com = [0.2, 0], points = { H = [0.4, 0] } }
        [joints]
        A = { type = "revolute", between = ["ground", "upper"] }
        B = { type = "revolute", between = ["upper.E", "fore"] }
        [loads.weight]
        type = "gravity"
        acceleration = [0, -9.81]
        [initial]
        A = { guess = { angle = 0.3 } }
        B = { guess = { angle = 0.9 } }
        "#;
    let led = |named: &[&str]| {
        let own = model(hands);
        let motions = [("fore.H.x", "0.6 - 0.2*t"), ("fore.H.y", "0.45 + 0.1*t")]
            .map(|(name, text)| Motion::formula(&own, name, text).expect("a motion"));
        let named = named.iter().map(|name| (*name).to_owned()).collect();
        let actuators = Actuators { named, ..Actuators::default() };
        inverse(own, &motions, &Range { from: 0.0, to: 1.0, n: 5 }, &actuators)
    };
    let (code, message, help) = refusal(led(&[]));
    assert_eq!(code, "Q016");
    assert!(message.contains("`fore.H.x`") && help.contains("--actuator A --actuator B"), "{help}");
    let (_, message, help) = refusal(led(&["B"]));
    assert!(message.contains("`B`") && help.contains("--actuator B --actuator A"), "{help}");
    led(&["A", "B"]).expect("efforts");
}

#[test]
fn friction_that_no_effort_overcomes_is_refused() {
    let trammel = |mu: f64| {
        model(&format!(
            r#"
            [bodies]
            driver = {{ mass = "1 kg" }}
            follower = {{ mass = "2 kg" }}
            [bodies.rod]
            mass = "0.1 kg"
            inertia = "0.01 kg m^2"
            points = {{ D = [0, 0], F = ["1 m", 0] }}
            [joints]
            level = {{ type = "prismatic", between = ["ground", "driver"], axis = [1, 0] }}
            upright = {{ type = "prismatic", between = ["ground", "follower"], axis = [0, 1] }}
            D = {{ type = "revolute", between = ["driver", "rod.D"] }}
            F = {{ type = "revolute", between = ["rod.F", "follower"] }}
            [loads]
            gravity = {{ type = "gravity", acceleration = [0, "-9.81 m/s^2"] }}
            rub = {{ type = "friction", joint = "upright", mu = {mu} }}
            [drives.motor]
            joint = "level"
            motion = "0.94 m - 0.1 m/s*t"
            [initial]
            upright = {{ guess = {{ position = "0.34 m" }} }}
            D = {{ guess = {{ angle = "160 deg" }} }}
            "#
        ))
    };
    let times = Range { from: 0.0, to: 0.1, n: 3 };
    inverse(trammel(0.1), &[], &times, &Actuators::default()).expect("efforts");
    let (code, message, _) = refusal(inverse(trammel(0.5), &[], &times, &Actuators::default()));
    assert!(code == "Q018" && message.contains("`rub`"), "{code} {message}");
}
