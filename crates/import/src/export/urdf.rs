//! A robot as URDF: a tree of links whose frames are at their joints.

use bksim_model::MotionKind;

use crate::draft::number;
use crate::shapes::Solid;
use crate::spatial::{Pose, Rotation, Vector, sub};

use super::parts::{Axis, Connection, Report, Robot};
use super::{Xml, escaped, numbers, rpy};

/// Beyond any limit.
const NO_LIMIT: f64 = 1e15;

/// The text of the file.
pub(super) fn text(robot: &Robot, report: &mut Report) -> String {
    let frames = frames(robot);
    let mut xml = Xml::default();
    xml.open(&format!("robot name=\"{}\"", escaped(&robot.name)));
    // A first link that is fixed to the ground at its own frame stands for the ground.
    let on_ground = |connection: &&Connection| connection.parent == 0 || connection.child == 0;
    let mut grounded = robot.connections.iter().filter(on_ground);
    let first = grounded.next().filter(|only| {
        let pose = robot.links[only.child].pose;
        only.word == "weld"
            && pose.at == [0.0; 3]
            && pose.turn.is_none()
            && robot.links[0].shapes.is_empty()
    });
    let stands_for_ground = first.filter(|_| grounded.next().is_none()).map(|only| only.child);
    // Nor does a robot that moves freely need the ground.
    let is_free = |connection: &&Connection| connection.word == "free";
    let is_afloat = robot.connections.iter().filter(on_ground).all(|of| is_free(&of))
        && robot.connections.iter().filter(is_free).count() == 1;
    let is_left = |link: usize| link == 0 && (is_afloat || stands_for_ground.is_some());
    for (idx, link) in robot.links.iter().enumerate().filter(|(idx, _)| !is_left(*idx)) {
        if link.is_massless() && link.shapes.is_empty() {
            xml.leaf(&format!("link name=\"{}\"", link.name));
            continue;
        }
        xml.open(&format!("link name=\"{}\"", link.name));
        let from = frames[idx];
        if !link.is_massless() {
            xml.open("inertial");
            xml.leaf(&origin(Pose::at(sub(link.inertia.com, from))));
            xml.leaf(&format!("mass value=\"{}\"", number(link.inertia.mass)));
            let keys = ["ixx", "iyy", "izz", "ixy", "iyz", "ixz"].into_iter();
            let of = |(key, value): (&str, f64)| format!(" {key}=\"{}\"", number(value));
            let entries: String = keys.zip(link.inertia.tensor).map(of).collect();
            xml.leaf(&format!("inertia{entries}"));
            xml.close("inertial");
        }
        for (solid, pose) in &link.shapes {
            visual(&mut xml, *solid, Pose { at: sub(pose.at, from), turn: pose.turn });
        }
        xml.close("link");
    }
    for connection in &robot.connections {
        let is_first = Some(connection.child) == stands_for_ground;
        if is_first || (connection.word == "free" && is_left(0)) {
            continue;
        }
        joint(&mut xml, (robot, connection), &frames, report);
    }
    xml.close("robot");
    xml.text
}

/// The origin of each link's frame in that of its body: the point of the joint that carries it, where this turns.
fn frames(robot: &Robot) -> Vec<Vector> {
    let of = |link: &super::parts::Link| {
        let carrier = link.carrier.map(|idx| &robot.connections[idx]);
        let turning = carrier
            .filter(|carrier| carrier.axes.iter().any(|axis| axis.kind == MotionKind::Rotation));
        turning.map_or([0.0; 3], |carrier| {
            let [x, y, z] = link.pose.inverse().apply(carrier.center);
            [x, y, z].map(|c| if c.abs() < 1e-15 { 0.0 } else { c })
        })
    };
    robot.links.iter().map(of).collect()
}

fn origin(pose: Pose) -> String {
    let turn = if pose.turn.is_none() {
        String::new()
    } else {
        format!(" rpy=\"{}\"", numbers(&rpy(pose.turn)))
    };
    format!("origin xyz=\"{}\"{turn}", numbers(&pose.at))
}

fn visual(xml: &mut Xml, solid: Solid, pose: Pose) {
    let shape = match solid {
        Solid::Box { half } => format!("box size=\"{}\"", numbers(&half.map(|side| 2.0 * side))),
        Solid::Cylinder { radius, half } => {
            format!("cylinder radius=\"{}\" length=\"{}\"", number(radius), number(2.0 * half))
        }
        Solid::Sphere { radius } => format!("sphere radius=\"{}\"", number(radius)),
        Solid::Capsule { .. } | Solid::Ellipsoid { .. } => return,
    };
    xml.open("visual");
    xml.leaf(&origin(pose));
    xml.open("geometry");
    xml.leaf(&shape);
    xml.close("geometry");
    xml.close("visual");
}

/// A joint; one of several motions as a chain of links without mass.
fn joint(
    xml: &mut Xml,
    (robot, connection): (&Robot, &Connection),
    frames: &[Vector],
    report: &mut Report,
) {
    let frame = |link: usize| robot.links[link].pose.then(Pose::at(frames[link]));
    let place = frame(connection.parent).inverse().then(frame(connection.child));
    let [parent, child] =
        [connection.parent, connection.child].map(|link| robot.links[link].name.clone());
    let into = frame(connection.child).turn.inverse();
    let n = connection.axes.len();
    if n == 0 {
        let kind = if connection.word == "free" { "floating" } else { "fixed" };
        xml.open(&format!("joint name=\"{}\" type=\"{kind}\"", connection.name));
        ends(xml, place, [&parent, &child]);
        xml.close("joint");
        return;
    }
    let mut before = parent;
    for (idx, axis) in connection.axes.iter().enumerate() {
        let after =
            if idx + 1 < n { format!("{}_{}", connection.name, idx + 1) } else { child.clone() };
        if idx + 1 < n {
            xml.leaf(&format!("link name=\"{after}\""));
        }
        let place = if idx == 0 { place } else { Pose::NONE };
        motion(xml, robot, (axis, into), (place, [&before, &after]));
        if axis.armature != 0.0 {
            report.leave_out(format!("armature of joint {}", axis.name), &connection.span);
        }
        before = after;
    }
}

fn ends(xml: &mut Xml, place: Pose, [parent, child]: [&str; 2]) {
    xml.leaf(&origin(place));
    xml.leaf(&format!("parent link=\"{parent}\""));
    xml.leaf(&format!("child link=\"{child}\""));
}

fn motion(
    xml: &mut Xml,
    robot: &Robot,
    (axis, into): (&Axis, Rotation),
    (place, links): (Pose, [&str; 2]),
) {
    let kind = match (axis.kind, axis.limits) {
        (MotionKind::Translation, _) => "prismatic",
        (MotionKind::Rotation, None) => "continuous",
        (MotionKind::Rotation, Some(_)) => "revolute",
    };
    xml.open(&format!("joint name=\"{}\" type=\"{kind}\"", axis.name));
    ends(xml, place, links);
    xml.leaf(&format!("axis xyz=\"{}\"", numbers(&into.apply(axis.along))));
    if axis.damping != 0.0 || axis.friction != 0.0 {
        let [damping, friction] = [axis.damping, axis.friction].map(number);
        xml.leaf(&format!("dynamics damping=\"{damping}\" friction=\"{friction}\""));
    }
    if kind != "continuous" {
        let [min, max] = axis.limits.unwrap_or_default();
        let [min, max] = [min.unwrap_or(-NO_LIMIT), max.unwrap_or(NO_LIMIT)].map(number);
        let none = number(NO_LIMIT);
        xml.leaf(&format!(
            "limit lower=\"{min}\" upper=\"{max}\" effort=\"{none}\" velocity=\"{none}\""
        ));
    }
    if let Some(mimic) = robot.mimics.iter().find(|mimic| mimic.of == axis.name) {
        let [offset, multiplier, ..] = mimic.coefficients.map(number);
        let by = mimic.by.as_deref().unwrap_or_default();
        xml.leaf(&format!("mimic joint=\"{by}\" multiplier=\"{multiplier}\" offset=\"{offset}\""));
    }
    xml.close("joint");
}
