//! The sidecar, the model file next to a drawing: its keys come before those of the drawing.

use toml_edit::{DocumentMut, Item, Table, TableLike};

use super::report::{BodyReport, MassSource};
use super::spelling::{Spellings, spelled_body};
use crate::attachment::{Content, Value};
use crate::drawing::Location;
use crate::kind;

/// The key that names the drawing.
pub const DRAWING_KEY: &str = "drawing";

/// A model file, as a tree that keeps its comments.
#[derive(Clone, Debug, Default)]
pub(super) struct Sidecar {
    document: DocumentMut,
}

/// The drawing that a model file names; `None` when it names none or is no TOML.
pub fn named_drawing(text: &str) -> Option<String> {
    let document: DocumentMut = text.parse().ok()?;
    Some(document.get(DRAWING_KEY)?.as_str()?.to_owned())
}

impl Sidecar {
    /// Of a text that is TOML; one that is not states nothing.
    pub(super) fn new(text: &str) -> Self {
        Self { document: text.parse().unwrap_or_default() }
    }

    /// The keys it states of a body, as values of the drawing; all have the location of the body.
    pub(super) fn body_values(&self, name: &str, location: &Location) -> Vec<Value> {
        let body = self.table(&["bodies", name]);
        let body = body.or_else(|| self.table(&["bodies", &spelled_body(name)]));
        let Some(body) = body else { return Vec::new() };
        let keys = kind::by_name("body").expect("bodies are a kind of attachment").keys;
        let stated = |key: &&'static str| {
            let mut text = plain(body.get(key)?)?;
            // Bare lengths are in drawing units in the drawing alone.
            if *key == "thickness" && text.parse::<f64>().is_ok() {
                text = format!("{text} {}", self.unit("length").as_deref().unwrap_or("m"));
            }
            let content = Content::Text(text);
            Some(Value { key, content, location: location.clone() })
        };
        keys.iter().filter_map(stated).collect()
    }

    /// The unit that it states for a quantity.
    pub(super) fn unit(&self, quantity: &str) -> Option<String> {
        Some(self.table(&["units"])?.get(quantity)?.as_str()?.to_owned())
    }

    /// The names of its loads that are gravity.
    pub(super) fn gravities(&self) -> Vec<String> {
        let loads = self.table(&["loads"]).into_iter().flat_map(TableLike::iter);
        let is_gravity = |item: &Item| item.get("type").and_then(Item::as_str) == Some("gravity");
        loads.filter(|(_, item)| is_gravity(item)).map(|(name, _)| name.to_owned()).collect()
    }

    fn table(&self, path: &[&str]) -> Option<&dyn TableLike> {
        let mut table: &dyn TableLike = self.document.as_table();
        for key in path {
            table = table.get(key)?.as_table_like()?;
        }
        Some(table)
    }

    /// The whole model: this file, and below it what the drawing says.
    pub(super) fn merged(
        mut self,
        drawn: &DocumentMut,
        bodies: &[BodyReport],
        spellings: &Spellings,
    ) -> String {
        spellings.spell(&mut self.document);
        // Stated here, density and thickness were made a part of the computed mass.
        for body in bodies.iter().filter(|body| body.source == MassSource::Computed) {
            self.remove_body_keys(spellings.name(&body.name), &["density", "thickness"]);
        }
        self.document.remove(DRAWING_KEY);

        // One entry after the other: first those of the drawing, in its order.
        merge(self.document.as_table_mut(), drawn.as_table(), false);
        for section in ["bodies", "joints", "loads", "drives"] {
            let drawn = drawn.get(section).and_then(Item::as_table_like);
            let merged = self.document.get_mut(section).and_then(Item::as_table_mut);
            if let (Some(drawn), Some(merged)) = (drawn, merged) {
                order_as(merged, drawn);
            }
        }
        renumber(self.document.as_table_mut(), &mut 0);
        self.document.to_string()
    }

    fn remove_body_keys(&mut self, body: &str, keys: &[&str]) {
        let bodies = self.document.get_mut("bodies").and_then(Item::as_table_like_mut);
        let table = bodies.and_then(|t| t.get_mut(body)).and_then(Item::as_table_like_mut);
        if let Some(table) = table {
            for key in keys {
                table.remove(key);
            }
        }
    }
}

/// The text of a number, a text or a flag.
fn plain(item: &Item) -> Option<String> {
    let value = item.as_value()?;
    let text = value.as_str().map(str::to_owned);
    text.or_else(|| value.as_integer().map(|number| number.to_string()))
        .or_else(|| value.as_float().map(|number| number.to_string()))
        .or_else(|| value.as_bool().map(|flag| flag.to_string()))
}

/// Sorts the entries of a table: those of the drawing come first, in its order.
fn order_as(table: &mut Table, drawn: &dyn TableLike) {
    let rank = |key: &str| {
        let found = drawn.iter().position(|(known, _)| known == key);
        found.unwrap_or(usize::MAX)
    };
    let mut keys: Vec<String> = table.iter().map(|(key, _)| key.to_owned()).collect();
    keys.sort_by_key(|key| rank(key));
    for key in keys {
        let (key, item) = table.remove_entry(&key).expect("the keys are those of the table");
        table.insert_formatted(&key, item);
    }
}

/// Writes tables in the order in which they stand in one another, not in that of their files.
fn renumber(table: &mut Table, next: &mut isize) {
    table.set_position(Some(*next));
    *next += 1;
    for (_, item) in table.iter_mut() {
        if let Some(inner) = item.as_table_mut() {
            renumber(inner, next);
        }
    }
}

/// Adds what is missing; `is_whole` where a table that is stated is stated whole.
fn merge(into: &mut dyn TableLike, from: &dyn TableLike, is_whole: bool) {
    for (key, item) in from.iter() {
        let Some(known) = into.get_mut(key) else {
            into.insert(key, item.clone());
            continue;
        };
        if let (Some(known), Some(more), false) =
            (known.as_table_like_mut(), item.as_table_like(), is_whole)
        {
            merge(known, more, key == "initial");
        }
    }
}
