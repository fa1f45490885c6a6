//! The values of a model that a page lets be typed and slid, and its elements with their keys.

use bksim_model::StatedRange;
use bksim_model::file::{Holds, sections};
use serde_json::{Value, json};

use crate::numbers::{in_unit, literal, rounded};
use crate::places::Places;
use crate::scan::{Kind, Place};

/// Steps of a slider over its range.
const N_STEPS: f64 = 200.0;

/// Every parameter, initial value, drive and end time as JSON: path, name, value as written, and, for a number, the
/// number, its unit and a range, the stated one where there is one.
pub(crate) fn controls(places: &Places<'_>, ranges: &[StatedRange]) -> Vec<Value> {
    let is_control = |place: &&Place| {
        let path: Vec<&str> = place.path.iter().map(String::as_str).collect();
        place.is_value()
            && match path.as_slice() {
                ["parameters", _] | ["drives", _, "motion"] | ["solve", "t_end"] => true,
                ["initial", rest @ ..] => !rest.is_empty(),
                _ => false,
            }
    };
    places.all.iter().filter(is_control).map(|place| control(places, place, ranges)).collect()
}

fn control(places: &Places<'_>, place: &Place, ranges: &[StatedRange]) -> Value {
    let quoted = places.quoted(place);
    let text = quoted.unwrap_or(places.text_of(place));
    let kind = place.path[0].as_str();
    let name = match kind {
        "parameters" | "drives" => place.path[1].clone(),
        "initial" => {
            let words: Vec<&str> = place.path[1..].iter().map(String::as_str).collect();
            words.join(".").replace(".guess", "")
        }
        _ => place.path[1..].join("."),
    };
    let path = place.path.join(".");
    let mut value = json!({
        "path": path,
        "kind": kind,
        "name": name,
        "text": text,
        "is_guess": place.path.iter().any(|key| key == "guess"),
    });
    if let Some(literal) = literal(text) {
        let in_own = |end: f64| match literal.unit.as_str() {
            "" => end,
            unit => rounded(in_unit(end, unit)),
        };
        let stated = ranges.iter().find(|range| range.path == path);
        let about = || range_about(literal.number, &literal.unit);
        let [low, high] = stated.map_or_else(about, |range| range.ends.map(in_own));
        value["number"] = json!(literal.number);
        value["unit"] = json!(literal.unit);
        value["is_stated"] = json!(stated.is_some());
        value["range"] = json!([low, high, (high - low) / N_STEPS]);
    }
    value
}

/// Range of a slider about a number: a whole turn of an angle, from a fifth to twice of all else.
pub fn range_about(number: f64, unit: &str) -> [f64; 2] {
    match (unit, number) {
        ("deg", x) if x.abs() <= 180.0 => [-180.0, 180.0],
        (_, 0.0) => [-1.0, 1.0],
        (_, x) if x > 0.0 => [0.2 * x, 2.0 * x],
        (_, x) => [2.0 * x, 0.2 * x],
    }
}

/// Keys that an element may have and has not.
fn other_keys(places: &Places<'_>, section: &str, path: &[&str]) -> Vec<&'static str> {
    let type_path = [path, &["type"]].concat();
    let word = places.find(&type_path).and_then(|place| places.quoted(place));
    let form = sections().into_iter().find(|form| form.name == section);
    let keys = match form.map(|form| form.holds) {
        Some(Holds::Named(forms)) => {
            forms.into_iter().find(|form| form.word == word).map_or_else(Vec::new, |form| form.keys)
        }
        Some(Holds::Table(keys)) => keys.into_iter().map(|(key, _)| key).collect(),
        _ => Vec::new(),
    };
    let is_given = |key: &str| {
        places.below(path).any(|place| place.path.get(path.len()).is_some_and(|own| own == key))
    };
    keys.into_iter().filter(|key| *key != "type" && !is_given(key)).collect()
}

/// Bodies, joints, loads and other elements as JSON, with their keys and values as written, and the keys
/// that they may have, too.
pub(crate) fn elements(places: &Places<'_>) -> Vec<Value> {
    const SECTIONS: [&str; 8] =
        ["bodies", "joints", "loads", "drives", "couplings", "conditions", "contacts", "ground"];
    let mut found = Vec::new();
    for section in SECTIONS {
        let names =
            if section == "ground" { vec![String::new()] } else { places.elements(section) };
        for name in names {
            let path = if section == "ground" { vec![section] } else { vec![section, &name] };
            // Whole values: lists are typed as they are written, points one by one.
            let is_whole = |place: &&Place| {
                let keys = &place.path[path.len()..];
                match keys {
                    [_] => {
                        place.kind != Kind::Header
                            && !(keys[0] == "points" && place.kind == Kind::Inline)
                    }
                    [first, _] => first == "points" && place.kind != Kind::Header,
                    _ => false,
                }
            };
            let keys: Vec<Value> = places
                .below(&path)
                .filter(is_whole)
                .map(|place| {
                    let text = places.quoted(place).unwrap_or(places.text_of(place));
                    json!({
                        "path": place.path.join("."),
                        "key": place.path[path.len()..].join("."),
                        "text": text,
                    })
                })
                .collect();
            if !keys.is_empty() {
                let name = if name.is_empty() { section } else { &name };
                let more = other_keys(places, section, &path);
                found.push(json!({ "section": section, "name": name, "keys": keys, "more": more }));
            }
        }
    }
    found
}
