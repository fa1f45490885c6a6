//! A Geneva wheel while its pin is in a slot, against the closed form: position, speed, acceleration, pin.

mod support;

use support::elements::{column, number, reference};
use support::{Within, at, close, coordinate, derive, model, solve};

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
