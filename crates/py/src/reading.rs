//! Equations to be read: their notations and parts by the words of Python.

use bksim::Rejected;
use bksim::mbs::equations::page::Style;
use bksim::reading::{Contents, Unreadable};
use bksim_load::Text;

use crate::fault::Fault;

/// The notation of a word.
pub(crate) fn style(word: &str) -> Result<Style, Fault> {
    Ok(match word {
        "text" => Style::Text,
        "aligned" => Style::Aligned { width: 100, unicode: true },
        "latex" => Style::Latex,
        "typst" => Style::Typst,
        "mathml" => Style::MathMl,
        other => {
            let known = "text, aligned, latex, typst and mathml";
            return Err(Fault::Value(format!("{other:?} is none of {known}")));
        }
    })
}

/// Contents with the parts of these names.
pub(crate) fn contents(is_absolute: bool, has_groups: bool, parts: &[String]) -> Contents {
    let has = |name: &str| parts.iter().any(|part| part == name);
    Contents {
        in_absolute_angles: is_absolute,
        has_named_constants: has_groups,
        has_steps: has("steps"),
        has_levels: has("levels"),
        has_free_bodies: has("free_bodies"),
        has_effort: has("effort"),
    }
}

/// The fault of a part that does not exist in the model of this text.
pub(crate) fn fault(source: &Text, why: Unreadable) -> Fault {
    match why {
        Unreadable::Rejected(Rejected(faults)) => Fault::assembly(source, &faults),
        other => Fault::Value(other.to_string()),
    }
}
