//! Completions: the words that may stand at a place.

use bksim::edit::names::{COORDINATES, Defined, POINTS};
use bksim::edit::scan::{Cursor, Place, cursor, own_text, places};
use bksim::expr::function_names;
use bksim::model::Model;
use bksim::model::file::{Holds, TableForm, sections};
use bksim::model::library::LibraryPart;
use serde_json::{Value, json};

use super::document::Document;
use super::faults::judge;
use super::names::defined;
use crate::commands::schema::row;

/// Kinds of completions, as the protocol numbers them.
const FUNCTION: u32 = 3;
const VARIABLE: u32 = 6;
const MODULE: u32 = 9;
const PROPERTY: u32 = 10;
const UNIT: u32 = 11;
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
const REFERENCES: [(&str, &str); 8] = [
    ("clock", "clocks"),
    ("joint", "joints"),
    ("carrier", "bodies"),
    ("on", POINTS),
    ("from", "bodies"),
    ("curve", "curves"),
    ("law", "curves"),
    ("about", POINTS),
];

/// Keys of tables within tables: the key of the table, its keys.
#[rustfmt::skip]
const INNER: [(&str, &[&str]); 8] = [
    ("inertia", &["value", "about", "as_stated"]),
    ("points", &["at", "rpy", "quaternion", "x", "y", "z"]),
    ("between", &["at", "rpy", "quaternion", "x", "y", "z"]),
    ("axes", &["x", "y", "z"]),
    ("follower", &["kind", "radius", "direction", "offset", "pivot", "arm", "sense"]),
    ("segments", &["rise", "return", "over", "dwell", "law"]),
    ("when", &["condition", "value"]),
    ("shapes", &[
        "type", "size", "radius", "length", "outline", "thickness", "corners", "faces", "unit", "at", "rpy", "quaternion",
        "x", "y", "z",
    ]),
];

/// Keys of the start of a body, and of a joint.
#[rustfmt::skip]
const BODY_STARTS: [&str; 14] = [
    "x", "y", "z", "angle", "vx", "vy", "vz", "rate", "rpy", "quaternion", "axes", "w", "frame", "guess",
];
const JOINT_STARTS: [&str; 5] = ["angle", "rate", "guess", "position", "velocity"];

/// Units of quantities, by the words of the reference, the usual ones first.
#[rustfmt::skip]
const UNITS: [(&str, &[&str]); 20] = [
    ("mass", &["kg", "g", "t", "lb"]),
    ("length", &["mm", "m", "cm", "in", "ft"]),
    ("point", &["mm", "m", "cm", "in", "ft"]),
    ("length or angle", &["mm", "m", "deg", "rad"]),
    ("angle", &["deg", "rad", "rev", "mrad"]),
    ("time", &["s", "ms", "min", "h"]),
    ("velocity", &["m/s", "mm/s", "km/h"]),
    ("acceleration", &["m/s^2", "mm/s^2"]),
    ("mass × length²", &["kg m^2", "kg mm^2", "g cm^2"]),
    ("mass / length³", &["kg/m^3", "g/cm^3"]),
    ("force", &["N", "kN", "mN", "lbf", "kgf"]),
    ("torque", &["N m", "N mm", "kN m"]),
    ("force, torque", &["N", "N m"]),
    ("force / length", &["N/m", "N/mm", "kN/m"]),
    ("force × time / length", &["N s/m", "N s/mm"]),
    ("torque / angle", &["N m/rad", "N m/deg", "N mm/rad"]),
    ("torque × time / angle", &["N m s/rad", "N mm s/rad"]),
    ("rate", &["rad/s", "rpm", "deg/s", "Hz"]),
    ("angular velocity", &["rad/s", "rpm", "deg/s"]),
    ("start", &["deg", "rad", "mm", "m"]),
];

/// Units where nothing says which quantity it is.
#[rustfmt::skip]
const COMMON: [&str; 21] = [
    "mm", "m", "kg", "g", "s", "ms", "deg", "rad", "rpm", "Hz", "N", "kN", "N m", "N/m", "N/mm", "N s/m", "N m/rad", "m/s",
    "m/s^2", "kg m^2", "kg/m^3",
];

/// Words of `[initial]` with their units.
const STARTS: [(&str, &[&str]); 4] = [
    ("angle", &["deg", "rad", "rev"]),
    ("rate", &["rad/s", "rpm", "deg/s"]),
    ("position", &["mm", "m", "in"]),
    ("velocity", &["m/s", "mm/s"]),
];

fn item(label: &str, kind: u32, detail: &str) -> Value {
    json!({ "label": label, "kind": kind, "detail": detail })
}

/// The completions at a byte; `is_space` after a space, where only units and what follows a comma are offered.
pub(super) fn at(document: &Document, byte: usize, nesting: usize, is_space: bool) -> Value {
    let text = &document.text;
    let place = cursor(text, byte);
    let written = place.text.and_then(|from| text.get(from..byte));
    if place.is_comment {
        return json!([]);
    }
    let begins = text[..byte].trim_end().ends_with(['{', ',']);
    if is_space && !begins && !written.is_some_and(ends_in_number) {
        return json!([]);
    }
    if place.is_header {
        let is_first = !text[..byte].rsplit('[').next().unwrap_or_default().contains('.');
        let all = sections().into_iter().filter(|form| is_first && !is_top_key(&form.holds));
        return all.map(|form| item(form.name, MODULE, "section")).collect();
    }
    let all = places(text);
    if !place.is_value {
        return keys((text, byte), &all, &place.path);
    }
    let [section, .., last] = place.path.as_slice() else {
        let section = place.path.first().map_or("", String::as_str);
        let form = sections().into_iter().find(|form| form.name == section);
        let Some(Holds::Word(words)) = form.map(|form| form.holds) else { return json!([]) };
        let items = words.iter().map(|word| item(word, VALUE, ""));
        return in_quotes(items.collect(), &place);
    };
    let is_element = last.parse::<usize>().is_ok();
    let key = place.path.iter().rfind(|part| part.parse::<usize>().is_err());
    let key = key.map_or("", String::as_str);
    if let Some(written) = written
        && ends_in_number(written)
    {
        return units(&all, text, &place.path, key);
    }
    let own_type = place.path.get(..2).and_then(|table| own_text(&all, table, "type", text));
    if key == "between" && is_element {
        let ends = if section == "couplings" { "joints" } else { POINTS };
        return in_quotes(named(text, ends, &[], written.unwrap_or_default()), &place);
    }
    if is_space {
        return json!([]);
    }
    let words = words_of(section, own_type, key);
    if !words.is_empty() && !is_element {
        let items = words.iter().map(|word| item(word, VALUE, ""));
        return in_quotes(items.collect(), &place);
    }
    if let Some((_, of)) = REFERENCES.iter().find(|(of, _)| *of == key) {
        return in_quotes(named(text, of, &place.path, written.unwrap_or_default()), &place);
    }
    // Expressions are texts.
    if written.is_none() { json!([]) } else { names(document, byte, nesting) }
}

/// Names or words, with quotes around them where none are open.
fn in_quotes(mut items: Value, place: &Cursor) -> Value {
    for item in items.as_array_mut().into_iter().flatten().filter(|_| place.text.is_none()) {
        let label = item["label"].as_str().unwrap_or_default();
        item["insertText"] = format!("\"{label}\"").into();
    }
    items
}

/// True if a section is a key of the top level.
fn is_top_key(holds: &Holds) -> bool {
    matches!(holds, Holds::Text | Holds::Word(_))
}

/// True if a unit may follow: `25`, `25 `, `25 m`, `2*3.5 k`.
fn ends_in_number(written: &str) -> bool {
    let stem = written.trim_end_matches(|c: char| c.is_alphabetic() || c == '°');
    let number = stem.trim_end();
    let digits =
        number.len() - number.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.').len();
    let before = number[..number.len() - digits].chars().next_back();
    digits > 0
        && number.ends_with(|c: char| c.is_ascii_digit())
        && before.is_none_or(|c| !c.is_alphanumeric() && !"_^".contains(c))
}

/// The keys that a table may have, without those that it has.
fn keys((text, byte): (&str, usize), all: &[Place], path: &[String]) -> Value {
    let known: Vec<String> = match path {
        [] => {
            let top = sections().into_iter().filter(|form| is_top_key(&form.holds));
            top.map(|form| form.name.to_owned()).collect()
        }
        [section] if section == "initial" => {
            let names = defined(text).into_iter().filter(Defined::is_plain);
            let sections = ["bodies", "joints", COORDINATES];
            names
                .filter(|known| sections.contains(&known.section.as_str()))
                .map(|k| k.name)
                .collect()
        }
        [section, name, rest @ ..]
            if section == "initial" && rest.iter().all(|key| key == "guess") =>
        {
            let is_body = defined(text).iter().any(|of| of.section == "bodies" && of.name == *name);
            let joint = ["joints".to_owned(), name.clone()];
            let keys = match own_text(all, &joint, "type", text) {
                _ if is_body => &BODY_STARTS[..],
                Some("revolute") => &JOINT_STARTS[..3],
                Some("prismatic") => &JOINT_STARTS[2..],
                _ => &JOINT_STARTS,
            };
            let is_stated = rest.is_empty();
            let fits = |key: &&&str| is_stated || !["guess", "frame"].contains(*key);
            keys.iter().filter(fits).map(|key| (*key).to_owned()).collect()
        }
        [of, .., with] if of == "use" && with == "with" => {
            let part = own_text(all, &path[..2], "part", text).and_then(LibraryPart::named);
            let names = part.into_iter().flat_map(|part| defined(part.text));
            names.filter(Defined::is_plain).map(|known| known.name).collect()
        }
        [section, rest @ ..] => {
            let form = sections().into_iter().find(|form| form.name == *section);
            let of_section = match (form.map(|form| form.holds), rest.len()) {
                (Some(Holds::Table(keys)), 0) => keys.into_iter().map(|(key, _)| key).collect(),
                (Some(Holds::Named(forms)), 1) => {
                    of_forms(forms, own_text(all, path, "type", text))
                }
                _ => {
                    let inner = rest
                        .iter()
                        .rev()
                        .find_map(|part| INNER.iter().find(|(key, _)| key == part));
                    inner.map_or(Vec::new(), |(_, keys)| keys.to_vec())
                }
            };
            of_section.into_iter().map(str::to_owned).collect()
        }
    };
    let is_there = |key: &String| {
        all.iter().any(|place| {
            let is_inside = place.path.len() > path.len() && place.path.starts_with(path);
            // The key at the cursor may be written anew.
            let is_at_cursor = place.keys.iter().any(|at| at.start <= byte && byte <= at.end);
            is_inside && place.path[path.len()] == *key && !is_at_cursor
        })
    };
    let section = path.first().map_or("Top level", String::as_str);
    let own_type = path.get(..2).and_then(|table| own_text(all, table, "type", text));
    let detail = |key: &str| {
        let cells = row(section, own_type, key).unwrap_or_default();
        cells.into_iter().rfind(|cell| !cell.is_empty()).unwrap_or_default()
    };
    let left = known.iter().filter(|key| !is_there(key));
    left.map(|key| item(key, PROPERTY, &detail(key))).collect()
}

/// The keys of forms of this type, or of all.
fn of_forms(forms: Vec<TableForm>, own: Option<&str>) -> Vec<&'static str> {
    let is_known = forms.iter().any(|form| own.is_some() && form.word == own);
    let of = forms.into_iter().filter(|form| !is_known || form.word == own);
    let mut keys: Vec<&str> = Vec::new();
    for key in of.flat_map(|form| form.keys) {
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    keys
}

/// The words that a key may have: types, those of its section, those in quotes in the reference.
fn words_of(section: &str, own_type: Option<&str>, key: &str) -> Vec<String> {
    let form = sections().into_iter().find(|form| form.name == section);
    match form.map(|form| form.holds) {
        Some(Holds::Named(forms)) if key == "type" => {
            return forms.iter().filter_map(|form| Some(form.word?.to_owned())).collect();
        }
        Some(Holds::Table(keys)) => {
            let words = keys.into_iter().find(|(own, words)| *own == key && !words.is_empty());
            if let Some((_, words)) = words {
                return words.into_iter().map(str::to_owned).collect();
            }
        }
        _ => (),
    }
    // Expressions may stand where an example does.
    let cells = row(section, own_type, key).unwrap_or_default();
    let choice =
        cells.iter().skip(1).find(|cell| cell.starts_with("`\"") && cell.contains("\"`, `\""));
    let parts = choice.into_iter().flat_map(|cell| cell.split('`').skip(1).step_by(2));
    parts.map(|part| part.trim_matches('"').to_owned()).collect()
}

/// The units of a value that a number begins.
fn units(all: &[Place], text: &str, path: &[String], key: &str) -> Value {
    let offered = |units: &[&str], detail: &str| -> Value {
        units.iter().map(|unit| item(unit, UNIT, detail)).collect()
    };
    if path[0] == "initial"
        && let Some((word, units)) = STARTS.iter().find(|(word, _)| key == *word)
    {
        return offered(units, word);
    }
    if path[0] == "initial" && ["x", "y", "z"].contains(&key) {
        return offered(UNITS[1].1, "length");
    }
    // Coordinates of points: their key is that of the table.
    let own_type = path.get(..2).and_then(|table| own_text(all, table, "type", text));
    let names = path.iter().skip(1).rev().filter(|part| part.parse::<usize>().is_err());
    let found = names.filter_map(|name| row(&path[0], own_type, name)).find_map(|cells| {
        let exact = |cell: &String| UNITS.iter().find(|(word, _)| cell == word);
        let begins = |cell: &String| {
            let of = |word: &str| {
                cell.strip_prefix(word).is_some_and(|rest| rest.starts_with([' ', ',']))
            };
            UNITS.iter().find(|(word, _)| of(word))
        };
        let cells = &cells[..cells.len().saturating_sub(1)];
        cells.iter().find_map(exact).or_else(|| cells.iter().find_map(begins))
    });
    found.map_or_else(|| offered(&COMMON, "unit"), |(word, units)| offered(units, word))
}

/// The names of a section; of points with their bodies, or those of the body before the dot.
fn named(text: &str, section: &str, path: &[String], written: &str) -> Value {
    let all = defined(text);
    let of = |section: &'static str| all.iter().filter(move |known| known.section == section);
    if section != POINTS {
        let own = all.iter().filter(|known| known.section == section);
        return own.map(|known| item(&known.name, VARIABLE, section)).collect();
    }
    // Moments of inertia are about a point of their own body.
    let own_body = path.get(1).filter(|_| path.last().is_some_and(|key| key == "about"));
    let body = own_body.map(String::as_str).or_else(|| Some(written.rsplit_once('.')?.0));
    if let Some(body) = body {
        let own = of(POINTS).filter_map(|point| point.name.strip_prefix(body)?.strip_prefix('.'));
        return own.map(|point| item(point, VARIABLE, "point")).collect();
    }
    let points = of(POINTS).map(|point| item(&point.name, VARIABLE, "point"));
    let bodies = of("bodies").map(|body| item(&body.name, MODULE, "body"));
    points.chain(bodies).chain([item("ground", MODULE, "body")]).collect()
}

/// Names that an expression may use: those of the model, or what belongs to the one before the dot.
fn names(document: &Document, byte: usize, nesting: usize) -> Value {
    let written = document.text.get(document.word(byte).start..byte).unwrap_or_default();
    let all = defined(&document.text);
    let Some((owner, _)) = written.rsplit_once('.') else {
        let plain = all.iter().filter(|known| known.is_plain());
        let plain = plain.map(|known| item(&known.name, VARIABLE, &known.section));
        let coordinates = all.iter().filter(|known| known.section == COORDINATES);
        let rates = coordinates.map(|c| item(&format!("{}_dot", c.name), VARIABLE, "rate"));
        let owners = OWNERS.into_iter().map(|(name, detail)| item(name, MODULE, detail));
        let functions = function_names().map(|name| item(name, FUNCTION, "function"));
        let names = plain.chain(rates).chain(owners).chain(functions);
        return names.chain([item("t", VARIABLE, "time")]).collect();
    };
    match owner.split_once('.') {
        None if owner == "reactions" => return named(&document.text, "joints", &[], ""),
        None if owner == "drives" => return named(&document.text, "drives", &[], ""),
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
