//! `[loads]` and `[drives]`.

use toml_edit::Value;

use super::Mechanism;
use super::number::direction;
use crate::attachment::Attachment;
use crate::compose::draft::{Draft, array, quantity, written};
use crate::compose::faults::Faults;
use crate::compose::names::names;
use crate::compose::partners::{Partners, point_of};
use crate::compose::points::Points;
use crate::compose::units::Quantity;
use crate::compose::weigh::factor;
use crate::drawing::Location;
use crate::geometry::Point;
use crate::geometry::vector::distance;
use crate::kind::Section;

/// Every load; those that pull at bodies put points onto them.
pub(in crate::compose) fn loads(
    mechanism: &Mechanism<'_>,
    points: &mut Points,
    faults: &mut Faults<'_>,
) -> Draft {
    let names = names(mechanism.source, Section::Loads, |it| it.kind.name, faults);
    let mut draft = Draft::default();
    for (attachment, name) in &names {
        let kind = match attachment.kind.name {
            "actuator" => "force",
            kind => kind,
        };
        draft.put(["loads", name, "type"], Value::from(kind), &attachment.location);
        let mut load = Load { mechanism, attachment, name, draft: &mut draft };
        match attachment.kind.name {
            "gravity" => load.put_gravity(),
            // Along the motion of a joint in place of between two points.
            "force" | "spring" | "damper" if attachment.value("joint").is_some() => {
                load.put_at_joint("loads", faults);
            }
            // Between the teeth of a coupling.
            "friction" if attachment.value("coupling").is_some() => load.put_values("loads", &[]),
            "force" => load.put_force(points, faults),
            "torque" => load.put_torque(faults),
            "actuator" | "spring" | "damper" => load.put_between(points, faults),
            _ => load.put_at_joint("loads", faults),
        }
    }
    draft
}

/// Every drive.
pub(in crate::compose) fn drives(mechanism: &Mechanism<'_>, faults: &mut Faults<'_>) -> Draft {
    let names = names(mechanism.source, Section::Drives, |_| "drive", faults);
    let mut draft = Draft::default();
    for (attachment, name) in &names {
        let mut drive = Load { mechanism, attachment, name, draft: &mut draft };
        drive.put_at_joint("drives", faults);
    }
    draft
}

/// A load or a drive on its way into the text.
struct Load<'a> {
    mechanism: &'a Mechanism<'a>,
    attachment: &'a Attachment,
    name: &'a str,
    draft: &'a mut Draft,
}

impl Load<'_> {
    fn put(&mut self, key: &str, value: Value, location: &Location) {
        self.draft.put(["loads", self.name, key], value, location);
    }

    fn partners(&self) -> Partners<'_> {
        Partners { source: self.mechanism.source, bodies: self.mechanism.bodies }
    }

    fn put_gravity(&mut self) {
        let attachment = self.attachment;
        let Some(value) = attachment.value("acceleration") else { return };
        let unit = self.mechanism.source.unit();
        let stated = written("acceleration", &value.content, unit);
        let acceleration = if stated.is_array() {
            stated
        } else {
            let text = self.mechanism.units.text(value, Quantity::Acceleration);
            along(&text, direction(attachment.axis.unwrap_or([0.0, -1.0])))
        };
        self.put("acceleration", acceleration, &value.location);
    }

    fn put_force(&mut self, points: &mut Points, faults: &mut Faults<'_>) {
        let (mechanism, attachment) = (self.mechanism, self.attachment);
        let unit = mechanism.source.unit();
        let Some(at) = point_of(attachment, faults) else { return };
        let Some(body_idx) = self.partners().body_at(attachment, "body", at, faults) else {
            return;
        };
        let anchor = self.anchor(points, body_idx, "point", at);
        self.put("on", anchor, &attachment.location);
        if let Some(axes) = attachment.value("axes") {
            self.put("axes", written("axes", &axes.content, unit), &axes.location);
        }

        // The force as a vector, or as a size along the drawn direction.
        if let Some(vector) = attachment.value("vector") {
            self.put("vector", written("vector", &vector.content, unit), &vector.location);
        } else if let Some(value) = attachment.value("value") {
            let axis = attachment.axis.unwrap_or([1.0, 0.0]);
            let axis = match attachment.text("axes") {
                Some("body") => mechanism.frames[body_idx].vector_inward(axis),
                _ => axis,
            };
            let text = mechanism.units.text(value, Quantity::Force);
            self.put("vector", along(&text, direction(axis)), &value.location);
        }
    }

    fn put_torque(&mut self, faults: &mut Faults<'_>) {
        let attachment = self.attachment;
        let Some(body) = attachment.value("body") else {
            return self.put_at_joint("loads", faults);
        };
        let Some(body_idx) = self.partners().named(body, faults) else { return };
        let on = Value::from(self.mechanism.bodies.list[body_idx].name.as_str());
        self.put("on", on, &attachment.location);
        self.put_values("loads", &["body"]);
    }

    /// A force between two points: an actuator, a spring or a damper.
    fn put_between(&mut self, points: &mut Points, faults: &mut Faults<'_>) {
        let (source, attachment) = (self.mechanism.source, self.attachment);
        let location = &attachment.location;
        let Some(at) = point_of(attachment, faults) else { return };
        let ends = [at, attachment.to.unwrap_or(at)];
        let Some(bodies) = self.partners().pair(attachment, ends, faults) else { return };
        let first = self.anchor(points, bodies[0], "point1", ends[0]);
        let second = self.anchor(points, bodies[1], "point2", ends[1]);
        self.put("between", array([first, second].into_iter()), location);
        if attachment.kind.name == "spring" && attachment.value("length").is_none() {
            let length = source.scale.tidy_length(distance(ends[0], ends[1]));
            self.put("length", quantity(length, source.unit().name), location);
        }
        self.put_values("loads", &["body1", "body2", "point1", "point2"]);
    }

    /// A load or a drive in a joint: the name of the joint, then the other keys as they are.
    fn put_at_joint(&mut self, section: &str, faults: &mut Faults<'_>) {
        let Some(joint) = self.joint(faults) else { return };
        let stated = self.attachment.value("joint");
        let location = stated.map_or(&self.attachment.location, |value| &value.location);
        self.draft.put([section, self.name, "joint"], Value::from(joint), location);
        self.put_values(section, &["joint"]);
    }

    /// The values of all keys but some, as they are.
    fn put_values(&mut self, section: &str, but: &[&str]) {
        for value in &self.attachment.values {
            if value.key != "name" && !but.contains(&value.key) {
                let written = written(value.key, &value.content, self.mechanism.source.unit());
                self.draft.put([section, self.name, value.key], written, &value.location);
            }
        }
    }

    /// A body's point as a model file names it; `key` may name the point, else it is called as the load.
    fn anchor(&self, points: &mut Points, body_idx: usize, key: &str, at: Point) -> Value {
        let name = self.attachment.text(key).unwrap_or(self.name);
        let point = points.name_of(body_idx, name, at, &self.attachment.location);
        Value::from(format!("{}.{point}", self.mechanism.bodies.list[body_idx].name))
    }

    /// The joint that a key names, or that is at the point of the attachment.
    fn joint(&self, faults: &mut Faults<'_>) -> Option<String> {
        let (mechanism, attachment) = (self.mechanism, self.attachment);
        if let Some(name) = attachment.text("joint") {
            return Some(name.to_owned());
        }
        let at = point_of(attachment, faults)?;
        mechanism.joint_at(attachment, at, "joint", faults)
    }
}

/// A vector of the size that a text says along a direction.
fn along(text: &str, direction: Point) -> Value {
    array(direction.into_iter().map(|cosine| match cosine {
        0.0 => Value::from(0),
        1.0 => Value::from(text),
        -1.0 => Value::from(format!("-{}", factor(text))),
        cosine => Value::from(format!("{}*({cosine})", factor(text))),
    }))
}
