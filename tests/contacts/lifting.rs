//! Limits that follow other positions: followers that lift off their cams, and land again.

use std::f64::consts::TAU;

use crate::support::{
    Measures, Within, all_close, at, close, coordinate, derive, elements, example, model, solve,
    with_method,
};
use bksim::mbs::constraint::Source;
use bksim::model::Method;
use bksim::sim::hybrid::ChangeKind;

/// A follower of 0.4 kg on a cam, pressed by a spring of 500 N/m with 20 N at the lift zero.
fn follower(limit: &str, rate: f64, t_end: f64) -> String {
    format!(
        r#"
[bodies.cam]
mass = "1 kg"
inertia = "2e-3 kg m^2"
[bodies.follower]
mass = "0.4 kg"
[joints.A]
type = "revolute"
between = ["ground", "cam"]
[joints.guide]
type = "prismatic"
between = ["ground", "follower"]
axis = [0, 1]
[curves.lift]
type = "cam-law"
segments = [
  {{ rise = "20 mm", over = "180 deg", law = "3-4-5" }},
  {{ return = "20 mm", over = "180 deg", law = "3-4-5" }},
]
[drives.turn]
joint = "A"
motion = "{rate:?} rad/s*t"
[loads.contact]
type = "stop"
joint = "guide"
min = "{limit}"
[loads.spring]
type = "force"
on = "follower"
vector = [0, "-20 N - 500 N/m*guide.position"]
[solve]
t_end = {t_end:?}
rtol = 1e-11
atol = 1e-13
"#
    )
}

#[test]
fn a_follower_lifts_off_where_its_cam_would_have_to_pull() {
    // s = e (1 − cos ωt): F = m e ω² cos ωt + k e (1 − cos ωt) + 20 N, zero at the angle below.
    let (m, k, e, omega) = (0.4, 500.0, 0.01, 100.0_f64);
    let off = (-(k * e + 20.0) / (m * e * omega * omega - k * e)).acos() / omega;
    for method in ["explicit", "radau"] {
        let text = follower("10 mm*(1 - cos(A.angle))", omega, 0.06);
        let text = text.replace("[solve]\n", &format!("[solve]\nmethod = \"{method}\"\n"));
        let mechanism = derive(model(&text));
        let motion = solve(&mechanism);
        let times = |of: fn(&ChangeKind) -> bool| {
            let changes = motion.summary.changes.iter().filter(|change| of(&change.kind));
            changes.map(|change| change.t).collect::<Vec<f64>>()
        };
        let parted = times(|kind| matches!(kind, ChangeKind::Part(_)));
        close("the lift-off", parted[0], off, Within { relative: 0.0, absolute: 1e-10 });

        // Free flight against the spring, until it is on the cam again.
        let (x, v) = (e * (1.0 - (omega * off).cos()), e * omega * (omega * off).sin());
        let (free, middle) = ((k / m).sqrt(), -20.0 / k);
        let flight = |t: f64| {
            let s = free * (t - off);
            middle + (x - middle) * s.cos() + v / free * s.sin()
        };
        let landed = times(|kind| matches!(kind, ChangeKind::Hit(..)))[0];
        let on_cam = e * (1.0 - (omega * landed).cos());
        close("the landing", flight(landed), on_cam, Within { relative: 0.0, absolute: 2e-10 });
        assert!(landed > off + 0.01, "{landed}");
        let guide = coordinate(&mechanism, "guide_position");
        for sample in &motion.samples {
            let t = sample.t;
            let is_flying = t > off && t < landed;
            let expected = if is_flying { flight(t) } else { e * (1.0 - (omega * t).cos()) };
            if t < landed {
                close(
                    &format!("s at {t} s"),
                    sample.q[guide],
                    expected,
                    Within { relative: 0.0, absolute: 2e-10 },
                );
            }
            let (sin, cos) = (omega * t).sin_cos();
            let force = m * e * omega * omega * cos + k * e * (1.0 - cos) + 20.0;
            let (drive, contact) = (sample.lambda[0], sample.lambda[1]);
            if t < off - 1e-6 {
                let within = Within { relative: 1e-9, absolute: 1e-9 };
                close(&format!("F at {t} s"), contact, force, within);
                // The cam bears F ds/dα, which its drive gives.
                close(&format!("M at {t} s"), drive, force * e * sin, within);
            } else if is_flying {
                assert!(contact == 0.0, "{contact} at {t} s");
            }
        }
    }
}

#[test]
fn a_slow_cam_keeps_its_follower_and_gives_it_the_law() {
    let mechanism = derive(model(&follower("lift(A.angle)", 20.0, 0.3)));
    let motion = solve(&mechanism);
    assert!(
        motion.summary.changes.iter().all(|change| !matches!(change.kind, ChangeKind::Part(_)))
    );
    let guide = coordinate(&mechanism, "guide_position");
    for t in [0.03, 0.06, 0.12, 0.15] {
        let u = 20.0 * t / std::f64::consts::PI;
        let law = 0.02 * (10.0 * u.powi(3) - 15.0 * u.powi(4) + 6.0 * u.powi(5));
        close("the lift", at(&motion, t).q[guide], law, Within { relative: 0.0, absolute: 1e-12 });
    }
}

/// A valve leaves its cam where m s″ ω² + k (s₀ + s) = 0, however loose the tolerances: the instant is found on a
/// state next to the rows, on which the cam may still push.
#[test]
fn a_valve_lifts_off_at_any_tolerance() {
    let (m, k, s0, lift) = (0.25, 30e3, 0.01, 7e-3);
    let (beta, omega) = (80.0_f64.to_radians(), 3000.0 * TAU / 60.0);
    let force = |u: f64| {
        let slowing = TAU * (TAU * u).sin() * lift * (omega / beta).powi(2);
        m * slowing + k * (s0 + lift * (u - (TAU * u).sin() / TAU))
    };
    let (mut before, mut after) = (0.5, 0.75);
    for _ in 0..60 {
        let middle = 0.5 * (before + after);
        *if force(middle) > 0.0 { &mut before } else { &mut after } = middle;
    }
    let off = before * beta / omega;
    for method in [Method::Explicit, Method::Radau] {
        for rtol in [1e-4, 1e-5, 1e-6, 1e-7] {
            let mut model = example("valve-train");
            (model.solve.method, model.solve.rtol) = (method, rtol);
            let motion = solve(&derive(model));
            let mut changes = motion.summary.changes.iter();
            let parted = changes.find(|change| matches!(change.kind, ChangeKind::Part(_)));
            let found = parted.expect("the valve floats").t;
            close(
                &format!("{method:?}, {rtol}"),
                found,
                off,
                Within { relative: 0.0, absolute: 1e-7 },
            );
        }
    }
}

/// The valve train of a pushrod engine, reduced by hand to the lift s of its tappet: m(s) s̈ + ½ m′(s) ṡ² = Q(s) + F.
struct PushrodTrain;

/// The other parts at a lift of the tappet, and their derivatives by it.
struct Parts {
    /// From the height of the stem's point down, m.
    valve: f64,
    valve_slope: f64,
    /// m(s), kg.
    mass: f64,
}

impl PushrodTrain {
    const OMEGA: f64 = 2900.0 * TAU / 60.0;
    const RISE: f64 = 70.0 * TAU / 360.0;

    /// Cycloidal rise and return: s, ds/dt and d²s/dt² on the cam.
    fn on_cam(t: f64) -> [f64; 3] {
        let (h, u) = (7e-3, Self::OMEGA * t / Self::RISE);
        if u >= 2.0 {
            return [0.0; 3];
        }
        let (u, sense) = if u <= 1.0 { (u, 1.0) } else { (2.0 - u, -1.0) };
        let (sin, cos) = (TAU * u).sin_cos();
        let rate = Self::OMEGA / Self::RISE;
        [h * (u - sin / TAU), sense * h * (1.0 - cos) * rate, h * TAU * sin * rate * rate]
    }

    /// The pushrod of length L from the tappet to the rocker's arm a: |d − a u(φ)| = L with d from tappet to pivot.
    fn parts(s: f64) -> Parts {
        let (a, b, l, c) = (0.025_f64, 0.038, 0.147_f64, 0.0735);
        let d = [0.025, 0.150 - s];
        let reach = d[0] * d[0] + d[1] * d[1];
        let phi = d[1].atan2(d[0]) - ((reach + a * a - l * l) / (2.0 * a * reach.sqrt())).acos();
        let (sin, cos) = phi.sin_cos();
        // Along the rod from its foot, and the same differentiated: w · w′ = 0.
        let rod = [d[0] - a * cos, d[1] - a * sin];
        let phi_slope = -rod[1] / (a * (d[1] * cos - d[0] * sin));
        let rod_slope = [a * sin * phi_slope, -1.0 - a * cos * phi_slope];
        let turn = (rod[0] * rod_slope[1] - rod[1] * rod_slope[0]) / (l * l);
        let middle = [c / l * rod_slope[0], 1.0 + c / l * rod_slope[1]];
        let valve_slope = -b * cos * phi_slope;
        let mass = 0.09
            + 0.05 * (middle[0].powi(2) + middle[1].powi(2))
            + 9e-5 * turn * turn
            + 3e-5 * phi_slope * phi_slope
            + 0.11 * valve_slope * valve_slope;
        Parts { valve: 0.005 - b * sin, valve_slope, mass }
    }

    /// m(s) s̈ + ½ m′ ṡ² − Q for an acceleration: the force of the cam.
    fn force(s: f64, rate: f64, acceleration: f64) -> f64 {
        let Parts { valve, valve_slope, mass } = Self::parts(s);
        let h = 3e-5;
        let [far, near] =
            [2.0, 1.0].map(|n| Self::parts(s + n * h).mass - Self::parts(s - n * h).mass);
        let mass_slope = (8.0 * near - far) / (12.0 * h);
        let spring = -35e3 * (0.009 + valve) * valve_slope;
        mass * acceleration + 0.5 * mass_slope * rate * rate - spring
    }

    /// A step of free flight of length h by the classical method of Runge and Kutta.
    fn flown([s, v]: [f64; 2], h: f64) -> [f64; 2] {
        let slope = |[s, v]: [f64; 2]| [v, -Self::force(s, v, 0.0) / Self::parts(s).mass];
        let ahead = |k: [f64; 2], by: f64| [s + by * k[0], v + by * k[1]];
        let k1 = slope([s, v]);
        let k2 = slope(ahead(k1, 0.5 * h));
        let k3 = slope(ahead(k2, 0.5 * h));
        let k4 = slope(ahead(k3, h));
        let sum = |i: usize| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) * h / 6.0;
        [s + sum(0), v + sum(1)]
    }

    /// The flights until `end`: one begins where the cam would pull, at once where it does so at a landing.
    fn flights(end: f64) -> Vec<Flight> {
        let pull = |t: f64| {
            let [s, v, a] = Self::on_cam(t);
            Self::force(s, v, a)
        };
        let (mut flights, mut t) = (Vec::new(), 0.0);
        while t < end {
            if pull(t + STEP) > 0.0 {
                t += STEP;
                continue;
            }
            let off = if pull(t) > 0.0 { root(pull, [t, t + STEP]) } else { t };
            let flight = Self::flight(off);
            t = flight.landed;
            flights.push(flight);
        }
        flights
    }

    /// The flight from an instant.
    fn flight(off: f64) -> Flight {
        let [s, v, _] = Self::on_cam(off);
        let mut states = vec![[s, v]];
        loop {
            let (t, last) = (off + STEP * (states.len() - 1) as f64, states[states.len() - 1]);
            let above = |part: f64| Self::flown(last, part)[0] - Self::on_cam(t + part)[0];
            if states.len() > 2 && above(STEP) < 0.0 {
                return Flight { off, landed: t + root(above, [0.0, STEP]), states };
            }
            states.push(Self::flown(last, STEP));
        }
    }
}

/// Length of the steps of a flight, s.
const STEP: f64 = 2e-6;

/// A flight of the tappet: its lift and the rate of that, [`STEP`] by [`STEP`].
struct Flight {
    off: f64,
    landed: f64,
    states: Vec<[f64; 2]>,
}

impl Flight {
    /// Lift, rate and no acceleration that would have to be stated, at an instant in it.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "instants of a flight are behind its beginning"
    )]
    fn at(&self, t: f64) -> [f64; 3] {
        let step = ((t - self.off) / STEP).floor();
        let [s, v] = PushrodTrain::flown(self.states[step as usize], t - self.off - STEP * step);
        [s, v, 0.0]
    }
}

/// Where a function that is above zero at the first end, and below at the other, passes it.
fn root(f: impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2]) -> f64 {
    assert!(f(low) > 0.0 && f(high) < 0.0, "{} … {}", f(low), f(high));
    for _ in 0..80 {
        let middle = f64::midpoint(low, high);
        *if f(middle) > 0.0 { &mut low } else { &mut high } = middle;
    }
    low
}

/// Five bodies and nine joints against one equation, integrated on its own: lift-off, flight, landing, the lift of the
/// valve, the force of the cam and the torque that turns it.
#[test]
fn a_pushrod_train_floats_as_its_reduced_equation_says() {
    let flights = PushrodTrain::flights(0.012);
    let expected: Vec<[f64; 2]> =
        flights.iter().map(|flight| [flight.off, flight.landed]).collect();
    assert!(flights[0].landed > flights[0].off + 1e-3, "{expected:?}");
    let text = elements::text("overhead-valve-train");
    for method in ["explicit", "radau"] {
        let mechanism = derive(model(&with_method(&text, method)));
        let motion = solve(&mechanism);
        let landings = motion.summary.changes.iter();
        let landings = landings.filter(|change| matches!(change.kind, ChangeKind::Hit(..)));
        let landings: Vec<f64> = landings.map(|change| change.t).collect();
        let instant = Within { relative: 0.0, absolute: 1e-9 };
        let changes = &motion.summary.changes;
        let parted = changes.iter().find(|change| matches!(change.kind, ChangeKind::Part(_)));
        close(method, parted.expect("it leaves its cam").t, flights[0].off, instant);
        all_close(
            method,
            &landings,
            &flights.iter().map(|f| f.landed).collect::<Vec<_>>(),
            instant,
        );
        let row = |is_it: fn(&Source) -> bool| {
            mechanism.compiled.sources.iter().position(is_it).expect("a row")
        };
        let [contact, drive] = [
            row(|source| matches!(source, Source::Stop(_))),
            row(|source| matches!(source, Source::Drive(_))),
        ];
        let measures = Measures::new(&mechanism, &["lifter.position", "guide.position"]);
        for sample in &motion.samples {
            let (t, what) = (sample.t, format!("{method} at {} s", sample.t));
            let flight = flights.iter().find(|flight| t > flight.off && t < flight.landed);
            let [s, v, a] = flight.map_or_else(|| PushrodTrain::on_cam(t), |it| it.at(t));
            let found = measures.at(sample);
            let length = Within { relative: 0.0, absolute: 2e-10 };
            close(&what, found[0], s, length);
            close(&what, found[1], PushrodTrain::parts(s).valve, length);
            let force = if flight.is_some() { 0.0 } else { PushrodTrain::force(s, v, a) };
            let within = Within { relative: 1e-7, absolute: 1e-5 };
            close(&what, sample.lambda[contact], force, within);
            close(&what, sample.lambda[drive], force * v / PushrodTrain::OMEGA, within);
        }
    }
}
