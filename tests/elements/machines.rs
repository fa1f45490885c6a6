//! Small machines as an engineer writes them down: a pair of gears, a belt that stretches, a controlled cart, a cam.

use std::f64::consts::PI;

use crate::support::elements::effort;
use crate::support::{Within, close, coordinate, derive, messages, model, reaction, solve};

use bksim::model::file::{Source, read};

fn within(absolute: f64) -> Within {
    Within { relative: 0.0, absolute }
}

/// 300 rpm.
const SPEED: f64 = 10.0 * PI;

const GEARS: &str = r#"
[parameters]
z1 = 20
z2 = 45
m = "2 mm"
[bodies.g1]
mass = "1 kg"
inertia = "1e-3 kg m^2"
[bodies.g2]
mass = "3 kg"
inertia = "6e-3 kg m^2"
[ground]
points = { A = [0, 0], B = ["m*(z1+z2)/2", 0] }
[joints.A]
type = "revolute"
between = ["ground.A", "g1"]
[joints.B]
type = "revolute"
between = ["ground.B", "g2"]
[couplings.mesh]
type = "gear"
between = ["A", "B"]
teeth = ["z1", "z2"]
module = "m"
[drives.motor]
joint = "A"
motion = "300 rpm*t"
[loads.brake]
type = "torque"
on = "g2"
value = "-5 N m"
[solve]
t_end = "1 s"
rtol = 1e-10
atol = 1e-12
"#;

/// Twenty teeth drive forty-five against a brake of 5 N m at a pitch radius of 45 mm.
#[test]
fn a_pair_of_gears() {
    let mechanism = derive(model(GEARS));
    let motion = solve(&mechanism);
    let wheel = coordinate(&mechanism, "B_angle");
    for sample in &motion.samples {
        close("angle", sample.q[wheel], -SPEED * sample.t * 20.0 / 45.0, within(1e-11));
        close("tooth", effort(&mechanism, sample, "mesh").abs(), 5.0 / 0.045, within(1e-9));
    }
}

const BELT: &str = r#"
[parameters]
way = "2*sqrt((0.6 m)^2 - (0.12 m)^2) + pi*0.28 m + 2*0.12 m*asin(0.2)"
[ground]
points = { A = [0, 0], B = ["0.6 m", 0] }
[bodies.p1]
mass = "2 kg"
inertia = "4e-3 kg m^2"
[bodies.p2]
mass = "5 kg"
inertia = "4e-2 kg m^2"
[joints.A]
type = "revolute"
between = ["ground.A", "p1"]
coordinate = "a"
[joints.B]
type = "revolute"
between = ["ground.B", "p2"]
coordinate = "b"
[couplings.belt]
type = "belt"
between = ["A", "B"]
radii = ["80 mm", "200 mm"]
length = "way"
stiffness = "1e5 N/m"
[loads.motor]
type = "torque"
on = "p1"
value = "20 N m*(1 - a_dot/(1500 rpm))"
[solve]
t_end = "1 s"
rtol = 1e-10
atol = 1e-12
"#;

/// Both wheels swing on the belt and come to the speed at which the motor has no torque left.
#[test]
fn a_motor_on_a_belt_that_stretches() {
    let mechanism = derive(model(BELT));
    let motion = solve(&mechanism);
    let [a, b] = ["a", "b"].map(|name| coordinate(&mechanism, name));
    let last = motion.samples.last().expect("a sample");
    close("motor", last.v[a], 50.0 * PI, Within { relative: 2e-3, absolute: 0.0 });
    close("driven", last.v[b], 20.0 * PI, Within { relative: 2e-3, absolute: 0.0 });
    // As if the belt were rigid but for its small swings: ω (1 − exp(−t/τ)), τ = J ω/M.
    let tau = (4e-3 + 4e-2 * 0.16) * 50.0 * PI / 20.0;
    for sample in &motion.samples {
        let rigid = 50.0 * PI * (1.0 - (-sample.t / tau).exp());
        close(&format!("motor at {} s", sample.t), sample.v[a], rigid, within(8.0));
    }
}

const CART: &str = r#"
[parameters]
kp = "120 N"
kd = "25 N s"
ki = "60 N/s"
[bodies.cart]
mass = "1 kg"
[bodies.pole]
mass = "0.2 kg"
com = [0, "0.4 m"]
inertia = "0.01 kg m^2"
points = { T = [0, "0.8 m"] }
[joints.rail]
type = "prismatic"
between = ["ground", "cart"]
axis = [1, 0]
coordinate = "x"
[joints.pin]
type = "revolute"
between = ["cart", "pole"]
coordinate = "th"
[states.e_int]
rate = "th"
start = "0 rad s"
[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]
[loads.control]
type = "force"
on = "cart"
vector = ["-(kp*th + ki*e_int + kd*th_dot)", 0]
[initial]
x = 0
th = "8 deg"
[solve]
t_end = "5 s"
rtol = 1e-10
atol = 1e-12
"#;

/// The pole comes up from 8° to within a tenth of a degree, by a controller with an integral.
#[test]
fn a_pole_on_a_cart() {
    let mechanism = derive(model(CART));
    let motion = solve(&mechanism);
    let pole = coordinate(&mechanism, "th");
    let [first, last] = [&motion.samples[0], motion.samples.last().expect("a sample")];
    close("start", first.q[pole], 8.0 * PI / 180.0, within(1e-12));
    close("end", last.q[pole], 0.0, within(0.1 * PI / 180.0));
}

const CAM: &str = r#"
[parameters]
e = "10 mm"
R = "30 mm"
[bodies.cam]
mass = "0.5 kg"
com = ["e", 0]
inertia = "2e-4 kg m^2"
points = { O = [0, 0] }
[bodies.follower]
mass = "0.3 kg"
[joints.O]
type = "revolute"
between = ["ground", "cam.O"]
coordinate = "phi"
[joints.guide]
type = "prismatic"
between = ["ground", "follower"]
axis = [0, 1]
coordinate = "y"
[curves.disc]
type = "formula"
formula = ["e + R*cos(p)", "R*sin(p)"]
[joints.contact]
type = "line-on-curve"
between = ["cam", "follower"]
curve = "disc"
axis = [1, 0]
[drives.motor]
joint = "O"
motion = "300 rpm*t"
[initial]
contact = { guess = { angle = "90 deg" } }
[solve]
t_end = "0.4 s"
rtol = 1e-10
atol = 1e-12
"#;

/// A disc of 30 mm turns 10 mm off its centre: y = R + e sin φ, and its force is m ÿ.
#[test]
fn an_eccentric_disc_under_a_flat_follower() {
    let mechanism = derive(model(CAM));
    let motion = solve(&mechanism);
    let lift = coordinate(&mechanism, "y");
    for sample in &motion.samples {
        let sin = (SPEED * sample.t).sin();
        close("lift", sample.q[lift], 0.03 + 0.01 * sin, within(1e-11));
        let force = reaction(&mechanism, sample, "contact")[1];
        close("force", force, -0.3 * 0.01 * SPEED * SPEED * sin, within(1e-7));
    }
}

/// Words that other programs use say where the element is written.
#[test]
fn couplings_written_as_joints_or_loads_say_where_they_belong() {
    let fault = |text: &str| {
        let diagnostics = read(&Source::new(text, "machine")).diagnostics;
        let notes = diagnostics.iter().flat_map(|d| d.notes.clone()).collect::<Vec<_>>();
        (messages(&diagnostics), notes.join("; "))
    };
    let as_joint = GEARS.replace("[couplings.mesh]", "[joints.mesh]");
    let (message, notes) = fault(&as_joint);
    assert!(message.contains("[M008] `type` of joint `mesh` cannot be `gear`"), "{message}");
    assert!(notes.contains("[couplings.NAME]"), "{notes}");
    let as_load = BELT.replace("[couplings.belt]", "[loads.belt]");
    assert!(fault(&as_load).1.contains("[couplings.NAME]"), "{as_load}");
    let as_joint = CAM.replace("line-on-curve", "cam");
    assert!(fault(&as_joint).1.contains("[curves.NAME]"), "{as_joint}");
}

/// A crank pin of 50 mm in the slot of a sliding yoke of 2 kg.
const YOKE: &str = r#"
[bodies.crank]
mass = "1 kg"
inertia = "1e-3 kg m^2"
points = { O = [0, 0], P = ["50 mm", 0] }
[bodies.yoke]
mass = "2 kg"
[joints.O]
type = "revolute"
between = ["ground", "crank.O"]
[joints.guide]
type = "prismatic"
between = ["ground", "yoke"]
axis = [1, 0]
[joints.slot]
type = "slot"
between = ["yoke", "crank.P"]
axis = [0, 1]
[drives.motor]
joint = "O"
motion = "10 rad/s*t"
[solve]
t_end = "1 s"
rtol = 1e-11
atol = 1e-13
"#;

/// A Scotch yoke: x = r cos φ, and the slot pushes with m ẍ.
#[test]
fn a_yoke_moves_by_the_cosine_of_its_crank() {
    let mechanism = derive(model(YOKE));
    let motion = solve(&mechanism);
    let yoke = coordinate(&mechanism, "guide_position");
    for sample in &motion.samples {
        let cos = (10.0 * sample.t).cos();
        close("yoke", sample.q[yoke], 0.05 * cos, within(1e-11));
        // On the crank, so against the yoke's acceleration.
        let force = reaction(&mechanism, sample, "slot")[0];
        close("pin", force, 2.0 * 5.0 * cos, within(1e-7));
    }
}

/// A shaft with a right-handed and a left-handed thread of 4 mm between two jaws, which a force presses apart.
const JAWS: &str = r#"
[bodies.shaft]
mass = "1 kg"
inertia = "2e-4 kg m^2"
[bodies.left]
mass = "0.5 kg"
[bodies.right]
mass = "0.5 kg"
[joints.S]
type = "revolute"
between = ["ground", "shaft"]
[joints.L]
type = "prismatic"
between = ["ground", "left"]
axis = [1, 0]
[joints.R]
type = "prismatic"
between = ["ground", "right"]
axis = [1, 0]
[couplings.one]
type = "screw"
between = ["S", "R"]
lead = "4 mm"
[couplings.other]
type = "screw"
between = ["S", "L"]
lead = "-4 mm"
[loads.apart]
type = "force"
on = "right"
vector = ["300 N", 0]
[loads.back]
type = "force"
on = "left"
vector = ["-300 N", 0]
[solve]
t_end = "0.5 s"
rtol = 1e-11
atol = 1e-13
"#;

/// Both jaws move alike: the shaft turns by 2 F (p/2π) over its inertia and that of the jaws.
#[test]
fn two_threads_of_opposite_hands() {
    let mechanism = derive(model(JAWS));
    let motion = solve(&mechanism);
    let [shaft, left, right] =
        ["S_angle", "L_position", "R_position"].map(|name| coordinate(&mechanism, name));
    let per_turn = 4e-3 / (2.0 * PI);
    let acceleration = 600.0 * per_turn / (2e-4 + 2.0 * 0.5 * per_turn * per_turn);
    for sample in &motion.samples {
        let angle = 0.5 * acceleration * sample.t * sample.t;
        close("shaft", sample.q[shaft], angle, Within { relative: 1e-9, absolute: 1e-9 });
        close("right", sample.q[right], per_turn * sample.q[shaft], within(1e-11));
        close("left", sample.q[left], -sample.q[right], within(1e-11));
    }
}

/// A rack of 8 mm pinion radius steers a knuckle 0.6 m next to it by a tie rod.
const STEERING: &str = r#"
[parameters]
rod = "sqrt((0.25 m)^2 + (0.02 m)^2)"
[ground]
points = { P = [0, 0], K = ["0.6 m", 0] }
[bodies.pinion]
mass = "0.2 kg"
inertia = "1e-5 kg m^2"
[bodies.rack]
mass = "1.5 kg"
points = { E = ["0.3 m", "-0.1 m"] }
[bodies.knuckle]
mass = "10 kg"
inertia = "0.3 kg m^2"
points = { K = [0, 0], T = ["-50 mm", "-120 mm"] }
[joints.P]
type = "revolute"
between = ["ground.P", "pinion"]
[joints.guide]
type = "prismatic"
between = ["ground.P", "rack"]
axis = [1, 0]
[joints.K]
type = "revolute"
between = ["ground.K", "knuckle.K"]
[joints.tie]
type = "link"
between = ["rack.E", "knuckle.T"]
length = "rod"
[couplings.steering]
type = "rack"
between = ["P", "guide"]
radius = "8 mm"
[drives.wheel]
joint = "P"
motion = "300 deg*sin(2 rad/s*t)"
[solve]
t_end = "3 s"
rtol = 1e-11
atol = 1e-13
"#;

/// The knuckle turns by the law of cosines of the triangle of pivot, rack end and arm.
#[test]
fn a_rack_steers_a_knuckle() {
    let mechanism = derive(model(STEERING));
    let motion = solve(&mechanism);
    let [guide, knuckle] = ["guide_position", "K_angle"].map(|name| coordinate(&mechanism, name));
    let (arm, rod) = (0.05f64.hypot(0.12), 0.25f64.hypot(0.02));
    let own = (-0.12f64).atan2(-0.05);
    for sample in &motion.samples {
        let travel = 8e-3 * 300f64.to_radians() * (2.0 * sample.t).sin();
        close("rack", sample.q[guide], travel, within(1e-11));
        let (x, y) = (0.3 + travel - 0.6, -0.1_f64);
        let far = x.hypot(y);
        let between = ((arm * arm + far * far - rod * rod) / (2.0 * arm * far)).acos();
        let expected = y.atan2(x) + between - own;
        close(&format!("knuckle at {} s", sample.t), sample.q[knuckle], expected, within(1e-9));
    }
}
