//! Limits that follow other positions: followers that lift off their cams, and land again.

mod support;

use std::f64::consts::TAU;

use bksim::model::Method;
use bksim::sim::hybrid::ChangeKind;
use support::{Within, at, close, coordinate, derive, example, model, solve};

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
/// state beside the rows, on which the cam may still push.
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
