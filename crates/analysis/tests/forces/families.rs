//! Equilibria that are not isolated, against mechanisms whose balance is known.

use crate::support::model;
use bksim_analysis::{
    AnalysisError, Equilibrium, Range, Stability, Statics, statics, statics_over,
};

fn found(text: &str) -> Statics {
    statics(model(text), &[], &[]).expect("equilibria")
}

/// Dimension and moving positions of the family of each equilibrium.
fn families(text: &str) -> Vec<Option<(usize, Vec<String>)>> {
    let of = |e: &Equilibrium| e.family.as_ref().map(|f| (f.dimension, f.moves.clone()));
    found(text).equilibria.iter().map(of).collect()
}

fn family(dimension: usize, moves: &[&str]) -> (usize, Vec<String>) {
    (dimension, moves.iter().map(|name| (*name).to_owned()).collect())
}

const GRAVITY: &str = "[loads.weight]\ntype = \"gravity\"\nacceleration = [0, \"-9.81 m/s^2\"]\n";

const DOOR: &str = r#"
[bodies.door]
mass = "20 kg"
inertia = "3 kg m^2"
com = ["0.4 m", 0]
[joints.hinge]
type = "revolute"
between = ["ground", "door"]
"#;

/// An arm of 2 kg whose spring without length of its own holds it: k h a = m g l.
const LAMP: &str = r#"
[parameters]
m = "2 kg"
l = "0.3 m"
a = "0.2 m"
h = "0.25 m"
k = "m*9.81 m/s^2*l/(h*a)"
[ground.points]
hook = [0, "h"]
[bodies.arm]
mass = "m"
inertia = "0.05 kg m^2"
com = ["l", 0]
[bodies.arm.points]
eye = ["a", 0]
[joints.A]
type = "revolute"
between = ["ground", "arm"]
[initial]
A.angle = "0.4 rad"
[loads.spring]
type = "spring"
between = ["ground.hook", "arm.eye"]
stiffness = "k"
length = "0 m"
"#;

/// A cart that rolls freely with a pendulum.
const CART: &str = r#"
[bodies.cart]
mass = "1 kg"
[bodies.rod]
mass = "1 kg"
inertia = "0.01 kg m^2"
com = ["0.5 m", 0]
[joints.rail]
type = "prismatic"
between = ["ground", "cart"]
axis = [1, 0]
[joints.A]
type = "revolute"
between = ["cart", "rod"]
[initial]
A.angle = "-1 rad"
"#;

#[test]
fn a_door_is_in_balance_wherever_it_is() {
    assert_eq!(families(DOOR), [Some(family(1, &["hinge.angle"]))]);
}

#[test]
fn a_lamp_is_in_balance_along_a_curve_for_one_stiffness_alone() {
    let lamp = format!("{LAMP}{GRAVITY}");
    let all = found(&lamp);
    assert_eq!(families(&lamp), [Some(family(1, &["A.angle"]))]);
    assert_eq!(all.equilibria[0].stability, Stability::Neutral);
    assert!(all.is_complete);
    let stiffer = lamp.replace("k = \"m*", "k = \"1.01*m*");
    assert_eq!(families(&stiffer), [None, None]);
}

#[test]
fn two_balanced_arms_have_a_family_in_two_dimensions() {
    // The second arm is balanced about its joint, the first one carries it on the other side of its own mass.
    let arms = format!(
        "{GRAVITY}{}",
        r#"
[bodies.lower]
mass = "3 kg"
inertia = "0.1 kg m^2"
com = ["-0.2 m", 0]
[bodies.lower.points]
tip = ["0.5 m", 0]
[bodies.upper]
mass = "1.2 kg"
inertia = "0.03 kg m^2"
[joints.A]
type = "revolute"
between = ["ground", "lower"]
[joints.B]
type = "revolute"
between = ["lower.tip", "upper"]
[initial]
A.angle = "0.3 rad"
B.angle = "1 rad"
"#
    );
    assert_eq!(families(&arms), [Some(family(2, &["A.angle", "B.angle"]))]);
}

#[test]
fn a_pendulum_on_a_free_cart_has_two_families() {
    let text = format!("{CART}{GRAVITY}");
    assert_eq!(families(&text), vec![Some(family(1, &["rail.position"])); 2]);
    let mut stability: Vec<Stability> =
        found(&text).equilibria.iter().map(|e| e.stability).collect();
    stability.sort_by_key(|of| *of == Stability::Unstable);
    assert_eq!(stability, [Stability::Neutral, Stability::Unstable]);
}

#[test]
fn wheels_with_a_spring_between_them_turn_together() {
    let wheels = r#"
[bodies.first]
mass = "1 kg"
inertia = "0.1 kg m^2"
[bodies.second]
mass = "1 kg"
inertia = "0.2 kg m^2"
[joints.A]
type = "revolute"
between = ["ground", "first"]
[joints.B]
type = "revolute"
between = ["first", "second"]
[joints.C]
type = "revolute"
between = ["ground", "second"]
[loads.shaft]
type = "torque"
joint = "B"
value = "-3 N m*B.angle"
[initial]
A.angle = "0.2 rad"
"#;
    let all = families(wheels);
    assert_eq!(all, [Some(family(1, &["A.angle", "C.angle"]))]);
}

#[test]
fn closed_loops_without_loads_are_in_balance_wherever_they_go() {
    let loops = r#"
[ground.points]
D = ["1 m", 0]
[bodies.crank]
mass = "1 kg"
inertia = "0.1 kg m^2"
[bodies.crank.points]
B = ["0.4 m", 0]
[bodies.coupler]
mass = "1 kg"
inertia = "0.1 kg m^2"
[bodies.coupler.points]
C = ["1.1 m", 0]
[bodies.rocker]
mass = "1 kg"
inertia = "0.1 kg m^2"
[bodies.rocker.points]
C = ["0.8 m", 0]
[joints]
A = { type = "revolute", between = ["ground", "crank"] }
B = { type = "revolute", between = ["crank.B", "coupler"] }
C = { type = "revolute", between = ["coupler.C", "rocker.C"] }
D = { type = "revolute", between = ["ground.D", "rocker"] }
[initial]
A = { angle = 0.7 }
D = { guess = { angle = 1.5 } }
"#;
    assert_eq!(families(loops), [Some(family(1, &["A.angle", "B.angle", "C.angle", "D.angle"]))]);
}

#[test]
fn a_stiffness_that_vanishes_in_one_pose_makes_no_family() {
    let cubic = format!(
        "{DOOR}[loads.law]\ntype = \"torque\"\njoint = \"hinge\"\nvalue = \"-5 N m*hinge.angle^3\"\n"
    );
    let all = found(&cubic);
    assert_eq!(all.equilibria.len(), 1);
    assert_eq!(
        (all.equilibria[0].stability, &all.equilibria[0].family),
        (Stability::Neutral, &None)
    );

    // With two free motions, one of them without stiffness.
    let cart = format!(
        "{CART}{GRAVITY}[loads.law]\ntype = \"force\"\njoint = \"rail\"\nvalue = \"-5 N/m^3*rail.position^3\"\n"
    );
    assert_eq!(families(&cart), [None, None]);
}

#[test]
fn play_is_a_family_within_its_ends() {
    let play = "value = \"-5 N m*(max(hinge.angle - 0.3, 0) + min(hinge.angle + 0.3, 0))\"";
    let text = format!("{DOOR}[loads.law]\ntype = \"torque\"\njoint = \"hinge\"\n{play}\n");
    assert_eq!(families(&text), [Some(family(1, &["hinge.angle"]))]);
}

#[test]
fn families_are_not_followed_over_a_parameter() {
    let range = Range { from: 1.0, to: 3.0, n: 5 };
    let fault =
        statics_over(model(&format!("{LAMP}{GRAVITY}")), ("m", range), &[]).expect_err("families");
    assert!(matches!(fault, AnalysisError::NotIsolated { .. }), "{fault}");
}
