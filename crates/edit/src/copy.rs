//! A body like another one, as it is or mirrored.

use crate::draft::{Draft, written_key, written_text};
use crate::edit::EditError;
use crate::names::fresh;
use crate::numbers::{length, literal, written};
use crate::places::Places;
use crate::scan::{Kind, Place};

/// Adds a copy of a body at a place; its points are mirrored in the x axis of its frame if `is_mirrored`.
///
/// # Errors
/// [`EditError::Missing`] where there is no such body.
pub(crate) fn copy(
    draft: &mut Draft,
    name: &str,
    at: [f64; 2],
    is_mirrored: bool,
) -> Result<(), EditError> {
    let places = draft.places()?;
    let path = ["bodies", name];
    if places.below(&path).next().is_none() {
        return Err(EditError::missing(&[name]));
    }
    let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let own = fresh(&places, stem);
    let keys = keys_below(&places, &path);
    let mut pairs: Vec<(String, String)> = keys
        .iter()
        .filter(|key| !["free", "count"].contains(&key.as_str()))
        .map(|key| {
            let is_place = ["com", "points", "outline"].contains(&key.as_str());
            let path = [&path[..], &[key]].concat();
            let plain = |place: &Place| places.text_of(place).to_owned();
            (key.clone(), value(&places, &path, is_mirrored && is_place, &plain))
        })
        .collect();
    pairs.push(("free".to_owned(), "true".to_owned()));
    let [x, y] = at.map(|x| written_text(&length(x)));
    draft.add_table(&["bodies", &own], &pairs)?;
    draft.set(&["initial", &own], &format!("{{ guess = {{ x = {x}, y = {y}, angle = 0 }} }}"))
}

/// The keys right below a path, each once.
pub(crate) fn keys_below(places: &Places<'_>, path: &[&str]) -> Vec<String> {
    let mut keys: Vec<String> = Vec::new();
    for place in places.below(path) {
        if let Some(key) = place.path.get(path.len()).filter(|key| !keys.contains(key)) {
            keys.push(key.clone());
        }
    }
    keys
}

/// A value as TOML on one line, tables in braces, numbers and texts as `written` gives them; second coordinates are
/// negated if `is_mirrored`.
pub(crate) fn value(
    places: &Places<'_>,
    path: &[&str],
    is_mirrored: bool,
    written: &dyn Fn(&Place) -> String,
) -> String {
    let children = || keys_below(places, path);
    let child = |key: &String| value(places, &[path, &[key]].concat(), is_mirrored, written);
    match places.find(path) {
        Some(Place { kind: Kind::Array, .. }) => {
            let is_place =
                is_mirrored && places.find(&[path, &["1"]].concat()).is_some_and(is_number);
            // Turns about x and about z change their sense.
            let turned: &[&str] = if path.last() == Some(&"rpy") { &["0", "2"] } else { &["1"] };
            let is_turned = |key: &String| is_place && turned.contains(&key.as_str());
            let elements: Vec<String> = children()
                .iter()
                .map(|key| if is_turned(key) { negated(&child(key)) } else { child(key) })
                .collect();
            format!("[{}]", elements.join(", "))
        }
        Some(place) if place.is_value() => written(place),
        _ => {
            let pairs: Vec<String> = children()
                .iter()
                .map(|key| format!("{} = {}", written_key(key), child(key)))
                .collect();
            format!("{{ {} }}", pairs.join(", "))
        }
    }
}

/// True if a place is that of a coordinate rather than of a list.
fn is_number(place: &Place) -> bool {
    place.is_value()
}

/// The opposite of a coordinate, as TOML.
fn negated(value: &str) -> String {
    let Some(text) =
        value.strip_prefix(['"', '\'']).and_then(|text| text.strip_suffix(['"', '\'']))
    else {
        return literal(value)
            .map_or_else(|| value.to_owned(), |known| written(0.0 - known.number));
    };
    if let Some(known) = literal(text) {
        let number = written(0.0 - known.number);
        return written_text(format!("{number} {}", known.unit).trim_end());
    }
    let opposite = match text.trim().strip_prefix('-') {
        Some(name) if bksim_model::file::is_name(name.trim()) => name.trim().to_owned(),
        _ if bksim_model::file::is_name(text.trim()) => format!("-{}", text.trim()),
        _ => format!("-({})", text.trim()),
    };
    written_text(&opposite)
}
