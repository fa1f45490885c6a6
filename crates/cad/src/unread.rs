//! Warnings about geometry that was passed over.

use bksim_model::diagnostic::Diagnostic;

use crate::attach::LEGEND_LAYER;
use crate::codes;
use crate::drawing::{Drawing, Entity, Shape, Unread};
use crate::excerpt::Excerpts;

/// Of warnings that are all alike this many are shown.
const SHOWN: usize = 20;

/// One warning for each entity that has geometry and was passed over.
pub(crate) fn unread(drawing: &Drawing, excerpts: &Excerpts<'_>) -> Vec<Diagnostic> {
    let explains = |entity: &&Entity| entity.location.layer.eq_ignore_ascii_case(LEGEND_LAYER);
    let entities = drawing.entities.iter().filter(|entity| !explains(entity));
    let passed_over = entities.filter_map(|entity| match &entity.shape {
        Shape::Unread { why, block } => Some((entity, why, block)),
        _ => None,
    });
    let mut warnings: Vec<Diagnostic> = passed_over
        .map(|(entity, why, block)| {
            let warning = warning(&entity.location.kind, *why, block.as_deref());
            excerpts.at(warning, &entity.location, "")
        })
        .collect();
    let n_more = warnings.len().saturating_sub(SHOWN);
    warnings.truncate(SHOWN);
    if let (Some(last), true) = (warnings.last_mut(), n_more > 0) {
        last.notes.push(format!("{n_more} more entities were passed over"));
    }
    warnings
}

fn warning(kind: &str, why: Unread, block: Option<&str>) -> Diagnostic {
    let what = match block {
        Some(block) => format!("a {kind} of the block `{block}`"),
        None => format!("a {kind}"),
    };
    match why {
        Unread::NoCurve(reason) => {
            let message = format!("{what} makes no curve and was passed over: {reason}");
            let help = "delete it, or let the CAD program mend the drawing (AUDIT, RECOVER)";
            Diagnostic::warning(codes::NO_CURVE, message).help(help)
        }
        Unread::OutOfPlane => {
            let message = format!("{what} does not lie in the plane and was passed over");
            let help =
                "draw it in the plane of the drawing (its extrusion is 0, 0, 1), or delete it";
            Diagnostic::warning(codes::OUT_OF_PLANE, message).help(help)
        }
        Unread::TooMany { limit } => {
            let message = format!("{what} was passed over: {limit}");
            let help = "save what belongs to the mechanism as a drawing of its own";
            Diagnostic::warning(codes::TOO_LARGE, message).help(help)
        }
    }
}
