//! Quick fixes: the cures of faults as edits.

use std::ops::Range;

use serde_json::{Value, json};

use super::document::Document;
use super::faults::Shown;

/// Longer texts are cut in titles.
const MOST_LETTERS: usize = 60;

/// The cures of the faults that a range of bytes meets.
pub(super) fn of(document: &Document, uri: &str, faults: &[Shown], at: &Range<usize>) -> Value {
    let met =
        faults.iter().filter(|fault| fault.span.start <= at.end && at.start <= fault.span.end);
    let actions = met.flat_map(|fault| {
        fault.cures.iter().enumerate().map(|(i, cure)| {
            let edit = json!({ "range": document.range(&cure.span), "newText": cure.text });
            json!({
                "title": title(&document.text[cure.span.clone()], &cure.text),
                "kind": "quickfix",
                "diagnostics": [fault.json],
                "isPreferred": i == 0,
                "edit": { "changes": { uri: [edit] } },
            })
        })
    });
    actions.collect()
}

/// `Write "1 kg"`, `Remove mass = 1`.
fn title(old: &str, new: &str) -> String {
    let (verb, text) = if new.trim().is_empty() { ("Remove", old) } else { ("Write", new) };
    let line = text.trim().lines().next().unwrap_or_default();
    let cut: String = line.chars().take(MOST_LETTERS).collect();
    let is_whole = cut == text.trim();
    format!("{verb} {cut}{}", if is_whole { "" } else { " …" })
}
