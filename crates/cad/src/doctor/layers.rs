//! Layers that are not shown though the mechanism is on them.

use bksim_model::diagnostic::Diagnostic;

use crate::codes;
use crate::excerpt::Excerpts;
use crate::model::Sheet;
use crate::unread::first_by_layer;

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
