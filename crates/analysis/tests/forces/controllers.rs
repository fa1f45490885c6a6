//! Questions with states of controllers and motors, against closed forms and against runs.

use crate::support::model;
use bksim_analysis::{
    About, Actuators, AnalysisError, Channels, Inverse, Motion, Range, Stability, balanced,
    inverse, linearize, modes, statics, statics_over,
};
use bksim_model::Model;
use bksim_sim::Mechanism;
use nalgebra::{Complex, DVector};

fn channels(inputs: &[&str], outputs: &[&str]) -> Channels {
    let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    Channels { inputs: owned(inputs), outputs: owned(outputs), states: Vec::new() }
}

fn close(found: f64, expected: f64, tolerance: f64) {
    let off = (found - expected).abs();
    assert!(off <= tolerance * expected.abs().max(1.0), "{found} instead of {expected}");
}

/// A mass of 2 kg against a force of 3 N, held at `r` by proportional and integral parts with a damper.
const PI_MASS: &str = r#"
[parameters]
r = "0.3 m"
push = "3 N"

[bodies.cart]
mass = "2 kg"

[joints.rail]
type = "prismatic"
between = ["ground", "cart"]
axis = [1, 0]

[initial]
rail.position = "0.1 m"

[states.z]
rate = "r - rail.position"
start = "0 m s"

[signals.u]
value = "50 N/m*(r - rail.position) + 20 N/m/s*z"

[loads.control]
type = "force"
joint = "rail"
value = "u - 8 N s/m*rail.velocity - push"
"#;

#[test]
fn a_mass_with_a_pi_controller_has_the_matrices_of_its_equations() {
    let asked = channels(&["r", "push"], &["rail.position", "z", "signals.u"]);
    let found = linearize(model(PI_MASS), About::Static, &asked).expect("a linear system");
    let names: Vec<&str> = found.states.iter().map(|state| state.name.as_str()).collect();
    assert_eq!(names[2], "z");
    assert_eq!(found.states[2].unit, "m*s");
    // m ẍ = 50 (r − x) + 20 z − 8 ẋ − push,  ż = r − x.
    let a = [[0.0, 1.0, 0.0], [-25.0, -4.0, 10.0], [-1.0, 0.0, 0.0]];
    let b = [[0.0, 0.0], [25.0, -0.5], [1.0, 0.0]];
    let c = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [-50.0, 0.0, 20.0]];
    let d = [[0.0, 0.0], [0.0, 0.0], [50.0, 0.0]];
    for i in 0..3 {
        for j in 0..3 {
            close(found.a[(i, j)], a[i][j], 1e-12);
            close(found.c[(i, j)], c[i][j], 1e-12);
        }
        for j in 0..2 {
            close(found.b[(i, j)], b[i][j], 1e-12);
            close(found.d[(i, j)], d[i][j], 1e-12);
        }
    }
    // At rest in place, though the force goes on: the integral holds it.
    let position = found.pose.iter().find(|(name, ..)| name == "rail.position").expect("a pose");
    close(position.1, 0.3, 1e-10);
}

#[test]
fn modes_with_a_controller_are_the_roots_of_its_polynomial() {
    let found = modes(model(PI_MASS), About::Static).expect("modes");
    assert_eq!((found.n_infinite, found.stability), (0, Stability::Stable));
    // 2 s³ + 8 s² + 50 s + 20 = 0: a real root and a pair.
    assert_eq!(found.modes.len(), 2);
    for mode in &found.modes {
        let s = Complex::new(mode.s[0], mode.s[1]);
        let value = s * s * s * 2.0 + s * s * 8.0 + s * 50.0 + 20.0;
        assert!(value.norm() < 1e-11, "{s}: {value}");
    }
}

#[test]
fn a_controller_that_is_too_fast_is_unstable() {
    // Routh: 8·50 < 2 k for k = 201.
    let text = PI_MASS.replace("20 N/m/s*z", "201 N/m/s*z");
    let found = modes(model(&text), About::Static).expect("modes");
    assert_eq!(found.stability, Stability::Flutter);
    let text = PI_MASS.replace("20 N/m/s*z", "199 N/m/s*z");
    assert_eq!(modes(model(&text), About::Static).expect("modes").stability, Stability::Stable);
}

/// A pendulum that a motor with inductance holds at an angle, its voltage with an integral part.
const MOTOR: &str = r#"

[parameters]
U0 = "0 V"
wanted = "0.7 rad"

[loads.weight]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]

[bodies.arm]
mass = "1.5 kg"
inertia = "0.02 kg m^2"
com = ["0.3 m", 0]

[joints.A]
type = "revolute"
between = ["ground", "arm"]

[initial]
A.angle = "0.4 rad"

[states.i]
rate = "(U - 0.8 ohm*i - 1.2 V s/rad*A.rate)/(0.05 H)"
start = "0 A"

[states.e]
rate = "wanted - A.angle"
start = "0 rad s"

[signals.U]
value = "U0 + 30 V/rad*(wanted - A.angle) + 25 V/rad/s*e - 4 V s/rad*A.rate"

[loads.motor]
type = "torque"
joint = "A"
value = "1.2 N m/A*i - 0.1 N m s/rad*A.rate"
"#;

#[test]
fn a_motor_with_inductance_has_the_matrices_of_its_equations() {
    let asked = channels(&["U0"], &["states.i", "A.rate"]);
    let found = linearize(model(MOTOR), About::Static, &asked).expect("a linear system");
    let inertia = 0.02 + 1.5 * 0.09;
    let gravity = 1.5 * 9.81 * 0.3 * 0.7_f64.sin();
    let a = [
        [0.0, 1.0, 0.0, 0.0],
        [gravity / inertia, -0.1 / inertia, 1.2 / inertia, 0.0],
        [-30.0 / 0.05, -5.2 / 0.05, -0.8 / 0.05, 25.0 / 0.05],
        [-1.0, 0.0, 0.0, 0.0],
    ];
    for (i, row) in a.iter().enumerate() {
        for (j, expected) in row.iter().enumerate() {
            close(found.a[(i, j)], *expected, 1e-9);
        }
        close(found.b[(i, 0)], [0.0, 0.0, 20.0, 0.0][i], 1e-12);
    }
    assert_eq!(found.outputs[0].unit, "A");
}

/// The state after a while of a run from a start with one deviation.
fn after(mut model: Model, deviations: [f64; 4]) -> Vec<f64> {
    let pool = &model.pool;
    for initial in &mut model.initial {
        let k = match initial.measure {
            bksim_model::Measure::JointPosition(..) => 0,
            bksim_model::Measure::State(id) => 2 + id.0,
            _ => 1,
        };
        initial.value = pool.add(initial.value, pool.float(deviations[k]));
    }
    model.solve.t_end = 0.3;
    (model.solve.rtol, model.solve.atol) = (1e-11, 1e-12);
    let mechanism = Mechanism::derive(model, Vec::new()).expect("equations");
    let motion = mechanism.solve().expect("a run");
    let last = motion.samples.last().expect("samples");
    vec![last.q[0], last.v[0], last.v[1], last.v[2]]
}

#[test]
fn small_deviations_of_a_run_follow_the_linear_equations() {
    // In motion, about the start: ẋ = A x + constant, so that differences of runs follow e^{A t} for short.
    let asked = channels(&["U0"], &["A.angle"]);
    let linear = linearize(model(MOTOR), About::Static, &asked).expect("a linear system");
    // Begin at the equilibrium.
    let angle = 0.7_f64;
    let current = 1.5 * 9.81 * 0.3 * angle.cos() / 1.2;
    let e = 0.8 * current / 25.0;
    let text = MOTOR
        .replace("A.angle = \"0.4 rad\"", "A.angle = \"0.7 rad\"\nA.rate = \"0 rad/s\"")
        .replace("start = \"0 A\"", &format!("start = \"{current:.17} A\""))
        .replace("start = \"0 rad s\"", &format!("start = \"{e:.17} rad s\""));
    let rest = after(model(&text), [0.0; 4]);
    let step = 1e-5;
    let exponential = (linear.a.clone() * 0.3).exp();
    for k in 0..4 {
        let mut deviations = [0.0; 4];
        deviations[k] = step;
        let there = after(model(&text), deviations);
        deviations[k] = -step;
        let back = after(model(&text), deviations);
        let change: Vec<f64> = (0..4).map(|i| (there[i] - back[i]) / (2.0 * step)).collect();
        let off = (DVector::from_vec(change) - exponential.column(k)).norm();
        assert!(off < 1e-5 * exponential.column(k).norm(), "{k}: {off}");
    }
    close(rest[0], angle, 1e-9);
}

#[test]
fn states_have_no_rates_in_equilibria() {
    // 50 (r − x) + 20 z = push and r − x = 0.
    let found = statics(model(PI_MASS), &[], &[]).expect("an equilibrium");
    let table = found.table();
    assert_eq!(table.rows.len(), 1);
    let value = |name: &str| table.column(name).expect("a column")[0];
    close(value("rail.position"), 0.3, 1e-10);
    close(value("z"), 0.15, 1e-10);
    close(found.equilibria[0].stiffness[0], 50.0, 1e-9);
    assert_eq!(found.equilibria[0].stability, Stability::Stable);

    let range = Range { from: 3.0, to: 7.0, n: 3 };
    let over = statics_over(model(PI_MASS), ("push", range), &[]).expect("equilibria").table();
    let (push, z) = (over.column("push").expect("forces"), over.column("z").expect("states"));
    assert_eq!(push, [3.0, 5.0, 7.0]);
    z.iter().zip(&push).for_each(|(z, push)| close(*z, push / 20.0, 1e-9));

    // m ẍ = 50 (r − x) − 80 z − …: the integral acts the other way, and no rest is stable.
    let reversed = PI_MASS.replace("+ 20 N/m/s*z", "- 80 N/m/s*z");
    let found = statics(model(&reversed), &[], &[]).expect("an equilibrium");
    assert_eq!(found.equilibria[0].stability, Stability::Unstable);
}

#[test]
fn signals_with_memory_are_refused_with_states() {
    let sampled = format!("{PI_MASS}\n[clocks.c]\nevery = \"10 ms\"\n")
        .replace("[signals.u]\n", "[signals.u]\nclock = \"c\"\n");
    let fault =
        linearize(model(&sampled), About::Start, &Channels::default()).expect_err("a clock");
    let fault = &fault.diagnostics()[0];
    assert!(fault.message.contains("sampled signal `u`"), "{}", fault.message);
}

fn motion(model: &Model, name: &str, formula: &str) -> Vec<Motion> {
    vec![Motion::formula(model, name, formula).expect("a motion")]
}

fn efforts(text: &str, (name, formula): (&str, &str), times: &Range) -> Inverse {
    let model = model(text);
    let motions = motion(&model, name, formula);
    inverse(model, &motions, times, &Actuators::default()).expect("efforts")
}

#[test]
fn states_follow_a_given_motion_and_efforts_are_what_is_needed_besides() {
    let times = Range { from: 0.0, to: 2.0, n: 9 };
    let found = efforts(PI_MASS, ("rail.position", "0.1 + 0.05*t^2"), &times);
    let column = |name: &str| found.table.column(name).unwrap_or_else(|| panic!("{name}"));
    let (t, effort, z, u) = (column("t"), column("rail.effort"), column("z"), column("signals.u"));
    for k in 0..t.len() {
        let (x, v) = (0.1 + 0.05 * t[k] * t[k], 0.1 * t[k]);
        let integral = 0.2 * t[k] - 0.05 / 3.0 * t[k].powi(3);
        let control = 50.0 * (0.3 - x) + 20.0 * integral;
        close(z[k], integral, 1e-9);
        close(u[k], control, 1e-9);
        close(effort[k], 2.0 * 0.1 - (control - 8.0 * v - 3.0), 1e-9);
    }
    assert_eq!(found.controllers, ["z"]);
}

#[test]
fn a_run_of_a_motor_needs_no_other_effort() {
    // The motor drives by itself; the inductance is ten times as fast as the arm.
    let mut free = model(MOTOR);
    (free.solve.t_end, free.solve.rtol, free.solve.atol) = (0.5, 1e-11, 1e-12);
    free.solve.every = Some(5e-4);
    let run = Mechanism::derive(free, Vec::new()).expect("equations").solve().expect("a run");
    let times: Vec<f64> = run.samples.iter().map(|sample| sample.t).collect();
    let values = run.samples.iter().map(|sample| [sample.q[0], sample.v[0], sample.a[0]]).collect();
    let again = model(MOTOR);
    let motions = vec![Motion::samples(&again, "A.angle", times, values).expect("a motion")];
    let asked = Range { from: 0.0, to: 0.5, n: 6 };
    let found = inverse(again, &motions, &asked, &Actuators::default()).expect("efforts");
    let effort = found.table.column("A.effort").expect("efforts");
    let current = found.table.column("i").expect("currents");
    let largest = current.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    assert!(largest > 3.0, "{current:?}");
    for effort in effort {
        assert!(effort.abs() < 1e-5 * largest, "{effort}");
    }
    close(current[5], run.samples.last().expect("samples").v[1], 1e-6);
}

#[test]
fn sampled_signals_change_at_their_ticks_along_a_given_motion() {
    let text = PI_MASS
        .replace("[states.z]\nrate = \"r - rail.position\"\nstart = \"0 m s\"\n", "")
        .replace(
            "[signals.u]\nvalue = \"50 N/m*(r - rail.position) + 20 N/m/s*z\"",
            "[clocks.c]\nevery = \"0.1 s\"\n\
             [signals.z]\nclock = \"c\"\nvalue = \"previous(z) + 0.1 s*(r - rail.position)\"\n\
             start = \"0 m s\"\n\
             [signals.u]\nclock = \"c\"\nvalue = \"50 N/m*(r - rail.position) + 20 N/m/s*z\"",
        );
    let times = Range { from: 0.0, to: 0.5, n: 11 };
    let found = efforts(&text, ("rail.position", "0.1 + 0.4*t"), &times);
    let effort = found.table.column("rail.effort").expect("efforts");
    let (mut z, mut u) = (0.0, 0.0);
    for (k, found) in effort.iter().enumerate() {
        // Every other of the times is a tick.
        if k % 2 == 0 {
            let off = 0.3 - (0.1 + 0.4 * 0.05 * k as f64);
            z += 0.1 * off;
            u = 50.0 * off + 20.0 * z;
        }
        close(*found, -(u - 8.0 * 0.4 - 3.0), 1e-12);
    }
    assert_eq!(found.controllers, ["z", "u"]);
}

#[test]
fn an_effort_that_the_model_gives_is_not_asked_for() {
    let cart = model(PI_MASS);
    let motions = motion(&cart, "rail.position", "0.1 + 0.1*t");
    let times = Range { from: 0.0, to: 1.0, n: 3 };
    let actuators = Actuators { named: vec!["control".to_owned()], ..Actuators::default() };
    let fault = inverse(cart, &motions, &times, &actuators).expect_err("a load");
    assert!(matches!(&fault, AnalysisError::GivenEffort { name } if name == "control"), "{fault}");
}

#[test]
fn values_balance_a_start_with_states_that_have_no_rates() {
    let start = |text: &str, name: &str| balanced(model(text), &[name.to_owned()], &[]);
    // r − x = 0 and 20 z = push.
    let found = start(PI_MASS, "r").expect("a balance");
    close(found.values[0].1, 0.1, 1e-10);
    let z = found.equilibrium.pose.iter().find(|(name, ..)| name == "z").expect("a state").1;
    close(z, 0.15, 1e-10);
    // The integral holds any push where it is, and none elsewhere.
    let there = PI_MASS.replace("\"0.1 m\"", "\"0.3 m\"");
    let fault = start(&there, "push").expect_err("any value");
    assert!(matches!(fault, AnalysisError::StatesBalance { .. }), "{fault}");
    let fault = start(PI_MASS, "push").expect_err("no value");
    assert!(matches!(fault, AnalysisError::NotBalanced { .. }), "{fault}");

    let found = start(MOTOR, "wanted").expect("a balance");
    close(found.values[0].1, 0.4, 1e-9);
    let value =
        |of: &str| found.equilibrium.pose.iter().find(|(name, ..)| name == of).expect("it").1;
    let current = 1.5 * 9.81 * 0.3 * 0.4_f64.cos() / 1.2;
    close(value("i"), current, 1e-9);
    close(value("e"), 0.8 * current / 25.0, 1e-9);
}
