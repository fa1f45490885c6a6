//! [`Places`]: where the tables, keys and values of a text are, in bytes.

use std::ops::Range;

use toml_edit::{Array, Document, InlineTable, Item, Table, Value};

/// A table, key or value of a text.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Place {
    /// Keys from the root, elements of arrays by their number: `bodies`, `rod`, `points`, `B`, `0`.
    pub(crate) path: Vec<String>,
    /// Key of the place; none of elements of arrays, and of tables, whose headers hold several keys.
    pub(crate) key: Option<Range<usize>>,
    /// A value with its quotes and brackets, the header of a table.
    pub(crate) span: Range<usize>,
    pub(crate) kind: Kind,
}

/// Kind of a place.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Kind {
    /// `[bodies.rod]`.
    Table,
    /// `{ … }`.
    Inline,
    /// `[ … ]`.
    Array,
    /// A text, a number, true or false.
    Value,
}

/// All places of a text.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Places<'t> {
    pub(crate) text: &'t str,
    pub(crate) all: Vec<Place>,
}

impl<'t> Places<'t> {
    /// Places in `text`; `None` where it is not TOML.
    pub(crate) fn of(text: &'t str) -> Option<Self> {
        let document = Document::parse(text).ok()?;
        let mut places = Self { text, all: Vec::new() };
        places.take_table(document.as_table(), &mut Vec::new());
        places.all.sort_by_key(|place| place.span.start);
        Some(places)
    }

    fn take_table(&mut self, table: &Table, path: &mut Vec<String>) {
        if let Some(span) = table.span().filter(|_| !path.is_empty() && !table.is_dotted())
            && !table.is_implicit()
        {
            self.add(path, None, self.header(&span), Kind::Table);
        }
        for (name, item) in table {
            path.push(name.to_owned());
            let key = table.key(name).and_then(toml_edit::Key::span);
            match item {
                Item::Table(inner) => self.take_table(inner, path),
                Item::Value(value) => self.take_value(value, key, path),
                Item::ArrayOfTables(_) | Item::None => (),
            }
            path.pop();
        }
    }

    /// The line of a header, whatever the span of its table holds.
    fn header(&self, span: &Range<usize>) -> Range<usize> {
        let line = self.text[span.start..].find('\n').map_or(self.text.len(), |n| span.start + n);
        let closed = self.text[span.start..line].find(']').map_or(line, |n| span.start + n + 1);
        span.start..closed
    }

    fn take_value(&mut self, value: &Value, key: Option<Range<usize>>, path: &mut Vec<String>) {
        let Some(span) = value.span() else { return };
        match value {
            Value::InlineTable(table) => {
                self.add(path, key, span, Kind::Inline);
                self.take_inline(table, path);
            }
            Value::Array(array) => {
                self.add(path, key, span, Kind::Array);
                self.take_array(array, path);
            }
            _ => self.add(path, key, span, Kind::Value),
        }
    }

    fn take_inline(&mut self, table: &InlineTable, path: &mut Vec<String>) {
        for (name, value) in table {
            path.push(name.to_owned());
            let key = table.key(name).and_then(toml_edit::Key::span);
            self.take_value(value, key, path);
            path.pop();
        }
    }

    fn take_array(&mut self, array: &Array, path: &mut Vec<String>) {
        for (number, value) in array.iter().enumerate() {
            path.push(number.to_string());
            self.take_value(value, None, path);
            path.pop();
        }
    }

    fn add(&mut self, path: &[String], key: Option<Range<usize>>, span: Range<usize>, kind: Kind) {
        self.all.push(Place { path: path.to_vec(), key, span, kind });
    }

    /// The place of this path.
    pub(crate) fn find(&self, path: &[&str]) -> Option<&Place> {
        self.all.iter().find(|place| place.path.iter().map(String::as_str).eq(path.iter().copied()))
    }

    /// The text of a place.
    pub(crate) fn text_of(&self, place: &Place) -> &'t str {
        &self.text[place.span.clone()]
    }

    /// A text without its quotes; none of a number.
    pub(crate) fn quoted(&self, place: &Place) -> Option<&'t str> {
        if place.kind != Kind::Value {
            return None;
        }
        let text = self.text_of(place);
        let quote = text.chars().next().filter(|c| matches!(c, '"' | '\''))?;
        text.strip_prefix(quote)?.strip_suffix(quote)
    }

    /// Everything below a path, itself included.
    pub(crate) fn below(&self, path: &[&str]) -> impl Iterator<Item = &Place> + use<'_, 't> {
        let path: Vec<String> = path.iter().map(|key| (*key).to_owned()).collect();
        self.all.iter().filter(move |place| place.path.starts_with(&path))
    }

    /// Names of the elements of a section, each once, in the order of the text.
    pub(crate) fn elements(&self, section: &str) -> Vec<String> {
        let mut found: Vec<String> = Vec::new();
        for place in self.below(&[section]) {
            if let Some(name) = place.path.get(1).filter(|name| !found.contains(name)) {
                found.push(name.clone());
            }
        }
        found
    }

    /// Where the keys with dots between them begin that end with the key of a place, and the number of the first of
    /// them, at least `least`.
    pub(crate) fn start_of_keys(&self, place: &Place, least: usize) -> Option<(usize, usize)> {
        let (mut start, mut idx) = (place.key.as_ref()?.start, place.path.len() - 1);
        while idx > least {
            let before = self.text[..start].trim_end();
            let Some(before) = before.strip_suffix('.').map(str::trim_end) else { break };
            let Some(rest) = before.strip_suffix(place.path[idx - 1].as_str()) else { break };
            (start, idx) = (rest.len(), idx - 1);
        }
        Some((start, idx))
    }

    /// The end of what is directly in a table: its last value, or its header.
    pub(crate) fn end_of_table(&self, table: &Place) -> usize {
        let next = self.all.iter().filter(|place| place.kind == Kind::Table);
        let next = next.map(|place| place.span.start).find(|&at| at > table.span.start);
        let is_inside = |place: &&Place| {
            place.span.start >= table.span.start && next.is_none_or(|next| place.span.start < next)
        };
        self.all
            .iter()
            .filter(is_inside)
            .map(|place| place.span.end)
            .max()
            .unwrap_or(table.span.end)
    }

    /// The first byte of the line of a byte.
    pub(crate) fn line_start(&self, byte: usize) -> usize {
        self.text[..byte].rfind('\n').map_or(0, |at| at + 1)
    }

    /// The first byte after the line of a byte.
    pub(crate) fn line_end(&self, byte: usize) -> usize {
        self.text[byte..].find('\n').map_or(self.text.len(), |n| byte + n + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "name = \"x\"  # a\n\n[parameters]\nl = \"2 m\"\n[bodies.rod]  # the rod\nmass = 1\n\
                        points = { A = [0, \"l\"] }\n[bodies.rod.more]\nk = 1\n[initial]\nA.angle = 1\n";

    #[test]
    fn places_are_where_their_text_is() {
        let places = Places::of(TEXT).expect("TOML");
        let text = |path: &[&str]| places.find(path).map(|place| places.text_of(place));
        assert_eq!(text(&["name"]), Some("\"x\""));
        assert_eq!(text(&["bodies", "rod"]), Some("[bodies.rod]"));
        assert_eq!(text(&["bodies", "rod", "mass"]), Some("1"));
        assert_eq!(text(&["bodies", "rod", "points", "A", "1"]), Some("\"l\""));
        assert_eq!(text(&["initial", "A", "angle"]), Some("1"));
        let rod = places.find(&["bodies", "rod"]).expect("the rod");
        assert!(TEXT[..places.end_of_table(rod)].ends_with("\"l\"] }"));
        assert_eq!(places.elements("bodies"), ["rod"]);
        let l = places.find(&["parameters", "l"]).expect("l");
        assert_eq!((&TEXT[l.key.clone().expect("a key")], places.quoted(l)), ("l", Some("2 m")));
        assert!(Places::of("[bodies").is_none());
    }
}
