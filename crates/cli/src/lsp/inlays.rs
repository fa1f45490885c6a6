//! Values beside expressions, for an editor to show in the text.

use std::ops::Range;

use bksim::edit::scan::{Place, places};
use bksim::expr::function_names;
use bksim::model::Model;
use bksim::model::file::{Limits, Source, names_in, read};
use serde_json::{Value, json};

use super::document::Document;
use super::faults::judge;
use super::hover::value_of;
use super::names::defined;

/// Sections whose values, besides parameters, are constant where they use parameters alone.
const CONSTANT: [&str; 8] =
    ["ground", "bodies", "joints", "couplings", "curves", "loads", "initial", "solve"];

/// The values of expressions in a range of bytes, each behind its text: `= 0.25 m`.
pub(super) fn of(document: &Document, within: &Range<usize>, nesting: usize) -> Value {
    let text = &document.text;
    let parameters: Vec<String> = defined(text)
        .into_iter()
        .filter(|known| known.section == "parameters")
        .map(|known| known.name)
        .collect();
    let is_parameter = |name: &str| parameters.iter().any(|known| known == name);
    let is_function = |name: &str| name == "pi" || function_names().any(|known| known == name);
    let all = places(text);
    let expressions: Vec<(&Place, String)> = all
        .iter()
        .filter(|place| place.span.start < within.end && within.start < place.span.end)
        .filter_map(|place| {
            let quoted = &text[place.inside(text)?];
            let names: Vec<&str> =
                names_in(quoted, &is_parameter).into_iter().map(|at| &quoted[at]).collect();
            let is_own = names.iter().any(|name| is_parameter(name));
            let is_constant = names.iter().all(|name| is_parameter(name) || is_function(name));
            // A name alone in a place for names is none of a parameter.
            let is_name = place.path.last().is_some_and(|key| {
                ["on", "joint", "curve", "coordinate", "type", "clock", "carrier"]
                    .contains(&key.as_str())
            });
            (is_own && is_constant && !is_name).then(|| (place, place.path.join(".")))
        })
        .collect();
    if expressions.is_empty() {
        return json!([]);
    }
    let judged = judge(document, nesting);
    let Some(model) = judged.model else { return json!([]) };
    // Elsewhere than among the parameters values have no names: they get those of their paths.
    let is_whole =
        judged.source.is_some_and(|source| source.parts.is_none() && source.drawn.is_none());
    let promoted: Vec<String> = expressions
        .iter()
        .filter(|(place, _)| is_whole && CONSTANT.contains(&place.path[0].as_str()))
        .map(|(_, path)| path.clone())
        .collect();
    let limits = Limits { nesting };
    let source = Source { promoted: &promoted, limits, ..Source::new(text, &model.name) };
    let with_values = read(&source).model.unwrap_or(model);
    let hints = expressions.iter().filter_map(|(place, path)| {
        let value = value(&with_values, place, path)?;
        let place = document.range(&(place.span.end..place.span.end))["start"].clone();
        Some(json!({ "position": place, "label": format!("= {value}"), "paddingLeft": true }))
    });
    hints.collect()
}

fn value(model: &Model, place: &Place, path: &str) -> Option<String> {
    let name = match place.path.as_slice() {
        [section, name] if section == "parameters" => name.as_str(),
        _ => path,
    };
    model.parameters.iter().find(|parameter| parameter.name == name).map(value_of)
}
