//! Completions: the words that may stand at a place.

use bksim::expr::function_names;
use bksim::model::Model;
use bksim::model::file::{Holds, sections};
use serde_json::{Value, json};

use super::document::Document;
use super::faults::judge;
use super::names::{COORDINATES, defined};
use crate::commands::schema::meaning;

/// Kinds of completions, as the protocol numbers them.
const FUNCTION: u32 = 3;
const VARIABLE: u32 = 6;
const MODULE: u32 = 9;
const PROPERTY: u32 = 10;
const VALUE: u32 = 12;

/// The words after the name of a body, a point or a joint.
#[rustfmt::skip]
const MEASURES: [&str; 28] = [
    "angle", "rate", "position", "velocity", "angle1", "angle2", "angle3", "position1", "position2", "position3",
    "x", "y", "z", "vx", "vy", "vz", "ax", "ay", "az", "wx", "wy", "wz", "px", "py", "pz", "lx", "ly", "lz",
];

/// Owners of quantities that are no bodies and no joints.
const OWNERS: [(&str, &str); 3] = [
    ("reactions", "reactions of joints"),
    ("drives", "efforts of drives"),
    ("mechanism", "all bodies together"),
];

/// Keys whose texts name something of one section.
const REFERENCES: [(&str, &str); 3] =
    [("clock", "clocks"), ("joint", "joints"), ("carrier", "bodies")];

fn item(label: &str, kind: u32, detail: &str) -> Value {
    json!({ "label": label, "kind": kind, "detail": detail })
}

/// The completions at a byte.
pub(super) fn at(document: &Document, byte: usize, nesting: usize) -> Value {
    let place = document.place(byte);
    let start = document.text[..byte].rfind('\n').map_or(0, |at| at + 1);
    let line = &document.text[start..byte];
    let section = place.section.first().map_or("", String::as_str);
    let forms = sections();
    let known = forms.iter().find(|form| form.name == section);
    if line.trim_start().starts_with('[') && !line.contains('=') {
        return forms.iter().map(|form| item(form.name, MODULE, "section")).collect();
    }
    if !place.is_value {
        // The keys of this table, without those that it has; of its type where one is written.
        let keys: Vec<&str> = match known.map(|form| &form.holds) {
            Some(Holds::Table(keys)) => keys.iter().map(|(key, _)| *key).collect(),
            Some(Holds::Named(forms)) if place.section.len() > 1 => {
                let own = own_type(document, byte);
                let of = forms.iter().filter(|form| own.is_none() || form.word == own.as_deref());
                let mut keys: Vec<&str> = Vec::new();
                for key in of.flat_map(|form| &form.keys) {
                    if !keys.contains(key) {
                        keys.push(key);
                    }
                }
                keys
            }
            _ => Vec::new(),
        };
        let detail = |key: &str| meaning(section, key).unwrap_or_default();
        return keys.iter().map(|key| item(key, PROPERTY, &detail(key))).collect();
    }
    let key = place.key.as_ref().map_or("", |(key, _)| key.as_str());
    if key == "type"
        && let Some(Holds::Named(forms)) = known.map(|form| &form.holds)
    {
        return forms.iter().filter_map(|form| Some(item(form.word?, VALUE, "type"))).collect();
    }
    if let Some((_, section)) = REFERENCES.iter().find(|(of, _)| *of == key) {
        let all = defined(&document.text).into_iter().filter(|known| known.section == *section);
        return all.map(|known| item(&known.name, VARIABLE, section)).collect();
    }
    names(document, (&place.word, byte), nesting)
}

/// The `type` of the table around a byte.
fn own_type(document: &Document, byte: usize) -> Option<String> {
    let text = &document.text;
    let start = text[..byte].rfind("\n[").map_or(0, |at| at + 1);
    let end = text[byte..].find("\n[").map_or(text.len(), |at| byte + at);
    let line = text[start..end].lines().find_map(|line| line.trim().strip_prefix("type"))?;
    let value = line.trim_start().strip_prefix('=')?.trim();
    Some(value.split('"').nth(1)?.to_owned())
}

/// Names that an expression may use: those of the model, or what belongs to the one before the dot.
fn names(
    document: &Document,
    (word, byte): (&std::ops::Range<usize>, usize),
    nesting: usize,
) -> Value {
    let written = document.text.get(word.start..byte).unwrap_or_default();
    let all = defined(&document.text);
    let Some((owner, _)) = written.rsplit_once('.') else {
        let plain = all.iter().map(|known| item(&known.name, VARIABLE, &known.section));
        let coordinates = all.iter().filter(|known| known.section == COORDINATES);
        let rates = coordinates.map(|c| item(&format!("{}_dot", c.name), VARIABLE, "rate"));
        let owners = OWNERS.into_iter().map(|(name, detail)| item(name, MODULE, detail));
        let functions = function_names().map(|name| item(name, FUNCTION, "function"));
        let names = plain.chain(rates).chain(owners).chain(functions);
        return names.chain([item("t", VARIABLE, "time")]).collect();
    };
    // What belongs to all bodies, joints or drives.
    let of_section = |section: &str| -> Value {
        let all = all.iter().filter(|known| known.section == section);
        all.map(|known| item(&known.name, VARIABLE, section)).collect()
    };
    match owner.split_once('.') {
        None if owner == "reactions" => return of_section("joints"),
        None if owner == "drives" => return of_section("drives"),
        Some(("reactions", _)) => {
            let words = bksim::model::reaction_words();
            let unit = |word: &str| if word.starts_with('f') { "N" } else { "N m" };
            return words.map(|word| item(&word, PROPERTY, unit(&word))).collect();
        }
        _ => (),
    }
    let Some(model) = readable(document, byte, nesting) else { return json!([]) };
    let mut found = Vec::new();
    if let Some(body) = model.bodies.iter().find(|body| body.name == owner) {
        found.extend(body.points.iter().map(|point| item(&point.name, VARIABLE, "point")));
    }
    for word in MEASURES {
        let measure = bksim::model::Measure::named(&model, &format!("{owner}.{word}"));
        found.extend(measure.map(|measure| item(word, PROPERTY, measure.unit(&model))));
    }
    found.into()
}

/// The model. A text that is being written is none: then that of the text without the line around a byte, and
/// without lines that are faulty.
fn readable(document: &Document, byte: usize, nesting: usize) -> Option<Model> {
    /// Faults that come to light one after the other.
    const MOST: usize = 8;
    let mut tried = document.clone();
    let mut faulty = vec![byte];
    let mut judged = judge(&tried, nesting);
    for _ in 0..MOST {
        if judged.model.is_some() {
            break;
        }
        for at in faulty {
            let start = tried.text[..at].rfind('\n').map_or(0, |at| at + 1);
            let end = tried.text[at..].find('\n').map_or(tried.text.len(), |end| at + end);
            tried.text.replace_range(start..end, &" ".repeat(end - start));
        }
        judged = judge(&tried, nesting);
        faulty = judged.places(&tried);
    }
    judged.model
}
