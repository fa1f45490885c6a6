//! A spatial four-bar RSSR against numbers of another formulation: the equations of Newton and Euler of each body, with closure and its
//! derivatives by differences of eighth order in the crank's angle.

use crate::support::model;
use bksim_analysis::{About, Actuators, Channels, Motion, Range, inverse, linearize, modes};

const MODEL: &str = r#"
space = "spatial"
[ground.points]
O = [0, 0, 0]
D = { at = [0.3, 0.2, 0.1], x = [0, 1, 0], z = [0.6, 0, 0.8] }
[bodies.crank]
mass = 1.2
com = [0.04, 0.01, -0.005]
inertia = [0.002, 0.003, 0.004, 0.0002, -0.0001, 0.0003]
points = { A = [0.1, 0, 0] }
[bodies.coupler]
mass = 0.8
com = [0.2, 0.02, 0.01]
inertia = [0.001, 0.01, 0.0105, 0.0003, 0.0002, -0.0004]
points = { A = [0, 0, 0], B = [0.45, 0, 0] }
[bodies.rocker]
mass = 1.5
com = [0.11, -0.02, 0.03]
inertia = [0.003, 0.009, 0.01, 0.0005, -0.0003, 0.0002]
points = { B = [0.25, 0, 0] }
[joints]
motor = { type = "revolute", between = ["ground.O", "crank"], axis = [0, 0, 1] }
A = { type = "universal", between = ["crank.A", "coupler.A"], axis = [0, 0, 1], second = [0, 1, 0] }
B = { type = "spherical", between = ["coupler.B", "rocker.B"] }
pivot = { type = "revolute", between = ["ground.D", "rocker"], axis = [0, 0, 1] }
[loads]
gravity = { type = "gravity", acceleration = [0.5, 0, -9.81] }
spring = { type = "spring", between = ["ground.D", "coupler.B"], stiffness = 300, length = 0.1 }
[initial]
pivot = { guess = { angle = "-90 deg" } }
"#;

/// A torsion spring with a damper at the crank, by which the mechanism has an equilibrium that is stable.
const SPRING: &str = r#"
[loads.hold]
type = "torsion"
joint = "motor"
stiffness = 4
angle = 0.5
damping = 0.03
"#;

fn close(name: &str, found: f64, expected: f64) {
    let off = (found - expected).abs();
    assert!(off <= 1e-8 * expected.abs().max(1.0), "{name}: {found} instead of {expected}");
}

#[test]
fn efforts_and_reactions_balance_each_body() {
    let model = model(MODEL);
    let motion = Motion::formula(&model, "motor.angle", "0.3 + 7*t - 2*t^2").expect("a motion");
    let times = Range { from: 0.0, to: 0.25, n: 2 };
    let found = inverse(model, &[motion], &times, &Actuators::default()).expect("efforts");
    let expected: [(&str, [f64; 2]); 10] = [
        ("motor.effort", [-0.617_752_488_2, 0.122_296_224_53]),
        ("motor.fx", [-27.917_576_388_9, -1.021_417_966_4]),
        ("motor.my", [-0.979_138_728_75, 0.375_313_622_08]),
        ("A.fy", [-14.188_421_436_9, 0.664_402_883_34]),
        ("A.mx", [0.183_598_215_98, 0.113_606_192_04]),
        ("B.fx", [-59.498_205_303_2, -21.066_424_365_0]),
        ("B.fz", [26.364_153_879_5, 10.636_586_282_7]),
        ("pivot.fy", [3.145_391_497_2, -34.455_582_314_0]),
        ("pivot.my", [-5.197_006_282_1, -1.138_829_026_9]),
        ("pivot.mz", [-0.286_935_395_02, 1.319_365_319_2]),
    ];
    for (name, values) in expected {
        let column = found.table.column(name).unwrap_or_else(|| panic!("no column {name}"));
        for (found, expected) in column.iter().zip(values) {
            close(name, *found, expected);
        }
    }
}

#[test]
fn small_motions_have_the_stiffness_and_inertia_along_the_free_motion() {
    // V″, 2 T/θ̇² and the slopes of point B at the root of V′.
    let (angle, stiffness, inertia) = (0.492_770_640_25, 4.109_642_449_8, 0.008_734_725_012_9);
    let slope = [0.002_095_25, -0.001_571_44];
    let text = format!("{MODEL}{SPRING}");
    let one = |name: &str| vec![name.to_owned()];
    let channels = Channels {
        inputs: one("motor.angle"),
        outputs: vec!["coupler.B.x".to_owned(), "coupler.B.vz".to_owned()],
        states: one("motor.angle"),
    };
    let found = linearize(model(&text), About::Static, &channels).expect("a linear system");
    let at = found.pose.iter().find(|(name, ..)| name == "motor.angle").expect("an angle").1;
    close("angle", at, angle);
    close("A by angle", found.a[(1, 0)], -stiffness / inertia);
    close("A by rate", found.a[(1, 1)], -0.03 / inertia);
    close("B", found.b[(1, 0)], 1.0 / inertia);
    close("C", found.c[(0, 0)], slope[0]);
    close("C by rate", found.c[(1, 1)], slope[1]);
    let found = modes(model(&text), About::Static).expect("a mode");
    let [mode] = found.modes.as_slice() else { panic!("one mode") };
    close("omega", mode.omega, (stiffness / inertia).sqrt());
    close("damping", mode.damping, 0.5 * 0.03 / (stiffness * inertia).sqrt());
}
