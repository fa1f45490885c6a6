//! Efforts at stops: closed ones bear, and motions through them are refused.

use super::rubbing::{column, efforts, needs_what_a_run_takes, refusal};
use crate::support::model;
use bksim_analysis::{Actuators, AnalysisError, EffortLimit, Range, inverse};

const ARM_AND_WHEEL: &str = r#"
    [bodies.arm]
    mass = "2 kg"
    com = [0.3, 0]
    inertia = 0.05
    [bodies.wheel]
    mass = "1 kg"
    inertia = 0.02
    [ground]
    points = { W = [1, 0] }
    [joints.A]
    type = "revolute"
    between = ["ground", "arm"]
    [joints.B]
    type = "revolute"
    between = ["ground.W", "wheel"]
    [couplings.g]
    type = "gear"
    between = ["A", "B"]
    radii = [0.6, 0.4]
    [drives.m]
    joint = "A"
    motion = "10 deg + 3 rad/s*t + 1 rad/s^2*t^2"
    [initial]
    A = { angle = "10 deg" }
    [loads.s]
    type = "stop"
    joint = "A"
    max = "40 deg"
    "#;

#[test]
fn a_motion_through_a_stop_is_refused_with_the_instant() {
    let times = Range { from: 0.0, to: 0.4, n: 5 };
    let found = inverse(model(ARM_AND_WHEEL), &[], &times, &Actuators::default());
    let (code, message, help) = refusal(found);
    assert_eq!(code, "Q015");
    assert!(message.contains("`s`") && message.contains("0.165412"), "{message}");
    // The help, taken at its word.
    let written = help.split('"').nth(1).expect("times");
    let before = Range::parse(written, "s").expect("times");
    inverse(model(ARM_AND_WHEEL), &[], &before, &Actuators::default()).expect("efforts");

    // There and back between two of the times.
    let back =
        ARM_AND_WHEEL.replace("10 deg + 3 rad/s*t + 1 rad/s^2*t^2", "40.1 deg*sin(10 rad/s*t)");
    let back = back.replace("A = { angle = \"10 deg\" }", "A = { angle = 0 }");
    let times = Range { from: 0.0, to: 0.3, n: 2 };
    let (code, message, _) = refusal(inverse(model(&back), &[], &times, &Actuators::default()));
    let at = (40.0_f64 / 40.1).asin() / 10.0;
    assert!(code == "Q015" && message.contains(&format!("{at:.6}")), "{message}, not {at}");
    // Up to the stop and no further.
    let touching = back.replace("40.1 deg*sin", "40 deg*sin");
    inverse(model(&touching), &[], &times, &Actuators::default()).expect("efforts");
}

#[test]
fn a_stop_that_is_held_closed_leaves_the_effort_open_on_one_side() {
    let held = ARM_AND_WHEEL.replace("10 deg + 3 rad/s*t + 1 rad/s^2*t^2", "40 deg");
    let held = held.replace("A = { angle = \"10 deg\" }", "A = { angle = \"40 deg\" }");
    let held =
        format!("{held}[loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"9.81 m/s^2\"]\n");
    let found = efforts(&held, &Range { from: 0.0, to: 0.1, n: 2 });
    let [effort, least, most] =
        ["effort", "effort_min", "effort_max"].map(|word| column(&found, &format!("m.{word}"))[0]);
    // The load presses it onto the stop: no effort is needed, and any that presses more is possible.
    let pressing = 2.0 * 9.81 * 0.3 * 40.0_f64.to_radians().cos();
    assert!(effort.abs() < 1e-9 && (least + pressing).abs() < 1e-7, "{effort}, {least}");
    assert_eq!(most, f64::INFINITY);
    let limit = EffortLimit { name: "m".to_owned(), limit: 3.0 };
    let actuators = Actuators { limits: vec![limit], ..Actuators::default() };
    let times = Range { from: 0.0, to: 0.1, n: 2 };
    let bounded = inverse(model(&held), &[], &times, &actuators).expect("efforts");
    assert!((column(&bounded, "m.effort_max")[0] - 3.0).abs() < 1e-7);
}

/// A cam that lifts its follower by a stop.
fn cam(spring: &str) -> String {
    format!(
        r#"
        [bodies]
        cam = {{ mass = "1 kg", inertia = "1e-3 kg m^2" }}
        follower = {{ mass = "0.3 kg" }}
        [joints]
        O = {{ type = "revolute", between = ["ground", "cam"] }}
        guide = {{ type = "prismatic", between = ["ground", "follower"], axis = [0, 1] }}
        [drives.motor]
        joint = "O"
        motion = "100 rad/s*t"
        [loads]
        spring = {{ type = "force", joint = "guide", value = "{spring}" }}
        contact = {{ type = "stop", joint = "guide", min = "10 mm*sin(O.angle)" }}
        [initial]
        guide = {{ position = 0, velocity = "1 m/s" }}
        "#
    )
}

#[test]
fn a_closed_stop_moves_what_it_bears() {
    let text = cam("-30 N - 4000 N/m*(guide.position + 10 mm)");
    let times = Range { from: 0.0, to: 0.05, n: 11 };
    needs_what_a_run_takes(&text, &times);
    let found = efforts(&text, &times);
    for (t, effort) in times.values().into_iter().zip(column(&found, "motor.effort")) {
        // The follower's force F on the cam, times the slope of the lift.
        let (sin, cos) = (100.0 * t).sin_cos();
        let force = 30.0 + 4000.0 * (0.01 * sin + 0.01) + 0.3 * -0.01 * 1e4 * sin;
        let expected = force * 0.01 * cos;
        assert!((effort - expected).abs() < 1e-9, "at {t}: {effort} instead of {expected}");
    }
    // From a later time on the stop is as closed.
    let later = efforts(&text, &Range { from: 0.02, to: 0.04, n: 3 });
    assert!((column(&later, "motor.effort")[0] - column(&found, "motor.effort")[4]).abs() < 1e-9);
}

#[test]
fn a_stop_that_would_have_to_pull_is_named_with_the_instant() {
    // 5 N + 10 N (1 + s) = 30 N s for s = sin(100 t).
    let at = 0.75_f64.asin() / 100.0;
    // At many times, and at two between which it would have to pull, though at neither.
    for n in [101, 2] {
        let found = inverse(
            model(&cam("-5 N - 1000 N/m*(guide.position + 10 mm)")),
            &[],
            &Range { from: 0.0, to: 0.04, n },
            &Actuators::default(),
        );
        let (code, message, _) = refusal(found);
        assert!(code == "Q017" && message.contains("`contact`"), "{code} {message}");
        assert!(message.contains(&format!("{at:.7}")), "{message}, not {at}");
    }
}

/// A drum that lowers its load by more than g would have to push it by the rope.
#[test]
fn a_rope_that_would_have_to_push_is_told_from_a_stop() {
    let text = "[ground]\npoints = { O = [0, 0], G = [-0.15, -5] }\n\
        [bodies]\ndrum = { points = { Z = [0, 0] }, mass = 10, inertia = 0.3 }\n\
        load = { points = { Z = [0, 0] }, mass = 20 }\n\
        [joints]\nA = { type = \"revolute\", between = [\"ground.O\", \"drum\"] }\n\
        g = { type = \"prismatic\", between = [\"ground.G\", \"load\"], axis = [0, 1] }\n\
        [couplings.rope]\ntype = \"rope\"\nslack = true\n\
        over = [\"load.Z\", { drum = \"drum.Z\", radius = 0.15, turn = \"right\" }]\n\
        [loads]\ngravity = { type = \"gravity\", acceleration = [0, -9.81] }\n\
        [drives.d]\njoint = \"A\"\nmotion = \"-10 rad/s*t + 50 rad/s^2*t^2\"\n[solve]\nt_end = 0.2\n";
    let times = Range { from: 0.0, to: 0.1, n: 3 };
    let (code, message, _) = refusal(inverse(model(text), &[], &times, &Actuators::default()));
    assert!(code == "Q017" && message.contains("the rope `rope` would have to push"), "{message}");
}

/// A follower that a stop lifts where it is closed: apart from its cam at the start, the stop is named.
#[test]
fn a_stop_that_is_open_at_the_start_is_named_where_motions_are_free() {
    let text = |at: &str| {
        format!(
            "[bodies]\ncam = {{ mass = 1, inertia = 0.001 }}\nfollower = {{ mass = 0.3 }}\n\
             [joints]\nO = {{ type = \"revolute\", between = [\"ground\", \"cam\"] }}\n\
             guide = {{ type = \"prismatic\", between = [\"ground\", \"follower\"], axis = [0, 1] }}\n\
             [loads]\nspring = {{ type = \"force\", joint = \"guide\", value = \"-30 N\" }}\n\
             contact = {{ type = \"stop\", joint = \"guide\", min = \"0.01*sin(O.angle)\" }}\n\
             [drives]\nmotor = {{ joint = \"O\", motion = \"20 rad/s*t\" }}\n\
             [initial]\nguide = {{ position = {at} }}\n[solve]\nt_end = 0.05\n"
        )
    };
    let times = Range { from: 0.0, to: 0.05, n: 3 };
    let ask = |at: &str| inverse(model(&text(at)), &[], &times, &Actuators::default());
    let Err(AnalysisError::NMotions { left, open, .. }) = ask("0.02") else {
        panic!("a free motion")
    };
    assert_eq!((left, open), (vec!["guide.position".to_owned()], vec!["contact".to_owned()]));
    let closed = text("0").replace("position = 0", "position = 0, velocity = 0.2");
    assert!(inverse(model(&closed), &[], &times, &Actuators::default()).is_ok());
}
