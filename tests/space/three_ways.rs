//! Every kind of joint in space in three ways: in the tree, cut, and put together from simpler ones; in the coordinates of
//! joints, of bodies, and of both. The same motion and the same reactions.
//!
//! A body hangs on a carrier that swings about an oblique axis; gravity is oblique too, and a spring pulls. Where a
//! composite has bodies between the two, they have no mass, so that they pass on what they bear.

use crate::support::{Measures, Within, all_close, at, derive, model, reaction, solve};

const WITHIN: Within = Within { relative: 1e-8, absolute: 1e-8 };

const MEASURES: [&str; 21] = [
    "b.x", "b.y", "b.z", "b.vx", "b.vy", "b.vz", "b.ax", "b.ay", "b.az", "b.cxx", "b.cxy", "b.cyx",
    "b.cyz", "b.czz", "b.wx", "b.wy", "b.wz", "b.alx", "b.aly", "b.alz", "c.ax",
];

const MECHANISM: &str = r#"
space = "spatial"
[ground]
points = { S = [0.2, 1.0, 0.9] }
[bodies.c]
mass = 2
com = [0.3, 0.1, 0]
inertia = [0.3, 0.2, 0.25, 0.01, 0.02, 0.03]
points = { P = [0.5, 0.2, -0.1], H = [0.5, 0.2, -0.2] }
[bodies.b]
mass = 1
com = [0.1, 0.3, 0.2]
inertia = [0.02, 0.05, 0.04]
points = { P = [0, 0, 0], Q = [0.3, 0.2, 0.4], R = [0.1, 0.4, 0.3], T = [0, 0, 0.1] }
[joints.hinge]
type = "revolute"
between = ["ground", "c"]
axis = [0.2, 1, 1]
[loads.gravity]
type = "gravity"
acceleration = [2, -3, -9]
[loads.spring]
type = "spring"
between = ["ground.S", "b.Q"]
stiffness = 25
length = 0.3
damping = 0.4
[initial]
hinge = { angle = 0, rate = 0 }
b = { guess = { x = 0.6, y = 0.5, z = 0.1, rpy = [0, 0, 0], w = [0, 0, 0] } }
[solve]
t_end = 0.6
every = 0.1
rtol = 1e-11
atol = 1e-12
"#;

/// The joint `name` from a point to a point.
fn joint(name: &str, [from, to]: [&str; 2], kind: &str, keys: &str) -> String {
    format!("[joints.{name}]\ntype = \"{kind}\"\nbetween = [\"{from}\", \"{to}\"]\n{keys}\n")
}

/// A joint between the two bodies.
fn own(name: &str, kind: &str, keys: &str) -> String {
    joint(name, ["c.P", "b.P"], kind, keys)
}

/// Slides along some of the axes, one after the other, of which the last carries `m`.
fn slides(axes: &[&str]) -> String {
    let mut text = String::new();
    let mut from = "c.P".to_owned();
    for (i, axis) in axes.iter().enumerate() {
        let to = format!("m{}", i + 1);
        text.extend([format!("[bodies.{to}]\nmass = 0\n")]);
        text += &joint(&format!("s{i}"), [&from, &to], "prismatic", &format!("axis = {axis}"));
        from = to;
    }
    text
}

/// The motion and the whole reaction on the body at its joint point.
fn motion(what: &str, text: &str, on_body: &[&str]) -> Vec<[Vec<f64>; 2]> {
    moved(what, &format!("{MECHANISM}{text}"), on_body)
}

/// Motion ([`motion`]) with the coordinates of all bodies.
fn absolute(what: &str, text: &str, on_body: &[&str]) -> Vec<[Vec<f64>; 2]> {
    moved(what, &format!("coordinates = \"absolute\"\n{MECHANISM}{text}"), on_body)
}

fn moved(what: &str, text: &str, on_body: &[&str]) -> Vec<[Vec<f64>; 2]> {
    let mechanism = derive(model(text));
    let motion = solve(&mechanism);
    let measures = Measures::new(&mechanism, &MEASURES);
    let times = (0..=6).map(|i| 0.1 * f64::from(i));
    let samples = times.map(|t| {
        let sample = at(&motion, t);
        let mut whole = vec![0.0; 6];
        for name in on_body {
            let six = reaction(&mechanism, sample, name);
            whole.iter_mut().zip(six).for_each(|(sum, part)| *sum += part);
        }
        [measures.at(sample), whole]
    });
    let samples: Vec<_> = samples.collect();
    let moved: f64 = (0..3).map(|i| (samples[6][0][i] - samples[0][0][i]).abs()).sum();
    assert!(moved > 0.05, "{what} stays where it is");
    samples
}

#[track_caller]
fn alike(what: &str, one: &[[Vec<f64>; 2]], other: &[[Vec<f64>; 2]]) {
    for (i, (a, b)) in one.iter().zip(other).enumerate() {
        let what = format!("{what}, sample {i}");
        all_close(&format!("{what}: motion"), &b[0], &a[0], WITHIN);
        all_close(&format!("{what}: reaction"), &b[1], &a[1], WITHIN);
    }
}

/// The joint in the tree, cut next to a hinge in the tree, and in the coordinates of all bodies.
#[track_caller]
fn in_all_coordinates(kind: &str, keys: &str) -> Vec<[Vec<f64>; 2]> {
    let tree = motion(kind, &own("j", kind, &format!("{keys}\ncut = false")), &["j"]);
    let cut = motion(kind, &own("j", kind, &format!("{keys}\ncut = true")), &["j"]);
    alike(&format!("{kind}, cut"), &tree, &cut);
    let all_cut = absolute(kind, &own("j", kind, keys), &["j"]);
    alike(&format!("{kind}, absolute"), &tree, &all_cut);
    tree
}

/// The joint in all coordinates, then what it is made of, with the joints of that on the body.
#[track_caller]
fn check(kind: &str, keys: &str, composite: &str, on_body: &[&str]) {
    let tree = in_all_coordinates(kind, keys);
    let composed = motion(kind, composite, on_body);
    alike(&format!("{kind}, composed"), &tree, &composed);
}

#[test]
fn revolute() {
    let parts = own("p", "spherical", "") + &own("q", "parallel-axes", "axis = [0, 1, 2]");
    check("revolute", "axis = [0, 1, 2]", &parts, &["p", "q"]);
}

#[test]
fn prismatic() {
    let parts = own("p", "cylindrical", "axis = [0, 0, 1]")
        + &own("q", "perpendicular-axes", "axis = [1, 0, 0]\nsecond = [0, 1, 0]");
    check("prismatic", "axis = [0, 0, 1]", &parts, &["p", "q"]);
}

#[test]
fn cylindrical() {
    let parts = own("p", "point-on-line", "axis = [1, 0, 1]")
        + &own("q", "parallel-axes", "axis = [1, 0, 1]");
    check("cylindrical", "axis = [1, 0, 1]", &parts, &["p", "q"]);
}

#[test]
fn spherical() {
    let parts = own("p", "point-on-line", "axis = [1, 0, 0]")
        + &own("q", "point-on-plane", "axis = [1, 0, 0]");
    check("spherical", "", &parts, &["p", "q"]);
}

#[test]
fn universal() {
    let keys = "axis = [1, 0, 0]\nsecond = [0, 1, 1]";
    let parts = own("p", "spherical", "") + &own("q", "perpendicular-axes", keys);
    check("universal", keys, &parts, &["p", "q"]);
}

#[test]
fn planar() {
    let axis = "axis = [0, 1, 1]";
    let parts = own("p", "point-on-plane", axis) + &own("q", "parallel-axes", axis);
    check("planar", axis, &parts, &["p", "q"]);
}

#[test]
fn screw() {
    // Its coupling bears part of the wrench, so the parts are a sleeve that turns alone and one that slides by it.
    let keys = "axis = [0, 0, 1]\nlead = 0.4";
    let tree = in_all_coordinates("screw", keys);
    let parts = "[bodies.m]\nmass = 0\n".to_owned()
        + &joint("p", ["c.P", "m"], "revolute", "axis = [0, 0, 1]")
        + &joint("q", ["m", "b.P"], "prismatic", "axis = [0, 0, 1]")
        + "[couplings.thread]\ntype = \"screw\"\nbetween = [\"p\", \"q\"]\nlead = 0.4\n";
    let composed = motion("screw", &parts, &[]);
    for (a, b) in tree.iter().zip(&composed) {
        all_close("screw, composed", &b[0], &a[0], WITHIN);
    }
}

#[test]
fn a_spring_about_the_axis_of_a_screw() {
    // Cut, the screw counts its turns by its travel; what bears the body is the same.
    let torsion = "[loads.torsion]\ntype = \"torsion\"\njoint = \"j\"\nstiffness = 3\nangle = 0.1\ndamping = 0.05\n";
    let keys = "axis = [0, 0, 1]\nlead = 0.4";
    let sprung = |cut: &str| {
        motion(
            "screw",
            &(torsion.to_owned() + &own("j", "screw", &format!("{keys}\ncut = {cut}"))),
            &["j"],
        )
    };
    alike("a sprung screw, cut", &sprung("false"), &sprung("true"));
}

#[test]
fn weld() {
    let parts = own("p", "revolute", "axis = [0, 0, 1]")
        + &own("q", "perpendicular-axes", "axis = [1, 0, 0]\nsecond = [0, 1, 0]");
    check("weld", "", &parts, &["p", "q"]);
}

#[test]
fn slot() {
    let parts = own("p", "point-on-line", "axis = [1, 0, 0]")
        + &own("q", "parallel-axes", "axis = [0, 0, 1]");
    check("slot", "axis = [1, 0, 0]", &parts, &["p", "q"]);
}

#[test]
fn point_on_line() {
    let parts = own("p", "point-on-plane", "axis = [0, 1, 0]")
        + &own("q", "point-on-plane", "axis = [0, 0, 1]");
    check("point-on-line", "axis = [1, 0, 0]", &parts, &["p", "q"]);
}

#[test]
fn point_on_plane() {
    let parts = slides(&["[1, 0, 0]", "[0, 1, 0]"]) + &joint("p", ["m2", "b.P"], "spherical", "");
    check("point-on-plane", "axis = [0, 0, 1]", &parts, &["p"]);
}

#[test]
fn parallel_axes() {
    let parts = own("p", "perpendicular-axes", "axis = [1, 0, 0]\nsecond = [0, 0, 1]")
        + &own("q", "perpendicular-axes", "axis = [0, 1, 0]\nsecond = [0, 0, 1]");
    check("parallel-axes", "axis = [0, 0, 1]", &parts, &["p", "q"]);
}

#[test]
fn perpendicular_axes() {
    let keys = "axis = [1, 0, 0]\nsecond = [0, 1, 0]";
    let parts = slides(&["[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]"])
        + &joint("p", ["m3", "b.P"], "universal", keys);
    check("perpendicular-axes", keys, &parts, &["p"]);
}

#[test]
fn free() {
    // Free of the carrier is free of everything.
    let tree = motion("free", &own("j", "free", ""), &["j"]);
    alike("free, absolute", &tree, &absolute("free", &own("j", "free", ""), &["j"]));
    let parts = slides(&["[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]"])
        + &joint("p", ["m3", "b.P"], "spherical", "");
    alike("free, composed", &tree, &motion("free", &parts, &["p"]));
}

#[test]
fn link() {
    // From the carrier's point to a point of the body, 0.5099 m away at the start.
    let between = ["c.P", "b.R"];
    let length = "length = \"sqrt(0.26)\"";
    let one = motion("link", &joint("j", between, "link", length), &["j"]);
    let all_cut = absolute("link", &joint("j", between, "link", length), &["j"]);
    alike("link, absolute", &one, &all_cut);
    // The rod lies along its own x.
    let parts = "[bodies.m]\nmass = 0\npoints.R = [\"sqrt(0.26)\", 0, 0]\n".to_owned()
        + &joint("p", ["c.P", "m"], "universal", "axis = [0, 1, 0]\nsecond = [0, 0, 1]")
        + &joint("q", ["m.R", "b.R"], "spherical", "");
    alike("link, composed", &one, &motion("link", &parts, &["q"]));
}

/// A ball joint next to one leg of a Clemens coupling: two arms of one shape, hinged across either shaft, mirror
/// images of each other in the plane that halves the bend.
#[test]
fn constant_velocity() {
    let keys = "axis = [0, 0, 1]";
    let one = motion("cv", &own("j", "constant-velocity", keys), &["j"]);
    let all_cut = absolute("cv", &own("j", "constant-velocity", keys), &["j"]);
    alike("constant-velocity, absolute", &one, &all_cut);

    // The leg bears on the shaft next to the joint's own point, so that its force has a moment about it.
    let leg = "[bodies.m1]\nmass = 0\npoints = { E = [0.3, 0, 0.1] }\n\
               [bodies.m2]\nmass = 0\npoints = { E = [0.3, 0, -0.1] }\n"
        .to_owned()
        + &own("p", "spherical", "")
        + &joint("h", ["c.H", "m1"], "revolute", "axis = [0, 1, 0]")
        + &joint("e", ["m1.E", "m2.E"], "spherical", "")
        + &joint("q", ["m2", "b.T"], "revolute", "axis = [0, 1, 0]");
    let mechanism = derive(model(&format!("{MECHANISM}{leg}")));
    let run = solve(&mechanism);
    let measures = Measures::new(&mechanism, &MEASURES);
    let from = Measures::new(&mechanism, &["b.P.x", "b.P.y", "b.P.z"]);
    let to = Measures::new(&mechanism, &["b.T.x", "b.T.y", "b.T.z"]);
    let sample = |i: usize| {
        let sample = at(&run, one_tenth(i));
        let [ball, arm] = ["p", "q"].map(|name| reaction(&mechanism, sample, name));
        let (from, to) = (from.at(sample), to.at(sample));
        let r = [0, 1, 2].map(|k| to[k] - from[k]);
        let moment = [1, 2, 0].map(|y| {
            let z = (y + 1) % 3;
            r[y] * arm[z] - r[z] * arm[y]
        });
        let lever = [0.0; 3].into_iter().chain(moment);
        let whole = ball.iter().zip(&arm).zip(lever).map(|((a, b), c)| a + b + c).collect();
        [measures.at(sample), whole]
    };
    let composed: Vec<[Vec<f64>; 2]> = (0..=6).map(sample).collect();
    alike("constant-velocity, composed", &one, &composed);

    // A double Cardan joint whose halves bend alike, in the coordinates of its joints.
    let halves = "[bodies.m]\nmass = 0\n".to_owned()
        + &joint("p", ["c.P", "m"], "universal", "axis = [1, 0, 0]\nsecond = [0, 1, 0]")
        + &joint("q", ["m", "b.P"], "universal", "axis = [0, 1, 0]\nsecond = [1, 0, 0]")
        + "[couplings.inner]\ntype = \"relation\"\nrelation = \"p.angle2 - q.angle1\"\n\
           [couplings.outer]\ntype = \"relation\"\nrelation = \"p.angle1 - q.angle2\"\n";
    let composed = motion("cv", &halves, &[]);
    for (a, b) in one.iter().zip(&composed) {
        all_close("a double Cardan joint", &b[0], &a[0], WITHIN);
    }
}

fn one_tenth(i: usize) -> f64 {
    [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6][i]
}

/// One motion of a joint driven, the others from a stated start.
#[test]
fn driven_joints_move_alike_in_all_coordinates() {
    let turn = "0.2 rad + 0.7 rad/s*t";
    let slide = "0.1 m + 0.2 m/s*t";
    let cross = "axis = [1, 0, 0]\nsecond = [0, 1, 1]";
    let table = [
        ("revolute", "axis = [0, 1, 2]", "angle", turn, ""),
        ("prismatic", "axis = [0, 0, 1]", "position", slide, ""),
        ("cylindrical", "axis = [1, 0, 1]", "position", slide, "angle = 0.3, rate = 0.1"),
        ("spherical", "", "angle2", turn, "angle1 = 0.3, angle3 = 0.1, rate1 = 0.2, rate3 = 0"),
        ("universal", cross, "angle2", turn, "angle1 = 0.3, rate1 = 0.2"),
        (
            "planar",
            "axis = [0, 1, 1]",
            "position2",
            slide,
            "position1 = 0.1, angle = 0.3, velocity1 = 0, rate = 0.1",
        ),
        ("screw", "axis = [0, 0, 1]\nlead = 0.4", "angle", turn, ""),
        ("slot", "axis = [1, 0, 0]", "angle", turn, "position = 0.1, velocity = 0.2"),
    ];
    for (kind, keys, of, law, start) in table {
        let drive = format!("[drives.d]\njoint = \"j\"\nof = \"{of}\"\nmotion = \"{law}\"\n");
        let start = if start.is_empty() { String::new() } else { format!("\nj = {{ {start} }}") };
        let from = format!("[initial]{start}");
        let mechanism = MECHANISM.replace("[initial]", &from);
        let run = |way: &str, policy: &str, keys: &str| {
            let text = format!("{policy}{mechanism}{}{drive}", own("j", kind, keys));
            moved(&format!("{kind}, {of} driven, {way}"), &text, &["j"])
        };
        let tree = run("tree", "", &format!("{keys}\ncut = false"));
        let cut = run("cut", "", &format!("{keys}\ncut = true"));
        alike(&format!("{kind}, {of} driven, cut"), &tree, &cut);
        let all_cut = run("absolute", "coordinates = \"absolute\"\n", keys);
        alike(&format!("{kind}, {of} driven, absolute"), &tree, &all_cut);
    }
}

/// Springs, limits and signals know the second turn from the first, whatever the coordinates of bodies.
#[test]
fn angles_that_something_goes_by_count_their_turns() {
    let spring = "[loads.e]\ntype = \"torsion\"\njoint = \"j\"\nof = \"angle\"\nstiffness = 0.2\n";
    let stop =
        "[loads.e]\ntype = \"stop\"\njoint = \"j\"\nof = \"angle\"\nmax = 4\nrestitution = 0.5\n";
    let signal = "[loads.e]\ntype = \"torque\"\njoint = \"j\"\nof = \"angle\"\nvalue = \"-0.2 N m*j.angle\"\n";
    let planar = "position1 = 0, velocity1 = 0, position2 = 0, velocity2 = 0, angle = 0, rate = 12";
    let table = [
        ("revolute", spring, "angle = 0, rate = 12"),
        ("cylindrical", stop, "position = 0, velocity = 0, angle = 0, rate = 12"),
        ("planar", signal, planar),
    ];
    for (kind, load, start) in table {
        let mechanism = MECHANISM.replace("[initial]", &format!("[initial]\nj = {{ {start} }}"));
        let run = |policy: &str| {
            let text = format!("{policy}{mechanism}{}{load}", own("j", kind, "axis = [0, 1, 2]"));
            moved(kind, &text, &["j"])
        };
        alike(kind, &run(""), &run("coordinates = \"absolute\"\n"));
    }
}

/// A crank in space on a slanted pin, driven for two turns and a half, whose end pulls a swinging rod.
const DRIVEN: &str = r#"
[bodies.crank]
mass = "1 kg"
com = [0.1, 0, 0]
inertia = [0.01, 0.02, 0.02]
points = { E = [0.2, 0, 0] }
[bodies.rod]
mass = "0.5 kg"
com = [0, 0.1, 0.05]
inertia = [0.005, 0.004, 0.006]
[joints]
A = { type = "revolute", between = ["ground", "crank"], axis = [1, 2, 2] }
B = { type = "revolute", between = ["crank.E", "rod"], axis = [0, 0, 1] }
[drives.motor]
joint = "A"
motion = "0.3 rad + 2*pi*t/(1 s)"
[loads.weight]
type = "gravity"
acceleration = [0, 0, "-9.81 m/s^2"]
[initial]
B = { angle = 0, rate = 0 }
[solve]
t_end = "2.5 s"
every = "0.1 s"
rtol = 1e-9
atol = 1e-11
"#;

#[test]
fn a_drive_turns_a_joint_without_coordinates_more_than_half_a_turn() {
    let moved = |head: &str, method: &str| {
        let text = DRIVEN.replace("[solve]", &format!("[solve]\nmethod = \"{method}\""));
        let mechanism = derive(model(&format!("coordinates = \"{head}\"\n{text}")));
        let motion = solve(&mechanism);
        let [_, position] = motion.summary.position_residual;
        assert!(position < 1e-8, "{head}, {method}: {position}");
        let measures = Measures::new(&mechanism, &["rod.x", "rod.y", "rod.z", "crank.cxy"]);
        motion.samples.iter().flat_map(|sample| measures.at(sample)).collect::<Vec<f64>>()
    };
    let relative = moved("relative", "explicit");
    for method in ["explicit", "radau"] {
        let within = Within { relative: 1e-6, absolute: 1e-6 };
        all_close(method, &moved("absolute", method), &relative, within);
    }
}
