//! The author's own words: values of a model file as they are written there.

use toml_edit::{Array, DocumentMut, Item, TableLike, Value};

/// A table of the file by its name, in file order.
pub(super) type Entries<'a> = Vec<(&'a str, &'a Item)>;

/// The entries of a table of the file; none when there is no such table.
pub(super) fn entries<'a>(document: &'a DocumentMut, table: &str) -> Entries<'a> {
    document.get(table).and_then(Item::as_table_like).map(all).unwrap_or_default()
}

/// All entries of a table.
pub(super) fn all(table: &dyn TableLike) -> Entries<'_> {
    table.iter().collect()
}

/// The value of a key of a table, in one line.
pub(super) fn words(table: &dyn TableLike, key: &str) -> Option<String> {
    table.get(key).and_then(Item::as_value).map(text)
}

/// A value in one line: the words of a string, a number as it is written, an array in brackets.
pub(super) fn text(value: &Value) -> String {
    match value {
        Value::String(words) => one_line(words.value()),
        Value::Integer(number) => number.display_repr().into_owned(),
        Value::Float(number) => number.display_repr().into_owned(),
        Value::Boolean(flag) => flag.value().to_string(),
        Value::Array(array) => bracketed(array),
        Value::Datetime(time) => time.value().to_string(),
        Value::InlineTable(table) => one_line(&table.to_string()),
    }
}

/// An array without line ends, comments and quotes.
fn bracketed(array: &Array) -> String {
    format!("[{}]", array.iter().map(text).collect::<Vec<_>>().join(", "))
}

/// A value in one line as a model file has it within a list or a table, with quotes.
pub(super) fn quoted(item: &Item) -> Option<String> {
    let value = item.clone().into_value().ok()?;
    Some(match &value {
        Value::Array(_) | Value::InlineTable(_) => nested(&value),
        value => text(value),
    })
}

fn nested(value: &Value) -> String {
    match value {
        Value::Array(array) => {
            format!("[{}]", array.iter().map(nested).collect::<Vec<_>>().join(", "))
        }
        Value::InlineTable(table) => {
            let entries = table.iter().map(|(key, value)| format!("{key} = {}", nested(value)));
            format!("{{ {} }}", entries.collect::<Vec<_>>().join(", "))
        }
        Value::String(words) => Value::from(one_line(words.value())).to_string(),
        value => text(value),
    }
}

pub(super) fn one_line(words: &str) -> String {
    words.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// True if a text is a number without a unit.
pub(super) fn is_bare(text: &str) -> bool {
    text.parse::<f64>().is_ok()
}
