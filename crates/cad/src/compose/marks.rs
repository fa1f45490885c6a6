//! Named points, stated centres of mass and stated frames.

use std::collections::BTreeMap;

use super::bodies::{Bodies, GROUND};
use super::faults::Faults;
use super::frame::Frame;
use super::partners::{Partners, point_of};
use super::points::{NamedPoint, Points};
use super::source::Source;
use crate::attachment::Attachment;
use crate::drawing::Location;
use crate::geometry::Point;
use crate::kind::Section;

/// Finds the body of every mark: points are returned, centres and frames become the body's.
pub(super) fn marks(source: Source<'_>, bodies: &mut Bodies, faults: &mut Faults<'_>) -> Points {
    let mut points = Points::new(bodies.list.len(), source.scale.rounding);
    for ground in source.attached(Section::Ground) {
        if let (Some(name), Some(at)) = (ground.text("name"), ground.at) {
            points.name_at(GROUND, name, at, &ground.location);
        }
    }

    let mut singles: BTreeMap<(usize, &str), Location> = BTreeMap::new();
    for attachment in source.attachments {
        let section = attachment.kind.section;
        if !matches!(section, Section::Centre | Section::Frames | Section::Points) {
            continue;
        }
        let Some(at) = point_of(attachment, faults) else { continue };
        let partners = Partners { source, bodies };
        let Some(body_idx) = partners.body_at(attachment, "body", at, faults) else { continue };
        if section == Section::Points {
            mark_point(bodies, &mut points, body_idx, attachment, at, faults);
            continue;
        }

        // A body has one centre of mass and one frame.
        let body = &mut bodies.list[body_idx];
        let key = (body_idx, attachment.kind.name);
        if let Some(other) = singles.insert(key, attachment.location.clone()) {
            let message = format!("body `{}` has two {}", body.name, attachment.kind.block);
            let locations = [&attachment.location, &other];
            faults.add_duplicate(&message, "remove one of them", locations);
        } else if section == Section::Centre {
            body.centre = Some(at);
        } else {
            body.frame = Some(Frame::along(at, attachment.axis.unwrap_or([1.0, 0.0])));
        }
    }
    points
}

/// Puts a named point onto a body.
fn mark_point(
    bodies: &Bodies,
    points: &mut Points,
    body_idx: usize,
    attachment: &Attachment,
    at: Point,
    faults: &mut Faults<'_>,
) {
    let Some(name) = attachment.text("name") else {
        return faults.add_nameless("a point", attachment);
    };
    if let Some(other) = points.named(body_idx, name) {
        let message = format!("body `{}` has two points `{name}`", bodies.list[body_idx].name);
        let help = "give each point of a body a name of its own";
        return faults.add_duplicate(&message, help, [&attachment.location, &other.location]);
    }
    let location = attachment.location.clone();
    points.add(body_idx, NamedPoint { name: name.to_owned(), at, location });
}
