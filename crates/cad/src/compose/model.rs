//! The parts of a drawing as the text of a model.

use toml_edit::Value;

use super::draft::{Draft, array, point_value, quantity, written};
use super::part::{Frame, find, text_of};
use super::plate::{Weight, factor};
use super::{BodyReport, Composer, JointReport};
use crate::attachment::{Attachment, Content};
use crate::drawing::Location;
use crate::geometry::Point;
use crate::geometry::vector::distance;
use crate::kind::{Placement, Section};

/// Keys of joints that say how the motion starts.
const STARTS: [&str; 4] = ["angle", "rate", "position", "velocity"];

impl Composer<'_> {
    /// Writes everything into the draft, in the order of a model file.
    pub(super) fn write(&mut self) {
        self.write_top();
        self.write_plain(Section::Parameters, "parameters");
        let weights: Vec<Weight> =
            (1..self.parts.len()).map(|part_idx| self.weigh(part_idx)).collect();
        // Loads and joints may still need points of bodies.
        let mut later = Draft::default();
        std::mem::swap(&mut later, &mut self.draft);
        self.write_joints();
        self.write_loads();
        self.write_drives();
        std::mem::swap(&mut later, &mut self.draft);
        self.write_points(0, ["ground", ""]);
        for (part_idx, weight) in (1..self.parts.len()).zip(weights) {
            self.write_body(part_idx, weight);
        }
        for section in ["joints", "loads", "drives", "initial"] {
            if let Some(item) = later.document.remove(section) {
                self.draft.document.insert(section, item);
            }
        }
        self.draft.locations.extend(later.locations);
        self.write_starts();
        self.write_plain(Section::Solve, "solve");
    }

    /// Name, policy of coordinates, and what bare numbers mean.
    fn write_top(&mut self) {
        let unit = self.drawing.unit;
        for attachment in self.attachments.iter().filter(|a| a.kind.section == Section::Model) {
            for value in &attachment.values {
                let written = written("", &value.content, unit);
                if ["name", "coordinates"].contains(&value.key) {
                    self.draft.document.insert(value.key, written.into());
                    self.draft.note(vec![value.key.to_owned()], &value.location);
                } else {
                    self.draft.put(["units", "", value.key], written, &value.location);
                }
            }
        }
    }

    /// Sections that are nothing but keys and values.
    fn write_plain(&mut self, section: Section, name: &str) {
        let unit = self.drawing.unit;
        for attachment in self.attachments.iter().filter(|a| a.kind.section == section) {
            if section == Section::Parameters {
                let Some(parameter) = text_of(attachment, "name") else {
                    self.nameless("a parameter", attachment);
                    continue;
                };
                if let Some(value) = find(&attachment.values, "value") {
                    if let Some(twin) = self.draft.place_of(&[name, parameter]) {
                        let message = format!("two parameters are called `{parameter}`");
                        let help = "give each a name of its own";
                        self.twins(&message, help, [&value.location, &twin]);
                        continue;
                    }
                    let written = written("value", &value.content, unit);
                    self.draft.put([name, "", parameter], written, &value.location);
                }
                continue;
            }
            for value in &attachment.values {
                let written = written(value.key, &value.content, unit);
                self.draft.put([name, "", value.key], written, &value.location);
            }
        }
    }

    fn write_body(&mut self, part_idx: usize, weight: Weight) {
        let part = &self.parts[part_idx];
        let (name, frame) = (part.name.clone(), part.frame.unwrap_or_default());
        let Some(location) = part.location.clone() else { return };
        let values = part.values.clone();
        let unit = self.drawing.unit;
        let stated = |key: &str| find(&values, key);
        let origin = |key: &str| stated(key).map_or(&location, |value| &value.location).clone();
        let mass_key = if stated("mass").is_some() { "mass" } else { "density" };
        let put = |draft: &mut Draft, key: &str, value: Value, location: &Location| {
            draft.put(["bodies", &name, key], value, location);
        };
        let mass = match stated("mass") {
            Some(value) => written("mass", &value.content, unit),
            None => Value::from(weight.mass.as_deref().unwrap_or_default()),
        };
        put(&mut self.draft, "mass", mass, &origin(mass_key));
        let com = self.tidy(frame.point_inward(weight.centre));
        if com != [0.0; 2] {
            put(&mut self.draft, "com", point_value(com, unit), &location);
        }
        if let Some(value) = stated("inertia") {
            let inertia = written("inertia", &value.content, unit);
            let about = self.parts[part_idx].about();
            let inertia = match about.map(|about| &about.content) {
                Some(Content::Text(point)) => {
                    let pairs = [("value", inertia), ("about", Value::from(point.as_str()))];
                    Value::from(pairs.into_iter().collect::<toml_edit::InlineTable>())
                }
                _ => inertia,
            };
            put(&mut self.draft, "inertia", inertia, &value.location);
        } else if let Some(inertia) = &weight.inertia {
            put(&mut self.draft, "inertia", Value::from(inertia.as_str()), &origin(mass_key));
        }
        for key in ["coordinates", "free"] {
            if let Some(value) = stated(key) {
                let written = written(key, &value.content, unit);
                put(&mut self.draft, key, written, &value.location);
            }
        }
        self.write_points(part_idx, ["bodies", &name]);
        self.write_outline(part_idx, frame, &name, &location);
        let part = &self.parts[part_idx];
        self.bodies.push(BodyReport {
            name,
            source: weight.source,
            mass: weight.mass,
            centre: weight.centre,
            area: weight.area,
            frame,
            paths: part.paths.iter().map(|(path, _)| path.clone()).collect(),
            location,
        });
    }

    fn write_points(&mut self, part_idx: usize, owner: [&str; 2]) {
        let part = &self.parts[part_idx];
        let frame = part.frame.unwrap_or_default();
        for point in part.points.clone() {
            let at = point_value(self.tidy(frame.point_inward(point.at)), self.drawing.unit);
            self.draft.point(owner, &point.name, at, &point.location);
        }
    }

    /// The outer outlines as polygons: for pictures only, what they weigh is stated.
    fn write_outline(&mut self, part_idx: usize, frame: Frame, name: &str, location: &Location) {
        let Some(outline) = &self.parts[part_idx].outline else { return };
        let unit = self.drawing.unit;
        let polygons: Vec<Value> = outline
            .loops
            .iter()
            .filter(|part| !part.is_hole)
            .map(|part| part.path.flattened(self.picture_tolerance))
            .filter(|corners| corners.len() > 3)
            .map(|corners| {
                let inward =
                    |corner: &Point| point_value(self.coarse(frame.point_inward(*corner)), unit);
                // The first corner comes again as the last.
                array(corners[1..].iter().map(inward))
            })
            .collect();
        if !polygons.is_empty() {
            let value = array(polygons.into_iter());
            self.draft.put(["bodies", name, "outline"], value, location);
        }
    }

    fn write_joints(&mut self) {
        let unit = self.drawing.unit;
        for connection in self.connections.clone() {
            let attachment = connection.attachment;
            let name = connection.name.as_str();
            let location = &attachment.location;
            let between = [0, 1].map(|end_idx| {
                let body = &self.parts[connection.bodies[end_idx]].name;
                Value::from(format!("{body}.{}", connection.points[end_idx]))
            });
            let frames = connection.bodies.map(|body| self.parts[body].frame.unwrap_or_default());
            let put = |draft: &mut Draft, key: &str, value: Value, location: &Location| {
                draft.put(["joints", name, key], value, location);
            };
            put(&mut self.draft, "type", Value::from(attachment.kind.name), location);
            put(&mut self.draft, "between", array(between.into_iter()), location);
            if attachment.kind.placement == Placement::Frame {
                let axis = frames[0].vector_inward(attachment.axis.unwrap_or([1.0, 0.0]));
                let axis = direction(axis).map(number);
                put(&mut self.draft, "axis", array(axis.into_iter()), location);
            }
            if ["prismatic", "weld"].contains(&attachment.kind.name) {
                let angle = clean_angle(frames[1].angle - frames[0].angle);
                if angle != 0.0 {
                    put(&mut self.draft, "angle", quantity(angle, "rad"), location);
                }
            }
            if attachment.kind.name == "link" && find(&attachment.values, "length").is_none() {
                let [a, b] = connection.at;
                let length = self.tidy([distance(a, b), 0.0])[0];
                put(&mut self.draft, "length", quantity(length, unit.name), location);
            }
            for value in &attachment.values {
                let written = written(value.key, &value.content, unit);
                if STARTS.contains(&value.key) {
                    self.draft.start(name, value.key, written, false, &value.location);
                } else if ["coordinate", "cut", "length"].contains(&value.key) {
                    put(&mut self.draft, value.key, written, &value.location);
                }
            }
            self.joints.push(JointReport {
                name: name.to_owned(),
                kind: attachment.kind.name,
                bodies: connection.bodies.map(|body| self.parts[body].name.clone()),
                at: connection.at,
            });
        }
    }

    fn write_loads(&mut self) {
        let names = self.names(Section::Loads, |attachment| attachment.kind.name.to_owned());
        for (attachment, name) in names {
            let kind = match attachment.kind.name {
                "actuator" => "force",
                kind => kind,
            };
            let location = &attachment.location;
            self.draft.put(["loads", &name, "type"], Value::from(kind), location);
            match attachment.kind.name {
                "gravity" => self.write_gravity(attachment, &name),
                "force" => self.write_force(attachment, &name),
                "torque" => self.write_torque(attachment, &name),
                "actuator" | "spring" | "damper" => self.write_between(attachment, &name),
                _ => self.write_at_joint(attachment, "loads", &name),
            }
        }
    }

    fn write_gravity(&mut self, attachment: &Attachment, name: &str) {
        let Some(value) = find(&attachment.values, "acceleration") else { return };
        let location = &value.location;
        let acceleration = match written("acceleration", &value.content, self.drawing.unit) {
            Value::Array(vector) => Value::Array(vector),
            _ => {
                along(&self.text(value, "m/s^2"), direction(attachment.axis.unwrap_or([0.0, -1.0])))
            }
        };
        self.draft.put(["loads", name, "acceleration"], acceleration, location);
    }

    fn write_force(&mut self, attachment: &Attachment, name: &str) {
        let Some(at) = self.point_of(attachment) else { return };
        let Some(body) = self.body_at(attachment, "body", at) else { return };
        let location = &attachment.location;
        let wish = text_of(attachment, "point").unwrap_or(name).to_owned();
        let anchor = self.anchor(body, &wish, at, location);
        self.draft.put(["loads", name, "on"], Value::from(anchor), location);
        let unit = self.drawing.unit;
        if let Some(axes) = find(&attachment.values, "axes") {
            let written = written("axes", &axes.content, unit);
            self.draft.put(["loads", name, "axes"], written, &axes.location);
        }
        if let Some(vector) = find(&attachment.values, "vector") {
            let written = written("vector", &vector.content, unit);
            self.draft.put(["loads", name, "vector"], written, &vector.location);
        } else if let Some(value) = find(&attachment.values, "value") {
            let axis = attachment.axis.unwrap_or([1.0, 0.0]);
            let axis = match text_of(attachment, "axes") {
                Some("body") => self.parts[body].frame.unwrap_or_default().vector_inward(axis),
                _ => axis,
            };
            let vector = along(&self.text(value, "N"), direction(axis));
            self.draft.put(["loads", name, "vector"], vector, &value.location);
        }
    }

    fn write_torque(&mut self, attachment: &Attachment, name: &str) {
        if find(&attachment.values, "body").is_none() {
            return self.write_at_joint(attachment, "loads", name);
        }
        let at = attachment.at.unwrap_or_default();
        let Some(body) = self.body_at(attachment, "body", at) else { return };
        let on = Value::from(self.parts[body].name.as_str());
        self.draft.put(["loads", name, "on"], on, &attachment.location);
        self.write_values(attachment, "loads", name, &["body"]);
    }

    fn write_between(&mut self, attachment: &Attachment, name: &str) {
        let Some(at) = self.point_of(attachment) else { return };
        let ends = [at, attachment.to.unwrap_or(at)];
        let Some(bodies) = self.partners(attachment, ends) else { return };
        let location = &attachment.location;
        let anchors = [0, 1].map(|end_idx| {
            let wish =
                text_of(attachment, ["point1", "point2"][end_idx]).unwrap_or(name).to_owned();
            Value::from(self.anchor(bodies[end_idx], &wish, ends[end_idx], location))
        });
        self.draft.put(["loads", name, "between"], array(anchors.into_iter()), location);
        if attachment.kind.name == "spring" && find(&attachment.values, "length").is_none() {
            let length = self.tidy([distance(ends[0], ends[1]), 0.0])[0];
            let length = quantity(length, self.drawing.unit.name);
            self.draft.put(["loads", name, "length"], length, location);
        }
        self.write_values(attachment, "loads", name, &["body1", "body2", "point1", "point2"]);
    }

    /// What acts in a joint: its name, then the other keys as they are.
    fn write_at_joint(&mut self, attachment: &Attachment, section: &str, name: &str) {
        let Some(joint) = self.joint_of(attachment) else { return };
        let stated = find(&attachment.values, "joint");
        let location = stated.map_or(&attachment.location, |value| &value.location);
        self.draft.put([section, name, "joint"], Value::from(joint), location);
        self.write_values(attachment, section, name, &["joint"]);
    }

    fn write_values(&mut self, attachment: &Attachment, section: &str, name: &str, but: &[&str]) {
        for value in &attachment.values {
            if value.key != "name" && !but.contains(&value.key) {
                let written = written(value.key, &value.content, self.drawing.unit);
                self.draft.put([section, name, value.key], written, &value.location);
            }
        }
    }

    fn write_drives(&mut self) {
        for (attachment, name) in self.names(Section::Drives, |_| "drive".to_owned()) {
            self.write_at_joint(attachment, "drives", &name);
        }
    }

    /// A body's point as a model file names it; a point of the wished name comes first.
    fn anchor(&mut self, body: usize, wish: &str, at: Point, location: &Location) -> String {
        let step = self.step;
        let part = &mut self.parts[body];
        let known = part.points.iter().any(|point| point.name == wish);
        let stated = if known { wish.to_owned() } else { part.point(wish, at, location, step) };
        let is_there =
            part.points.iter().any(|point| point.name == stated && distance(point.at, at) <= step);
        let point = if is_there { stated } else { part.point(wish, at, location, step) };
        format!("{}.{point}", part.name)
    }

    /// Stated starts, and the drawn pose as the guess of every body.
    fn write_starts(&mut self) {
        let unit = self.drawing.unit;
        for attachment in self.attachments.iter().filter(|a| a.kind.section == Section::Initial) {
            let Some(name) = text_of(attachment, "name") else {
                self.nameless("a start", attachment);
                continue;
            };
            let guess = text_of(attachment, "guess").unwrap_or_default();
            let is_guess = written("guess", &Content::Text(guess.to_owned()), unit).as_bool();
            for value in attachment.values.iter().filter(|v| !["name", "guess"].contains(&v.key)) {
                let written = written(value.key, &value.content, unit);
                self.draft.start(name, value.key, written, is_guess == Some(true), &value.location);
            }
        }
        for body in self.bodies.clone() {
            let [x, y] = self.tidy(body.centre);
            let angle = clean_angle(body.frame.angle);
            let pose = [("x", quantity(x, unit.name)), ("y", quantity(y, unit.name))];
            let pose = pose.into_iter().chain([("angle", quantity(angle, "rad"))]);
            for (key, value) in pose {
                if !self.draft.has_start(&body.name, key) {
                    self.draft.start(&body.name, key, value, true, &body.location);
                }
            }
        }
    }
}

/// A unit vector; what rounding left of a zero is one.
fn direction([x, y]: Point) -> Point {
    let length = x.hypot(y);
    if length == 0.0 {
        return [1.0, 0.0];
    }
    [x / length, y / length].map(clean)
}

/// Sine and cosine of right angles are whole.
fn clean(x: f64) -> f64 {
    const ROUNDING: f64 = 4.0 * f64::EPSILON;
    if (x - x.round()).abs() < ROUNDING { x.round() + 0.0 } else { x }
}

fn clean_angle(angle: f64) -> f64 {
    if angle.abs() < 4.0 * f64::EPSILON { 0.0 } else { angle }
}

/// A number; whole ones without a point.
fn number(x: f64) -> Value {
    x.to_string().parse().unwrap_or_else(|_| Value::from(x))
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
