//! An arm and a six-legged platform next to Pinocchio, MuJoCo and Exudyn.
//!
//! The arm is the PUMA 560, which falls freely from a pose in which its last three axes are not in line; measured are its
//! six angles. The platform stands on six legs, each a cross, a tube, a piston on a spring with a damper, and a ball; it
//! falls under gravity that is a little inclined, on springs that differ, and all its six freedoms move; measured are
//! the places of three of its balls.

use std::f64::consts::PI;
use std::fmt::Write;

use bksim::Mechanism;
use bksim::expr::Expr;
use bksim::model::{CoordinatePolicy, Model, Vector};
use serde_json::{Value, json};

use crate::error::BenchError;
use crate::models;
use crate::peers::Context;
use crate::race::{Case, Peer, compare};
use crate::report::Report;

/// The arm whose equations the literature counts.
const PUMA: &str = include_str!("../../../tests/fixtures/puma-560.toml");

const TOLERANCES: [f64; 4] = [1e-3, 1e-5, 1e-7, 1e-9];

const ARM_PEERS: [Peer; 3] = [
    Peer { name: "Pinocchio, DOP853", script: "arm_pinocchio", sizes: &[1e-4, 1e-6, 1e-8, 1e-10] },
    Peer { name: "MuJoCo, RK4", script: "arm_mujoco", sizes: &[4e-3, 2e-3, 1e-3, 5e-4] },
    Peer { name: "Exudyn, RK67", script: "arm_exudyn", sizes: &[2e-2, 1e-2, 5e-3, 2e-3] },
];

const PLATFORM_PEERS: [Peer; 3] = [
    Peer {
        name: "Pinocchio, DOP853",
        script: "platform_pinocchio",
        sizes: &[1e-4, 1e-6, 1e-8, 1e-10],
    },
    Peer {
        name: "MuJoCo, RK4, soft balls",
        script: "platform_mujoco",
        sizes: &[4e-3, 2e-3, 1e-3, 5e-4],
    },
    Peer {
        name: "Exudyn, generalised alpha",
        script: "platform_exudyn",
        sizes: &[2e-3, 1e-3, 5e-4, 2e-4],
    },
];

/// Compares both machines.
pub(crate) fn measure(context: &Context) -> Result<Report, BenchError> {
    let mut report = Report::new("machines", "An arm and a six-legged platform");
    compare(&[arm()?, platform()], context, &mut report)?;
    let note = "MuJoCo's balls that close loops are springs, as stiff as its step allows: its error falls with h²";
    report.notes.push(note.to_owned());
    Ok(report)
}

/// The arm in relative coordinates, where it is a tree without constraints.
fn arm() -> Result<Case, BenchError> {
    const NAME: &str = "PUMA 560";
    const START: [f64; 6] = [0.1; 6];
    let stop =
        |e: bksim::Rejected| BenchError::Model { name: NAME.to_owned(), message: e.to_string() };
    let mechanism = Mechanism::derive(models::model(PUMA, NAME)?, Vec::new()).map_err(stop)?;
    let (bodies, gravity) = description(&mechanism);
    Ok(Case {
        name: NAME.to_owned(),
        text: PUMA.to_owned(),
        measured: (1..=START.len()).map(|i| format!("J{i}.angle")).collect(),
        t_end: 1.0,
        level: 1e-8,
        policies: vec![CoordinatePolicy::Relative],
        tolerances: &TOLERANCES,
        finest: 1e-12,
        peers: &ARM_PEERS,
        request: json!({ "bodies": bodies, "gravity": gravity, "q": START }),
    })
}

/// The bodies as the peers take them, in the order of the coordinates, and gravity.
fn description(mechanism: &Mechanism) -> (Vec<Value>, [f64; 3]) {
    let model = &mechanism.model;
    let value = |e: Expr| value(model, &mechanism.parameters, e);
    let three = |v: &Vector| v.map(value);
    let bodies = model.bodies.iter().enumerate().skip(1).map(|(idx, body)| {
        let carrying = model.joints.iter().find(|joint| joint.successor.body.0 == idx);
        let joint = carrying.expect("each body hangs on a joint");
        assert!(joint.kind.is_pin(), "a tree of revolutes");
        let from = &model.bodies[joint.predecessor.body.0];
        let place = joint.predecessor.point.map(|point| three(&from.points[point.0].position));
        let inertia = [three(&body.inertia.moments), three(&body.inertia.products)].concat();
        json!({
            "parent": joint.predecessor.body.0,
            "place": place.unwrap_or_default(),
            "axis": three(&joint.axis),
            "mass": value(body.mass),
            "com": three(&body.com),
            "inertia": inertia,
        })
    });
    let gravity = model.loads.iter().find_map(|load| load.kind.gravity());
    (bodies.collect(), gravity.map(|g| three(&g)).unwrap_or_default())
}

fn value(model: &Model, parameters: &[f64], e: Expr) -> f64 {
    let of = |symbol| {
        let place = model.parameters.iter().position(|p| p.symbol == symbol)?;
        Some(parameters[place])
    };
    model.pool.evaluate(e, &of).expect("a number of parameters")
}

/// A body of the platform with its centre on z: mass, kg, place of the centre, m, and moments of inertia, kg m².
struct Part {
    name: &'static str,
    mass: f64,
    com: f64,
    inertia: [f64; 3],
}

const PLATE: Part = Part { name: "platform", mass: 50.0, com: 0.05, inertia: [5.0, 6.0, 9.0] };
const TUBE: Part = Part { name: "tube", mass: 4.0, com: 0.4, inertia: [0.2, 0.2, 0.01] };
const PISTON: Part = Part { name: "piston", mass: 3.0, com: -0.4, inertia: [0.15, 0.15, 0.005] };

impl Part {
    fn text(&self, number: &str) -> String {
        let Self { name, mass, com, inertia } = self;
        format!(
            "[bodies.{name}{number}]\nmass = {mass:?}\ncom = [0, 0, {com:?}]\ninertia = {inertia:?}\n"
        )
    }

    fn json(&self) -> Value {
        json!({ "mass": self.mass, "com": self.com, "inertia": self.inertia })
    }
}

/// Height of the platform at the start, m; unloaded length of the springs, m; of the dampers, N s/m.
const HEIGHT: f64 = 1.2;
const UNLOADED: f64 = 1.36;
const DAMPING: f64 = 20.0;
const GRAVITY: [f64; 3] = [1.0, 0.5, -9.81];

/// Six points in pairs on a circle.
fn circle(radius: f64, angles: [f64; 6]) -> [[f64; 3]; 6] {
    angles.map(|degrees| {
        let angle = degrees * PI / 180.0;
        [radius * angle.cos(), radius * angle.sin(), 0.0]
    })
}

fn feet() -> [[f64; 3]; 6] {
    circle(1.0, [-8.0, 8.0, 112.0, 128.0, 232.0, 248.0])
}

fn balls() -> [[f64; 3]; 6] {
    circle(0.6, [-50.0, 50.0, 70.0, 170.0, 190.0, 290.0])
}

/// Stiffness of the spring of a leg, N/m.
fn stiffness(i: usize) -> f64 {
    2000.0 * (1.0 + 0.1 * i as f64)
}

/// The platform with its legs in relative coordinates, some balls cut, and in coordinates of bodies.
fn platform() -> Case {
    let springs: Vec<f64> = (0..6).map(stiffness).collect();
    Case {
        name: "six legs".to_owned(),
        text: platform_text(),
        measured: [1, 3, 5]
            .iter()
            .flat_map(|i| ["x", "y", "z"].map(|axis| format!("platform.P{i}.{axis}")))
            .collect(),
        t_end: 1.0,
        level: 1e-7,
        policies: vec![CoordinatePolicy::Relative, CoordinatePolicy::Absolute],
        tolerances: &TOLERANCES,
        finest: 1e-12,
        peers: &PLATFORM_PEERS,
        request: json!({
            "feet": feet(), "balls": balls(), "stiffness": springs, "height": HEIGHT,
            "unloaded": UNLOADED, "damping": DAMPING, "gravity": GRAVITY,
            "platform": PLATE.json(), "tube": TUBE.json(), "piston": PISTON.json(),
        }),
    }
}

/// The model file: at rest, the platform level, the angles of the crosses as guesses.
fn platform_text() -> String {
    let mut text = format!(
        "space = \"spatial\"\n[loads.gravity]\ntype = \"gravity\"\nacceleration = {GRAVITY:?}\n"
    );
    let mut add =
        |part: std::fmt::Arguments<'_>| text.write_fmt(part).expect("text takes everything");
    add(format_args!("{}", PLATE.text("")));
    let (feet, balls) = (feet(), balls());
    for (i, ball) in balls.iter().enumerate() {
        add(format_args!("points.P{} = {ball:?}\n", i + 1));
    }
    add(format_args!("[ground.points]\n"));
    for (i, foot) in feet.iter().enumerate() {
        add(format_args!("B{} = {foot:?}\n", i + 1));
    }
    for i in 1..=6 {
        let number = i.to_string();
        add(format_args!("{}{}", TUBE.text(&number), PISTON.text(&number)));
        add(format_args!(
            "[joints.cross{i}]\ntype = \"universal\"\nbetween = [\"ground.B{i}\", \"tube{i}\"]\n\
             axis = [1, 0, 0]\nsecond = [0, 1, 0]\n\
             [joints.leg{i}]\ntype = \"prismatic\"\nbetween = [\"tube{i}\", \"piston{i}\"]\n\
             axis = [0, 0, 1]\n\
             [joints.ball{i}]\ntype = \"spherical\"\nbetween = [\"piston{i}\", \"platform.P{i}\"]\n\
             [loads.spring{i}]\ntype = \"spring\"\njoint = \"leg{i}\"\nstiffness = {:?}\n\
             length = {UNLOADED}\ndamping = {DAMPING}\n",
            stiffness(i - 1)
        ));
    }
    // Stated is the place of the centre of mass.
    let height = HEIGHT + PLATE.com;
    add(format_args!(
        "[initial]\nplatform = {{ x = 0, y = 0, z = {height:?}, rpy = [0, 0, 0], vx = 0, vy = 0, vz = 0, w = [0, 0, 0] }}\n"
    ));
    for (i, (foot, ball)) in feet.iter().zip(&balls).enumerate() {
        let way = [ball[0] - foot[0], ball[1] - foot[1], HEIGHT];
        let length = way.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (first, second) = ((-way[1]).atan2(way[2]), (way[0] / length).asin());
        let i = i + 1;
        add(format_args!(
            "cross{i} = {{ guess = {{ angle1 = {first:?}, angle2 = {second:?} }} }}\n"
        ));
        add(format_args!("leg{i} = {{ guess = {{ position = {length:?} }} }}\n"));
    }
    text
}
