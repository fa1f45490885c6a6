//! Bodies that bend: frequencies with every kind of ends, a beam that is spun up, stretching and buckling.

use bksim::analysis::{About, Channels, linearize, modes};
use serde_json::Value;

use crate::support::elements::{column, number, reference};
use crate::support::{at, derive, model, reaction, signal, solve};

/// The beam of the reference with `n` shapes and these joints.
fn beam(n: usize, rest: &str) -> String {
    format!(
        r#"
[ground]
points = {{ B = ["1 m", 0] }}
[bodies.beam]
flexible = {{ length = "1 m", section = ["20 mm", "5 mm"], E = "210 GPa", density = "7850 kg/m^3", modes = {n} }}
points = {{ tip = ["1 m", 0] }}
{rest}
"#
    )
}

/// The ends of a case.
fn ends(case: u64) -> String {
    let joint = |name: &str, kind: &str, between: &str, more: &str| {
        format!("[joints.{name}]\ntype = \"{kind}\"\nbetween = [{between}]\n{more}\n")
    };
    let clamped = joint("root", "weld", "\"ground\", \"beam\"", "");
    let pinned = joint("root", "revolute", "\"ground\", \"beam\"", "");
    let tip = "\"ground.B\", \"beam.tip\"";
    let held = joint("end", "slot", tip, "axis = [1, 0]");
    let clamped_tip = joint("end", "prismatic", tip, "axis = [1, 0]");
    let mass = joint("end", "revolute", "\"beam.tip\", \"load\"", "");
    match case {
        1 => clamped,
        2 => pinned + &held,
        3 => clamped + &held,
        4 => clamped + &clamped_tip,
        5 => String::new(),
        _ => format!("{clamped}{mass}[bodies.load]\nmass = \"0.785 kg\"\n"),
    }
}

/// Frequencies of a case, those of rigid motions left out.
fn frequencies(case: u64, n: usize) -> Vec<f64> {
    let mut text = beam(n, &ends(case));
    if case == 5 {
        text = text.replace("points = { tip", "free = true\npoints = { tip");
    }
    let found = modes(model(&text), About::Start).unwrap_or_else(|e| panic!("{case}: {e}"));
    found.modes.iter().map(|mode| mode.omega).filter(|&omega| omega > 1.0).collect()
}

#[test]
fn beams_have_their_frequencies_with_every_kind_of_ends() {
    let data = reference("touch/beam_modes");
    let expected = |case: u64, mode: usize| {
        let is_it = |row: &&Value| row[0].as_u64() == Some(case) && row[1] == mode + 1;
        let row = data["rows"].as_array().expect("rows").iter().find(is_it).expect("a row");
        number(row, column(&data, "omega"))
    };
    for case in 1..=6 {
        // With more shapes the errors fall as those of polynomials do.
        let more = if case == 1 { Some((9, [1e-8, 1e-7, 1e-5])) } else { None };
        for (n, within) in [Some((7, [1e-6, 1e-3, 1e-2])), more].into_iter().flatten() {
            let found = frequencies(case, n);
            for (mode, within) in within.into_iter().enumerate() {
                let (found, expected) = (found[mode], expected(case, mode));
                let error = (found / expected - 1.0).abs();
                assert!(
                    error < within,
                    "case {case}, {n} shapes, mode {}: {found} for {expected}, off by {error:.1e}",
                    mode + 1
                );
            }
        }
    }
}

/// The beam of the spin-up on its hub, with this motion.
fn spun(flexible: &str, motion: &str, solve: &str) -> String {
    format!(
        r#"
[bodies.beam]
flexible = {{ length = "10 m", A = "4e-4 m^2", I = "2e-7 m^4", E = "70 GPa", density = "3000 kg/m^3", {flexible} }}
points = {{ tip = ["10 m", 0] }}
[joints.hub]
type = "revolute"
between = ["ground", "beam"]
[drives.motor]
joint = "hub"
motion = "{motion}"
[outputs]
tip = "beam.tip.y*cos(hub.angle) - beam.tip.x*sin(hub.angle)"
reach = "beam.tip.x*cos(hub.angle) + beam.tip.y*sin(hub.angle)"
[solve]
{solve}
"#
    )
}

#[test]
fn a_beam_that_is_spun_up_lags_and_comes_back() {
    let motion = "if(t < 15 s, 0.2 rad/s^2*t^2 + 0.4 rad/s^2*(7.5 s/pi)^2*(cos(pi*t/(7.5 s)) - 1), 45 rad + 6 rad/s*(t - 15 s))";
    let text = spun("modes = 4", motion, "t_end = \"20 s\"\nevery = \"0.02 s\"");
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let data = reference("touch/spin_up_beam");
    for row in data["rows"].as_array().expect("rows") {
        let (t, expected) = (number(row, 0), number(row, 1));
        let found = signal(&mechanism, at(&motion, t), "tip");
        assert!((found - expected).abs() < 0.02 * 0.5743, "{t} s: {found} for {expected}");
    }
    let lags = motion.samples.iter().map(|sample| signal(&mechanism, sample, "tip"));
    let largest = lags.fold(0.0, f64::min);
    let expected = data["values"]["largest_lag"].as_f64().expect("a number");
    assert!((largest / expected - 1.0).abs() < 0.01, "{largest} for {expected}");
}

#[test]
fn a_spinning_beam_stretches_as_linear_elasticity_says() {
    let data = reference("touch/spin_up_beam");
    let value = |name: &str| data["values"][name].as_f64().expect("a number");
    let solve_for = "t_end = \"25 s\"\nevery = \"25 s\"\nrtol = 1e-9\natol = 1e-12";
    let text = spun("modes = 1, axial = 4, damping = \"0.3 s\"", "6 rad/s*t", solve_for);
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let last = at(&motion, 25.0);
    let stretch = signal(&mechanism, last, "reach") - 10.0;
    let expected = value("tip_stretch");
    assert!((stretch / expected - 1.0).abs() < 1e-6, "{stretch} for {expected}");
    let [x, y, _] = reaction(&mechanism, last, "hub")[..3].try_into().expect("a force");
    let (force, expected) = (f64::hypot(x, y), value("root_force_stretched"));
    assert!((force / expected - 1.0).abs() < 1e-6, "{force} for {expected}");
}

/// Imaginary parts of the eigenvalues at 6 rad/s.
fn spinning(flexible: &str) -> Vec<f64> {
    let text = spun(flexible, "6 rad/s*t", "t_end = \"1 s\"");
    let linear = linearize(model(&text), About::Start, &Channels::default()).expect("linear");
    let mut found: Vec<f64> = linear.poles.iter().map(|s| s[1]).filter(|s| *s > 0.1).collect();
    found.sort_by(f64::total_cmp);
    found
}

#[test]
fn spinning_stiffens_a_beam_in_its_plane_and_across() {
    let data = reference("touch/spin_up_beam");
    let compare = |found: &[f64], name: &str| {
        let expected: Vec<f64> =
            serde_json::from_value(data["values"][name].clone()).expect("numbers");
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found / expected - 1.0).abs() < 1e-3, "{name}: {found} for {expected}");
        }
    };
    compare(&spinning("modes = 6"), "omega_in_plane");
    let all = spinning("modes = 1, across = 7, I_across = \"2e-7 m^4\"");
    let across: Vec<f64> = all.iter().copied().skip(1).collect();
    compare(&across, "omega_out_of_plane");
}

/// Two beams in a row under gravity, with a motor in the elbow at the far end of the first.
const ELBOW: &str = r#"
[ground]
points = { S = ["1.1 m", "-0.3 m"] }
[bodies.upper]
flexible = { length = "0.6 m", section = ["20 mm", "4 mm"], material = "steel", modes = 2, axial = 1 }
points = { middle = ["0.3 m", 0], tip = ["0.6 m", 0] }
[bodies.lower]
flexible = { length = "0.5 m", section = ["20 mm", "3 mm"], material = "steel", modes = 2 }
points = { tip = ["0.5 m", 0] }
[joints.shoulder]
type = "revolute"
between = ["ground", "upper"]
[joints.elbow]
type = "revolute"
between = ["upper.tip", "lower"]
[loads.motor]
type = "torque"
joint = "elbow"
value = "2 N m*sin(20 rad/s*t)"
[loads.friction]
type = "torque"
joint = "elbow"
value = "-0.02 N m s/rad*elbow.rate"
[loads.spring]
type = "spring"
between = ["ground.S", "upper.middle"]
stiffness = "50 N/m"
length = "0.9 m"
[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]
[states.gain]
rate = "(2 N m*sin(20 rad/s*t) - 0.02 N m s/rad*elbow.rate)*elbow.rate"
start = "0 J"
[outputs]
work = "gain"
x = "lower.tip.x"
y = "lower.tip.y"
[initial]
shoulder = { angle = "-20 deg", rate = 0 }
elbow = { angle = "-40 deg", rate = 0 }
[solve]
t_end = "0.5 s"
every = "0.1 s"
rtol = 1e-10
atol = 1e-12
"#;

#[test]
fn a_motor_at_the_end_of_a_beam_does_the_work_of_its_own_joint() {
    let ways = ["", "coordinates = \"absolute\"\n"].map(|policy| {
        let mechanism = derive(model(&format!("{policy}{ELBOW}")));
        let motion = solve(&mechanism);
        let total = |t: f64| {
            let energy = &at(&motion, t).energy;
            energy.kinetic + energy.potential
        };
        [0.1, 0.3, 0.5].map(|t| {
            let sample = at(&motion, t);
            let [work, x, y] = ["work", "x", "y"].map(|name| signal(&mechanism, sample, name));
            let gained = total(t) - total(0.0);
            assert!((gained - work).abs() < 1e-7, "{policy}{t} s: {gained} J for {work} J");
            [x, y]
        })
    });
    for (tree, cut) in ways[0].iter().flatten().zip(ways[1].iter().flatten()) {
        assert!((tree - cut).abs() < 1e-7, "{tree} and {cut}");
    }
}

/// A load at the tip of a driven arm: the pin at its root has no moment about its own axis, and bears the same in all coordinates.
#[test]
fn the_root_of_a_beam_bears_what_hangs_on_its_tip() {
    let text = |coordinates: &str| {
        format!(
            "coordinates = \"{coordinates}\"\n[bodies.arm]\n\
             flexible = {{ length = 1.2, section = [\"30 mm\", \"9 mm\"], material = \"aluminium\", modes = 2 }}\n\
             points = {{ tip = [1.2, 0] }}\n[bodies.load]\nmass = 0.4\ninertia = 4e-4\n\
             [joints]\nhub = {{ type = \"revolute\", between = [\"ground\", \"arm\"] }}\n\
             grip = {{ type = \"weld\", between = [\"arm.tip\", \"load\"] }}\n\
             [loads.g]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n\
             [drives.motor]\njoint = \"hub\"\nmotion = \"-0.8 + 2 rad/s^3*t^3\"\n\
             [solve]\nt_end = 0.05\nevery = 0.01\nrtol = 1e-10\natol = 1e-12\n"
        )
    };
    let [own, other] = ["relative", "absolute"].map(|of| derive(model(&text(of))));
    let [first, second] = [&own, &other].map(solve);
    for (a, b) in first.samples.iter().zip(&second.samples) {
        for joint in ["hub", "grip"] {
            let [a, b] = [reaction(&own, a, joint), reaction(&other, b, joint)];
            for (k, (a, b)) in a.iter().zip(b).enumerate() {
                assert!((a - b).abs() < 1e-4, "{joint}, {k}: {a} and {b}");
            }
        }
        let moment = reaction(&own, a, "hub")[5];
        assert!(moment.abs() < 1e-9, "{moment} N m about the axis of a pin");
    }
}

/// A four-bar whose coupler bends closes with a straight one, and at rates at which it stays so.
#[test]
fn a_start_bends_no_beam_that_need_not_bend() {
    let text = "[ground]\npoints = { D = [0.4, 0] }\n[bodies.crank]\nmass = 0.3\ninertia = 0.001\npoints = { B = [0.1, 0] }\n\
                [bodies.coupler]\nflexible = { length = 0.35, section = [\"20 mm\", \"3 mm\"], material = \"steel\", modes = 2 }\n\
                points = { C = [0.35, 0] }\n[bodies.rocker]\nmass = 0.5\ninertia = 0.005\npoints = { C = [0.3, 0] }\n\
                [joints]\nA = { type = \"revolute\", between = [\"ground\", \"crank\"] }\n\
                B = { type = \"revolute\", between = [\"crank.B\", \"coupler\"] }\n\
                C = { type = \"revolute\", between = [\"coupler.C\", \"rocker.C\"] }\n\
                D = { type = \"revolute\", between = [\"ground.D\", \"rocker\"] }\n\
                [initial]\nA = { angle = \"60 deg\", rate = 3 }\nB = { guess = { angle = \"-50 deg\" } }\n\
                D = { guess = { angle = \"100 deg\" } }\n[solve]\nt_end = 0.01\n";
    let mechanism = derive(model(text));
    let start = mechanism.start().expect("a start");
    let place = |name: &str| crate::support::coordinate(&mechanism, name);
    for shape in ["coupler_q1_angle", "coupler_q2_angle"] {
        let k = place(shape);
        assert!(
            start.q[k].abs() + start.v[k].abs() < 1e-12,
            "{shape}: {}, {}",
            start.q[k],
            start.v[k]
        );
    }
    // The distance between the ends of crank and rocker.
    let crank = [0.1 * 60_f64.to_radians().cos(), 0.1 * 60_f64.to_radians().sin()];
    let angle = start.q[place("D_angle")];
    let rocker = [0.4 + 0.3 * angle.cos(), 0.3 * angle.sin()];
    let length = (rocker[0] - crank[0]).hypot(rocker[1] - crank[1]);
    assert!((length - 0.35).abs() < 1e-12, "{length}");
}

/// A cantilever under a force at its tip is at rest in the shape w″ = F (L − x)/EI, and bears F (L − x) in each section.
#[test]
fn sections_bear_the_moment_of_a_force_at_the_tip() {
    // 1 − ξ = P₀/2 − P₁/2.
    let (force, pull) = (2.0, 30.0);
    let second = 0.02 * 0.005_f64.powi(3) / 12.0;
    let first = force / (2.0 * 210e9 * second);
    let text = beam(4, "")
        .replace("modes = 4", "modes = 4, axial = 2, stiffening = false")
        .replace("tip = [", "half = [\"0.5 m\", 0], tip = [")
        + &format!(
            "[joints.root]\ntype = \"weld\"\nbetween = [\"ground\", \"beam\"]\n\
             [loads.tip]\ntype = \"force\"\non = \"beam.tip\"\nvector = [{pull}, {force}]\n\
             [initial]\nbeam_q1 = {{ angle = {first:e} }}\nbeam_q2 = {{ angle = {:e} }}\nbeam_q3 = {{ angle = 0 }}\nbeam_q4 = {{ angle = 0 }}\n\
             beam_u1 = {{ position = {:e} }}\nbeam_u2 = {{ position = 0 }}\n\
             [solve]\nt_end = 1e-3\nevery = 1e-3\n",
            -first,
            pull / (210e9 * 1e-4)
        );
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    for t in [0.0, 1e-3] {
        let sample = at(&motion, t);
        for (name, share) in [("root", 1.0), ("half", 0.5), ("tip", 0.0)] {
            let found = |what: &str| signal(&mechanism, sample, &format!("beam_{what}_{name}"));
            let moment = force * share;
            let stress = moment * 0.0025 / second + pull / 1e-4;
            for (what, expected, scale) in
                [("moment", moment, force), ("force", pull, pull), ("stress", stress, stress)]
            {
                let off = (found(what) - expected).abs();
                assert!(
                    off < 1e-6 * scale,
                    "{what} {name} at {t} s: {} for {expected}",
                    found(what)
                );
            }
        }
    }
}
