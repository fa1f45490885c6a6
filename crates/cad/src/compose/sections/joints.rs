//! `[joints]`.

use toml_edit::Value;

use super::Mechanism;
use super::number::{clean_angle, direction, number};
use crate::compose::connect::Connection;
use crate::compose::draft::{Draft, array, quantity, written};
use crate::compose::lengths::coordinate;
use crate::compose::report::JointReport;
use crate::geometry::vector::distance;
use crate::kind::Placement;

/// Keys that a model file has, too.
const OWN_KEYS: [&str; 14] = [
    "coordinate",
    "cut",
    "length",
    "curve",
    "radius",
    "side",
    "axis",
    "direction",
    "min",
    "max",
    "restitution",
    "second_curve",
    "tangents",
    "rolling",
];

/// Every joint with its points and its axis in the frame of its first body.
pub(in crate::compose) fn joints(mechanism: &Mechanism<'_>) -> (Draft, Vec<JointReport>) {
    let mut draft = Draft::default();
    let name = |body_idx: usize| &mechanism.bodies.list[body_idx].name;
    for connection in mechanism.connections {
        put_joint(&mut draft, mechanism, connection);
    }
    let report = |connection: &Connection<'_>| JointReport {
        name: connection.name.clone(),
        kind: connection.attachment.kind.name,
        bodies: connection.bodies.map(|body_idx| name(body_idx).clone()),
        at: connection.at,
    };
    (draft, mechanism.connections.iter().map(report).collect())
}

fn put_joint(draft: &mut Draft, mechanism: &Mechanism<'_>, connection: &Connection<'_>) {
    let (source, unit) = (mechanism.source, mechanism.source.unit());
    let Connection { attachment, name, bodies, points, at } = connection;
    let (kind, location) = (attachment.kind, &attachment.location);
    let frames = bodies.map(|body_idx| mechanism.frames[body_idx]);
    let mut put = |key: &str, value: Value| draft.put(["joints", name, key], value, location);

    put("type", Value::from(kind.name));
    let between = [0, 1].map(|end_idx| {
        let body = &mechanism.bodies.list[bodies[end_idx]].name;
        Value::from(format!("{body}.{}", points[end_idx]))
    });
    put("between", array(between.into_iter()));

    // Direction, angle and length as they are drawn.
    if kind.placement == Placement::Frame {
        let axis = frames[0].vector_inward(attachment.axis.unwrap_or([1.0, 0.0]));
        put("axis", array(direction(axis).map(number).into_iter()));
    }
    if ["prismatic", "weld"].contains(&kind.name) {
        let angle = clean_angle(frames[1].angle - frames[0].angle);
        if angle != 0.0 {
            put("angle", quantity(angle, "rad"));
        }
    }
    if kind.name == "link" && attachment.value("length").is_none() {
        let length = source.scale.tidy_length(distance(at[0], at[1]));
        put("length", coordinate(mechanism.lengths.link(name), length, unit.name));
    }

    for value in &attachment.values {
        if OWN_KEYS.contains(&value.key) {
            let written = written(value.key, &value.content, unit);
            draft.put(["joints", name, value.key], written, &value.location);
        }
    }
}
