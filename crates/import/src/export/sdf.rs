//! A robot as SDF: links at their places, joints between any of them.

use bksim_model::MotionKind;

use crate::draft::number;
use crate::shapes::Solid;
use crate::spatial::Pose;

use super::parts::{Axis, Connection, Link, Report, Robot};
use super::{Xml, escaped, numbers, rpy};

/// The text of the file.
pub(super) fn text(robot: &Robot, report: &mut Report) -> String {
    let mut xml = Xml::default();
    xml.open("sdf version=\"1.11\"");
    // Gravity is that of a world; a model alone falls with the usual one.
    let has_world = robot.gravity != crate::urdf::GRAVITY;
    if has_world {
        xml.open("world name=\"world\"");
        xml.text("gravity", &numbers(&robot.gravity));
    }
    xml.open(&format!("model name=\"{}\"", escaped(&robot.name)));
    for (idx, link) in robot.links.iter().enumerate().skip(1) {
        self::link(&mut xml, link);
        robot.warn_of_inertia(idx, report);
    }
    for connection in robot.connections.iter().filter(|connection| connection.word != "free") {
        joint(&mut xml, robot, connection, report);
    }
    xml.close("model");
    if has_world {
        xml.close("world");
    }
    xml.close("sdf");
    xml.text
}

fn pose(xml: &mut Xml, pose: Pose) {
    if pose != Pose::NONE {
        let [roll, pitch, yaw] = if pose.turn.is_none() { [0.0; 3] } else { rpy(pose.turn) };
        xml.text("pose", &format!("{} {}", numbers(&pose.at), numbers(&[roll, pitch, yaw])));
    }
}

fn link(xml: &mut Xml, link: &Link) {
    xml.open(&format!("link name=\"{}\"", link.name));
    pose(xml, link.pose);
    xml.open("inertial");
    pose(xml, Pose::at(link.inertia.com));
    xml.text("mass", &number(link.inertia.mass));
    xml.open("inertia");
    let keys = ["ixx", "iyy", "izz", "ixy", "iyz", "ixz"];
    keys.into_iter()
        .zip(link.inertia.tensor)
        .for_each(|(key, value)| xml.text(key, &number(value)));
    xml.close("inertia");
    xml.close("inertial");
    for (idx, (solid, place)) in link.shapes.iter().enumerate() {
        let (kind, sizes) = match *solid {
            Solid::Box { half } => ("box", vec![("size", numbers(&half.map(|side| 2.0 * side)))]),
            Solid::Cylinder { radius, half } => {
                ("cylinder", vec![("radius", number(radius)), ("length", number(2.0 * half))])
            }
            Solid::Sphere { radius } => ("sphere", vec![("radius", number(radius))]),
            Solid::Capsule { .. } | Solid::Ellipsoid { .. } => continue,
        };
        xml.open(&format!("visual name=\"shape_{}\"", idx + 1));
        pose(xml, *place);
        xml.open("geometry");
        xml.open(kind);
        for (key, value) in &sizes {
            xml.text(key, value);
        }
        xml.close(kind);
        xml.close("geometry");
        xml.close("visual");
    }
    xml.close("link");
}

fn joint(xml: &mut Xml, robot: &Robot, connection: &Connection, report: &mut Report) {
    let kind = match connection.word {
        "revolute" if connection.axes.iter().all(|axis| axis.limits.is_none()) => "continuous",
        "weld" => "fixed",
        "spherical" => "ball",
        word => word,
    };
    let (parent, child) = (&robot.links[connection.parent], &robot.links[connection.child]);
    xml.open(&format!("joint name=\"{}\" type=\"{kind}\"", connection.name));
    xml.text("parent", &parent.name);
    xml.text("child", &child.name);
    pose(xml, Pose::at(child.pose.inverse().apply(connection.center)));
    if let Some(lead) = connection.lead {
        xml.text("screw_thread_pitch", &number(lead));
    }
    for (axis, tag) in connection.axes.iter().zip(["axis", "axis2"]) {
        motion(xml, robot, axis, (tag, child.pose));
        if axis.armature != 0.0 {
            report.leave_out(format!("armature of joint {}", axis.name), &connection.span);
        }
    }
    xml.close("joint");
}

/// Values count from the reference pose.
fn motion(xml: &mut Xml, robot: &Robot, axis: &Axis, (tag, child): (&str, Pose)) {
    xml.open(tag);
    xml.text("xyz", &numbers(&child.turn.inverse().apply(axis.along)));
    if let Some(limits) = axis.limits {
        xml.open("limit");
        for (key, limit) in ["lower", "upper"].into_iter().zip(limits) {
            if let Some(limit) = limit {
                xml.text(key, &number(limit - axis.at));
            }
        }
        xml.close("limit");
    } else if axis.kind == MotionKind::Translation {
        xml.leaf("limit");
    }
    let springs = [
        ("spring_reference", axis.rest - axis.at, axis.stiffness),
        ("spring_stiffness", axis.stiffness, axis.stiffness),
        ("damping", axis.damping, axis.damping),
        ("friction", axis.friction, axis.friction),
    ];
    if springs.iter().any(|(.., decides)| *decides != 0.0) {
        xml.open("dynamics");
        for (key, value, _) in springs.iter().filter(|(.., decides)| *decides != 0.0) {
            xml.text(key, &number(*value));
        }
        xml.close("dynamics");
    }
    if let Some(mimic) = robot.mimics.iter().find(|mimic| mimic.of == axis.name) {
        let by = mimic.by.as_deref().unwrap_or_default();
        let mut axes = robot.connections.iter().flat_map(|connection| {
            connection
                .axes
                .iter()
                .zip(["axis", "axis2"])
                .map(move |(axis, tag)| (connection, axis, tag))
        });
        if let Some((leader, of, its_tag)) = axes.find(|(_, axis, _)| axis.name == by) {
            let [offset, multiplier, ..] = mimic.about([axis.at, of.at]);
            xml.open(&format!("mimic joint=\"{}\" axis=\"{its_tag}\"", leader.name));
            xml.text("multiplier", &number(multiplier));
            xml.text("offset", &number(offset));
            xml.text("reference", "0");
            xml.close("mimic");
        }
    }
    xml.close(tag);
}
