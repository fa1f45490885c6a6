//! Stability under forces that follow the motion and damping that feeds it, against published values.

use crate::support::model;
use bksim_analysis::{About, AnalysisError, Channels, Stability, linearize, modes, statics};

/// Ziegler's column: two rods of 1 m with masses of 2 kg and 1 kg at their ends, torsion springs of 1 N m/rad.
fn ziegler(load: f64, damping: f64) -> String {
    let spring = |joint: &str| {
        format!("{{ type = \"torsion\", joint = \"{joint}\", stiffness = 1, damping = {damping} }}")
    };
    format!(
        "[bodies]\na = {{ mass = 2, inertia = 0, com = [1, 0], points = {{ e = [1, 0] }} }}\n\
         b = {{ mass = 1, inertia = 0, com = [1, 0], points = {{ e = [1, 0] }} }}\n\
         [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"a\"] }}\n\
         B = {{ type = \"revolute\", between = [\"a.e\", \"b\"] }}\n\
         [loads]\nk1 = {}\nk2 = {}\n\
         f = {{ type = \"force\", on = \"b.e\", vector = [-{load}, 0], axes = \"body\" }}\n",
        spring("A"),
        spring("B")
    )
}

/// H. Ziegler, *Die Stabilitätskriterien der Elastomechanik*, Ing.-Arch. 20 (1952): flutter at 7/2 − √2 = 2.086 without
/// damping, at 41/28 = 1.464 with as little as one likes in both joints.
#[test]
fn zieglers_column_flutters_at_the_published_loads() {
    for (load, damping, stability) in [
        (2.08, 0.0, Stability::Marginal),
        (2.09, 0.0, Stability::Flutter),
        (1.46, 0.001, Stability::Stable),
        (1.47, 0.001, Stability::Flutter),
    ] {
        let found = modes(model(&ziegler(load, damping)), About::Static).expect("modes");
        assert_eq!(found.stability, stability, "{load} {damping}");
        let all = statics(model(&ziegler(load, damping)), &[], &[]).expect("equilibria");
        assert_eq!(all.equilibria[0].stability, stability, "{load} {damping}");
        let grows = found.modes.iter().any(|mode| mode.s[0] > 1e-6);
        assert_eq!(grows, stability == Stability::Flutter);
    }
}

/// M. Beck, *Die Knicklast des einseitig eingespannten, tangential gedrückten Stabes*, ZAMP 3 (1952): 20.05 EI/L².
#[test]
fn becks_column_flutters_at_the_published_load() {
    for (load, stability) in [(19.9, Stability::Marginal), (20.2, Stability::Flutter)] {
        let text = format!(
            "[bodies]\nb = {{ flexible = {{ length = 1, EI = 1, rho = 1 }}, points = {{ e = [1, 0] }} }}\n\
             t = {{ mass = 0, inertia = 0 }}\n\
             [joints]\nA = {{ type = \"weld\", between = [\"ground\", \"b\"] }}\n\
             B = {{ type = \"weld\", between = [\"b.e\", \"t\"] }}\n\
             [loads]\nf = {{ type = \"force\", on = \"t\", vector = [-{load}, 0], axes = \"body\" }}\n"
        );
        assert_eq!(modes(model(&text), About::Start).expect("modes").stability, stability);
    }
}

#[test]
fn damping_below_zero_lets_a_hanging_pendulum_flutter() {
    for (torque, stability) in [("0.5", Stability::Flutter), ("-0.5", Stability::Stable)] {
        let text = format!(
            "[bodies.p]\nmass = 1\ninertia = 0\ncom = [0, -1]\n\
             [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"p\"]\n\
             [loads]\ng = {{ type = \"gravity\", acceleration = [0, -9.81] }}\n\
             pump = {{ type = \"torque\", joint = \"A\", value = \"{torque} N m s*A.rate\" }}\n"
        );
        let found = statics(model(&text), &[], &[]).expect("equilibria");
        assert_eq!(found.equilibria[0].stability, stability);
        assert_eq!(found.equilibria[1].stability, Stability::Unstable);
    }
}

/// The rate of what a drive's position depends on acts by itself: its response is no gain of the value alone.
#[test]
fn an_input_that_moves_a_drive_is_refused_by_name() {
    let text = "[parameters]\ny = 0\n[bodies]\nbase = { mass = 1 }\nm = { mass = 2 }\n\
                [joints]\nb = { type = \"prismatic\", between = [\"ground\", \"base\"], axis = [1, 0] }\n\
                s = { type = \"prismatic\", between = [\"base\", \"m\"], axis = [1, 0] }\n\
                [drives.d]\njoint = \"b\"\nmotion = \"y\"\n\
                [loads.k]\ntype = \"spring\"\njoint = \"s\"\nstiffness = 800\nlength = 0\ndamping = 8\n";
    let channels = Channels { inputs: vec!["y".into()], ..Channels::default() };
    let fault = linearize(model(text), About::Static, &channels).expect_err("refused");
    let AnalysisError::MovingInput { name, what } = &fault else { panic!("{fault}") };
    assert_eq!((name.as_str(), what.as_str()), ("y", "drive `d`"));
}
