//! Joints: their bodies, and their points on each.

use bksim_model::diagnostic::Diagnostic;
use bksim_model::file::suggest;

use super::bodies::{Bodies, Body};
use super::faults::Faults;
use super::names::names;
use super::partners::{Partners, point_of};
use super::points::{NamedPoint, Points};
use super::report::JointSnap;
use super::snap::snap;
use super::source::Source;
use crate::attachment::{Attachment, Content, Value};
use crate::codes;
use crate::geometry::Point;
use crate::kind::{Placement, Section};

/// The keys that name the points of a joint on its bodies.
const POINT_KEYS: [&str; 2] = ["point1", "point2"];

/// Keys of a joint that a pin through more than two bodies cannot have.
const SINGLE_KEYS: [&str; 3] = ["angle", "rate", "coordinate"];

/// A joint of the drawing with its bodies.
#[derive(Clone, Debug)]
pub(super) struct Connection<'a> {
    pub(super) attachment: &'a Attachment,
    pub(super) name: String,
    /// Indices of its bodies, the first one first.
    pub(super) bodies: [usize; 2],
    /// Names of its points on each.
    pub(super) points: [String; 2],
    /// Where it is, on each.
    pub(super) at: [Point; 2],
}

/// The joints of a drawing.
pub(super) struct Connected<'a> {
    /// In the order of the drawing.
    pub(super) connections: Vec<Connection<'a>>,
    /// Points of bodies that were taken as those of joints.
    pub(super) snaps: Vec<JointSnap>,
}

/// One end of a joint: a point of a body and its name there.
struct End {
    point: String,
    at: Point,
}

/// Finds the bodies, names and points of all joints; points that have no name yet are added.
pub(super) fn connect<'a>(
    source: Source<'a>,
    bodies: &Bodies,
    points: &mut Points,
    faults: &mut Faults<'_>,
) -> Connected<'a> {
    let names = names(source, Section::Joints, |_| "J", faults);
    // Joints that name points of others come after those others.
    let names_points =
        |attachment: &Attachment| POINT_KEYS.iter().any(|key| attachment.value(key).is_some());
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by_key(|&joint_idx| names_points(names[joint_idx].0));

    let mut connected = Connecting { source, bodies, points, snaps: Vec::new() };
    let mut connections: Vec<Vec<Connection<'a>>> = vec![Vec::new(); names.len()];
    for joint_idx in order {
        let (attachment, name) = &names[joint_idx];
        let Some(at) = point_of(attachment, faults) else { continue };
        connections[joint_idx] = match (Partners { source, bodies }).pinned(attachment, at, faults)
        {
            Some(pinned) if pinned.len() > 2 => {
                let taken: Vec<&str> = names.iter().map(|(_, name)| name.as_str()).collect();
                connected.pin(attachment, (name, at), &pinned, &taken, faults)
            }
            Some(pair) => connected.joint(attachment, name, ([at; 2], [pair[0], pair[1]]), faults),
            // A list of bodies that is wrong was reported.
            None if attachment.value("bodies").is_some() => Vec::new(),
            None => {
                let at = [at, attachment.to.unwrap_or(at)];
                let pair = Partners { source, bodies }.pair(attachment, at, faults);
                pair.map_or_else(Vec::new, |pair| {
                    connected.joint(attachment, name, (at, pair), faults)
                })
            }
        };
    }
    let snaps = connected.snaps;
    Connected { connections: connections.into_iter().flatten().collect(), snaps }
}

/// The joints that are found, on their way.
struct Connecting<'s, 'p> {
    source: Source<'s>,
    bodies: &'p Bodies,
    points: &'p mut Points,
    snaps: Vec<JointSnap>,
}

impl Connecting<'_, '_> {
    /// A joint between two bodies, drawn at a place on each; none where an end has a fault.
    fn joint<'a>(
        &mut self,
        attachment: &'a Attachment,
        name: &str,
        (at, pair): ([Point; 2], [usize; 2]),
        faults: &mut Faults<'_>,
    ) -> Vec<Connection<'a>> {
        let mut end = |end_idx: usize| {
            let (body_idx, at) = (pair[end_idx], at[end_idx]);
            let body = &self.bodies.list[body_idx];
            if let Some(value) = attachment.value(POINT_KEYS[end_idx]) {
                return stated_end(value, body, self.points.of(body_idx), faults);
            }
            // A direction may be given anywhere along it: only pins are where bodies have their holes.
            if attachment.kind.placement == Placement::Point {
                self.snaps.extend(snap(self.source, attachment, at, body, faults));
            }
            let point = self.points.name_at(body_idx, name, at, &attachment.location);
            Some(End { point, at })
        };
        let (first, second) = (end(0), end(1));
        let joint = first.zip(second).map(|(first, second)| Connection {
            attachment,
            name: name.to_owned(),
            bodies: pair,
            points: [first.point, second.point],
            at: [first.at, second.at],
        });
        joint.into_iter().collect()
    }

    /// A pin through n bodies: n − 1 joints `A_1`, `A_2`, … of the first with each of the others.
    fn pin<'a>(
        &mut self,
        attachment: &'a Attachment,
        (name, at): (&str, Point),
        pinned: &[usize],
        taken: &[&str],
        faults: &mut Faults<'_>,
    ) -> Vec<Connection<'a>> {
        let own: Vec<String> = (1..pinned.len()).map(|number| format!("{name}_{number}")).collect();
        let all = own.join(", ");
        // What a joint has by itself, each of them would have.
        if let Some(value) = SINGLE_KEYS.iter().find_map(|key| attachment.value(key)) {
            let message = format!(
                "joint `{name}` is a pin through {} bodies: `{}` could be that of {all}",
                pinned.len(),
                value.key
            );
            let help = "state a start by BK_INITIAL under the name that is meant; coordinates of a pin \
                        are named by joints of their own, with `body1` and `body2`";
            let fault = Diagnostic::error(codes::AMBIGUOUS_PARTNERS, message).help(help);
            faults.add(fault, &value.location);
            return Vec::new();
        }
        if let Some(used) = own.iter().find(|own| taken.contains(&own.as_str())) {
            let message = format!(
                "joint `{name}` is a pin through {} bodies, the joints {all}, but another joint is \
                 called `{used}`",
                pinned.len()
            );
            let fault =
                Diagnostic::error(codes::DUPLICATE_NAME, message).help("rename one of the two");
            faults.add(fault, &attachment.location);
            return Vec::new();
        }
        let mut joints = Vec::new();
        let mut ends = Vec::new();
        for &body_idx in pinned {
            let body = &self.bodies.list[body_idx];
            self.snaps.extend(snap(self.source, attachment, at, body, faults));
            ends.push(self.points.name_at(body_idx, name, at, &attachment.location));
        }
        for (idx, own) in own.into_iter().enumerate() {
            joints.push(Connection {
                attachment,
                name: own,
                bodies: [pinned[0], pinned[idx + 1]],
                points: [ends[0].clone(), ends[idx + 1].clone()],
                at: [at; 2],
            });
        }
        joints
    }
}

/// The end of a joint at a point of its body that the author names.
fn stated_end(
    value: &Value,
    body: &Body,
    points: &[NamedPoint],
    faults: &mut Faults<'_>,
) -> Option<End> {
    let Content::Text(name) = &value.content else { return None };
    if let Some(point) = points.iter().find(|point| point.name == *name) {
        return Some(End { point: name.clone(), at: point.at });
    }
    let known: Vec<&str> = points.iter().map(|point| point.name.as_str()).collect();
    let message = format!("body `{}` has no point `{name}`", body.name);
    let help = format!("{}; a BK_POINT makes one", suggest(name, &known));
    let fault = Diagnostic::error(codes::UNKNOWN_PARTNER, message).help(help);
    faults.add_labelled(fault, &value.location, "no point has this name");
    None
}
