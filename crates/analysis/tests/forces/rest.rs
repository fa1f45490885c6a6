//! Dry friction in questions about a state: left out by name at rest, with all its slopes where it slides.

use crate::support::model;
use bksim_analysis::{
    About, Actuators, Channels, Motion, Range, balanced, inverse, linearize, modes, statics,
};

/// A bob at the end of an arm, whose pin rubs as `law` says.
fn pendulum(law: &str) -> String {
    format!(
        "[bodies.arm]\nmass = 1\ninertia = 0\ncom = [1, 0]\n\
         [joints.O]\ntype = \"revolute\"\nbetween = [\"ground\", \"arm\"]\n\
         [loads]\ng = {{ type = \"gravity\", acceleration = [0, -9.81] }}\n\
         rub = {{ type = \"friction\", joint = \"O\", {law} }}\n[solve]\nt_end = 1\n"
    )
}

/// Friction at rest holds all poses in which the load is less than its limit; the middle of them is in balance without it.
#[test]
fn an_equilibrium_is_one_without_friction_and_says_so() {
    for law in ["torque = \"2 N m\"", "mu = 0.3, radius = 0.1"] {
        let found = statics(model(&pendulum(law)), &[], &[]).expect("equilibria");
        assert_eq!(found.held.left_out, ["friction `rub`"], "{law}");
        assert!(found.held.rows.is_empty());
        let mut sines: Vec<f64> = Vec::new();
        for of in &found.equilibria {
            let (_, angle, _) =
                of.pose.iter().find(|(name, ..)| name == "O.angle").expect("an angle");
            sines.push(angle.sin());
        }
        sines.sort_by(f64::total_cmp);
        assert!((sines[0] + 1.0).abs() + (sines[1] - 1.0).abs() < 1e-12, "{law}: {sines:?}");
        let swing = modes(model(&pendulum(law)), About::Stable).expect("modes");
        assert!((swing.modes[0].omega - 9.81_f64.sqrt()).abs() < 1e-9, "{law}");
        assert_eq!(swing.held.left_out, ["friction `rub`"]);
        let linear = linearize(model(&pendulum(law)), About::Static, &Channels::default());
        assert_eq!(linear.expect("equations").held.left_out, ["friction `rub`"]);
    }
}

/// m x″ = −k (1 − l/r) x − μ N with N = m g − k (1 − l/r) h and r² = x² + h².
#[test]
fn friction_that_slides_has_the_slope_of_what_the_guide_bears() {
    let block = |mu: f64| {
        model(&format!(
            "[ground]\npoints = {{ H = [0, 1] }}\n[bodies.b]\nmass = 2\n\
             [joints.s]\ntype = \"prismatic\"\nbetween = [\"ground\", \"b\"]\naxis = [1, 0]\n\
             [loads]\ng = {{ type = \"gravity\", acceleration = [0, -9.81] }}\n\
             k = {{ type = \"spring\", between = [\"ground.H\", \"b\"], stiffness = 10, length = 0.2 }}\n\
             rub = {{ type = \"friction\", joint = \"s\", mu = {mu} }}\n\
             [initial]\ns = {{ position = 0.5, velocity = 1 }}\n[solve]\nt_end = 1\n"
        ))
    };
    let (k, l, x, h, m): (f64, f64, f64, f64, f64) = (10.0, 0.2, 0.5, 1.0, 2.0);
    let r = x.hypot(h);
    for mu in [0.0, 0.3] {
        let found = linearize(block(mu), About::Start, &Channels::default()).expect("equations");
        let slope = -k * (1.0 - l / r + l * x * x / r.powi(3)) + mu * k * h * l * x / r.powi(3);
        let own = found.a[(1, 0)];
        assert!((own - slope / m).abs() < 1e-10, "{own} instead of {} at mu = {mu}", slope / m);
        assert!(found.held.left_out.is_empty());
    }
}

/// A rope that slides over a drum: (m₁ + c m₂) x″ = −k x with c = exp(μ π), as T₁ = c T₂ while the drum turns below it.
#[test]
fn a_rope_that_slides_over_a_drum_has_the_slope_of_its_pull() {
    let text = include_str!("../../../../tests/fixtures/touch/capstan.toml");
    let text = text.replace("A = [\"-0.15 m\", 0]", "A = [\"-0.15 m\", 0], D = [\"-0.15 m\", -1]");
    let text = format!(
        "{text}\n[loads.k]\ntype = \"spring\"\nbetween = [\"ground.D\", \"m1.hook\"]\n\
         stiffness = 2000\nlength = 1\n"
    );
    let found = linearize(model(&text), About::Start, &Channels::default()).expect("equations");
    let at =
        |name: &str| found.states.iter().position(|state| state.name == name).expect("a state");
    let own = found.a[(at("guide1_position_dot"), at("guide1_position"))];
    let slope = -2000.0 / (12.0 + 10.0 * (0.15 * std::f64::consts::PI).exp());
    assert!((own - slope).abs() < 1e-9, "{own} instead of {slope}");
}

/// A load with a pole, one without values, one that overflows: no equilibrium, mode or effort without a number.
#[test]
fn loads_without_values_are_named_and_never_in_balance() {
    let text = |value: &str| {
        format!(
            "[parameters]\nm = 1\n[bodies.arm]\nmass = \"m\"\ninertia = 0.1\ncom = [0.5, 0]\n\
             [joints.O]\ntype = \"revolute\"\nbetween = [\"ground\", \"arm\"]\n\
             [loads]\ng = {{ type = \"gravity\", acceleration = [0, -9.81] }}\n\
             k = {{ type = \"torsion\", joint = \"O\", stiffness = 20 }}\n\
             u = {{ type = \"torque\", on = \"arm\", value = \"0.5 N m*{value}\" }}\n\
             [initial]\nO = {{ angle = 0.2 }}\n[solve]\nt_end = 1\n"
        )
    };
    let load = |value: f64, angle: f64| -20.0 * angle - 4.905 * angle.cos() + 0.5 * value;
    for (value, function) in [
        ("1/(O.angle/(1 rad) - 0.2)", (|x| 1.0 / (x - 0.2)) as fn(f64) -> f64),
        ("exp(5000*O.angle/(1 rad))", |x| (5000.0 * x).exp()),
        ("1/(O.angle/(1 rad) - 0.5)", |x| 1.0 / (x - 0.5)),
    ] {
        let found = match statics(model(&text(value)), &[], &[]) {
            Ok(found) => found,
            // No value anywhere in the turn of the start.
            Err(fault) => {
                assert!(value.contains("exp"), "{fault}");
                assert_eq!(fault.diagnostics()[0].code.0, "Q023");
                continue;
            }
        };
        for of in &found.equilibria {
            let angle = of.q[0];
            let left = load(function(angle), angle);
            assert!(left.abs() < 1e-6, "{left} N m are left at {angle} by {value}");
            assert!(of.stiffness.iter().all(|k| k.is_finite()));
        }
    }
    // The slope of a root where it is zero; a pole and an overflow in the start itself.
    for value in
        ["sqrt(O.angle/(1 rad) - 0.2)", "1/(O.angle/(1 rad) - 0.2)", "exp(5000*O.angle/(1 rad))"]
    {
        for fault in [
            modes(model(&text(value)), About::Start).err(),
            linearize(model(&text(value)), About::Start, &Channels::default()).err(),
            balanced(model(&text(value)), &["m".to_owned()], &[]).err(),
        ] {
            let fault = fault.unwrap_or_else(|| panic!("an answer for {value}"));
            let found = &fault.diagnostics()[0];
            assert!(["Q012", "Q023"].contains(&found.code.0), "{} of {value}", found.message);
        }
    }
    let motion = Motion::formula(&model(&text("1")), "O.angle", "0.2 - 0.3*t").expect("a motion");
    let times = Range { from: 0.0, to: 0.5, n: 3 };
    let pole = model(&text("1/(O.angle/(1 rad) - 0.2)"));
    let fault = inverse(pole, &[motion], &times, &Actuators::default()).expect_err("a pole");
    let found = &fault.diagnostics()[0];
    assert_eq!(found.code.0, "Q023");
    assert!(found.message.contains("force along O_angle") && found.message.contains("t = 0 s"));
}
