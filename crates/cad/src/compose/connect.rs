//! Joints: their bodies, and their points on each.

use bksim_model::diagnostic::Diagnostic;
use bksim_model::file::suggest;

use super::bodies::{Bodies, Body};
use super::faults::Faults;
use super::names::names;
use super::partners::{Partners, point_of};
use super::points::{NamedPoint, Points};
use super::report::Snap;
use super::snap::snap;
use super::source::Source;
use crate::attachment::{Attachment, Content, Value};
use crate::codes;
use crate::geometry::Point;
use crate::kind::{Placement, Section};

/// The keys that name the points of a joint on its bodies.
const POINT_KEYS: [&str; 2] = ["point1", "point2"];

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
    pub(super) snaps: Vec<Snap>,
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

    let mut snaps = Vec::new();
    let mut connections: Vec<Option<Connection<'a>>> = vec![None; names.len()];
    for joint_idx in order {
        let (attachment, name) = &names[joint_idx];
        let Some((at, pair)) = position(source, bodies, attachment, faults) else { continue };
        let mut end = |end_idx: usize| {
            let (body_idx, at) = (pair[end_idx], at[end_idx]);
            let body = &bodies.list[body_idx];
            if let Some(value) = attachment.value(POINT_KEYS[end_idx]) {
                return stated_end(value, body, points.of(body_idx), faults);
            }
            // A direction may be given anywhere along it: only pins are where bodies have their holes.
            if attachment.kind.placement == Placement::Point {
                snaps.extend(snap(source, attachment, at, body, faults));
            }
            let point = points.name_at(body_idx, name, at, &attachment.location);
            Some(End { point, at })
        };
        let (first, second) = (end(0), end(1));
        connections[joint_idx] = first.zip(second).map(|(first, second)| Connection {
            attachment,
            name: name.clone(),
            bodies: pair,
            points: [first.point, second.point],
            at: [first.at, second.at],
        });
    }
    Connected { connections: connections.into_iter().flatten().collect(), snaps }
}

/// Where a joint is drawn on each of its bodies, and which these are.
fn position(
    source: Source<'_>,
    bodies: &Bodies,
    attachment: &Attachment,
    faults: &mut Faults<'_>,
) -> Option<([Point; 2], [usize; 2])> {
    let at = point_of(attachment, faults)?;
    let at = [at, attachment.to.unwrap_or(at)];
    let pair = Partners { source, bodies }.pair(attachment, at, faults)?;
    Some((at, pair))
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
