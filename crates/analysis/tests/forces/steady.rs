//! Equilibria that turn with drives, against closed forms.

use crate::support::model;
use bksim_analysis::{About, Channels, Stability, Statics, letters, linearize, modes, statics};

const G: f64 = 9.81;

/// The value of a quantity in an equilibrium.
fn value(found: &Statics, k: usize, name: &str) -> f64 {
    let pose = &found.equilibria[k].pose;
    pose.iter().find(|(own, ..)| own == name).map(|(_, value, _)| *value).expect("a quantity")
}

/// A bead on a hoop of 0.5 m that a drive turns about the vertical.
fn hoop(motion: &str, axis: &str) -> String {
    format!(
        "[bodies]\nhoop = {{ mass = 1, inertia = [0.1, 0.1, 0.1] }}\n\
         arm = {{ mass = 0, inertia = [0, 0, 0], points = {{ P = [0, 0, -0.5] }} }}\nbead = {{ mass = 0.2 }}\n\
         [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"hoop\"], axis = {axis} }}\n\
         B = {{ type = \"revolute\", between = [\"hoop\", \"arm\"], axis = [0, 1, 0] }}\n\
         C = {{ type = \"weld\", between = [\"arm.P\", \"bead\"] }}\n\
         [drives.d]\njoint = \"A\"\nmotion = \"{motion}\"\n\
         [loads]\ng = {{ type = \"gravity\", acceleration = [0, 0, -{G}] }}\n\
         [initial]\nB = {{ angle = \"20 deg\" }}\n"
    )
}

#[test]
fn a_bead_on_a_hoop_that_turns_rests_where_centrifugal_forces_balance_its_weight() {
    for rate in [7.0, 4.0] {
        let text = hoop(&format!("{rate} rad/s*t"), "[0, 0, 1]");
        let found = statics(model(&text), &[], &[]).expect("equilibria");
        let drives = &found.held.steady;
        assert_eq!((drives[0].name.as_str(), drives[0].unit), ("d", "rad/s"));
        assert_eq!(drives[0].rate, rate);
        assert!(found.held.stopped.is_empty() && found.is_complete);
        let cosine = G / (0.5 * rate * rate);
        let stable: Vec<usize> = (0..found.equilibria.len())
            .filter(|&k| found.equilibria[k].stability == Stability::Stable)
            .collect();
        let swing = modes(model(&text), About::Stable).expect("modes").modes[0].s;
        if cosine < 1.0 {
            assert_eq!((found.equilibria.len(), stable.len()), (4, 2));
            for k in stable {
                assert!((value(&found, k, "B.angle").cos() - cosine).abs() < 1e-9);
            }
            let omega = rate * (1.0 - cosine * cosine).sqrt();
            assert!(swing[0].abs() < 1e-9 && (swing[1] - omega).abs() < 1e-8, "{swing:?}");
        } else {
            assert_eq!((found.equilibria.len(), stable.len()), (2, 1));
            let omega = (G / 0.5 - rate * rate).sqrt();
            assert!((swing[1] - omega).abs() < 1e-8, "{swing:?}");
        }
        let linear = linearize(model(&text), About::Stable, &Channels::default()).expect("A");
        assert!((linear.a[(1, 0)] + swing[1] * swing[1]).abs() < 1e-7, "{}", linear.a);
    }
}

#[test]
fn a_mass_on_an_arm_that_turns_moves_out_until_its_spring_is_too_soft() {
    let arm = |rate: f64| {
        format!(
            "[bodies]\narm = {{ mass = 1, inertia = 0.1 }}\nm = {{ mass = 1 }}\n\
             [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"arm\"] }}\n\
             S = {{ type = \"prismatic\", between = [\"arm\", \"m\"], axis = [1, 0] }}\n\
             [drives.d]\njoint = \"A\"\nmotion = \"{rate} rad/s*t\"\n\
             [loads]\nk = {{ type = \"spring\", joint = \"S\", stiffness = 100, length = 0.1 }}\n"
        )
    };
    for (rate, stability) in [(6.0, Stability::Stable), (12.0, Stability::Unstable)] {
        let found = statics(model(&arm(rate)), &[], &[]).expect("an equilibrium");
        let softer = 100.0 - rate * rate;
        assert!((value(&found, 0, "S.position") - 10.0 / softer).abs() < 1e-9);
        assert!((found.equilibria[0].stiffness[0] - softer).abs() < 1e-9);
        assert_eq!(found.equilibria[0].stability, stability);
    }
}

/// A body on two slides across each other, each with a spring, on a disc that turns: below the critical rate the frame's
/// potential has a minimum, above it Coriolis' forces hold a maximum.
#[test]
fn gyroscopic_forces_hold_a_maximum_and_do_not_let_motions_decay() {
    for (rate, stability) in [(8.0, Stability::Stable), (12.0, Stability::Marginal)] {
        let text = format!(
            "[bodies]\ndisc = {{ mass = 1, inertia = 1 }}\ns = {{ mass = 0, inertia = 0 }}\nm = {{ mass = 1 }}\n\
             [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"disc\"] }}\n\
             X = {{ type = \"prismatic\", between = [\"disc\", \"s\"], axis = [1, 0] }}\n\
             Y = {{ type = \"prismatic\", between = [\"s\", \"m\"], axis = [0, 1] }}\n\
             [drives.d]\njoint = \"A\"\nmotion = \"{rate} rad/s*t\"\n\
             [loads]\nx = {{ type = \"spring\", joint = \"X\", stiffness = 100, length = 0 }}\n\
             y = {{ type = \"spring\", joint = \"Y\", stiffness = 100, length = 0 }}\n"
        );
        let found = modes(model(&text), About::Static).expect("modes");
        let omegas: Vec<f64> = found.modes.iter().map(|mode| mode.s[1]).collect();
        assert!((omegas[0] - (10.0_f64 - rate).abs()).abs() < 1e-7, "{omegas:?}");
        assert!((omegas[1] - (10.0 + rate)).abs() < 1e-7, "{omegas:?}");
        assert_eq!(found.stability, stability);
    }
}

/// One side of a governor: arms and links as long as each other, a bob between them, a collar on the spindle.
#[test]
fn a_governor_lifts_its_collar_by_a_loop_that_turns() {
    let (m, collar, length, rate) = (0.5, 0.3, 0.2, 14.0);
    let text = format!(
        "[bodies]\nspindle = {{ mass = 1, inertia = [0.1, 0.1, 0.1] }}\n\
         arm = {{ mass = 0, inertia = [0, 0, 0], points = {{ E = [0, 0, -{length}] }} }}\n\
         bob = {{ mass = {m} }}\n\
         link = {{ mass = 0, inertia = [0, 0, 0], points = {{ E = [0, 0, -{length}] }} }}\n\
         collar = {{ mass = {collar}, inertia = [0, 0, 0] }}\n\
         [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"spindle\"], axis = [0, 0, 1] }}\n\
         B = {{ type = \"revolute\", between = [\"spindle\", \"arm\"], axis = [0, 1, 0] }}\n\
         W = {{ type = \"weld\", between = [\"arm.E\", \"bob\"] }}\n\
         C = {{ type = \"revolute\", between = [\"arm.E\", \"link\"], axis = [0, 1, 0] }}\n\
         D = {{ type = \"revolute\", between = [\"link.E\", \"collar\"], axis = [0, 1, 0] }}\n\
         S = {{ type = \"prismatic\", between = [\"spindle\", \"collar\"], axis = [0, 0, 1] }}\n\
         [drives.d]\njoint = \"A\"\nmotion = \"{rate} rad/s*t\"\n\
         [loads]\ng = {{ type = \"gravity\", acceleration = [0, 0, -{G}] }}\n\
         [initial]\nB = {{ angle = \"40 deg\" }}\nC = {{ guess = {{ angle = \"-80 deg\" }} }}\n"
    );
    let found = statics(model(&text), &[], &[]).expect("equilibria");
    assert_eq!(found.held.steady.len(), 1);
    let cosine = (m + 2.0 * collar) * G / (m * rate * rate * length);
    let stable = |k: &usize| found.equilibria[*k].stability == Stability::Stable;
    let k = (0..found.equilibria.len()).find(stable).expect("a stable one");
    assert!((value(&found, k, "B.angle").cos() - cosine).abs() < 1e-9);
    assert!((value(&found, k, "S.position") + 2.0 * length * cosine).abs() < 1e-9);
}

/// Where forces depend on how far a drive has turned, or its rate is none that stays, it is held and named.
#[test]
fn a_drive_without_a_steady_motion_is_held_and_named() {
    for (motion, axis, rate) in
        [("7 rad/s*t", "[1, 0, 0]", 7.0), ("3 rad/s*t + 1 rad/s^2*t^2", "[0, 0, 1]", 3.0)]
    {
        let found = statics(model(&hoop(motion, axis)), &[], &[]).expect("equilibria");
        assert!(found.held.steady.is_empty());
        assert_eq!((found.held.stopped[0].name.as_str(), found.held.stopped[0].rate), ("d", rate));
        assert!(found.equilibria.iter().any(|e| e.stability == Stability::Stable));
    }
}

/// A law that is softer to one side: half a period with each stiffness.
#[test]
fn modes_at_a_kink_name_both_sides() {
    let text = "[bodies.m]\nmass = 1\n\
                [joints.g]\ntype = \"prismatic\"\nbetween = [\"ground\", \"m\"]\naxis = [1, 0]\n\
                [loads]\nf = { type = \"force\", joint = \"g\", \
                value = \"if(g.position > 0 m, -400 N/m*g.position, -100 N/m*g.position)\" }\n";
    let found = modes(model(text), About::Static).expect("modes");
    let [kink] = &found.state.kinks[..] else { panic!("{:?}", found.state) };
    assert_eq!(kink.stiffness, [100.0, 400.0]);
    let [below, above, whole] = kink.omega.expect("frequencies");
    let period = std::f64::consts::PI * (1.0 / 10.0 + 1.0 / 20.0);
    assert!((below - 10.0).abs() < 1e-9 && (above - 20.0).abs() < 1e-9);
    assert!((whole - std::f64::consts::TAU / period).abs() < 1e-9);
    // A law without a kink has none.
    let smooth = text.replace("-400 N/m", "-100 N/m");
    assert!(modes(model(&smooth), About::Static).expect("modes").state.kinks.is_empty());
}

/// In letters the rate of the drive is an expression, too, and the certificate compares them at other values of it.
#[test]
fn letters_about_a_steady_motion_have_the_rate_of_the_drive() {
    let text = format!("[parameters]\nw = \"7 rad/s\"\n{}", hoop("w*t", "[0, 0, 1]"));
    let found = letters(model(&text), &Channels::default()).expect("equations").expect("letters");
    assert!(found.a[1][0].contains('w'), "{:?}", found.a);
    assert!(found.largest_difference < 1e-9, "{}", found.largest_difference);
}
