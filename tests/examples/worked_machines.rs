//! Machines among the examples against the formulas of textbooks that their READMEs name.

use std::f64::consts::{PI, TAU};

use super::worked::{column, meet, near, over};
use crate::support::{Measures, at, derive, example, example_text, model, signal, solve};
use bksim::analysis::{About, Actuators, Range, inverse, modes};
use bksim::sim::hybrid::ChangeKind;
use bksim::sim::run::Sample;
use bksim::{Mechanism, Motion};

const G: f64 = 9.81;

/// An example solved, with its end at another time if one is given.
fn solved(name: &str, t_end: Option<f64>) -> (Mechanism, Motion) {
    let mut model = example(name);
    if let Some(t_end) = t_end {
        (model.solve.t_end, model.solve.every) = (t_end, Some(t_end / 200.0));
    }
    let mechanism = derive(model);
    let motion = solve(&mechanism);
    (mechanism, motion)
}

/// Measures by their names at the end of a motion.
fn at_end<const N: usize>(name: &str, t_end: Option<f64>, names: [&str; N]) -> [f64; N] {
    let (mechanism, motion) = solved(name, t_end);
    let last = motion.samples.last().expect("samples");
    Measures::new(&mechanism, &names).at(last).try_into().expect("a value for each name")
}

/// Times at which changes of a kind happen.
fn times(motion: &Motion, wanted: fn(&ChangeKind) -> bool) -> Vec<f64> {
    let changes = motion.summary.changes.iter();
    changes.filter(|change| wanted(&change.kind)).map(|change| change.t).collect()
}

/// OP · OQ = a² − b² makes a straight line of a circle through O: x = (a² − b²)/2c, y = x tan(φ/2).
#[test]
fn peaucelliers_line_is_straight() {
    let found = over(example("peaucellier"), "C.angle", "-60:60 deg:25");
    let x = (0.4_f64 * 0.4 - 0.2 * 0.2) / (2.0 * 0.13);
    let crank = column(&found, "C.angle");
    let [xs, ys] = ["AQ.Q.x", "AQ.Q.y"].map(|name| column(&found, name));
    for (i, phi) in crank.iter().enumerate() {
        near(xs[i], x, 1e-13);
        near(ys[i], x * (0.5 * phi).tan(), 1e-12);
    }
}

/// Similar triangles: OQ = k OT.
#[test]
fn a_pantograph_enlarges_what_it_traces() {
    let found = over(example("pantograph"), "tracer.angle", "0:360 deg:73");
    for axis in ["x", "y"] {
        let tracer = column(&found, &format!("short1.T.{axis}"));
        let pen = column(&found, &format!("long2.Q.{axis}"));
        for (tracer, pen) in tracer.iter().zip(pen) {
            near(pen, 2.5 * tracer, 1e-12);
        }
    }
}

/// The middle of the disc sees both axes at a right angle: x = e cos² φ, y = e sin φ cos φ.
#[test]
fn both_shafts_of_an_oldham_coupling_turn_alike() {
    let found = over(example("oldham-coupling"), "A.angle", "0:360 deg:37");
    let [a, b] = ["A.angle", "B.angle"].map(|name| column(&found, name));
    let [x, y] = ["disc.x", "disc.y"].map(|name| column(&found, name));
    for i in 0..a.len() {
        let (sin, cos) = a[i].sin_cos();
        near(b[i], a[i], 1e-12);
        near(x[i], 8e-3 * cos * cos, 1e-12);
        near(y[i], 8e-3 * sin * cos, 1e-12);
    }
}

/// The torque is dy/dφ = r cos φ times what the plunger takes: water on the way up, weight, m y″.
#[test]
fn a_scotch_yoke_needs_its_torque() {
    let (r, m, omega) = (0.03, 3.0, 2.0 * TAU);
    let found = inverse(
        example("scotch-yoke"),
        &[],
        &Range { from: 0.01, to: 0.49, n: 25 },
        &Actuators::default(),
    );
    let found = found.expect("efforts").table;
    let column = |name: &str| found.column(name).unwrap_or_else(|| panic!("{:?}", found.columns));
    for (t, effort) in column("t").into_iter().zip(column("motor.effort")) {
        let (sin, cos) = (omega * t - 0.5 * PI).sin_cos();
        let water = if cos > 0.0 { 20e5 * PI * 0.06 * 0.06 / 4.0 } else { 0.0 };
        let expected = (water + m * G - m * r * omega * omega * sin) * r * cos;
        near(effort, expected, 1e-9 * expected.abs().max(1.0));
    }
}

/// API 11E: the rods go at a r sin α/(c sin β) for each radian of the crank.
#[test]
fn a_pump_jack_has_its_torque_factor() {
    let (r, p, c, a) = (0.8, 3.0, 2.1, 3.0);
    let found = over(example("pump-jack"), "O.angle", "0:360 deg:73");
    let velocity = column(&found, "well.velocity");
    for (i, phi) in column(&found, "O.angle").into_iter().enumerate() {
        let pin = [r * phi.cos(), r * phi.sin()];
        // The tail of the beam is to the left of the line from the pin to the saddle.
        let saddle = [c, p];
        let tail = meet(pin, p, saddle, c);
        let angle =
            |u: [f64; 2], v: [f64; 2]| (u[0] * v[1] - u[1] * v[0]).atan2(u[0] * v[0] + u[1] * v[1]);
        let pitman = [tail[0] - pin[0], tail[1] - pin[1]];
        let beam = [tail[0] - saddle[0], tail[1] - saddle[1]];
        let (alpha, beta) = (angle(pin, pitman), angle(pitman, beam));
        let factor = a * r * alpha.sin() / (c * beta.sin());
        near(velocity[i].abs(), factor.abs(), 1e-12);
    }
}

/// Willis: the carrier has the mean rate of both wheels; each takes half of its torque, so its rate is that over its
/// damping.
#[test]
fn a_differential_halves_the_torque() {
    let [carrier, left, right] = at_end("differential", Some(8.0), ["C.rate", "L.rate", "R.rate"]);
    near(carrier, 0.5 * (left + right), 1e-12);
    near(left, 100.0 / 2.0, 1e-6);
    near(right, 100.0 / 40.0, 1e-6);
}

/// Pulleys turn as their radii say; the strands before and after a pulley differ by its torque and inertia over its radius;
/// the slack one balances the spring on the arm.
#[test]
fn a_belt_drive_has_its_tensions() {
    let (mechanism, motion) = solved("belt-drive", None);
    let last = motion.samples.last().expect("samples");
    let measures = Measures::new(&mechanism, &["A.rate", "B.rate", "T.angle"]).at(last);
    let [crank, alternator, arm] = measures[..] else { panic!("three measures") };
    near(alternator, 8.0 / 3.0 * crank, 1e-9);
    let rows = mechanism.system.constraints.iter().zip(&last.lambda);
    let belt = rows.filter(|(row, _)| row.direction == "coupling");
    let tensions: Vec<f64> = belt.map(|(_, tension)| *tension).collect();
    let [into_idler, into_alternator, tight] = tensions[..] else { panic!("{tensions:?}") };
    let (of_rotor, of_roller) = (40.0 * 80.0 / 30.0, 40.0 * 80.0 / 35.0);
    near(tight - into_alternator, (6.0 + 2.5e-3 * of_rotor) / 0.03, 1e-6);
    near(into_alternator - into_idler, 2.5e-4 * of_roller / 0.035, 1e-6);

    // Lines that touch two circles: from the left of the crank's to the right of the idler's, and back.
    let pivot = [0.21, -0.04];
    let idler = [pivot[0] + 0.08 * arm.cos(), pivot[1] + 0.08 * arm.sin()];
    let direction = |from: [f64; 2], to: [f64; 2], sides: f64| {
        let d = [to[0] - from[0], to[1] - from[1]];
        d[1].atan2(d[0]) - (sides / d[0].hypot(d[1])).asin()
    };
    let before = direction([0.0, 0.0], idler, -0.035 - 0.08);
    let after = direction(idler, [0.26, 0.1], 0.03 + 0.035);
    let pull = [0, 1].map(|k| {
        let along = |angle: f64| [angle.cos(), angle.sin()][k];
        into_alternator * along(after) - into_idler * along(before)
    });
    let lever = [idler[0] - pivot[0], idler[1] - pivot[1]];
    let moment = lever[0] * pull[1] - lever[1] * pull[0];
    near(moment, 1.5 * (arm - 60.0_f64.to_radians()), 1e-6);
}

/// The valve floats where −m s″ ω² exceeds the spring's force k (s₀ + s) anywhere in the rise.
#[test]
fn a_valve_floats_beyond_its_speed() {
    let (m, k, s0, lift, beta) = (0.25, 30e3, 0.01, 7e-3, 80.0_f64.to_radians());
    let square = |u: f64| {
        let [rise, slowing] = [u - (TAU * u).sin() / TAU, -TAU * (TAU * u).sin()];
        k * (s0 + lift * rise) / (m * slowing * lift / (beta * beta))
    };
    let limit =
        (5001..10000).map(|i| square(1e-4 * f64::from(i))).fold(f64::INFINITY, f64::min).sqrt();
    for (part, floats) in [(0.9999, false), (1.0001, true)] {
        let rate = part * limit;
        let text = example_text("valve-train");
        let text = text.replace("\"3000 rpm\"", &format!("\"{rate:?} rad/s\""));
        let mut model = model(&text);
        model.solve.t_end = TAU / rate;
        let motion = solve(&derive(model));
        let parted = times(&motion, |kind| matches!(kind, ChangeKind::Part(..)));
        assert_eq!(!parted.is_empty(), floats, "{part} of the limit: {parted:?}");
    }
}

/// Both wheels by intersections of circles about kingpin and end of the rack.
#[test]
fn the_steered_wheels_are_where_circles_meet() {
    let (arm, lean, back, half, track) = (0.16, 18.0_f64.to_radians(), 0.14, 0.3, 1.3);
    let rod = (0.5 * track - arm * lean.sin() - half).hypot(back - arm * lean.cos());
    let found = over(example("steering"), "way.position", "-0.075:0.075 m:31");
    let [left, right] = ["L.angle", "R.angle"].map(|name| column(&found, name));
    for (i, way) in column(&found, "way.position").into_iter().enumerate() {
        let pin = meet([way - half, -back], rod, [-0.5 * track, 0.0], arm);
        let turn = (pin[0] + 0.5 * track).atan2(-pin[1]) - lean;
        near(left[i], turn, 1e-12);
        let pin = meet([0.5 * track, 0.0], arm, [way + half, -back], rod);
        let turn = (pin[0] - 0.5 * track).atan2(-pin[1]) + lean;
        near(right[i], turn, 1e-12);
    }
}

/// m₁ m₂ ω⁴ − (m₁ k₂ + m₂ (k₁ + k₂)) ω² + k₁ k₂ = 0 without the damper.
#[test]
fn a_quarter_car_has_its_two_frequencies() {
    let text = example_text("quarter-car").replace("\"1.5 N s/mm\"", "0");
    let found = modes(model(&text), About::Start).expect("modes");
    let (m1, m2, k1, k2) = (40.0, 320.0, 200e3, 20e3);
    let (a, b, c): (f64, f64, f64) = (m1 * m2, m1 * k2 + m2 * (k1 + k2), k1 * k2);
    let root = (b * b - 4.0 * a * c).sqrt();
    for (mode, square) in found.modes.iter().zip([(b - root) / (2.0 * a), (b + root) / (2.0 * a)]) {
        near(mode.omega, square.sqrt(), 1e-9 * mode.omega);
    }
}

/// Accelerated for the time of one swing, the load swings to 2 a/g and hangs still.
#[test]
fn the_load_of_a_gantry_crane_hangs_still() {
    let (mechanism, motion) = solved("gantry-crane", None);
    let measures = Measures::new(&mechanism, &["rope.angle"]);
    let angle = |sample: &Sample| measures.at(sample)[0].abs();
    let swing = TAU * (6.0 / G).sqrt();
    let largest = motion.samples.iter().map(angle).fold(0.0, f64::max);
    near(largest, 2.0 * 1.5 / swing / G, 1e-3);
    let cruising = motion.samples.iter().filter(|s| s.t > swing && s.t < swing + 2.0);
    for sample in cruising {
        assert!(angle(sample) < 0.03 * largest, "{} at {} s", angle(sample), sample.t);
    }
}

/// Raised evenly the screw takes F r tan(λ + ρ), here 20 N m less the speed times 1 N m s; let go, it stays.
#[test]
fn a_screw_jack_takes_its_torque_and_locks_itself() {
    let (mechanism, motion) = solved("screw-jack", None);
    let measures = Measures::new(&mechanism, &["thread.angle", "thread.rate"]);
    let (r, lead, mu) = (0.01, 4e-3, 0.12_f64);
    let angles = (lead / (TAU * r)).atan() + mu.atan();
    let torque = (8000.0 + 1.2 * G) * r * angles.tan();
    near(measures.at(at(&motion, 1.0))[1], 20.0 - torque, 1e-6);
    let [angle, rate] = measures.at(motion.samples.last().expect("samples"))[..] else {
        panic!("two measures")
    };
    near(angle, 2.0 * TAU, 1e-3);
    near(rate, 0.0, 1e-12);
}

/// The leg by the intersection of two circles about the strut's knee and the trunnion.
#[test]
fn a_landing_gear_folds() {
    let (mechanism, motion) = solved("landing-gear", None);
    let measures = Measures::new(&mechanism, &["U.angle", "O.angle"]);
    for sample in motion.samples.iter().step_by(10) {
        let [angle, leg] = measures.at(sample)[..] else { panic!("two measures") };
        let knee = [1.0 + 0.65 * angle.cos(), -0.09 + 0.65 * angle.sin()];
        let pin = meet(knee, 0.55, [0.0, 0.0], 0.75);
        near(leg, pin[0].atan2(-pin[1]), 1e-12);
    }
}

/// From 45° at the height y the stone flies for (v sin 45° + √(v² sin² 45° + 2 g y))/g.
#[test]
fn the_stone_of_a_trebuchet_flies_its_parabola() {
    let (mechanism, motion) = solved("trebuchet", Some(9.0));
    let measures = Measures::new(&mechanism, &["stone.y", "stone.vx", "stone.vy"]);
    let off = times(&motion, |kind| matches!(kind, ChangeKind::Part(..)));
    let (lifted, thrown) = (off[0], off[1]);
    let flying = motion.samples.iter().find(|s| s.t > thrown).expect("a flight");
    let [y, vx, vy] = measures.at(flying)[..] else { panic!("three measures") };
    // Back to where it was let go.
    let back = flying.t - thrown;
    let (vy, y) = (vy + G * back, y - vy * back - 0.5 * G * back * back);
    near(vy, vx, 1e-4);
    let landed = thrown + (vy + (vy * vy + 2.0 * G * y).sqrt()) / G;
    let hits = times(&motion, |kind| matches!(kind, ChangeKind::Hit(..)));
    let hit = hits.into_iter().find(|&t| t > thrown).expect("a landing");
    assert!(lifted < thrown);
    near(hit, landed, 1e-5);
}

/// The pistons by s = r cos θ + √(l² − r² sin² θ), their forces by central differences, and the counterweight's m r ω².
#[test]
fn a_v_twin_shakes_to_second_order_alone() {
    let (mechanism, motion) = solved("v-twin", None);
    let (m, r, l, omega) = (0.5, 0.04, 0.16, 50.0 * TAU);
    let slide = |theta: f64| {
        let (sin, cos): (f64, f64) = theta.sin_cos();
        r * cos + (l * l - r * r * sin * sin).sqrt()
    };
    let second = |theta: f64| {
        let d = 1e-3;
        (slide(theta + d) - 2.0 * slide(theta) + slide(theta - d)) / (d * d) * omega * omega
    };
    let mut largest: f64 = 0.0;
    for sample in motion.samples.iter().step_by(7) {
        let phi = omega * sample.t;
        let counterweight = [phi.cos(), phi.sin()].map(|part| -m * r * omega * omega * part);
        let mut force = counterweight;
        for axis in [0.25 * PI, 0.75 * PI] {
            let inertia = -m * second(phi - axis);
            force[0] += inertia * axis.cos();
            force[1] += inertia * axis.sin();
        }
        near(signal(&mechanism, sample, "shake_x"), force[0], 0.01);
        near(signal(&mechanism, sample, "shake_y"), force[1], 0.01);
        largest = largest.max(force[0].hypot(force[1]));
    }
    let second_order = 2.0_f64.sqrt() * m * r * omega * omega * r / l;
    near(largest, second_order, 0.05 * second_order);
}

/// The jib's rear end by two circles; its head stays within 2 % of its way at one height.
#[test]
fn the_head_of_a_luffing_crane_stays_level() {
    let (mechanism, motion) = solved("luffing-crane", Some(20.0));
    let measures = Measures::new(&mechanism, &["A.angle", "jib.H.x", "jib.H.y"]);
    let rows: Vec<Vec<f64>> = motion.samples.iter().map(|sample| measures.at(sample)).collect();
    for row in &rows {
        let d = [18.0 * row[0].cos(), 18.0 * row[0].sin()];
        let rear = meet([-5.6, 3.38], 14.87, d, 5.44);
        let head = [0, 1].map(|k| d[k] + (d[k] - rear[k]) * 15.94 / 5.44);
        near(row[1], head[0], 1e-11);
        near(row[2], head[1], 1e-11);
    }
    let span = |column: usize| {
        let values = || rows.iter().map(|row| row[column]);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    assert!(span(2) < 0.02 * span(1), "{} over {}", span(2), span(1));
}

/// The plate stays level, and its middle is at the length of the rods from the ends of the arms, moved inwards by e.
#[test]
fn the_plate_of_a_delta_robot_is_where_three_spheres_meet() {
    let (mechanism, motion) = solved("delta-robot", None);
    let names = [
        "plate.x",
        "plate.y",
        "plate.z",
        "motor1.angle",
        "motor2.angle",
        "motor3.angle",
        "plate.e0",
    ];
    let measures = Measures::new(&mechanism, &names);
    for sample in motion.samples.iter().step_by(20) {
        let values = measures.at(sample);
        for k in 0..3 {
            let turn = f64::from(u8::try_from(k).expect("three arms")) * TAU / 3.0;
            let reach = 0.16 - 0.05 + 0.2 * values[3 + k].cos();
            let elbow = [reach * turn.cos(), reach * turn.sin(), -0.2 * values[3 + k].sin()];
            let square: f64 = (0..3).map(|i| (values[i] - elbow[i]).powi(2)).sum();
            near(square.sqrt(), 0.45, 1e-12);
        }
        near(values[6].abs(), 1.0, 1e-12);
    }
}
