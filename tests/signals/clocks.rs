//! Sampled controllers: against a reference and their own recursions, at the ticks and in between.

use crate::support::{Within, at, close, derive, elements, model, solve, with_method};
use bksim::model::Outputs;
use bksim::sim::Stepping;
use bksim::sim::run::Sample;
use bksim::sim::sensitivity::Sensitive;
use bksim::{Mechanism, Motion};
use serde_json::Value;

/// A carriage of 2 kg, whose force follows from its position at the ticks of a clock.
const PID: &str = r#"
[bodies.carriage]
mass = "2 kg"
[joints.S]
type = "prismatic"
between = ["ground", "carriage"]
axis = [1, 0]
[clocks.control]
every = "10 ms"
start = "5 ms"
[signals.error]
clock = "control"
value = "0.3 m - S.position"
[signals.integral]
clock = "control"
value = "previous(integral) + error*0.01 s"
start = "0.02 m s"
[signals.force]
clock = "control"
value = "80 N/m*error + 60 N/m/s*integral + 20 N s/m*(error - previous(error))/0.01 s"
start = "1 N"
[loads.motor]
type = "force"
on = "carriage"
vector = ["force", 0]
[initial]
S.velocity = "0.1 m/s"
[solve]
t_end = "2 s"
every = "5 ms"
rtol = 1e-11
atol = 1e-13
"#;

/// Compares with the reference of the encoder: counts must be equal.
fn check_encoder(motion: &Motion) {
    let reference = elements::reference("elements/encoder_quantised");
    let number = |row: &Value, k: usize| row[k].as_f64().expect("a number");
    let rows = reference["rows"].as_array().expect("rows");
    let scale = |k: usize| rows.iter().map(|row| number(row, k).abs()).fold(0.0, f64::max);
    let scales = [1, 2, 4].map(scale);
    for row in rows {
        let t = number(row, 0);
        let sample = at(motion, t);
        let counted = sample.signals[0];
        assert!(counted == number(row, 3), "{counted} counts at {t} s: {row}");
        let found = [(1, sample.q[0]), (2, sample.v[0]), (4, sample.signals[1])];
        for ((column, value), scale) in found.into_iter().zip(scales) {
            let within = Within { relative: 0.0, absolute: 1e-9 * scale };
            close(&format!("column {column} at {t} s"), value, number(row, column), within);
        }
    }
}

#[test]
fn a_position_control_by_a_quantised_encoder() {
    for method in ["explicit", "radau", "auto"] {
        let encoder = elements::text("encoder-quantised");
        check_encoder(&solve(&derive(model(&with_method(&encoder, method)))));
    }
}

/// Position and velocity at each tick and half a period before it, by the exact recursion of a mass under a
/// constant force; with the integral and the force after the tick.
fn recursion(n: usize) -> Vec<[f64; 7]> {
    let (m, period) = (2.0, 0.01);
    let (mut x, mut v, mut force) = (0.0, 0.1, 1.0);
    let (mut integral, mut before) = (0.02, 0.0);
    let mut rows = Vec::new();
    for k in 0..n {
        // From the last tick, or from the start of the run; half way between two samples.
        let advance = |dt: f64| {
            let a = force / m;
            [x + v * dt + 0.5 * a * dt * dt, v + a * dt]
        };
        let (half, whole) = (advance(0.5 * period), advance(period));
        let [middle_x, middle_v] = if k == 0 { [x, v] } else { half };
        [x, v] = if k == 0 { half } else { whole };
        let error = 0.3 - x;
        integral += error * period;
        force = 80.0 * error + 60.0 * integral + 20.0 * (error - before) / period;
        before = error;
        rows.push([middle_x, middle_v, x, v, error, integral, force]);
    }
    rows
}

#[test]
fn a_sampled_pid_is_its_discrete_recursion() {
    for method in ["explicit", "radau", "auto"] {
        let motion = solve(&derive(model(&with_method(PID, method))));
        let within = Within { relative: 0.0, absolute: 1e-10 };
        let mut force = 1.0;
        for (k, row) in recursion(200).iter().enumerate() {
            let (middle, tick) = (&motion.samples[2 * k], &motion.samples[2 * k + 1]);
            let state = [middle.q[0], middle.v[0], tick.q[0], tick.v[0]];
            let held = [tick.signals[0], tick.signals[1], tick.signals[2]];
            for (found, expected) in state.iter().chain(&held).zip(row) {
                close(&format!("{method}, tick {k}"), *found, *expected, within);
            }
            assert!(tick.step_size > 0.0 && tick.step_size < 0.0101, "{}", tick.step_size);
            // Half way, the force is still that of the tick before.
            close("held", middle.signals[2], force, Within { relative: 1e-9, absolute: 1e-9 });
            close(
                "acceleration",
                middle.a[0],
                force / 2.0,
                Within { relative: 1e-9, absolute: 1e-9 },
            );
            force = row[6];
        }
    }
}

#[test]
fn slow_clocks_see_what_fast_ones_have_taken_at_the_same_tick() {
    let text = r#"
    [bodies.cart]
    mass = "1 kg"
    [joints.S]
    type = "prismatic"
    between = ["ground", "cart"]
    axis = [1, 0]
    [clocks.fast]
    every = "0.1 s"
    [clocks.slow]
    every = "0.3 s"
    [signals.count]
    clock = "fast"
    value = "previous(count) + 1"
    start = -1
    [signals.slow]
    clock = "slow"
    value = "100*count + previous(count)"
    start = 7
    [signals.rest]
    clock = "fast"
    value = "mod(count, 4) + 10*ceil(count/4) + 100*round(count/4)"
    [loads.none]
    type = "force"
    on = "cart"
    vector = ["0 N*slow", 0]
    [initial]
    S.velocity = "1 m/s"
    [solve]
    t_end = "3 s"
    every = "0.05 s"
    "#;
    let motion = solve(&derive(model(text)));
    let mut ticks = 0;
    for (i, sample) in motion.samples.iter().enumerate() {
        let (k, of_slow) = (i / 2, 3 * (i / 6));
        let named = |value: f64| sample.signals.contains(&value);
        assert!(named(k as f64), "count {k} at {} s: {:?}", sample.t, sample.signals);
        let slow = 100.0 * of_slow as f64 + of_slow as f64 - 1.0;
        assert!(named(slow), "{slow} at {} s: {:?}", sample.t, sample.signals);
        let rounded = (2 * k + 4) / 8;
        let rest = (k % 4 + 10 * k.div_ceil(4) + 100 * rounded) as f64;
        assert!(named(rest), "{rest} at {} s: {:?}", sample.t, sample.signals);
        ticks += usize::from(i % 2 == 0);
    }
    assert_eq!(ticks, 31);
}

#[test]
fn a_tick_may_press_bodies_onto_stops_and_break_friction() {
    let text = r#"
    [bodies.block]
    mass = "1 kg"
    [joints.S]
    type = "prismatic"
    between = ["ground", "block"]
    axis = [1, 0]
    [clocks.c]
    every = "0.5 s"
    [signals.push]
    clock = "c"
    value = "if(t < 0.7 s, 2 N, if(S.position < 0.1 m, 6 N, -6 N))"
    [loads.push]
    type = "force"
    on = "block"
    vector = ["push", 0]
    [loads.rub]
    type = "friction"
    joint = "S"
    force = "4 N"
    [solve]
    t_end = "2 s"
    every = "0.25 s"
    "#;
    // It sticks, slides from 1 s on with 2 m/s², is braked from 1.5 s on with 10 m/s², and goes back with 2 m/s².
    for method in ["explicit", "radau"] {
        let motion = solve(&derive(model(&with_method(text, method))));
        let within = Within { relative: 0.0, absolute: 1e-8 };
        close("stuck", at(&motion, 0.75).q[0], 0.0, within);
        close("slides", at(&motion, 1.5).q[0], 0.25, within);
        close("fast", at(&motion, 1.5).v[0], 1.0, within);
        let back = 0.3 - (0.4_f64).powi(2);
        close("back", at(&motion, 2.0).q[0], back, within);
    }
}

#[test]
fn a_tick_may_carry_an_expression_over_its_kink() {
    let text = r#"
    [bodies.block]
    mass = "10 kg"
    [joints.S]
    type = "prismatic"
    between = ["ground", "block"]
    axis = [1, 0]
    [clocks.c]
    every = "0.5 s"
    [signals.goal]
    clock = "c"
    value = "if(t < 0.3 s, -1 m, 1 m)"
    [loads.pull]
    type = "force"
    on = "block"
    vector = ["max(0 N, 10 N/m*(goal - S.position))", 0]
    [solve]
    t_end = "3 s"
    every = "0.5 s"
    rtol = 1e-11
    atol = 1e-12
    "#;
    // From 0.5 s on a spring pulls, until it is slack at x = 1 m.
    for method in ["explicit", "radau"] {
        let motion = solve(&derive(model(&with_method(text, method))));
        let within = Within { relative: 0.0, absolute: 1e-9 };
        close("at rest", at(&motion, 0.5).q[0], 0.0, within);
        close("pulled", at(&motion, 1.5).q[0], 1.0 - 1.0_f64.cos(), within);
        let slack = 0.5 + std::f64::consts::FRAC_PI_2;
        close("slack", at(&motion, 3.0).q[0], 1.0 + 3.0 - slack, within);
    }
}

#[test]
fn every_formulation_and_fixed_steps_end_at_ticks() {
    let last = recursion(200)[199];
    let with = |option: &str| {
        let text = PID.replace("[solve]\n", &format!("[solve]\n{option}\n"));
        solve(&derive(model(&text)))
    };
    let radau = "method = \"radau\"\nformulation = ";
    for name in ["index1", "index2", "index3", "ggl"] {
        let motion = with(&format!("{radau}\"{name}\""));
        let within = Within { relative: 0.0, absolute: 1e-9 };
        close(name, motion.samples[399].q[0], last[2], within);
    }
    // Steps that do not fit the period; the force is constant in each, so that they are exact.
    for method in ["explicit", "radau"] {
        let motion = with(&format!("step = \"3.7 ms\"\nmethod = \"{method}\""));
        let within = Within { relative: 0.0, absolute: 1e-10 };
        close(method, motion.samples[399].q[0], last[2], within);
    }
}

#[test]
fn steps_as_outputs_show_what_holds_from_the_tick_on() {
    let mut model = model(PID);
    model.solve.outputs = Outputs::Steps;
    let motion = solve(&derive(model));
    let rows = recursion(200);
    for (k, row) in rows.iter().enumerate() {
        let sample = at(&motion, 0.005 + 0.01 * k as f64);
        close("force", sample.signals[2], row[6], Within { relative: 0.0, absolute: 1e-9 });
    }
    assert!(motion.samples.windows(2).all(|pair| pair[0].t < pair[1].t));
}

#[test]
fn an_input_that_changes_leaves_the_ticks_and_what_is_held() {
    let text = PID.replace("[\"force\", 0]", "[\"force + push\", 0]");
    let text = format!("[parameters]\npush = \"0 N\"\n{text}");
    let simulation = derive(model(&text)).simulation().expect("equations");
    let mut run = simulation.begin().expect("a start");
    // Between two ticks, and at one.
    for (t, push) in [(0.012, 1.0), (0.035, -1.0)] {
        run.advance_to(t).expect("a run");
        run.set_input("push", push).expect("an input");
    }
    let force = |run: &Stepping| run.sample().signals[2];
    let at_tick = force(&run);
    run.advance_to(0.044).expect("a run");
    assert_eq!(force(&run), at_tick, "held up to the next tick");
    let (a, v) = (run.sample().a[0], run.sample().v[0]);
    close("a", a, (at_tick - 1.0) / 2.0, Within { relative: 1e-9, absolute: 1e-9 });
    run.advance_to(0.046).expect("a run");
    assert!(force(&run) != at_tick, "the tick at 45 ms");
    let halves = 0.001 * (a + run.sample().a[0]);
    close("v", run.sample().v[0], v + halves, Within { relative: 0.0, absolute: 1e-10 });
}

#[test]
fn a_run_held_at_a_tick_has_passed_it_and_goes_on_as_if_nobody_held_it() {
    let mechanism = derive(model(PID));
    let whole = solve(&mechanism);
    let simulation = mechanism.simulation().expect("equations");
    let mut run = simulation.begin().expect("a start");
    let state = |sample: &Sample| [sample.q[0], sample.v[0], sample.signals[2]].map(f64::to_bits);
    let mut saved = None;
    for (k, sample) in whole.samples.iter().enumerate().skip(1) {
        let held = run.advance_to(sample.t).expect("a run");
        assert_eq!(state(held), state(sample), "at {} s", sample.t);
        if k == 101 {
            saved = Some(run.save());
        }
    }
    // Back to a tick.
    run.restore(&saved.expect("a state")).expect("a run");
    assert_eq!(state(run.sample()), state(&whole.samples[101]));
    let later = &whole.samples[140];
    assert_eq!(state(run.advance_to(later.t).expect("a run")), state(later));
}

#[test]
fn what_needs_smooth_motion_refuses_clocks() {
    let mechanism = derive(model(PID));
    let simulation = mechanism.simulation().expect("equations");
    let by = [Sensitive::Initial(0)];
    let start = mechanism.start().expect("a start");
    let refused = simulation.plan_sensitivities(&start, &by).expect_err("sampled signals jump");
    assert!(format!("{refused:?}").contains("S012"), "{refused:?}");

    let fast = PID.replace("every = \"10 ms\"", "every = \"1e-15 ms\"");
    let refused = derive(model(&fast)).start().expect_err("nobody can follow that");
    assert!(format!("{refused:?}").contains("S020"), "{refused:?}");

    let back = PID.replace("t_end = \"2 s\"", "t_end = \"-2 s\"");
    let refused = derive(model(&back)).start().expect_err("ticks go forwards");
    assert!(format!("{refused:?}").contains("S008"), "{refused:?}");
}

#[test]
fn positions_know_nothing_of_controllers() {
    let mechanism = Mechanism::positions(model(PID)).expect("joints alone");
    let closed = mechanism.closed().expect("they close");
    assert_eq!(closed.q.len(), 1);
    assert!(mechanism.system.parameters(&mechanism.model).is_empty(), "no value is held");
}
