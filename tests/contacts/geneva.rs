//! A Geneva wheel while its pin is in a slot, against the closed form: position, speed, acceleration, pin.

use crate::support::elements::{column, number, reference};
use crate::support::{Within, at, close, coordinate, derive, example, model, solve};

/// The pin enters the slot at 45 degrees and leaves it as far behind the line of centres.
const WHEEL: &str = r#"
[parameters]
r = "0.1 m*sqrt(2)/2"
enters = "-45 deg"

[ground]
points = { W = ["0.1 m", 0] }

[bodies.driver]
mass = "1 kg"
inertia = "1e-3 kg m^2"
points = { pin = ["r", 0] }

[bodies.wheel]
mass = "2 kg"
inertia = "4e-3 kg m^2"

[joints.A]
type = "revolute"
between = ["ground", "driver"]

[joints.B]
type = "revolute"
between = ["ground.W", "wheel"]

[joints.S]
type = "slot"
between = ["wheel", "driver.pin"]
axis = [-1, 0]

[drives.motor]
joint = "A"
motion = "enters + 1 rad/s*t"

[initial]
B = { guess = { angle = "45 deg" } }

[solve]
t_end = "1.5707963267948966 s"
every = "0.07853981633974483 s"
rtol = 1e-10
atol = 1e-12
"#;

#[test]
fn a_wheel_with_four_slots() {
    let data = reference("elements/geneva_4");
    let mechanism = derive(model(WHEEL));
    let motion = solve(&mechanism);
    let wheel = coordinate(&mechanism, "B_angle");
    let (enters, rows) = (std::f64::consts::FRAC_PI_4, data["rows"].as_array().expect("rows"));
    let of = |row, name| number(row, column(&data, name));
    let within = |largest: f64| Within { relative: 0.0, absolute: 1e-12 * largest };
    for row in rows {
        let sample = at(&motion, of(row, "q") + enters);
        // The wheel turns against the driver.
        let q = of(row, "q");
        close(&format!("angle at {q}"), -sample.q[wheel], of(row, "phi"), within(1.0));
        close(&format!("speed at {q}"), -sample.v[wheel], of(row, "dphi"), within(2.4));
        close(&format!("acceleration at {q}"), -sample.a[wheel], of(row, "d2phi"), within(5.4));
    }
}

/// The example: two quarter turns, locked before, between and after them.
#[test]
fn the_wheel_of_the_example_turns_by_quarters() {
    let mechanism = derive(example("geneva"));
    let motion = solve(&mechanism);
    let wheel = coordinate(&mechanism, "B_angle");
    let speed = std::f64::consts::TAU;
    let of = |t: f64| {
        let sample = at(&motion, t);
        [sample.q[wheel], sample.v[wheel] / speed, sample.a[wheel] / speed.powi(2)]
    };
    let within = |largest: f64| Within { relative: 0.0, absolute: 1e-8 * largest };
    for (t, turned) in [(0.1, 0.5), (0.6, -0.5), (1.0, -0.5), (1.75, -1.5)] {
        let [angle, rate, acceleration] = of(t);
        close(&format!("angle at {t} s"), angle, turned * std::f64::consts::FRAC_PI_2, within(1.0));
        close(&format!("speed at {t} s"), rate, 0.0, within(1.0));
        close(&format!("acceleration at {t} s"), acceleration, 0.0, within(1.0));
    }
    // In the line of centres the wheel is fastest, λ/(1 − λ); behind it the acceleration is λ(1 − λ²) sin α/(1 + λ² − 2λ cos α)².
    let lambda = std::f64::consts::FRAC_1_SQRT_2;
    for (t, alpha) in [(0.25, 0.0), (0.3, 0.1 * speed / 2.0), (1.25, 0.0), (1.3, 0.05 * speed)] {
        let square = 1.0 + lambda * lambda - 2.0 * lambda * f64::cos(alpha);
        let rate = lambda * (alpha.cos() - lambda) / square;
        let acceleration = -lambda * (1.0 - lambda * lambda) * alpha.sin() / square.powi(2);
        close(&format!("speed at {t} s"), -of(t)[1], rate, within(2.5));
        close(&format!("acceleration at {t} s"), -of(t)[2], acceleration, within(5.5));
    }
}
