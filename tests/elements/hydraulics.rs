//! A hydraulic actuator against the values of another program's test of it.
//!
//! Arm, actuator and valve are those of the test `hydraulicActuatorSimpleTest` of Exudyn (J. Gerstmayr,
//! <https://github.com/jgerstmayr/EXUDYN>, `main/pythonDev/TestModels`); the equations are those of its manual,
//! *ObjectConnectorHydraulicActuatorSimple*: f = A (p₀ − p₁) − d v, ṗ = K/V (∓ A v + u Qₙ √Δp), with Δp to the
//! supply where the valve opens there, to the tank where it opens there.

use crate::support::{Measures, Within, close, derive, model, solve};

/// Pressures in Pa as pure numbers; the valve as a signal `u`.
fn arm(rate: f64, valve: &str) -> String {
    format!(
        "[ground]\npoints = {{ O = [0, 0], G = [0, -0.25] }}\n\
         [bodies.arm]\nmass = 120\ninertia = 10\ncom = [0.5, 0]\npoints = {{ A = [0, 0], H = [0.25, 0] }}\n\
         [joints.A]\ntype = \"revolute\"\nbetween = [\"ground.O\", \"arm.A\"]\n\
         [joints.jack]\ntype = \"cylinder\"\nbetween = [\"ground.G\", \"arm.H\"]\n\
         [states.p0]\nstart = 2e6\n\
         rate = \"1e11*(-0.01*jack.velocity/(1 m/s) + 2e-5*u*(if u >= 0 then sqrt(2e7 - p0) else sqrt(p0)))/(1 s)\"\n\
         [states.p1]\nstart = 2e6\n\
         rate = \"1e11*(0.01*jack.velocity/(1 m/s) - 2e-5*u*(if u <= 0 then sqrt(2e7 - p1) else sqrt(p1)))/(1 s)\"\n\
         {valve}\
         [loads.gravity]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n\
         [loads.oil]\ntype = \"force\"\njoint = \"jack\"\n\
         value = \"0.01 N*(p0 - p1) - 2e5 N s/m*jack.velocity\"\n\
         [initial]\nA = {{ angle = 0, rate = {rate} }}\n\
         [solve]\nt_end = 0.4\nrtol = 1e-10\natol = 1e-10\n"
    )
}

/// The length that the valve asks for at a time, over that at the start, m.
fn asked(time: &str) -> String {
    format!("0.1*(max(0.5, min(1.5, 1 - cos(pi*{time}/(1 s)))) - 0.5) + sqrt(0.125)")
}

/// With steps of 1 µs the valve follows at once: pressures and speeds as the test's author gives them, whose two
/// programs agree within about 1e-5. There the arm is given 2 rad/s with its centre at rest, which its pin does not allow:
/// about the pin this is the moment of momentum of 10/(10 + 120·0.5²) as much.
#[test]
fn an_arm_that_is_thrown_against_its_actuator() {
    let valve = format!("[signals.u]\nvalue = \"2*({} - jack.position/(1 m))\"\n", asked("t"));
    let mechanism = derive(model(&arm(0.5, &valve)));
    let motion = solve(&mechanism);
    let last = motion.samples.last().expect("the end");
    let found = Measures::new(&mechanism, &["arm.H.vx", "arm.H.vy"]).at(last);
    let state =
        |name: &str| last.v[crate::support::coordinate(&mechanism, &format!("{name}_integral"))];
    let within = Within { relative: 5e-5, absolute: 0.0 };
    close("p0", state("p0"), 6_441_296.090_862_97, within);
    close("p1", state("p1"), 3_008_420.042_320_05, within);
    close("vx", found[0], -0.005_006_1, within);
    close("vy", found[1], 0.203_386_69, within);
}
