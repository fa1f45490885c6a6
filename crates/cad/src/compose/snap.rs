//! Points that are taken as one though they are drawn as two, and points that are nearly one.

use bksim_model::diagnostic::Diagnostic;

use super::bodies::Body;
use super::faults::Faults;
use super::report::JointSnap;
use super::source::Source;
use crate::attachment::Attachment;
use crate::codes;
use crate::excerpt::short;
use crate::geometry::Point;
use crate::geometry::vector::distance;

/// Centres this many tolerances away look as if they had been meant.
const NEARLY: f64 = 100.0;

/// The snap of a body onto the point of an attachment, if they are two points; each, and each pair
/// that is nearly one, is reported.
pub(super) fn snap(
    source: Source<'_>,
    attachment: &Attachment,
    at: Point,
    body: &Body,
    faults: &mut Faults<'_>,
) -> Option<JointSnap> {
    let (scale, unit) = (source.scale, source.unit().name);

    // The features of the body near the point, the nearest first.
    let mut near: Vec<(f64, Point)> = body
        .features
        .iter()
        .map(|&feature| (distance(feature, at), feature))
        .filter(|(away, _)| *away <= NEARLY * scale.tolerance)
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    near.dedup_by(|a, b| distance(a.1, b.1) <= scale.rounding);
    let &(away, feature) = near.first()?;
    let (name, title) = (&body.name, attachment.title());
    let [x, y] = at.map(short);
    let [fx, fy] = feature.map(short);

    // None is taken as the point, but a centre nearby may have been meant.
    if away > scale.tolerance {
        if body.has_centre_at(feature, scale.rounding) {
            let message = format!(
                "a centre of `{name}` at ({fx}, {fy}) is {} {unit} away from {title} at ({x}, {y})",
                short(away)
            );
            let help = format!(
                "nothing was moved; move one onto the other, or take them as one point with \
                 `--tolerance {}`",
                short(away * 1.1)
            );
            let fault = Diagnostic::warning(codes::NOT_SNAPPED, message).help(help);
            faults.add(fault, &attachment.location);
        }
        return None;
    }

    // Two could be taken as the point.
    if let Some((next, second)) = near.get(1).filter(|(away, _)| *away <= scale.tolerance) {
        let [sx, sy] = second.map(short);
        let message = format!(
            "two points of `{name}`, ({fx}, {fy}) and ({sx}, {sy}), are within {} {unit} of {title} \
             at ({x}, {y})",
            short(scale.tolerance)
        );
        let help = format!(
            "take a smaller tolerance, `--tolerance {}`, or remove one of the points",
            short(f64::midpoint(away, *next))
        );
        let fault = Diagnostic::error(codes::AMBIGUOUS_SNAP, message).help(help);
        faults.add(fault, &attachment.location);
        return None;
    }

    // One is, though it is drawn elsewhere.
    if away <= scale.rounding {
        return None;
    }
    let message = format!(
        "`{name}` at ({fx}, {fy}) and {title} at ({x}, {y}) are {} {unit} apart: taken as one point",
        short(away)
    );
    let fault = Diagnostic::warning(codes::JOINT_SNAPPED, message).help(apart(away));
    faults.add(fault, &attachment.location);
    Some(JointSnap { what: title, body: name.clone(), from: feature, to: at, distance: away })
}

/// How to keep two points apart.
pub(super) fn apart(distance: f64) -> String {
    let less = short(distance * 0.9);
    format!("draw them at one point; `--tolerance {less}` would keep them apart")
}
