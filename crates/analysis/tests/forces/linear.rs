//! Linear systems and modes against references of 15 digits.

use crate::support::{Problem, model, number};
use bksim_analysis::{
    About, AnalysisError, Channels, Modes, Search, bode, exported_linear, linearize, modes,
};

fn close(found: f64, expected: f64, tolerance: f64) {
    let off = (found - expected).abs();
    assert!(off <= tolerance * expected.abs().max(1.0), "{found} instead of {expected}");
}

fn entry(found: &Modes, mode: usize, name: &str) -> [f64; 2] {
    let idx = found.quantities.iter().position(|q| q.name == name).expect("a quantity");
    found.modes[mode].shape[idx]
}

#[test]
fn four_bar_from_torque_to_angle() {
    let problem = Problem::load("lti-four-bar");
    let one = |name: &str| vec![name.to_owned()];
    let channels = Channels {
        inputs: one("crank.angle"),
        outputs: one("rocker.angle"),
        states: one("crank.angle"),
    };
    let found = linearize(problem.model(), About::Static, &channels).expect("a linear system");
    let values = &problem.0["values"];
    for (i, row) in values["A"].as_array().expect("A").iter().enumerate() {
        for (j, value) in row.as_array().expect("a row").iter().enumerate() {
            close(found.a[(i, j)], number(value), 1e-10);
        }
        close(found.b[(i, 0)], number(&values["B"][i]), 1e-10);
        close(found.c[(0, i)], number(&values["C"][i]), 1e-10);
    }
    assert_eq!(found.states[1].name, "crank.rate");
}

#[test]
fn undamped_pendulums_of_two_and_three_links() {
    for name in ["mode-string-2", "mode-physical-2", "mode-physical-3"] {
        let problem = Problem::load(name);
        let found = modes(problem.model(), About::Static).expect("modes");
        assert_eq!(found.modes.len(), problem.rows().len());
        for (k, row) in problem.rows().iter().enumerate() {
            close(found.modes[k].omega / row[0], 1.0, 1e-11);
            close(found.modes[k].shares.iter().sum::<f64>(), 1.0, 1e-12);
            for (i, expected) in row[2..].iter().enumerate() {
                let [re, im] = entry(&found, k, &format!("link{}.angle", i + 1));
                close(re, *expected, 1e-9);
                close(im, 0.0, 1e-12);
            }
        }
    }
}

#[test]
fn pendulum_with_dampers() {
    let problem = Problem::load("mode-damped-pendulum");
    let found = modes(problem.model(), About::Static).expect("modes");
    let rows = problem.rows();
    assert_eq!(found.modes.len(), rows.len());
    for (k, row) in rows.iter().enumerate() {
        let mode = &found.modes[k];
        close(mode.s[0], row[0], 1e-11);
        close(mode.s[1], row[1], 1e-11);
        close(mode.damping, row[3], 1e-11);
        for (i, name) in ["link1.angle", "link2.angle"].iter().enumerate() {
            let [re, im] = entry(&found, k, name);
            close(re, row[4 + 2 * i], 1e-9);
            close(im, row[5 + 2 * i], 1e-9);
        }
    }
}

/// Point masses on strings: ω² = g x with x the zeros of Laguerre's polynomial.
#[test]
fn masses_on_strings_in_three_kinds_of_coordinates() {
    let expected: [&[f64]; 3] = [
        &[2.397_199_397_9, 5.787_351_298_0],
        &[2.019_591_147_2, 4.744_142_739_7, 7.855_212_362_7],
        &[1.162_649_537_0, 2.675_060_584_5, 4.211_869_402_8],
    ];
    for (n, omegas) in [2, 3, 10].into_iter().zip(expected) {
        for kind in ["relative", "absolute", "links"] {
            let found = modes(model(&strings(n, kind)), About::Static).expect("modes");
            // Particles on links turn freely besides.
            let swinging: Vec<_> = found.modes.iter().filter(|mode| mode.omega > 1e-6).collect();
            assert_eq!(swinging.len(), n, "{kind}: {:?}", found.modes);
            for (mode, omega) in swinging.into_iter().zip(omegas) {
                close(mode.omega, *omega, 1e-9);
            }
        }
    }
}

fn strings(n: usize, kind: &str) -> String {
    let mut text = String::new();
    if kind == "absolute" {
        text += "coordinates = \"absolute\"\n";
    }
    for k in 1..=n {
        if kind == "links" {
            text.extend([format!("[bodies.m{k}]\nmass = 1\ninertia = 1\n")]);
        } else {
            text.extend([format!(
                "[bodies.m{k}]\nmass = 1\ninertia = 0\ncom = [1, 0]\npoints = {{ P = [0, 0], Q = [1, 0] }}\n"
            )]);
        }
    }
    text += "[joints]\n";
    for k in 1..=n {
        let before = if k == 1 { "ground".to_owned() } else { format!("m{}", k - 1) };
        if kind == "links" {
            text.extend([format!(
                "L{k} = {{ type = \"link\", between = [\"{before}\", \"m{k}\"], length = 1 }}\n"
            )]);
        } else {
            let before = if k == 1 { before } else { format!("{before}.Q") };
            text.extend([format!(
                "J{k} = {{ type = \"revolute\", between = [\"{before}\", \"m{k}.P\"] }}\n"
            )]);
        }
    }
    text += "[loads.gravity]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n";
    text += "[initial]\n";
    for k in 1..=n {
        if kind == "links" {
            text.extend([format!(
                "m{k} = {{ guess = {{ x = 0, y = {}, angle = 0 }} }}\n",
                -(k as f64)
            )]);
        } else {
            text.extend([format!("m{k} = {{ angle = \"-90 deg\" }}\n")]);
        }
    }
    text
}

/// A pendulum on a ball joint, which turns by a quaternion: ω² = m g l / J about two axes, and none about
/// the vertical.
#[test]
fn a_pendulum_on_a_ball() {
    let text = "space = \"spatial\"\n[bodies.bob]\nmass = 1\ninertia = [0.02, 0.03, 0.04]\n\
                com = [0, 0, -0.5]\n[joints.ball]\ntype = \"spherical\"\nbetween = [\"ground\", \"bob\"]\n\
                [loads.g]\ntype = \"gravity\"\nacceleration = [0, 0, -9.81]\n\
                [initial]\nbob = { rpy = [0.1, 0.1, 0.1] }\n";
    let found = modes(model(text), About::Static).expect("modes");
    let omegas: Vec<f64> = found.modes.iter().map(|mode| mode.omega).collect();
    let expected = [0.0, (9.81_f64 * 0.5 / 0.28).sqrt(), (9.81_f64 * 0.5 / 0.27).sqrt()];
    assert_eq!(omegas.len(), 3, "{omegas:?}");
    for (found, expected) in omegas.iter().zip(expected) {
        close(*found, expected, 1e-9);
    }
}

/// A point mass on a rod with a torque u: θ̈ = (u − m g l θ)/(m l²), and the pin carries m l θ̈ across.
#[test]
fn the_reaction_of_a_driven_pendulum_is_an_output() {
    let (m, l, g) = (2.0, 0.7, 9.81);
    for policy in ["relative", "absolute"] {
        let text = format!(
            "coordinates = \"{policy}\"\n[parameters]\nu = \"0 N*m\"\n[bodies.rod]\nmass = {m}\ninertia = 0\ncom = [{l}, 0]\n\
             [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"rod\"] }}\n\
             [loads]\ng = {{ type = \"gravity\", acceleration = [0, -{g}] }}\n\
             m = {{ type = \"torque\", on = \"rod\", value = \"u\" }}\n\
             [io]\ninput = [\"u\"]\noutput = [\"reactions.A.fx\", \"reactions.A.fy\", \"rod.angle\"]\n\
             [initial]\nrod = {{ angle = \"-90 deg\" }}\n"
        );
        let named = Channels { states: vec!["rod.angle".to_owned()], ..Channels::default() };
        let found = linearize(model(&text), About::Static, &named).expect("a linear system");
        let expected = [[-m * g, 0.0, 1.0 / l], [0.0; 3], [1.0, 0.0, 0.0]];
        for (i, row) in expected.iter().enumerate() {
            close(found.c[(i, 0)], row[0], 1e-12);
            close(found.c[(i, 1)], row[1], 1e-12);
            close(found.d[(i, 0)], row[2], 1e-12);
        }
        // As code, a column at a time.
        let function = exported_linear("pendulum", &found).expect("a function");
        let whole = |i: usize, j: usize| match (i < 2, j < 2) {
            (true, true) => found.a[(i, j)],
            (true, false) => found.b[(i, j - 2)],
            (false, true) => found.c[(i - 2, j)],
            (false, false) => found.d[(i - 2, j - 2)],
        };
        for j in 0..3 {
            let inputs: Vec<f64> = (0..3).map(|k| f64::from(u8::from(k == j))).collect();
            let mut outputs = vec![0.0; 5];
            function.tape.evaluate(&mut function.tape.workspace(&[]), &inputs, &mut outputs);
            let expected: Vec<f64> = (0..5).map(|i| whole(i, j)).collect();
            assert_eq!(outputs, expected);
        }
        // fx/u = s²/(l (s² + g/l)): two zeros at the origin.
        let response = bode(model(&text), About::Static, &named, None).expect("a response");
        let transfer = &response.transfers[0];
        assert_eq!(transfer.zeros.len(), 2, "{:?}", transfer.zeros);
        assert!(transfer.zeros.iter().all(|[re, im]| re.hypot(*im) < 1e-5), "{:?}", transfer.zeros);
        let last = transfer.gain.len() - 1;
        let w = response.omega[last];
        close(transfer.gain[last], w * w / (l * (w * w - g / l)), 1e-10);
    }
}

#[test]
fn motions_that_nothing_acts_on_are_modes_of_zero_and_nothing_else() {
    // An arm of two links without gravity; the slide at its end has a spring and a damper.
    let arm = model(
        "[bodies]\na = { mass = 5, inertia = 0.07, com = [0.2, 0], points = { E = [0.4, 0] } }\n\
         b = { mass = 3, inertia = 0.03, com = [0.15, 0], points = { W = [0.3, 0] } }\n\
         c = { mass = 2, inertia = 0.01 }\n\
         [joints]\nA = { type = \"revolute\", between = [\"ground\", \"a\"] }\n\
         B = { type = \"revolute\", between = [\"a.E\", \"b\"] }\n\
         C = { type = \"prismatic\", between = [\"b.W\", \"c\"], axis = [1, 0] }\n\
         [loads]\nspring = { type = \"spring\", joint = \"C\", stiffness = 500, length = 0, damping = 5 }\n\
         [initial]\nA = { angle = 0.5 }\nB = { angle = 0.8 }\nC = { position = 0 }\n",
    );
    let found = modes(arm, About::Start).expect("modes");
    let s: Vec<[f64; 2]> = found.modes.iter().map(|mode| mode.s).collect();
    assert_eq!(s.len(), 3, "{s:?}");
    assert_eq!(s[..2], [[0.0; 2]; 2]);
    // Along the slide acts the mass of c as the arm lets it: s² m + 5 s + 500 = 0 for some m below 2 kg.
    let mass = -5.0 / (2.0 * s[2][0]);
    assert!(mass > 0.5 && mass < 2.0, "{mass}");
    close(s[2][1], (500.0 / mass - s[2][0] * s[2][0]).sqrt(), 1e-9);
    for mode in &found.modes[..2] {
        assert!(mode.shares.iter().all(|share| (-1e-12..1.0 + 1e-12).contains(share)));
    }
}

/// A pendulum with θ″ = −(g/l) cos θ from the horizontal, by the classical Runge–Kutta method of order four.
fn swung(g_by_l: f64, t: f64) -> [f64; 2] {
    let rates = |[angle, rate]: [f64; 2]| [rate, -g_by_l * angle.cos()];
    let n = 20_000;
    let h = t / f64::from(n);
    let mut y = [0.0, 0.0];
    for _ in 0..n {
        let ahead = |k: [f64; 2], h: f64| [y[0] + h * k[0], y[1] + h * k[1]];
        let k1 = rates(y);
        let k2 = rates(ahead(k1, 0.5 * h));
        let k3 = rates(ahead(k2, 0.5 * h));
        let k4 = rates(ahead(k3, h));
        for i in 0..2 {
            y[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
        }
    }
    y
}

#[test]
fn equations_are_linear_about_an_instant_of_the_run() {
    let pendulum = |more: &str| {
        model(&format!(
            "[bodies.bob]\nmass = 2\ninertia = 0\ncom = [0.5, 0]\n\
             [joints]\nA = {{ type = \"revolute\", between = [\"ground\", \"bob\"] }}\n\
             [loads]\ng = {{ type = \"gravity\", acceleration = [0, -10] }}\n{more}\
             [initial]\nA = {{ angle = 0, rate = 0 }}\n\
             [solve]\nt_end = 0.1\nrtol = 1e-10\natol = 1e-12\n"
        ))
    };
    // Later than the run of the model ends.
    let about: About = "t = 300 ms".parse().expect("an instant");
    assert_eq!(about, About::Instant(0.3));
    let found = linearize(pendulum(""), about, &Channels::default()).expect("a system");
    let [angle, _] = swung(20.0, 0.3);
    close(found.pose.iter().find(|(name, ..)| name == "A.angle").expect("a pose").1, angle, 1e-8);
    // θ″ = −(g/l) cos θ has the slope (g/l) sin θ.
    close(found.a[(1, 0)], 20.0 * angle.sin(), 1e-7);
    assert_eq!(found.a.row(0).iter().copied().collect::<Vec<_>>(), [0.0, 1.0]);

    // On the stop that it has fallen on by then, nothing is free; it was in the start.
    let stop = "end = { type = \"stop\", joint = \"A\", min = \"-20 deg\" }\n";
    let at = |about| linearize(pendulum(stop), about, &Channels::default()).expect("a system");
    assert_eq!((at(About::Start).a.nrows(), at(About::Start).held.rows.len()), (2, 0));
    let fallen = at(About::Instant(2.0));
    assert_eq!((fallen.a.nrows(), fallen.held.rows), (0, vec!["stop `end`".to_owned()]));

    for text in ["t=", "t=1 m", "-1", "1.5", "end", "run.mcap"] {
        assert!(text.parse::<About>().expect_err(text).contains("`t=1 s`"));
    }
    let fault = modes(pendulum(""), About::Instant(0.3)).expect_err("moving");
    assert_eq!(fault.to_string(), "modes are about a pose at rest, not about the run at t = 0.3 s");
}

/// A rod of 2 kg, its centre of mass 0.7 m from the pin, that a drive holds at half a radian: all follow the gravity at once.
#[test]
fn resultants_efforts_and_energies_are_outputs() {
    let text = "[parameters]\nu = \"9.81 m/s^2\"\n[bodies.rod]\nmass = 2\ninertia = 0.1\ncom = [0.7, 0]\n\
        [joints]\nA = { type = \"revolute\", between = [\"ground\", \"rod\"] }\n\
        [loads]\ng = { type = \"gravity\", acceleration = [0, \"-u\"] }\n\
        [drives]\nhold = { joint = \"A\", motion = \"0.5 rad\" }\n[outputs]\nhalf = \"reactions.A.force/2\"\n\
        [io]\ninput = \"u\"\noutput = [\"reactions.A.force\", \"drives.hold\", \"energy.potential\", \"half\", \"outputs.half\"]\n";
    let found =
        linearize(model(text), About::Start, &Channels::default()).expect("a linear system");
    let expected = [2.0, 1.4 * 0.5_f64.cos(), 1.4 * 0.5_f64.sin(), 1.0, 1.0];
    for (i, slope) in expected.into_iter().enumerate() {
        close(found.d[(i, 0)], slope, 1e-12);
    }
    let named = Channels { outputs: vec!["reactions.A.forces".to_owned()], ..Channels::default() };
    let fault =
        linearize(model(text), About::Start, &named).expect_err("misspelt").diagnostics().remove(0);
    assert_eq!(fault.help.as_deref(), Some("did you mean `reactions.A.force`?"), "{fault:?}");
}

/// A root has no slope where it is zero: a matrix without a number is no answer.
#[test]
fn an_output_without_a_slope_is_refused() {
    let text = |at: &str| {
        format!(
            "[bodies]\ncart = {{ mass = 1 }}\n\
             [joints]\nS = {{ type = \"prismatic\", between = [\"ground\", \"cart\"], axis = [1, 0] }}\n\
             [loads]\nk = {{ type = \"spring\", joint = \"S\", stiffness = 100, length = {at} }}\n\
             [outputs]\nw = \"(S.position/(1 m))^0.5\"\n[initial]\nS = {{ position = {at} }}\n"
        )
    };
    let channels = Channels { outputs: vec!["w".to_owned()], ..Channels::default() };
    let asked = |at: &str| linearize(model(&text(at)), About::Start, &channels);
    let Err(AnalysisError::NoNumber { name, .. }) = asked("0") else { panic!("a slope") };
    assert_eq!(name, "w by S_position");
    let found = asked("0.25").expect("matrices");
    assert!((found.c[(0, 0)] - 1.0).abs() < 1e-12, "{}", found.c);
}

/// A hanging chain of many links swings as a rope does, ω = j₀₁/2 √(g/L), and only the equilibrium to which its start leads
/// is searched for.
#[test]
fn a_chain_of_many_links_swings_as_a_rope() {
    use std::fmt::Write as _;
    let n = 60;
    let mut text = "[loads.gravity]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n".to_owned();
    for k in 0..n {
        let from = if k == 0 { "ground".to_owned() } else { format!("b{}.E", k - 1) };
        let _ = write!(
            text,
            "[bodies.b{k}]\nmass = 1\ninertia = \"0.01/12\"\ncom = [0, -0.05]\npoints = {{ E = [0, -0.1] }}\n\
             [joints.j{k}]\ntype = \"revolute\"\nbetween = [\"{from}\", \"b{k}\"]\n"
        );
    }
    let found = modes(model(&text), About::Static).expect("modes");
    assert!(
        found.state.search == Search::None && found.state.others.is_empty(),
        "{:?}",
        found.state.others
    );
    assert_eq!(found.modes.len(), n);
    let length = 0.1 * n as f64;
    for (mode, zero) in found.modes.iter().zip([2.404_825_557_7, 5.520_078_110_3]) {
        close(mode.omega, 0.5 * zero * (9.81_f64 / length).sqrt(), 2e-3);
    }
}
