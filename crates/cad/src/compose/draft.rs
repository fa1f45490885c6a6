//! The text of a model under construction: values with their paths and their locations.

use std::collections::BTreeMap;

use toml_edit::{Array, DocumentMut, InlineTable, Item, Table, Value};

use crate::attachment::Content;
use crate::drawing::{LengthUnit, Location};
use crate::geometry::Point;

/// Keys whose bare numbers are lengths of the drawing.
const LENGTHS: [&str; 5] = ["thickness", "length", "x", "y", "position"];

/// Keys whose values are true or false.
const FLAGS: [&str; 6] = ["free", "cut", "guess", "internal", "crossed", "reversed"];

/// Keys whose values may be lists, with commas between their parts.
const LISTS: [&str; 15] = [
    "vector",
    "acceleration",
    "times",
    "axis",
    "between",
    "teeth",
    "radii",
    "turns",
    "formula",
    "range",
    "points",
    "units",
    "input",
    "rolling",
    "output",
];

/// A model file being written.
#[derive(Clone, Debug, Default)]
pub(super) struct Draft {
    pub(super) document: DocumentMut,
    /// Where each value comes from, by its path.
    pub(super) locations: BTreeMap<Vec<String>, Location>,
}

impl Draft {
    /// The drafts of different sections as one, in their order.
    pub(super) fn joined(drafts: impl IntoIterator<Item = Self>) -> Self {
        let mut whole = Self::default();
        for draft in drafts {
            for (key, item) in draft.document.into_table() {
                whole.document.insert(&key, item);
            }
            whole.locations.extend(draft.locations);
        }
        whole
    }

    /// Puts a value at `section.name.key`, or at `section.key` where the name is empty.
    pub(super) fn put(
        &mut self,
        [section, name, key]: [&str; 3],
        value: Value,
        location: &Location,
    ) {
        self.table([section, name]).insert(key, Item::Value(value));
        let path = [section, name, key].into_iter().filter(|part| !part.is_empty());
        self.note(path.map(str::to_owned).collect(), location);
    }

    /// Notes where a value comes from; of `bodies.crank` it is where its first value comes from.
    pub(super) fn note(&mut self, path: Vec<String>, location: &Location) {
        for length in 2..path.len() {
            self.locations.entry(path[..length].to_vec()).or_insert_with(|| location.clone());
        }
        self.locations.insert(path, location.clone());
    }

    /// Puts a point among those of a body or of the ground.
    pub(super) fn point(&mut self, owner: [&str; 2], name: &str, at: Value, location: &Location) {
        let [section, body] = owner;
        let table = self.table(owner);
        let points =
            table.entry("points").or_insert_with(|| Value::from(InlineTable::new()).into());
        if let Some(points) = points.as_inline_table_mut() {
            points.insert(name, at);
        }
        let path = [section, body, "points", name].into_iter().filter(|part| !part.is_empty());
        self.note(path.map(str::to_owned).collect(), location);
    }

    fn table(&mut self, [section, name]: [&str; 2]) -> &mut Table {
        if self.document.get(section).is_none() {
            let mut table = Table::new();
            table.set_implicit(!name.is_empty());
            self.document.insert(section, Item::Table(table));
        }
        let outer = table_of(self.document.entry(section).or_insert_with(new_table));
        if name.is_empty() {
            return outer;
        }
        table_of(outer.entry(name).or_insert_with(new_table))
    }

    /// Puts a key into the start of a body, a joint or a coordinate; into its guess if it is one.
    pub(super) fn start(
        &mut self,
        name: &str,
        key: &str,
        value: Value,
        is_guess: bool,
        location: &Location,
    ) {
        if key == "value" {
            // The start of a coordinate is a value by itself.
            let value = if is_guess {
                Value::from(InlineTable::from_iter([("guess", value)]))
            } else {
                value
            };
            return self.put(["initial", "", name], value, location);
        }
        let section = self.table(["initial", ""]);
        let entry = section.entry(name).or_insert_with(|| Value::from(InlineTable::new()).into());
        let Some(mut table) = entry.as_inline_table_mut() else { return };
        if is_guess {
            let guess = table.entry("guess").or_insert_with(|| Value::from(InlineTable::new()));
            let Some(guess) = guess.as_inline_table_mut() else { return };
            table = guess;
        }
        table.insert(key, value);
        self.note(vec!["initial".to_owned(), name.to_owned()], location);
    }

    /// Where a value comes from, if there is one.
    pub(super) fn location_of(&self, path: &[&str]) -> Option<&Location> {
        let path: Vec<String> = path.iter().map(|part| (*part).to_owned()).collect();
        self.locations.get(&path)
    }

    /// Whether a start states or guesses a key.
    pub(super) fn has_start(&self, name: &str, key: &str) -> bool {
        let entry = self.document.get("initial").and_then(|table| table.get(name));
        entry.is_some_and(|entry| {
            entry.get(key).is_some()
                || entry.get("guess").is_some_and(|guess| guess.get(key).is_some())
        })
    }
}

fn new_table() -> Item {
    Item::Table(Table::new())
}

fn table_of(item: &mut Item) -> &mut Table {
    if !item.is_table() {
        *item = new_table();
    }
    item.as_table_mut().expect("it was just made a table")
}

/// A value of the drawing as a value of a model file.
pub(super) fn written(key: &str, content: &Content, unit: LengthUnit) -> Value {
    match content {
        Content::Number(number) => Value::from(*number),
        Content::Length(length) => quantity(*length, unit.name),
        Content::Entity(handle) => Value::from(format!("{:X}", handle.0)),
        Content::Text(text) => text_value(key, text.trim(), unit),
    }
}

fn text_value(key: &str, text: &str, unit: LengthUnit) -> Value {
    if FLAGS.contains(&key) {
        let is_one_of = |words: [&str; 4]| words.iter().any(|word| word.eq_ignore_ascii_case(text));
        if is_one_of(["true", "yes", "1", "on"]) {
            return Value::from(true);
        }
        if is_one_of(["false", "no", "0", "off"]) {
            return Value::from(false);
        }
    }
    // As a model file has it, with quotes and braces.
    if text.starts_with(['[', '{'])
        && let Ok(mut value) = text.parse::<Value>()
    {
        value.decor_mut().clear();
        return value;
    }
    if key == "with" {
        return settings(text, unit);
    }
    let inner = bare(text);
    if key == "points" && inner.contains(';') {
        let rows = inner.split(';').map(bare).filter(|row| !row.is_empty());
        return array(rows.map(|row| list(row, unit)));
    }
    let is_list = inner != text || split(inner).nth(1).is_some();
    if key == "times" || LISTS.contains(&key) && is_list {
        return list(inner, unit);
    }
    if ["coordinates", "coordinate"].contains(&key) && inner.contains([',', ' ']) {
        let names = inner.split([',', ' ']).map(str::trim).filter(|name| !name.is_empty());
        return array(names.map(Value::from));
    }
    match text.parse::<f64>() {
        Ok(number) if LENGTHS.contains(&key) => quantity(number, unit.name),
        // As it is written, if TOML writes numbers so: `1e-8` stays.
        Ok(number) => match text.parse::<Value>() {
            Ok(value @ (Value::Integer(_) | Value::Float(_))) => value,
            _ => Value::from(number),
        },
        Err(_) => Value::from(text),
    }
}

/// The parts of a list, lists within it among them.
fn list(inner: &str, unit: LengthUnit) -> Value {
    array(split(inner).map(str::trim).map(|part| match bare(part) {
        row if row.len() < part.len() => list(row, unit),
        part => text_value("", part, unit),
    }))
}

/// A text without the brackets around it.
fn bare(text: &str) -> &str {
    let inner = text.trim().strip_prefix('[').and_then(|text| text.strip_suffix(']'));
    inner.unwrap_or(text).trim()
}

/// `R = 2 ohm; L = 1 mH` as a table.
fn settings(text: &str, unit: LengthUnit) -> Value {
    let entries = text.split(';').filter_map(|entry| entry.split_once('='));
    let value = |(key, value): (&str, &str)| {
        (key.trim().to_owned(), text_value("", value.trim().trim_matches('"'), unit))
    };
    Value::from(entries.map(value).collect::<InlineTable>())
}

/// The parts of a text between commas that stand in no parentheses and no brackets.
fn split(text: &str) -> impl Iterator<Item = &str> {
    let mut depth = 0_usize;
    text.split(move |c| {
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' => depth = depth.saturating_sub(1),
            _ => (),
        }
        c == ',' && depth == 0
    })
}

/// A number with its unit: `"120 mm"`; zero needs none.
pub(super) fn quantity(number: f64, unit: &str) -> Value {
    if number == 0.0 { Value::from(0) } else { Value::from(format!("{number} {unit}")) }
}

/// `["120 mm", 0]`.
pub(super) fn point_value(point: Point, unit: LengthUnit) -> Value {
    array(point.into_iter().map(|x| quantity(x, unit.name)))
}

/// An array in one line.
pub(super) fn array(values: impl Iterator<Item = Value>) -> Value {
    Value::from(values.collect::<Array>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_keep_the_order_of_their_drafts_and_values_their_locations() {
        let location = |layer: &str| {
            let (kind, layer) = ("INSERT".to_owned(), layer.to_owned());
            Location { kind, handle: None, layer, at: [0.0; 2], lines: None }
        };
        let draft = |section: &str| {
            let mut draft = Draft::default();
            draft.put([section, "a", "key"], Value::from(1), &location(section));
            draft
        };
        // Loads are written before bodies, which come first in a model file.
        let [loads, bodies] = ["loads", "bodies"].map(draft);
        let whole = Draft::joined([bodies, loads]);
        assert_eq!(whole.document.to_string(), "[bodies.a]\nkey = 1\n\n[loads.a]\nkey = 1\n");
        let layer = |path: &[&str]| whole.location_of(path).map(|at| at.layer.as_str());
        assert_eq!(layer(&["loads", "a", "key"]), Some("loads"));
        assert_eq!(layer(&["bodies", "a"]), Some("bodies"), "of its first value");
        assert_eq!(layer(&["joints", "a"]), None);
    }
}
