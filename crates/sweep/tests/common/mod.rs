//! Models and plans that the tests share.
#![allow(dead_code, reason = "each test file uses some of this")]

use bksim_sweep::{Axis, Design, Plan};

/// A crank, a rod and a slider: lengths, inertias, the start and the end of the run are expressions
/// of parameters.
pub fn press() -> String {
    r#"
[parameters]
l1 = "100 mm"
l2 = "3*l1"
m1 = "0.5 kg"
m2 = "0.8 kg"
k = "400 N/m"
J1 = "m1*l1^2/12"
phi = "30 deg"
T = "2*pi*sqrt(m2/k)"

[bodies.crank]
mass = "m1"
com = ["l1/2", 0]
inertia = "J1"
points = { A = [0, 0], B = ["l1", 0] }

[bodies.slider]
mass = "m2"

[joints.A]
type = "revolute"
between = ["ground", "crank.A"]
coordinate = "theta"

[joints.guide]
type = "prismatic"
between = ["ground", "slider"]
axis = [1, 0]
coordinate = "x"

[joints.rod]
type = "link"
between = ["crank.B", "slider"]
length = "l2"

[loads]
gravity = { type = "gravity", acceleration = [0, "-9.81 m/s^2"] }
spring = { type = "force", on = "slider", vector = ["k*(0.3 m - x)", 0] }
motor = { type = "torque", on = "crank", value = "0.2 N m - 0.01 N m s*theta_dot" }

[initial]
theta = "phi"
x = { guess = "4*l1" }

[solve]
t_end = "2*T"
every = "0.02 s"
"#
    .to_owned()
}

/// A grid.
pub fn plan(axes: &[(&str, &str)]) -> Plan {
    let axis = |(name, text): &(&str, &str)| {
        Axis::parse(name, text).expect("an axis").expect("more than one value")
    };
    Plan::new(axes.iter().map(axis).collect(), Design::Grid).expect("a plan")
}
