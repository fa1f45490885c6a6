//! Latched signals: relays against closed forms, state machines against a reference, the way they begin and
//! what they are refused in.

use crate::support::{Within, at, close, derive, elements, model, solve, with_method};
use bksim::Motion;
use bksim::sim::hybrid::ChangeKind;

/// A cart of m = 2 kg with a damper of b = 4 N s/m, which a force of 10 N pushes until it is faster than
/// 1.8 m/s, and again as soon as it is slower than 1.2 m/s.
const CART: &str = r#"
[bodies.cart]
mass = "2 kg"
[joints.S]
type = "prismatic"
between = ["ground", "cart"]
axis = [1, 0]
[signals.push]
start = "10 N"
when = [
  { condition = "S.velocity > 1.8 m/s", value = 0 },
  { condition = "S.velocity < 1.2 m/s", value = "10 N" },
]
[loads.motor]
type = "force"
on = "cart"
vector = ["push - 4 N s/m*S.velocity", 0]
[solve]
t_end = "4 s"
every = "step"
rtol = 1e-12
atol = 1e-13
"#;

/// Times at which something switched.
fn switching_times(motion: &Motion) -> Vec<f64> {
    let kinks = motion.summary.changes.iter();
    let kinks = kinks.filter(|change| matches!(change.kind, ChangeKind::Kink(_)));
    kinks.map(|change| change.t).collect()
}

#[test]
fn a_relay_with_hysteresis_switches_at_the_times_of_its_closed_form() {
    // v → 2.5 m/s with τ = m/b = 0.5 s while it is pushed, v → 0 else.
    let (tau, last, high, low) = (0.5_f64, 2.5_f64, 1.8_f64, 1.2_f64);
    let first = tau * (last / (last - high)).ln();
    let falls = tau * (high / low).ln();
    let rises = tau * ((last - low) / (last - high)).ln();
    for method in ["explicit", "radau", "auto"] {
        let motion = solve(&derive(model(&with_method(CART, method))));
        let (mut t, mut expected) = (first, Vec::new());
        while t < 4.0 {
            expected.push(t);
            t += if expected.len() % 2 == 1 { falls } else { rises };
        }
        // On its way up it first passes the lower threshold, where nothing changes.
        let found = &switching_times(&motion)[1..];
        assert_eq!(found.len(), expected.len(), "{method}: {found:?}");
        for (found, expected) in found.iter().zip(&expected) {
            let within = Within { relative: 0.0, absolute: 1e-10 };
            close(&format!("{method}: a switch"), *found, *expected, within);
        }
        // The value that is held is among the signals, and drives the cart.
        for sample in &motion.samples {
            let push = sample.signals[0];
            assert!(push == 0.0 || push == 10.0, "{push}");
            let within = Within { relative: 1e-12, absolute: 1e-12 };
            close("the acceleration", 2.0 * sample.a[0], push - 4.0 * sample.v[0], within);
        }
    }
}

#[test]
fn a_mass_on_a_spring_follows_the_arcs_of_its_relay() {
    // x″ = −ω²x ∓ ω²c: arcs about ∓c, from one switch at ±d to the next.
    let text = r#"
[bodies.cart]
mass = "1 kg"
[joints.S]
type = "prismatic"
between = ["ground", "cart"]
axis = [1, 0]
[signals.u]
start = "3 N"
when = [
  { condition = "S.position > 0.2 m", value = "-3 N" },
  { condition = "S.position < -0.2 m", value = "3 N" },
]
[loads.pull]
type = "force"
on = "cart"
vector = ["u - 9 N/m*S.position", 0]
[initial]
S.velocity = 0
[solve]
t_end = "6 s"
rtol = 1e-12
atol = 1e-13
"#;
    let (omega, centre, d) = (3.0_f64, 1.0 / 3.0_f64, 0.2_f64);
    let (mut x, mut v, mut c, mut t) = (0.0_f64, 0.0_f64, centre, 0.0_f64);
    let mut expected = Vec::new();
    loop {
        // x − c = r cos(ω s + φ) until it passes the threshold outwards: d upwards, or −d downwards.
        let target = if c > 0.0 { d } else { -d };
        let (radius, phase) = ((x - c).hypot(v / omega), (-v / omega).atan2(x - c));
        let angle = ((target - c) / radius).acos();
        let outwards = if c > 0.0 { -angle } else { angle };
        let turn = (outwards - phase).rem_euclid(2.0 * std::f64::consts::PI);
        t += turn / omega;
        if t >= 6.0 {
            break;
        }
        expected.push(t);
        (x, v) = (target, -radius * omega * outwards.sin());
        c = -c;
    }
    let motion = solve(&derive(model(text)));
    // Of all crossings of the thresholds those at which the force changes.
    let found = switching_times(&motion);
    assert!(expected.len() >= 4, "{expected:?}");
    for expected in expected {
        let nearest = found.iter().map(|t| (t - expected).abs()).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-10, "no switch at {expected}: {found:?}");
    }
}

#[test]
fn a_mass_is_brought_to_rest_in_the_shortest_time() {
    let reference = elements::reference("elements/bang_bang");
    let text = r#"
[bodies.cart]
mass = "1.5 kg"
[joints.S]
type = "prismatic"
between = ["ground", "cart"]
axis = [1, 0]
coordinate = "x"
[parameters]
a = "2 m/s^2"
[signals.phase]
start = 0
when = [
  { condition = "x + x_dot*abs(x_dot)/(2*a) < 0 and phase < 1", value = 1 },
  { condition = "x_dot > 0 and phase > 0.5", value = 2 },
]
[signals.force]
value = "if(phase < 1, -3 N, if(phase < 2, 3 N, 0 N))"
[loads.thrust]
type = "force"
on = "cart"
vector = ["force", 0]
[initial]
x = "1 m"
x_dot = "0.5 m/s"
[solve]
t_end = "4 s"
every = "0.1 s"
rtol = 1e-12
atol = 1e-13
"#;
    let value = |name: &str| reference["values"][name].as_f64().expect("a number");
    for method in ["explicit", "radau", "auto"] {
        let motion = solve(&derive(model(&with_method(text, method))));
        let within = Within { relative: 0.0, absolute: 1e-9 };
        for row in reference["rows"].as_array().expect("rows") {
            let number = |k: usize| row[k].as_f64().expect("a number");
            let sample = at(&motion, number(0));
            let force = sample.signals.iter().copied().find(|&f| f.abs() == 3.0).unwrap_or(0.0);
            close(&format!("x at {row}"), sample.q[0], number(1), within);
            close(&format!("v at {row}"), sample.v[0], number(2), within);
            assert!(force == number(3), "{force} at {row}");
        }
        let found = switching_times(&motion);
        for name in ["t_switch", "t_end"] {
            let nearest =
                found.iter().map(|t| (t - value(name)).abs()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-9, "{method}, {name}: {found:?}");
        }
    }
}

/// The cart with its force latched, and what it has latched of the motion: the position where it was pushed last,
/// and the count of pushes.
#[test]
fn what_is_latched_is_taken_from_the_instant_and_counts_on() {
    let more = r#"
[signals.place]
start = "0 m"
when = [{ condition = "S.velocity < 1.2 m/s", value = "S.position" }]
[signals.count]
start = 5
when = [{ condition = "S.velocity < 1.2 m/s", value = "count + 1" }]
"#;
    let text = CART.replace("[loads.motor]", &format!("{more}[loads.motor]"));
    let motion = solve(&derive(model(&text)));
    // A condition that holds at the start counts there.
    let first = &motion.samples[0];
    assert_eq!(first.signals, [10.0, 0.0, 6.0]);
    let mut before = first;
    for sample in &motion.samples[1..] {
        if sample.signals[0] > before.signals[0] {
            let within = Within { relative: 0.0, absolute: 1e-9 };
            close("the place", sample.signals[1], before.q[0], within);
            close("the rate there", before.v[0], 1.2, within);
            assert!(sample.signals[2] == before.signals[2] + 1.0);
        }
        before = sample;
    }
    assert!(before.signals[2] == 13.0, "{:?}", before.signals);
}
