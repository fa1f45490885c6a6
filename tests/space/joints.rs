//! Joints in space against reference motions: positions, orientations, their rates and accelerations,
//! and the reactions; each joint in the tree, cut, and put together from simpler ones.
//!
//! The frames of the points are parallel to the world's at the start, so that axes are written in world
//! axes and all angles begin at zero.

use std::fmt::Write;

use crate::support::{Within, at, close, derive, model, path, solve};
use bksim::Mechanism;
use bksim::expr::{Expr, SymbolId, Tape};
use bksim::mbs::spatial;
use bksim::model::{BodyId, PointId};
use bksim::sim::run::Sample;
use serde_json::Value;

/// Largest difference, relative to the largest value of a group of columns.
const WITHIN: f64 = 1e-9;

type Three = [f64; 3];

fn case(name: &str) -> Value {
    let file = path("tests/data/spatial").join(format!("{name}.json"));
    let text = std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    serde_json::from_str(&text).expect("a reference is JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn three(value: &Value) -> Three {
    [0, 1, 2].map(|i| number(&value[i]))
}

fn cross([a, b, c]: Three, [x, y, z]: Three) -> Three {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

/// R v for a unit quaternion.
fn turned([w, x, y, z]: [f64; 4], v: Three) -> Three {
    let n = [x, y, z];
    let once = cross(n, v);
    let twice = cross(n, once);
    [0, 1, 2].map(|i| v[i] + 2.0 * (w * once[i] + twice[i]))
}

/// The only body of a case, with the points `A` and the joints that the test writes.
struct Case {
    data: Value,
    body: Value,
}

impl Case {
    fn new(name: &str) -> Self {
        let data = case(name);
        let body = data["model"]["bodies"][0].clone();
        Self { data, body }
    }

    /// The quaternion of the body at the start.
    fn quaternion(&self) -> [f64; 4] {
        let q = [0, 1, 2, 3].map(|i| number(&self.body["quaternion_wxyz"][i]));
        let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        q.map(|x| x / norm)
    }

    /// The text of the model: the body with its point `A` at a world position, and some joints.
    fn text(&self, p_world: Three, rest: &str) -> String {
        let [w, x, y, z] = self.quaternion();
        let com = three(&self.body["com"]);
        let arm = [0, 1, 2].map(|i| p_world[i] - com[i]);
        let a = turned([w, -x, -y, -z], arm);
        let inertia = three(&self.body["inertia_about_com_body_axes"]);
        let gravity = three(&self.data["model"]["gravity"]);
        let mut text = String::from("space = \"spatial\"\n");
        writeln!(
            text,
            "[ground.points]\nA = {p_world:?}\n[bodies.b]\nmass = {}\ninertia = {inertia:?}\n\
             free = true\n[bodies.b.points]\n\
             A = {{ at = {a:?}, quaternion = [{w:?}, {:?}, {:?}, {:?}] }}\n\
             [loads.g]\ntype = \"gravity\"\nacceleration = {gravity:?}\n\
             [solve]\nt_end = 5\nevery = 0.5\nrtol = 1e-12\natol = 1e-13",
            number(&self.body["mass"]),
            -x,
            -y,
            -z,
        )
        .expect("text grows");
        text + rest
    }

    /// Runs the model and compares all columns that the data has.
    #[track_caller]
    fn check(&self, text: &str, variant: &str, joints: &[&str]) {
        let name = self.data["name"].as_str().expect("a name");
        let mechanism = derive(model(text));
        let motion = solve(&mechanism);
        let measure = Measure::new(&mechanism);
        let columns: Vec<&str> = self.data["columns"]
            .as_array()
            .expect("columns")
            .iter()
            .filter_map(Value::as_str)
            .collect();
        let rows = self.data["rows"].as_array().expect("rows");
        let start = |word: &str| columns.iter().position(|column| *column == word);
        let group = |row: &Value, from: usize| [0, 1, 2].map(|i| number(&row[from + i]));
        // The largest value of each group of columns, and the largest difference.
        let words = ["x", "vx", "ax", "wx", "alx", "force_x", "torque_x"];
        for (k, word) in words.into_iter().enumerate() {
            let Some(from) = start(word) else { continue };
            if k > 4 && joints.is_empty() {
                continue;
            }
            let values = rows.iter().flat_map(|row| group(row, from));
            let scale = values.fold(0.0, |most: f64, x| most.max(x.abs())).max(1e-3);
            for row in rows.iter().filter(|row| (number(&row[0]) * 2.0).fract() == 0.0) {
                let sample = at(&motion, number(&row[0]));
                let found = measure.at(&mechanism, sample, joints)[k];
                let expected = group(row, from);
                let off = (0..3).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f64::max);
                assert!(
                    off <= WITHIN * scale,
                    "{name} {variant}, {word} at {} s: {found:?} against {expected:?}, off by {:.1e}",
                    row[0],
                    off / scale
                );
            }
        }
        // The orientation, as the images of the axes.
        let Some(from) = start("qw") else { return };
        for row in rows.iter().filter(|row| (number(&row[0]) * 2.0).fract() == 0.0) {
            let q = [0, 1, 2, 3].map(|i| number(&row[from + i]));
            let found = measure.at(&mechanism, at(&motion, number(&row[0])), joints);
            for (axis, image) in found[7..].iter().enumerate() {
                let unit = [0, 1, 2].map(|i| f64::from(u8::from(i == axis)));
                let expected = turned(q, unit);
                let off = (0..3).map(|i| (image[i] - expected[i]).abs()).fold(0.0, f64::max);
                assert!(
                    off <= WITHIN,
                    "{name} {variant}, axis {axis} at {} s: off by {off:.1e}",
                    row[0]
                );
            }
        }
    }
}

/// Motion of the body, world axes.
struct Measure {
    tape: Tape,
}

impl Measure {
    fn new(mechanism: &Mechanism) -> Self {
        let (model, kinematics) = (&mechanism.model, &mechanism.system.kinematics);
        let pool = &model.pool;
        let position = kinematics.position(model, BodyId(1), None);
        let velocity = position.map(|e| kinematics.rate(model, e));
        let pose = &kinematics.poses[1];
        let images = spatial::axes(pool).map(|axis| pose.rotation.apply(pool, &axis));
        let second = |v: [Expr; 3]| v.map(|e| kinematics.second_rate(model, e));
        let groups = [position, velocity, second(velocity), pose.omega, second(pose.omega)];
        let [from, to] =
            [0, 1].map(|body| kinematics.position(model, BodyId(body), Some(PointId(0))));
        let arm = spatial::sub(pool, &to, &from);
        let outputs: Vec<Expr> = groups.into_iter().chain(images).chain([arm]).flatten().collect();
        let of = |pick: fn(&bksim::mbs::coordinate::Coordinate) -> SymbolId| {
            mechanism.system.coordinates().iter().map(pick).collect::<Vec<_>>()
        };
        let inputs = [of(|c| c.q), of(|c| c.v), of(|c| c.a)].concat();
        let tape = Tape::compile(pool, &outputs, &inputs, &[]).expect("a function of the motion");
        Self { tape }
    }

    /// Position, velocity, acceleration, ω, ω′; force and torque of the joints on the ground about its
    /// point `A`; images of the axes.
    fn at(&self, mechanism: &Mechanism, sample: &Sample, joints: &[&str]) -> Vec<Three> {
        let inputs = [&sample.q[..], &sample.v, &sample.a].concat();
        let mut out = vec![0.0; 27];
        self.tape.evaluate(&mut self.tape.workspace(&[]), &inputs, &mut out);
        let mut groups: Vec<Three> =
            out.chunks(3).map(|part| [part[0], part[1], part[2]]).collect();
        // From the point of the ground to that of the body, where the reactions are.
        let arm = groups.pop().expect("the last output");
        let (mut force, mut torque) = ([0.0; 3], [0.0; 3]);
        for joint in joints {
            let [fx, fy, fz, mx, my, mz] = crate::support::reaction(mechanism, sample, joint);
            let turning = cross(arm, [fx, fy, fz]);
            for i in 0..3 {
                force[i] -= [fx, fy, fz][i];
                torque[i] -= [mx, my, mz][i] + turning[i];
            }
        }
        groups.splice(5..5, [force, torque]);
        groups
    }
}

/// A joint `j` between the two points `A`.
fn joint(name: &str, kind: &str, keys: &str) -> String {
    format!("\n[joints.{name}]\ntype = \"{kind}\"\nbetween = [\"ground.A\", \"b.A\"]\n{keys}\n")
}

/// Joint in the tree and cut.
#[track_caller]
fn in_tree_and_cut(name: &str, kind: &str, keys: &str, start: &str) -> Case {
    let case = Case::new(name);
    let p = case.data["model"]["joints"][0].get("point").map_or([0.0; 3], three);
    case.check(&case.text(p, &joint("j", kind, keys)), "in the tree", &["j"]);
    let cut = joint("j", kind, &format!("{keys}\ncut = true"));
    let start = format!("\n[initial]\nj = {start}\n");
    case.check(&case.text(p, &(cut + &start)), "cut", &["j"]);
    case
}

#[test]
fn a_revolute_in_space() {
    let case = in_tree_and_cut("Revolute_Case01", "revolute", "axis = [0, 1, 0]", "{ angle = 0 }");
    let parts = joint("s", "spherical", "") + &joint("p", "parallel-axes", "axis = [0, 1, 0]");
    case.check(&case.text([0.0; 3], &parts), "as ball and parallel axes", &["s", "p"]);
}

#[test]
fn a_prismatic_in_space() {
    let case =
        in_tree_and_cut("Prismatic_Case01", "prismatic", "axis = [0, 0, 1]", "{ position = 0 }");
    let parts = joint("c", "cylindrical", "axis = [0, 0, 1]")
        + &joint("p", "perpendicular-axes", "axis = [1, 0, 0]\nsecond = [0, 1, 0]");
    case.check(&case.text([0.0; 3], &parts), "as cylindrical and perpendicular", &["c", "p"]);
}

/// A torsion spring with a damper on a revolute, in the tree and cut; the reference has its reaction and the
/// spring's torque together, so the motion is compared.
#[test]
fn a_torsion_spring_in_space() {
    let case = Case::new("RotSpring_Case01");
    let load = "[loads.s]\ntype = \"torsion\"\njoint = \"j\"\nstiffness = 200\ndamping = 10\n";
    for (cut, variant) in [("", "in the tree"), ("\ncut = true", "cut")] {
        let revolute = joint("j", "revolute", &format!("axis = [0, 1, 0]{cut}"));
        case.check(&case.text([0.0; 3], &(revolute + load)), variant, &[]);
    }
}

/// A spring of length zero that starts where it has no direction.
#[test]
fn a_spring_whose_ends_meet() {
    for name in ["TranSpring_Case01", "TranSpringCB_Case01"] {
        let case = Case::new(name);
        let load = &case.data["model"]["loads"][0];
        let [k, c] = ["k", "c"].map(|key| number(&load[key]));
        let spring = format!(
            "\n[loads.s]\ntype = \"spring\"\nbetween = [\"ground.A\", \"b.A\"]\n\
             stiffness = {k:?}\nlength = 0\ndamping = {c:?}\n"
        );
        for method in ["explicit", "radau"] {
            let text = case.text([0.0; 3], &format!("\nmethod = \"{method}\"\n{spring}"));
            case.check(&text, method, &[]);
        }
    }
}

/// A slide that is driven along its axis.
#[test]
fn a_linear_actuator() {
    let case = Case::new("LinActuator_Case01");
    let drive = "[drives.m]\njoint = \"j\"\nmotion = \"1 m/s * t\"\n";
    for (cut, variant) in [("", "in the tree"), ("\ncut = true", "cut")] {
        let slide = joint("j", "prismatic", &format!("axis = [0, 0, 1]{cut}"));
        case.check(&case.text([0.0; 3], &(slide + drive)), variant, &[]);
    }
}

#[test]
fn a_cylindrical_joint() {
    let case = in_tree_and_cut(
        "Cylindrical_Case01",
        "cylindrical",
        "axis = [0, 0, 1]",
        "{ position = 0, angle = 0 }",
    );
    let parts = joint("l", "point-on-line", "axis = [0, 0, 1]")
        + &joint("p", "parallel-axes", "axis = [0, 0, 1]");
    case.check(&case.text([0.0; 3], &parts), "as line and parallel axes", &["l", "p"]);
}

#[test]
fn a_spherical_joint() {
    // It swings about y: with x of the joint's frames there, far from the pole of the angles.
    let case = Case::new("Spherical_Case01");
    let start = "\n[initial]\nj = { angle1 = 0, angle2 = 0, angle3 = 0 }\n";
    let text = |rest: &str| {
        let text = case.text([0.0; 3], rest);
        let frame = "at = [0, 0, 0], x = [0, 1, 0], y = [0, 0, 1]";
        let text = text.replacen("A = [0.0, 0.0, 0.0]", &format!("A = {{ {frame} }}"), 1);
        let from = text.find("A = { at = [-2").expect("the point of the body");
        let end = text[from..].find('}').expect("its end") + from;
        let frame = frame.replacen("0, 0, 0", "-2, 0, 0", 1);
        format!("{}A = {{ {frame} {}", &text[..from], &text[end..])
    };
    let one = |keys: &str| text(&(joint("j", "spherical", keys) + start));
    case.check(&one(""), "in the tree", &["j"]);
    // A free body turns by angles of its own, which the swing would take to their pole.
    let parts = joint("l", "point-on-line", "axis = [1, 0, 0]\ncut = false")
        + &joint("p", "point-on-plane", "axis = [1, 0, 0]");
    case.check(&text(&parts), "as line and plane", &["l", "p"]);
}

#[test]
fn a_universal_joint() {
    let keys = "axis = [1, 0, 0]\nsecond = [0, 0, 1]";
    let case = in_tree_and_cut("Universal_Case01", "universal", keys, "{ angle1 = 0, angle2 = 0 }");
    let parts = joint("s", "spherical", "") + &joint("p", "perpendicular-axes", keys);
    let parts = parts + "\n[initial]\ns = { angle1 = 0, angle2 = 0, angle3 = 0 }\n";
    case.check(&case.text([0.0; 3], &parts), "as ball and perpendicular axes", &["s", "p"]);
}

#[test]
fn a_screw() {
    let axis = "axis = [0, \"sqrt(3)/2\", \"1/2\"]";
    let keys = format!("{axis}\nlead = 0.5");
    in_tree_and_cut("screw_pendulum", "screw", &keys, "{ angle = 0 }");
}

#[test]
fn a_heavy_top() {
    let case = Case::new("lagrange_top");
    // The frames are those of the body: it spins about z, and the axis leans by less than 90°.
    let own = case.text([0.0; 3], "");
    let start = "\n[initial]\nj = { angle1 = \"60 deg\", angle2 = 0, angle3 = 0, rate1 = 0, \
                 rate2 = 0, rate3 = 150 }\n";
    let q = own.find("quaternion").expect("a frame of the body");
    let end = own[q..].find(']').expect("its end") + q;
    let own = format!("{}quaternion = [1, 0, 0, 0{}", &own[..q], &own[end..]);
    case.check(&(own + &joint("j", "spherical", "") + start), "in the tree", &["j"]);
}

#[test]
fn a_distance_and_a_plane_make_a_link_on_a_hinge() {
    let case = Case::new("RevSpherical_Case01");
    // The reaction on the ground is about its own point, to which the link transmits a moment.
    let text = case.text([2.0, 0.0, 0.0], "");
    let text = text.replacen("A = [2.0, 0.0, 0.0]", "A = [0, 0, 0]", 1);
    let parts =
        joint("l", "link", "length = 2") + &joint("p", "point-on-plane", "axis = [0, 0, 1]");
    let start = "\n[initial]\nb = { x = 2, y = 2, z = 0 }\n";
    case.check(&(text + &parts + start), "as link and plane", &[]);
}

#[test]
fn a_link_to_a_centre_of_mass_in_space() {
    let case = Case::new("Distance_Case01");
    let text = case.text([0.0, 2.0, 0.0], "");
    let text = text.replacen("A = [0.0, 2.0, 0.0]", "A = [0, 0, 0]", 1);
    let start = "\n[initial]\nb = { x = 0, y = 2, z = 0 }\n";
    case.check(&(text + &joint("j", "link", "length = 2") + start), "as a link", &["j"]);
}

/// A pendulum on a ball joint that comes to the pole of three angles, but for a hundredth.
fn near_a_pole(names: &str, solve: &str) -> Mechanism {
    derive(model(&format!(
        "space = \"spatial\"\n[bodies.bob]\nmass = 1\ncom = [0, 0, -0.5]\n\
         inertia = [0.02, 0.02, 0.01]\n[joints.ball]\ntype = \"spherical\"\n\
         between = [\"ground\", \"bob\"]\n{names}\n\
         [initial]\nbob = {{ w = [0.01, 1, 0] }}\n[solve]\nt_end = 3\nevery = 0.01\n{solve}\n"
    )))
}

const NAMES: &str = "coordinate = [\"a\", \"b\", \"c\"]";

#[test]
fn a_run_into_a_pole_of_three_angles_says_so() {
    let coarse = "step = 0.01";
    let rejected = near_a_pole(NAMES, coarse).solve().expect_err("there is a pole");
    let told = crate::support::messages(&rejected.0);
    assert_eq!(rejected.0[0].code.0, "R013", "{told}");
    assert!(rejected.0[0].message.contains("joint `ball`"), "{told}");
    // Without the names it passes.
    solve(&near_a_pole("", coarse));
}

#[test]
fn a_run_past_a_pole_of_three_angles_warns() {
    let worth = |names: &str| {
        let mechanism = near_a_pole(names, "");
        let motion = solve(&mechanism);
        mechanism.simulation().expect("equations").diagnose_worth(&motion.summary)
    };
    let told = worth(NAMES);
    assert_eq!(told.iter().map(|fault| fault.code.0).collect::<Vec<_>>(), ["R013"]);
    assert!(told[0].message.contains("joint `ball`"), "{}", told[0].message);
    assert!(worth("").is_empty());
}

/// Two shafts through the origin, at an angle of 30°: the first turns at 10 rad/s, the second keeps its
/// direction, and a joint holds it to the first.
fn shafts(joint: &str, times: &[f64]) -> String {
    format!(
        "space = \"spatial\"\n[parameters]\nb = \"30 deg\"\n\
         [bodies.a]\nmass = 1\ninertia = [0.1, 0.1, 0.1]\n\
         [bodies.b]\nmass = 1\ninertia = [0.02, 0.02, 0.02]\n\
         points.A = {{ at = [0, 0, 0], x = [\"cos(b)\", \"sin(b)\", 0], z = [0, 0, 1] }}\n\
         [joints.hinge]\ntype = \"revolute\"\nbetween = [\"ground\", \"a\"]\naxis = [1, 0, 0]\n\
         [joints.bend]\n{joint}\n\
         [joints.bearing]\ntype = \"parallel-axes\"\nbetween = [\"ground\", \"b\"]\n\
         axis = [\"cos(b)\", \"sin(b)\", 0]\n\
         [drives.motor]\njoint = \"hinge\"\nmotion = \"10 rad/s*t\"\n\
         [solve]\nt_end = {:?}\ntimes = {times:?}\nrtol = 1e-11\natol = 1e-12\n",
        times[times.len() - 1]
    )
}

/// Rate of the second shaft about its axis, and the torque of the motor.
fn shaft_rates(text: &str, times: &[f64]) -> Vec<[f64; 2]> {
    let mechanism = derive(model(text));
    let motion = solve(&mechanism);
    let poses = bksim::sim::pose::Poses::compile(&mechanism.model, &mechanism.system);
    let poses = poses.expect("poses of the motion");
    let motor = mechanism.system.constraints.len() - 1;
    let axis = [3.0_f64.sqrt() / 2.0, 0.5, 0.0];
    let rates = times.iter().map(|&t| {
        let sample = at(&motion, t);
        let state = [(&sample.q[..], &sample.v[..])];
        let omega = poses.at(&mechanism.parameters, state)[0][2].omega;
        [(0..3).map(|i| omega[i] * axis[i]).sum(), sample.lambda[motor]]
    });
    rates.collect()
}

#[test]
fn a_cardan_joint_between_shafts() {
    let data = case("cardan_single");
    let rows: Vec<&Value> = data["rows"].as_array().expect("rows").iter().skip(1).collect();
    let times: Vec<f64> = rows.iter().map(|row| number(&row[0]) / 10.0).collect();
    let joint = "type = \"universal\"\nbetween = [\"a\", \"b\"]\naxis = [0, 0, 1]\nsecond = [\"-sin(b)\", \"cos(b)\", 0]";
    let within = Within { relative: 1e-9, absolute: 1e-9 };
    for cut in ["", "\ncut = true"] {
        let found = shaft_rates(&shafts(&format!("{joint}{cut}"), &times), &times);
        for ((row, t), [rate, torque]) in rows.iter().zip(&times).zip(found) {
            close(&format!("rate at {t} s{cut}"), rate, 10.0 * number(&row[2]), within);
            close(&format!("torque at {t} s{cut}"), torque, number(&row[4]), within);
        }
    }
}

#[test]
fn a_constant_velocity_joint_keeps_the_rate() {
    let times = [0.05, 0.1, 0.2, 0.35, 0.6];
    let found = shaft_rates(
        &shafts(
            "type = \"constant-velocity\"\nbetween = [\"a\", \"b.A\"]\naxis = [1, 0, 0]",
            &times,
        ),
        &times,
    );
    for (t, [rate, torque]) in times.iter().zip(found) {
        let within = Within { relative: 1e-9, absolute: 1e-9 };
        close(&format!("rate at {t} s"), rate, 10.0, within);
        close(&format!("torque at {t} s"), torque, 0.0, within);
    }
}
