//! Sensitivities of runs in which something switches: closed forms, differences of tight runs, and what has none.

use crate::both_ways::{Of, both_ways};
use bksim_expr::Jit;
use bksim_model::Method;
use bksim_sim::sensitivity::StateSensitivity;
use bksim_sim::{Mechanism, SensitivityMotion};

const TIGHT: f64 = 1e-11;
/// Of terms of both signs, gradients differ from what the derivatives forward sum up to.
const BOTH_WAYS: f64 = 1e-10;

/// A block of 2 kg on a guide, with what is appended.
fn block(axis: &str, rest: &str) -> String {
    format!(
        "[bodies.block]\nmass = \"2 kg\"\n[joints.S]\ntype = \"prismatic\"\n\
         between = [\"ground\", \"block\"]\naxis = {axis}\ncoordinate = \"x\"\n{rest}\n"
    )
}

const GRAVITY: &str =
    "[loads.gravity]\ntype = \"gravity\"\nacceleration = [0, \"-g\"]\n[parameters]\n";

fn mechanism(text: &str, (t_end, every): (f64, f64), method: Method, rtol: f64) -> Mechanism {
    let mut mechanism =
        Mechanism::from_toml(text, "model").unwrap_or_else(|fault| panic!("{fault}\n{text}"));
    let solve = &mut mechanism.model.solve;
    (solve.rtol, solve.atol, solve.method) = (rtol, rtol, method);
    (solve.t_end, solve.every) = (t_end, Some(every));
    mechanism
}

fn found(text: &str, times: (f64, f64), method: Method, names: &[&str]) -> SensitivityMotion {
    let mechanism = mechanism(text, times, method, TIGHT);
    let by: Vec<_> =
        names.iter().map(|name| mechanism.sensitive(name).expect("it is there")).collect();
    let simulation = mechanism.simulation().expect("a simulation");
    let motion = simulation.sensitivities(&by).unwrap_or_else(|fault| panic!("{names:?}: {fault}"));
    both_ways(&mechanism, &motion, &by, Of::Everything, BOTH_WAYS);
    motion
}

fn refused(text: &str, times: (f64, f64), name: &str) -> String {
    let mechanism = mechanism(text, times, Method::Auto, TIGHT);
    let by = [mechanism.sensitive(name).expect("it is there")];
    let outcome = mechanism.simulation().expect("a simulation").sensitivities(&by);
    let fault = outcome.expect_err("it has none");
    assert_eq!(fault.0[0].code.0, "S012", "{fault}");
    fault.to_string()
}

const ALL: [Method; 3] = [Method::Auto, Method::Explicit, Method::Radau];

/// Compares with central differences of two runs in which `written` is replaced, everything that a sample holds:
/// relative to the largest derivative of its kind.
fn agree(
    text: &str,
    times: (f64, f64),
    (name, written, value, h): (&str, &str, f64, f64),
    within: f64,
) {
    assert_eq!(text.matches(written).count(), 1, "{written}");
    let line = |value: f64| {
        let (key, unit) = (written.split('=').next().unwrap_or(""), written.split('"').nth(1));
        let unit = unit.and_then(|text| text.split_once(' ')).map_or("", |(_, unit)| unit);
        format!("{key}= \"{value:?} {unit}\"")
    };
    let run = |value: f64| {
        let text = text.replace(written, &line(value));
        mechanism(&text, times, Method::Auto, TIGHT).solve().unwrap_or_else(|e| panic!("{e}"))
    };
    let (up, down) = (run(value + h), run(value - h));
    for method in ALL {
        let motion = found(text, times, method, &[name]);
        assert_eq!(motion.sensitivities.len(), up.samples.len());
        let at = |k: usize| -> [Vec<f64>; 3] {
            let (up, down) = (&up.samples[k], &down.samples[k]);
            let slope = |up: &[f64], down: &[f64]| -> Vec<f64> {
                up.iter().zip(down).map(|(up, down)| (up - down) / (2.0 * h)).collect()
            };
            let reactions = slope(up.reactions.as_flattened(), down.reactions.as_flattened());
            let energy = [up, down].map(|s| {
                [
                    s.energy.kinetic,
                    s.energy.potential,
                    s.energy.kinetic + s.energy.potential,
                    s.energy.power,
                ]
            });
            let channels = [slope(&energy[0], &energy[1]), reactions].concat();
            [
                [slope(&up.q, &down.q), slope(&up.v, &down.v)].concat(),
                [slope(&up.a, &down.a), slope(&up.lambda, &down.lambda)].concat(),
                channels,
            ]
        };
        for kind in 0..3 {
            let size = (0..up.samples.len()).flat_map(|k| at(k)[kind].clone());
            let size = size.fold(0.0, |size: f64, value| size.max(value.abs()));
            for (k, by) in motion.sensitivities.iter().enumerate() {
                let StateSensitivity { q, v, a, lambda, channels } = &by[0];
                let expected = &at(k)[kind];
                let found = match kind {
                    0 => [q.as_slice(), v].concat(),
                    1 => [a.as_slice(), lambda].concat(),
                    _ => channels[..expected.len()].to_vec(),
                };
                for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
                    assert!(
                        (found - expected).abs() <= within * size + 1e-9,
                        "{method:?}: kind {kind}, number {i} by {name} at t = {}: {found} for {expected}",
                        motion.motion.samples[k].t
                    );
                }
            }
        }
    }
}

fn bouncing() -> String {
    block(
        "[0, 1]",
        &format!(
            "[loads.floor]\ntype = \"stop\"\njoint = \"S\"\nmin = \"low\"\nrestitution = \"e\"\n\
             {GRAVITY}g = \"9.81 m/s^2\"\nh = \"1 m\"\ne = 0.8\nlow = \"0 m\"\n\
             [initial]\nx = \"h\"\n"
        ),
    )
}

/// v₁ = √(2 g h), t₁ = v₁/g, t_n = t₁ + 2 v₁/g (e + … + eⁿ⁻¹), x = eⁿ v₁ (t − t_n) − g/2 (t − t_n)², differentiated
/// by h, e and g.
#[test]
fn a_bouncing_ball_has_the_sensitivities_of_its_closed_form() {
    let (g, h, e) = (9.81_f64, 1.0_f64, 0.8_f64);
    let v1 = (2.0 * g * h).sqrt();
    let series = |n: i32| (1..n).map(|k| e.powi(k)).sum::<f64>();
    let slopes = |n: i32| (1..n).map(|k| f64::from(k) * e.powi(k - 1)).sum::<f64>();
    let t_n = |n: i32| v1 / g * (1.0 + 2.0 * series(n));
    for method in ALL {
        let motion = found(&bouncing(), (2.5, 0.1), method, &["h", "e", "g", "low"]);
        for (sample, by) in motion.motion.samples.iter().zip(&motion.sensitivities) {
            let t = sample.t;
            let n = (1..20).take_while(|&n| t_n(n) < t).last().unwrap_or(0);
            let (since, speed) = (t - t_n(n), e.powi(n) * v1);
            // ∂x/∂p = ∂(eⁿ v₁) since − (eⁿ v₁ − g since) ∂t_n − ∂g since²/2, and its rate.
            let expected = |of_speed: f64, of_time: f64, of_g: f64| {
                [
                    of_speed * since - (speed - g * since) * of_time - of_g * since * since / 2.0,
                    of_speed + g * of_time - of_g * since,
                ]
            };
            let by_v1 = e.powi(n);
            let sum = 1.0 + 2.0 * series(n);
            let mut all = [
                expected(by_v1 * g / v1, sum / v1, 0.0),
                expected(f64::from(n) * e.powi(n - 1) * v1, 2.0 * v1 / g * slopes(n), 0.0),
                expected(by_v1 * h / v1, sum * (h / (v1 * g) - v1 / (g * g)), 1.0),
            ];
            if n == 0 {
                all = [[1.0, 0.0], [0.0, 0.0], [-t * t / 2.0, -t]];
            }
            for (k, expected) in all.iter().enumerate() {
                let found = [by[k].q[0], by[k].v[0]];
                for (found, expected) in found.iter().zip(expected) {
                    assert!(
                        (found - expected).abs() < 1e-7 * (1.0 + expected.abs()),
                        "{method:?} {k} at {t}: {found} for {expected}"
                    );
                }
            }
            // All moves with the floor where the start does, too: x − low depends on h − low.
            let sum = by[3].q[0] + by[0].q[0];
            assert!((sum - 1.0).abs() < 1e-7, "at {t}: {sum}");
        }
    }
}

/// A block that slides until it sticks: x = x₀ + v₀²/(2 a), a = μ g, F = μ m g.
#[test]
fn a_block_that_comes_to_rest_has_the_sensitivities_of_its_closed_form() {
    let text = block(
        "[1, 0]",
        "[loads.rub]\ntype = \"friction\"\njoint = \"S\"\nforce = \"F\"\n[parameters]\nF = \"8 N\"\n\
         fast = \"3 m/s\"\n[initial]\nx = 0\nx_dot = \"fast\"\n",
    );
    for method in ALL {
        let motion = found(&text, (2.0, 0.1), method, &["F", "fast", "x"]);
        // a = F/m = 4 m/s², at rest at 0.75 s.
        for (sample, by) in motion.motion.samples.iter().zip(&motion.sensitivities) {
            let t = sample.t.min(0.75);
            let rest = sample.t > 0.75;
            let by_force = if rest { -9.0 * 2.0 / (2.0 * 64.0) } else { -t * t / 4.0 };
            let by_speed = if rest { 0.75 } else { t };
            let expected = [by_force, by_speed, 1.0];
            for (k, expected) in expected.iter().enumerate() {
                let found = by[k].q[0];
                assert!(
                    (found - expected).abs() < 1e-9,
                    "{method:?} {k} at {}: {found} for {expected}",
                    sample.t
                );
            }
            if rest {
                assert!(by.iter().all(|by| by.v[0].abs() < 1e-12), "at rest");
            }
        }
    }
}

/// Pulled by a spring whose far end moves: stick and slip with static friction above the sliding one.
#[test]
fn stick_and_slip_agrees_with_differences_of_tight_runs() {
    let text = block(
        "[1, 0]",
        "[loads.rub]\ntype = \"friction\"\njoint = \"S\"\nforce = \"F\"\nstatic = \"7 N\"\n\
         [loads.pull]\ntype = \"force\"\non = \"block\"\n\
         vector = [\"k*(0.5 m/s*t - S.position) - 0.4 N*s/m*S.velocity\", 0]\n\
         [parameters]\nF = \"4 N\"\nk = \"20 N/m\"\n[initial]\nx = 0\nx_dot = 0\n",
    );
    agree(&text, (6.0, 0.25), ("F", "F = \"4 N\"", 4.0, 1e-5), 2e-5);
    agree(&text, (6.0, 0.25), ("k", "k = \"20 N/m\"", 20.0, 1e-4), 2e-5);
}

/// A force that jumps where the block passes a place, and another at an instant.
#[test]
fn kinks_of_place_and_time_agree_with_differences_of_tight_runs() {
    let text = block(
        "[1, 0]",
        "[loads.push]\ntype = \"force\"\non = \"block\"\n\
         vector = [\"if(S.position < far, 3 N, -5 N) + if(t > late, 2 N, 0 N) - abs(S.velocity)*c\", 0]\n\
         [parameters]\nfar = \"0.4 m\"\nlate = \"1.3 s\"\nc = \"0.5 N*s/m\"\n[initial]\nx = 0\nx_dot = 0.1\n",
    );
    agree(&text, (3.0, 0.11), ("far", "far = \"0.4 m\"", 0.4, 1e-6), 2e-5);
    agree(&text, (3.0, 0.11), ("late", "late = \"1.3 s\"", 1.3, 1e-6), 2e-5);
    agree(&text, (3.0, 0.11), ("c", "c = \"0.5 N*s/m\"", 0.5, 1e-6), 2e-5);
}

const DOUBLE: &str = r#"
[parameters]
l = "0.5 m"
m = "2 kg"
e = 0.6
g = "9.81 m/s^2"
[bodies.upper]
mass = 1
inertia = 0.02
com = ["0.25 m", 0]
points.end = ["0.5 m", 0]
[bodies.lower]
mass = "m"
inertia = 0.05
com = ["l/2", 0]
points.tip = ["l", 0]
[joints.A]
type = "revolute"
between = ["ground", "upper"]
[joints.B]
type = "revolute"
between = ["upper.end", "lower"]
[loads.gravity]
type = "gravity"
acceleration = [0, "-g"]
[loads.limit]
type = "stop"
joint = "B"
min = "-40 deg"
max = "40 deg"
restitution = "e"
[initial]
A = { angle = "-20 deg", rate = 0 }
B = { angle = "10 deg", rate = 0 }
"#;

/// Impacts on a stop inside a mechanism, whose masses depend on the pose.
#[test]
fn impacts_within_a_mechanism_agree_with_differences_of_tight_runs() {
    for by in [
        ("l", "l = \"0.5 m\"", 0.5, 1e-7),
        ("m", "m = \"2 kg\"", 2.0, 1e-6),
        ("e", "e = 0.6", 0.6, 1e-7),
    ] {
        agree(DOUBLE, (1.2, 0.07), by, 1e-4);
    }
}

/// A relay that latches a force between two thresholds.
#[test]
fn a_relay_agrees_with_differences_of_tight_runs() {
    let text = block(
        "[1, 0]",
        "[signals.drive]\nstart = \"1\"\nwhen = [\n  { condition = \"S.position > high\", value = \"-1\" },\n  \
         { condition = \"S.position < -0.1 m\", value = \"1\" },\n]\n\
         [loads.push]\ntype = \"force\"\non = \"block\"\nvector = [\"drive*force - 0.7 N*s/m*S.velocity\", 0]\n\
         [parameters]\nhigh = \"0.2 m\"\nforce = \"3 N\"\n[initial]\nx = 0\nx_dot = 0\n",
    );
    agree(&text, (4.0, 0.11), ("high", "high = \"0.2 m\"", 0.2, 1e-6), 5e-5);
    agree(&text, (4.0, 0.11), ("force", "force = \"3 N\"", 3.0, 1e-5), 5e-5);
}

/// Friction that follows the reaction of its own joint.
#[test]
fn friction_by_reactions_agrees_with_differences_of_tight_runs() {
    let text = "[parameters]\nmu = 0.3\nl = \"0.5 m\"\n[bodies.bob]\nmass = 2\ninertia = 0.01\ncom = [0, \"-l\"]\n\
        [joints.A]\ntype = \"revolute\"\nbetween = [\"ground\", \"bob\"]\n\
        [loads.rub]\ntype = \"friction\"\njoint = \"A\"\nmu = \"mu\"\nradius = \"0.04 m\"\n\
        [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n[initial]\nA = { angle = \"70 deg\", rate = 0 }\n";
    agree(text, (3.0, 0.11), ("mu", "mu = 0.3", 0.3, 1e-6), 5e-5);
    agree(text, (3.0, 0.11), ("l", "l = \"0.5 m\"", 0.5, 1e-6), 5e-5);
}

/// Loops, by every method; accelerations, multipliers, reactions and energies, too.
#[test]
fn a_loop_agrees_with_differences_by_every_method() {
    let text = include_str!("../../../examples/slider-crank/model.toml");
    agree(text, (1.0, 0.1), ("l1", "l1 = \"1 m\"", 1.0, 1e-5), 1e-6);
    agree(text, (1.0, 0.1), ("m3", "m3 = \"20 kg\"", 20.0, 1e-3), 1e-6);
}

#[test]
fn a_start_on_a_stop_has_no_sensitivity_by_its_height() {
    let text = block(
        "[0, 1]",
        &format!(
            "[loads.floor]\ntype = \"stop\"\njoint = \"S\"\nmin = \"low\"\n\
             {GRAVITY}g = \"9.81 m/s^2\"\nlow = \"0 m\"\n[initial]\nx = \"0 m\"\n"
        ),
    );
    let fault = refused(&text, (0.5, 0.1), "low");
    assert!(fault.contains("starts on a stop, and off it for other values of `low`"), "{fault}");
    let by = found(&text, (0.5, 0.1), Method::Auto, &["g"]);
    assert!(by.sensitivities.iter().all(|by| by[0].q[0] == 0.0 && by[0].a[0] == 0.0));
}

#[test]
fn a_stop_that_is_only_touched_has_no_sensitivities() {
    // Thrown up to just below the ceiling, and a hair into it.
    let text = |speed: f64| {
        block(
            "[0, 1]",
            &format!(
                "[loads.ceiling]\ntype = \"stop\"\njoint = \"S\"\nmax = \"1 m\"\nrestitution = 1\n\
                 {GRAVITY}g = \"9.81 m/s^2\"\n[initial]\nx = 0\nx_dot = {speed:?}\n"
            ),
        )
    };
    let touching = (2.0 * 9.81_f64).sqrt();
    let fault = refused(&text(touching * (1.0 + 1e-13)), (0.8, 0.1), "x_dot");
    assert!(fault.contains("`ceiling` is only touched at t = 0.45"), "{fault}");
    for speed in [touching * 0.99, touching * 1.01] {
        found(&text(speed), (0.8, 0.1), Method::Auto, &["x_dot"]);
    }
}

#[test]
fn two_stops_at_one_instant_have_no_sensitivities() {
    let text = block(
        "[0, 1]",
        &format!(
            "[bodies.other]\nmass = 1\n[joints.T]\ntype = \"prismatic\"\nbetween = [\"ground\", \"other\"]\naxis = [0, 1]\n\
             [loads.floor]\ntype = \"stop\"\njoint = \"S\"\nmin = 0\n[loads.ground]\ntype = \"stop\"\njoint = \"T\"\nmin = 0\n\
             {GRAVITY}g = \"9.81 m/s^2\"\nh = \"1 m\"\n[initial]\nx = \"h\"\nT = {{ position = 1 }}\n"
        ),
    );
    let fault = refused(&text, (1.0, 0.1), "h");
    assert!(fault.contains("several things switch at once"), "{fault}");
}

/// The linear equations have coefficients by loops, and by one function; the runs that they go along are the same bits.
#[test]
fn coefficients_written_down_are_those_of_loops() {
    let text = include_str!("../../../examples/slider-crank/model.toml");
    let names = ["m1", "i2", "l1", "q1"];
    let [written, looped] = [Jit::On, Jit::Off].map(|jit| {
        let mut mechanism = mechanism(text, (2.0, 0.5), Method::Explicit, 1e-8);
        mechanism.model.solve.jit = jit;
        let by = names.map(|name| mechanism.sensitive(name).expect("it is there"));
        let simulation = mechanism.simulation().expect("a simulation");
        simulation.sensitivities(&by).expect("sensitivities")
    });
    for (k, (written, looped)) in
        written.sensitivities.iter().zip(&looped.sensitivities).enumerate()
    {
        for (name, (written, looped)) in names.iter().zip(written.iter().zip(looped)) {
            let size = looped.v.iter().fold(f64::MIN_POSITIVE, |size, v| size.max(v.abs()));
            let pairs = written.q.iter().chain(&written.v).zip(looped.q.iter().chain(&looped.v));
            for (written, looped) in pairs {
                let error = (written - looped).abs() / size;
                assert!(error < 1e-10, "{name}, sample {k}: {written} and {looped}");
            }
        }
    }
    // They are not the same bits: other operations have been carried out.
    assert_ne!(written.sensitivities[4][0].v, looped.sensitivities[4][0].v);
    assert_eq!(written.motion.samples[4].q, looped.motion.samples[4].q);
}
