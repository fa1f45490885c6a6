//! The model text as a tree of values with their positions, in file order.
//!
//! TOML tables arrive sorted by key; [`Table`] restores the order of the text, because messages,
//! coordinates and equations follow the author's order.

use toml::de::{DeTable, DeValue};

use crate::diagnostic::Span;

/// A value and its position.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Node {
    /// Position of the value, with its quotes or brackets.
    pub(super) span: Span,
    pub(super) value: Value,
}

/// A value of any kind.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Value {
    Text(String),
    /// The value, and its digits without sign and `_` where they are decimal.
    Number {
        value: f64,
        digits: String,
    },
    Bool(bool),
    Date,
    Array(Vec<Node>),
    Table(Table),
}

/// Keys and values in file order.
#[derive(Clone, PartialEq, Debug, Default)]
pub(super) struct Table {
    pub(super) entries: Vec<Entry>,
}

/// A key and its value.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Entry {
    pub(super) key: String,
    pub(super) key_span: Span,
    pub(super) node: Node,
}

impl Table {
    /// Converts a parsed document. Its nesting is bounded before, so recursion is safe here.
    pub(super) fn from_toml(table: &DeTable<'_>) -> Self {
        let mut entries: Vec<Entry> = table
            .iter()
            .map(|(key, value)| Entry {
                key: key.get_ref().to_string(),
                key_span: key.span(),
                node: Node { span: value.span(), value: Value::from_toml(value.get_ref()) },
            })
            .collect();
        entries.sort_by_key(|entry| entry.key_span.start);
        Self { entries }
    }

    /// The entry of a key.
    pub(super) fn get(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.key == key)
    }

    /// The entry of a key, to be changed.
    pub(super) fn get_mut(&mut self, key: &str) -> Option<&mut Entry> {
        self.entries.iter_mut().find(|entry| entry.key == key)
    }

    /// Moves all positions by some bytes.
    pub(super) fn shift(&mut self, by: usize) {
        for Entry { key_span, node, .. } in &mut self.entries {
            *key_span = key_span.start + by..key_span.end + by;
            node.shift(by);
        }
    }
}

impl Value {
    fn from_toml(value: &DeValue<'_>) -> Self {
        match value {
            DeValue::String(text) => Self::Text(text.to_string()),
            DeValue::Integer(i) => Self::number(i.as_str(), integer(i.as_str(), i.radix())),
            // A number too large for a float reads as infinity and is refused where it is used.
            DeValue::Float(f) => Self::number(f.as_str(), f.as_str().parse().unwrap_or(f64::NAN)),
            DeValue::Boolean(value) => Self::Bool(*value),
            DeValue::Datetime(_) => Self::Date,
            DeValue::Array(values) => Self::Array(
                values
                    .iter()
                    .map(|v| Node { span: v.span(), value: Self::from_toml(v.get_ref()) })
                    .collect(),
            ),
            DeValue::Table(table) => Self::Table(Table::from_toml(table)),
        }
    }

    fn number(written: &str, value: f64) -> Self {
        let digits = written.trim_start_matches(['+', '-']);
        let is_decimal = digits.parse() == Ok(value.abs());
        Self::Number { value, digits: if is_decimal { digits.to_owned() } else { String::new() } }
    }

    /// Description for messages: `an array of 2`.
    pub(super) fn describe(&self) -> String {
        match self {
            Self::Text(text) if text.is_empty() => "an empty text".to_owned(),
            Self::Text(_) => "a text".to_owned(),
            Self::Number { .. } => "a number".to_owned(),
            Self::Bool(value) => format!("`{value}`"),
            Self::Date => "a date".to_owned(),
            Self::Array(values) => format!("an array of {}", values.len()),
            Self::Table(_) => "a table".to_owned(),
        }
    }
}

/// Reads digits of any length; `i64` would refuse a mass of twenty digits.
fn integer(digits: &str, radix: u32) -> f64 {
    if radix == 10 {
        return digits.parse().unwrap_or(f64::NAN);
    }
    digits
        .chars()
        .filter_map(|c| c.to_digit(radix))
        .fold(0.0, |sum, digit| f64::mul_add(sum, f64::from(radix), f64::from(digit)))
}

impl Node {
    /// The table that it is.
    pub(super) fn table(&self) -> Option<&Table> {
        match &self.value {
            Value::Table(table) => Some(table),
            _ => None,
        }
    }

    /// Nodes of it and below it.
    pub(super) fn weight(&self) -> usize {
        1 + match &self.value {
            Value::Array(nodes) => nodes.iter().map(Self::weight).sum(),
            Value::Table(table) => table.entries.iter().map(|entry| entry.node.weight()).sum(),
            _ => 0,
        }
    }

    fn shift(&mut self, by: usize) {
        self.span = self.span.start + by..self.span.end + by;
        match &mut self.value {
            Value::Array(nodes) => nodes.iter_mut().for_each(|node| node.shift(by)),
            Value::Table(table) => table.shift(by),
            _ => (),
        }
    }

    /// Gives all that is in it the same place.
    pub(super) fn move_to(&mut self, place: &Span) {
        self.span = place.clone();
        match &mut self.value {
            Value::Array(nodes) => nodes.iter_mut().for_each(|node| node.move_to(place)),
            Value::Table(table) => {
                for entry in &mut table.entries {
                    entry.key_span = place.clone();
                    entry.node.move_to(place);
                }
            }
            _ => (),
        }
    }

    /// The text and the position of its first character when escapes do not shift the rest.
    pub(super) fn text<'n>(&'n self, source: &str) -> Option<Quoted<'n>> {
        let Value::Text(text) = &self.value else { return None };
        let raw = source.get(self.span.clone()).unwrap_or_default();
        let offset = [1, 3].into_iter().find(|&quotes| {
            raw.len() == text.len() + 2 * quotes
                && raw.get(quotes..quotes + text.len()) == Some(text)
        });
        Some(Quoted { text, whole: self.span.clone(), start: offset.map(|o| self.span.start + o) })
    }
}

/// A quoted text and where it stands.
#[derive(Clone, Debug)]
pub(super) struct Quoted<'n> {
    pub(super) text: &'n str,
    /// The value with its quotes.
    pub(super) whole: Span,
    /// Position of the first character; `None` where escapes make positions inside unknown.
    pub(super) start: Option<usize>,
}

impl Quoted<'_> {
    /// Position in the file of a range of the text.
    pub(super) fn span_of(&self, range: &Span) -> Span {
        match self.start {
            Some(start) => start + range.start..start + range.end,
            None => self.whole.clone(),
        }
    }
}
