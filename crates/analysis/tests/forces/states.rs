//! The state that an answer is about: the nearest equilibrium whatever its stability, by name, and the others.

use crate::support::model;
use bksim_analysis::{
    About, AnalysisError, Channels, Search, Stability, linearize, modes, statics,
};

const G: f64 = 9.81;

/// A bob of 1 kg at 1 m, whose start is at an angle from upright.
fn pendulum(from_upright: f64) -> String {
    format!(
        "[parameters]\nu = \"0 N m\"\n[bodies.bob]\nmass = 1\ninertia = 0\ncom = [0, 1]\n\
         [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"bob\"] }}\n\
         [loads]\ng = {{ type = \"gravity\", acceleration = [0, -{G}] }}\n\
         motor = {{ type = \"torque\", on = \"bob\", value = \"u\" }}\n\
         [initial]\nA = {{ angle = \"{from_upright} deg\" }}\n"
    )
}

#[test]
fn a_degree_from_upright_is_the_upright_pendulum() {
    let make = || model(&pendulum(1.0));
    let found = linearize(make(), About::Static, &Channels::default()).expect("equations");
    assert!((found.a[(1, 0)] - G).abs() < 1e-9, "{}", found.a);
    let state = &found.state;
    assert_eq!((state.number, state.stability), (Some(1), Some(Stability::Unstable)));
    assert!(state.place[0].1.abs() < 1e-9 && state.search == Search::Complete, "{state:?}");
    let [other] = &state.others[..] else { panic!("{state:?}") };
    assert_eq!((other.number, other.stability), (2, Stability::Stable));
    assert!((other.place[0].1.abs() - std::f64::consts::PI).abs() < 1e-9, "{other:?}");

    // By number, and the nearest stable one.
    for about in [About::Number(2), About::Stable] {
        let found = linearize(make(), about, &Channels::default()).expect("equations");
        assert!((found.a[(1, 0)] + G).abs() < 1e-9, "{}", found.a);
        assert_eq!((found.state.number, found.state.others.len()), (Some(2), 1));
        let swing = modes(make(), about).expect("modes");
        assert!((swing.modes[0].omega - G.sqrt()).abs() < 1e-9);
    }
    let fault = linearize(make(), About::Number(3), &Channels::default()).expect_err("two");
    assert_eq!(fault.to_string(), "there is no equilibrium 3, of 2");
    let about: About = "2".parse().expect("a number");
    assert_eq!((about, "stable".parse()), (About::Number(2), Ok(About::Stable)));
}

#[test]
fn equilibria_are_listed_from_the_nearest_on() {
    for (degrees, first) in [(1.0, Stability::Unstable), (170.0, Stability::Stable)] {
        let found = statics(model(&pendulum(degrees)), &[], &[]).expect("equilibria");
        assert_eq!(found.equilibria[0].stability, first, "{degrees}");
    }
    // As near to both: the stable one comes first.
    let found = statics(model(&pendulum(90.0)), &[], &[]).expect("equilibria");
    assert_eq!(found.equilibria[0].stability, Stability::Stable);
    // Three rods in a row: every pair of neighbours in the list ascends.
    let mut text = format!("[loads]\ng = {{ type = \"gravity\", acceleration = [0, -{G}] }}\n");
    for k in 0..3 {
        let before = if k == 0 { "ground".to_owned() } else { format!("rod{}.end", k - 1) };
        text.extend([format!(
            "[bodies.rod{k}]\nmass = 1\ninertia = 0\ncom = [1, 0]\npoints = {{ end = [1, 0] }}\n\
             [joints.J{k}]\ntype = \"revolute\"\nbetween = [\"{before}\", \"rod{k}\"]\n\
             [initial.J{k}]\nangle = \"{} deg\"\n",
            [70.0, 20.0, 150.0][k]
        )]);
    }
    let start = [70.0_f64, 20.0, 150.0].map(f64::to_radians);
    let found = statics(model(&text), &[], &[]).expect("equilibria");
    let far = |q: &Vec<f64>| -> f64 {
        let off = q.iter().zip(start).map(|(q, s)| {
            let off = q - s;
            off - std::f64::consts::TAU * (off / std::f64::consts::TAU).round()
        });
        off.map(|off| off * off).sum()
    };
    let distances: Vec<f64> = found.equilibria.iter().map(|e| far(&e.q)).collect();
    assert!(distances.len() > 3, "{distances:?}");
    assert!(distances.windows(2).all(|pair| pair[0] <= pair[1] + 1e-6), "{distances:?}");
}

#[test]
fn modes_of_a_turning_start_name_the_rates_that_they_leave_out() {
    let text = "[bodies.rotor]\nmass = 2\ninertia = 0.3\n\
                [joints]\nA = { type = \"revolute\", between = [\"ground\", \"rotor\"] }\n\
                [loads]\ns = { type = \"torsion\", joint = \"A\", stiffness = 5 }\n\
                [initial]\nA = { angle = 0, rate = 40 }\n";
    let found = modes(model(text), About::Start).expect("modes");
    let [(name, rate, unit)] = &found.state.left_out[..] else { panic!("{:?}", found.state) };
    assert_eq!((name.as_str(), *rate, unit.as_str()), ("A.rate", 40.0, "rad/s"));
    assert!(modes(model(text), About::Static).expect("modes").state.left_out.is_empty());
}

#[test]
fn both_quaternions_of_a_pose_are_one_equilibrium() {
    let text = "space = \"spatial\"\ncoordinates = \"absolute\"\n\
                [bodies.arm]\nmass = 2\ncom = [0.5, 0, 0]\ninertia = [0.01, 0.1, 0.1]\npoints = { P = [0, 0, 0] }\n\
                [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"arm.P\"]\naxis = [0, 1, 0]\n\
                [loads.g]\ntype = \"gravity\"\nacceleration = [0, 0, -9.81]\n";
    let found = statics(model(text), &[], &[]).expect("equilibria");
    assert!(found.is_complete);
    assert_eq!(found.by, [("A.angle".to_owned(), "rad")]);
    let mut angles: Vec<f64> = found.table().column("A.angle").expect("angles");
    angles.sort_by(f64::total_cmp);
    assert_eq!(angles.len(), 2, "{angles:?}");
    for (angle, expected) in angles.iter().zip([-90.0, 90.0]) {
        assert!((angle.to_degrees() - expected).abs() < 1e-7, "{angles:?}");
    }
    // k = m g c about the pin.
    let least: Vec<f64> = found.equilibria.iter().map(|e| e.stiffness[0].abs()).collect();
    assert!(least.iter().all(|k| (k - 9.81).abs() < 1e-6), "{least:?}");
}

/// A cantilever of lumps: E I of a steel strip of 30 mm by 3 mm, 0.6 m long.
fn beam(n: usize) -> String {
    let mut text = format!(
        "[parameters]\nL = \"0.6 m\"\nE = \"206 GPa\"\nb = \"30 mm\"\nh = \"3 mm\"\nrho = \"7850 kg/m^3\"\n\
         I = \"b*h^3/12\"\na = \"L/{n}\"\n"
    );
    for k in 1..=n {
        let (before, share) = match k {
            1 => ("ground".to_owned(), "2*E*I/a"),
            _ => (format!("lump{}.tip", k - 1), "E*I/a"),
        };
        text.extend([format!(
            "[bodies.lump{k}]\nmass = \"rho*b*h*a\"\ncom = [\"a/2\", 0]\ninertia = \"rho*b*h*a^3/12\"\n\
             points = {{ tip = [\"a\", 0] }}\n\
             [joints.pin{k}]\ntype = \"revolute\"\nbetween = [\"{before}\", \"lump{k}\"]\n\
             [loads.bend{k}]\ntype = \"torsion\"\njoint = \"pin{k}\"\nstiffness = \"{share}\"\n"
        )]);
    }
    text
}

#[test]
fn a_beam_of_many_lumps_is_stable() {
    let found = modes(model(&beam(24)), About::Static).expect("modes");
    assert_eq!(found.stability, Stability::Stable);
    // Euler and Bernoulli: ω = 1.8751² √(E I / (ρ A L⁴)), less what lumps change.
    let (e, b, h, rho, l) = (206e9, 0.03, 0.003_f64, 7850.0, 0.6_f64);
    let expected =
        1.875_104_f64.powi(2) * (e * b * h.powi(3) / 12.0 / (rho * b * h * l.powi(4))).sqrt();
    let omega = found.modes[0].omega;
    assert!((omega / expected - 1.0).abs() < 0.01, "{omega} for {expected}");
}

#[test]
fn a_soft_spring_next_to_a_stiff_one_is_stable() {
    // 1 N/m next to 1e12 N/m: each is judged by its own terms.
    let text = "[bodies]\na = { mass = 1, inertia = 0 }\nb = { mass = 1, inertia = 0 }\n\
                [joints]\nA = { type = \"prismatic\", between = [\"ground\", \"a\"], axis = [1, 0] }\n\
                B = { type = \"prismatic\", between = [\"ground\", \"b\"], axis = [1, 0] }\n\
                [loads]\nsoft = { type = \"spring\", joint = \"A\", stiffness = 1, length = 0 }\n\
                stiff = { type = \"spring\", joint = \"B\", stiffness = 1e12, length = 0 }\n";
    let found = statics(model(text), &[], &[]).expect("balance");
    assert_eq!(found.equilibria[0].stability, Stability::Stable);
}

#[test]
fn what_an_equilibrium_leaves_free_is_named() {
    // A block that slides on a level guide is in balance anywhere.
    let text = "[bodies]\nblock = { mass = 1, inertia = 0 }\n\
                [joints]\nguide = { type = \"prismatic\", between = [\"ground\", \"block\"], axis = [1, 0] }\n\
                [loads]\ng = { type = \"gravity\", acceleration = [0, -9.81] }\n\
                [initial]\nguide = { position = 0.679747317 }\n";
    let found = statics(model(text), &[], &[]).expect("balance");
    let family = found.equilibria[0].family.as_ref().expect("a family");
    assert!(family.free.contains(&found.by[0].0), "{family:?} by {:?}", found.by);
    // Linear equations have one of them all the same.
    let state =
        linearize(model(text), About::Static, &Channels::default()).expect("equations").state;
    assert_eq!(state.stability, Some(Stability::Neutral));
    let none: Result<_, AnalysisError> = modes(model(text), About::Stable);
    assert_eq!(none.expect_err("none").to_string(), "none of 1 equilibrium is stable");
}
