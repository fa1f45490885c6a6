//! Layers: those that are not shown though the mechanism is on them, and those that nearly mean something.

use std::collections::BTreeMap;

use bksim_model::diagnostic::Diagnostic;
use bksim_model::file::suggest;

use super::DOCTOR_LAYER;
use crate::attach::LEGEND_LAYER;
use crate::codes;
use crate::drawing::{Drawing, Location, Shape};
use crate::excerpt::Excerpts;
use crate::kind::{BODY_LAYER, CURVE_LAYER, GROUND_LAYER, JOINT_LAYER, KINDS};
use crate::model::Sheet;

/// Layers that begin with this have a meaning.
const OURS: &str = "BK_";

/// Layers of ours without a meaning for the mechanism.
const OTHERS: [&str; 5] = ["BK_MARKS", "BK_LOADS", "BK_SHEET", LEGEND_LAYER, DOCTOR_LAYER];

/// The prefix of the layers of traces.
const TRACE: &str = "BK_TRACE_";

/// A warning for each layer that is off or frozen and has geometry or something attached.
pub(super) fn hidden(sheet: &Sheet, excerpts: &Excerpts<'_>) -> Vec<Diagnostic> {
    let by_layer = first_by_layer(&sheet.drawing);
    let is_hidden =
        |layer: &str| sheet.hidden_layers.iter().any(|it| it.eq_ignore_ascii_case(layer));
    let hidden = by_layer.into_iter().filter(|(layer, _)| is_hidden(layer));
    hidden
        .map(|(layer, (count, first))| {
            let what = if count == 1 { "entity" } else { "entities" };
            let message = format!("the layer `{layer}` is not shown, but read: {count} {what}");
            let help = "show the layer and look, or delete what does not belong to the mechanism";
            excerpts.at(Diagnostic::warning(codes::HIDDEN_LAYER, message).help(help), first, "")
        })
        .collect()
}

/// A warning for each layer whose name begins as ours do and means nothing.
pub(super) fn unknown(drawing: &Drawing, excerpts: &Excerpts<'_>) -> Vec<Diagnostic> {
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
fn first_by_layer(drawing: &Drawing) -> BTreeMap<&str, (usize, &Location)> {
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
