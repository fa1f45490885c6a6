//! Joints: their bodies, their points, and the frames that follow from them.

use bksim_mbs::diagnostic::Diagnostic;
use bksim_mbs::file::suggest;

use super::part::{Frame, find, text_of};
use super::{Composer, title};
use crate::attachment::{Attachment, Content};
use crate::codes;
use crate::excerpt::short;
use crate::geometry::Point;
use crate::geometry::vector::distance;
use crate::kind::{Placement, Section};

/// A joint of the drawing with its bodies.
#[derive(Clone, Debug)]
pub(super) struct Connection<'a> {
    pub(super) attachment: &'a Attachment,
    pub(super) name: String,
    /// Numbers of its bodies, the first one first.
    pub(super) bodies: [usize; 2],
    /// Names of its points on each.
    pub(super) points: [String; 2],
    /// Where it is, on each.
    pub(super) at: [Point; 2],
}

impl Composer<'_> {
    /// Finds bodies, names and points of all joints.
    pub(super) fn connect(&mut self) {
        let names = self.names(Section::Joints, |_| "J".to_owned());
        let mut connections: Vec<Option<Connection<'_>>> = names.iter().map(|_| None).collect();
        // Joints that name points of others come after those others.
        let names_points = |attachment: &Attachment| {
            ["point1", "point2"].iter().any(|key| find(&attachment.values, key).is_some())
        };
        for comes_after in [false, true] {
            for ((attachment, name), slot) in names.iter().zip(&mut connections) {
                if names_points(attachment) == comes_after {
                    *slot = self.connection(attachment, name);
                }
            }
        }
        self.connections = connections.into_iter().flatten().collect();
    }

    fn connection<'a>(&mut self, attachment: &'a Attachment, name: &str) -> Option<Connection<'a>> {
        let at = self.point_of(attachment)?;
        let at = [at, attachment.to.unwrap_or(at)];
        let bodies = self.partners(attachment, at)?;
        let points = [String::new(), String::new()];
        let mut connection = Connection { attachment, name: name.to_owned(), bodies, points, at };
        let ends = [0, 1].map(|end_idx| self.place_end(&mut connection, end_idx));
        (ends == [true; 2]).then_some(connection)
    }

    /// Puts one end of a joint onto its body: a named point of it, or a new one.
    fn place_end(&mut self, connection: &mut Connection<'_>, end_idx: usize) -> bool {
        let Connection { attachment, bodies, .. } = *connection;
        let body_idx = bodies[end_idx];
        let key = ["point1", "point2"][end_idx];
        if let Some(value) = find(&attachment.values, key) {
            let Content::Text(name) = &value.content else { return false };
            let points = &self.parts[body_idx].points;
            if let Some(point) = points.iter().find(|point| point.name == *name) {
                connection.at[end_idx] = point.at;
                connection.points[end_idx].clone_from(name);
                return true;
            }
            let known: Vec<&str> = points.iter().map(|point| point.name.as_str()).collect();
            let body = &self.parts[body_idx].name;
            let message = format!("body `{body}` has no point `{name}`");
            let help = format!("{}; a BK_POINT makes one", suggest(name, &known));
            let fault = Diagnostic::error(codes::UNKNOWN_PARTNER, message).help(help);
            self.fault_at(fault, &value.location, "no point has this name");
            return false;
        }
        let at = connection.at[end_idx];
        // A direction may be given anywhere along it: only pins are where bodies have their holes.
        if attachment.kind.placement == Placement::Point {
            self.snap(attachment, at, body_idx);
        }
        let step = self.step;
        let part = &mut self.parts[body_idx];
        connection.points[end_idx] = part.point(&connection.name, at, &attachment.location, step);
        true
    }

    /// Chooses a frame for every body without one: from its first pin, one with the ground if there
    /// is one, along its slide on the ground, else towards its next pin.
    pub(super) fn choose_frames(&mut self) {
        self.parts[0].frame = Some(Frame::default());
        for part_idx in 1..self.parts.len() {
            if self.parts[part_idx].frame.is_none() {
                self.parts[part_idx].frame = Some(self.natural_frame(part_idx));
            }
        }
    }

    fn natural_frame(&self, part_idx: usize) -> Frame {
        let mut pins: Vec<(bool, Point)> = Vec::new();
        let mut slides: Vec<(Point, Option<Point>)> = Vec::new();
        for connection in &self.connections {
            for end_idx in 0..2 {
                let other = connection.bodies[1 - end_idx];
                if connection.bodies[end_idx] != part_idx {
                    continue;
                }
                let at = connection.at[end_idx];
                match (connection.attachment.kind.name, end_idx) {
                    ("prismatic", _) => {
                        let axis = connection.attachment.axis.filter(|_| other == 0);
                        slides.push((at, axis));
                    }
                    // Of a slot, the first body has the slot and the second the pin.
                    ("slot", 0) => slides.push((at, None)),
                    _ => pins.push((other != 0, at)),
                }
            }
        }
        // The sort is stable: within the two groups the order is that of the drawing.
        pins.sort_by_key(|(is_inner, _)| *is_inner);
        let pins: Vec<Point> = pins.into_iter().map(|(_, at)| at).collect();
        let origin = pins.first().or(slides.first().map(|(at, _)| at)).copied();
        let origin = origin.unwrap_or_default();
        let next = pins.iter().find(|at| distance(**at, origin) > self.tolerance);
        let towards = next.map(|next| [next[0] - origin[0], next[1] - origin[1]]);
        let slide = slides.iter().find_map(|(_, axis)| *axis);
        match slide.or(towards) {
            Some(axis) => Frame::along(origin, axis),
            None => Frame { origin, angle: 0.0 },
        }
    }

    /// The joint that a key names, or that is at the point of the attachment.
    pub(super) fn joint_of(&mut self, attachment: &Attachment) -> Option<String> {
        if let Some(name) = text_of(attachment, "joint") {
            return Some(name.to_owned());
        }
        let at = self.point_of(attachment)?;
        let is_there =
            |connection: &&Connection<'_>| distance(connection.at[0], at) <= self.tolerance;
        let found: Vec<&str> =
            self.connections.iter().filter(is_there).map(|c| c.name.as_str()).collect();
        if let [one] = found.as_slice() {
            return Some((*one).to_owned());
        }
        let [x, y] = at.map(short);
        let message = match found.as_slice() {
            [] => format!("{} at ({x}, {y}) is at no joint", title(attachment)),
            many => format!(
                "{} at ({x}, {y}) is at {} joints: {}",
                title(attachment),
                many.len(),
                many.join(", ")
            ),
        };
        let fault = Diagnostic::error(codes::NO_JOINT_THERE, message)
            .help("move it onto its joint, or name the joint: `joint=…`");
        self.fault(fault, &attachment.location);
        None
    }
}
