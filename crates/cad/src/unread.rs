//! Warnings about what is passed over: geometry that cannot be read, and layers that mean nothing.

use std::collections::BTreeMap;

use bksim_model::diagnostic::Diagnostic;
use bksim_model::file::suggest;

use crate::attach::LEGEND_LAYER;
use crate::codes;
use crate::drawing::{Drawing, Entity, Location, Shape, Unread};
use crate::excerpt::Excerpts;
use crate::kind::{BODY_LAYER, CURVE_LAYER, DOCTOR_LAYER, GROUND_LAYER, JOINT_LAYER, KINDS};

/// Layers that begin with this have a meaning.
const OURS: &str = "BK_";

/// Layers of ours without a meaning for the mechanism.
const OTHERS: [&str; 5] = ["BK_MARKS", "BK_LOADS", "BK_SHEET", LEGEND_LAYER, DOCTOR_LAYER];

/// The prefix of the layers of traces.
const TRACE: &str = "BK_TRACE_";

/// Kinds that are for reading only, and show nothing of a mechanism.
const HARMLESS: [&str; 12] = [
    "DIMENSION",
    "LEADER",
    "MULTILEADER",
    "MLEADER",
    "TEXT",
    "MTEXT",
    "ATTDEF",
    "VIEWPORT",
    "TOLERANCE",
    "IMAGE",
    "WIPEOUT",
    "SEQEND",
];

/// One warning for each kind of entity that is not read, with the first of those that are chosen.
pub(crate) fn kinds(
    drawing: &Drawing,
    excerpts: &Excerpts<'_>,
    is_chosen: impl Fn(&Entity) -> bool,
) -> Vec<Diagnostic> {
    let unread = drawing.entities.iter().filter(|it| it.shape == Shape::Other && is_chosen(it));
    let mut kinds: Vec<(&str, usize, &Location)> = Vec::new();
    for entity in unread {
        let kind = entity.location.kind.as_str();
        let is_harmless = HARMLESS.iter().any(|known| kind.to_uppercase().contains(known));
        match kinds.iter_mut().find(|(known, ..)| *known == kind) {
            _ if is_harmless => (),
            Some((_, count, _)) => *count += 1,
            None => kinds.push((kind, 1, &entity.location)),
        }
    }
    let warning = |(kind, count, first): (&str, usize, &Location)| {
        let what = if count == 1 { "entity" } else { "entities" };
        let message = format!("{count} {what} of the kind {kind} cannot be read as geometry");
        let help = "explode what belongs to the mechanism into lines, arcs and polylines";
        excerpts.at(Diagnostic::warning(codes::UNREAD_KIND, message).help(help), first, "")
    };
    kinds.into_iter().map(warning).collect()
}

/// True if a layer is that of a shape of the mechanism: of a body, of the ground, of a curve.
pub(crate) fn is_of_shapes(layer: &str) -> bool {
    let starts =
        |head: &str| layer.get(..head.len()).is_some_and(|it| it.eq_ignore_ascii_case(head));
    [BODY_LAYER, CURVE_LAYER, GROUND_LAYER].into_iter().any(starts)
}

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
    let article = if kind.starts_with(['A', 'E', 'I', 'O']) { "an" } else { "a" };
    let what = match block {
        Some(block) => format!("{article} {kind} of the block `{block}`"),
        None => format!("{article} {kind}"),
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

/// A warning for each layer whose name begins as ours do and means nothing.
pub(crate) fn unknown_layers(drawing: &Drawing, excerpts: &Excerpts<'_>) -> Vec<Diagnostic> {
    let known: Vec<&str> = [GROUND_LAYER, JOINT_LAYER].into_iter().chain(OTHERS).collect();
    let starts = |layer: &str, head: &str| {
        layer.get(..head.len()).is_some_and(|it| it.eq_ignore_ascii_case(head))
    };
    let means_something = |layer: &str| {
        known.iter().any(|it| it.eq_ignore_ascii_case(layer))
            || starts(layer, TRACE)
            || [BODY_LAYER, CURVE_LAYER]
                .iter()
                .any(|head| starts(layer, head) && layer.len() > head.len())
            // Inserts may stand on a layer that is called as their block.
            || KINDS.iter().any(|kind| kind.block.eq_ignore_ascii_case(layer))
    };
    let by_layer = first_by_layer(drawing).into_iter();
    let unknown = by_layer.filter(|(layer, _)| starts(layer, OURS) && !means_something(layer));
    unknown
        .map(|(layer, (_, first))| {
            let message =
                format!("the layer `{layer}` means nothing: what is drawn on it is not read");
            let help = format!(
                "{}; the shape of a body is on a layer BK_BODY_name",
                suggest(&layer.to_uppercase(), &known)
            );
            excerpts.at(Diagnostic::warning(codes::UNKNOWN_LAYER, message).help(help), first, "")
        })
        .collect()
}

/// The number of entities on each layer, and the first of them.
pub(crate) fn first_by_layer(drawing: &Drawing) -> BTreeMap<&str, (usize, &Location)> {
    let mut layers: BTreeMap<&str, (usize, &Location)> = BTreeMap::new();
    for entity in &drawing.entities {
        if matches!(entity.shape, Shape::Text { .. } | Shape::Other) {
            continue;
        }
        let entry = layers.entry(&entity.location.layer).or_insert((0, &entity.location));
        entry.0 += 1;
    }
    layers
}
