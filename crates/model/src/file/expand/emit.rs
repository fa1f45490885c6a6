//! A tree written as one text of TOML, with the place that each piece came from.

use super::super::tree::{Entry, Node, Table, Value};
use crate::diagnostic::Span;

/// A piece of the text and the place that it came from.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Piece {
    /// In the text.
    pub(super) at: Span,
    /// In the files end to end.
    source: Span,
    kind: PieceKind,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum PieceKind {
    /// Taken as it is.
    Same,
    /// Text that stands for the whole of its source, or begins it.
    Whole,
    /// Put in where its source is.
    Inserted,
}

impl Piece {
    /// The place that a span came from which begins in one piece and ends in another.
    pub(super) fn source_of(span: &Span, [first, last]: [&Self; 2]) -> Span {
        let start = match first.kind {
            PieceKind::Whole => return first.source.clone(),
            PieceKind::Same => first.source.start + (span.start - first.at.start),
            PieceKind::Inserted => first.source.start,
        };
        let end = match last.kind {
            PieceKind::Same => last.source.start + (span.end - last.at.start),
            PieceKind::Whole | PieceKind::Inserted => last.source.end,
        };
        start..end.min(last.source.end).max(start)
    }
}

/// A text with its pieces, in order.
pub(super) struct Emitted {
    pub(super) text: String,
    pub(super) pieces: Vec<Piece>,
}

/// The text of a model: plain keys first, then the sections.
pub(super) fn emitted(root: &Table, sources: &str) -> Emitted {
    let mut writer = Writer { text: String::new(), pieces: Vec::new(), sources };
    let (sections, plain): (Vec<&Entry>, Vec<&Entry>) =
        root.entries.iter().partition(|entry| entry.node.table().is_some());
    writer.entries(plain);
    for section in sections {
        let Some(table) = section.node.table() else { continue };
        let is_named = |entry: &&Entry| entry.node.table().is_some() && section.key != "ground";
        let (named, plain): (Vec<&Entry>, Vec<&Entry>) = table.entries.iter().partition(is_named);
        if !plain.is_empty() || named.is_empty() {
            writer.header(&[section]);
            writer.entries(plain);
        }
        for entry in named {
            writer.header(&[section, entry]);
            writer.entries(entry.node.table().into_iter().flat_map(|table| &table.entries));
        }
    }
    Emitted { text: writer.text, pieces: writer.pieces }
}

struct Writer<'a> {
    text: String,
    pieces: Vec<Piece>,
    sources: &'a str,
}

impl Writer<'_> {
    /// `[bodies.crank]`
    fn header(&mut self, path: &[&Entry]) {
        if !self.text.is_empty() {
            self.text.push('\n');
        }
        self.text.push('[');
        for (idx, entry) in path.iter().enumerate() {
            if idx > 0 {
                self.text.push('.');
            }
            self.key(entry);
        }
        self.text.push_str("]\n");
    }

    /// A line each.
    fn entries<'e>(&mut self, entries: impl IntoIterator<Item = &'e Entry>) {
        for entry in entries {
            self.key(entry);
            self.text.push_str(" = ");
            self.node(&entry.node);
            self.text.push('\n');
        }
    }

    fn key(&mut self, entry: &Entry) {
        let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        let key = &entry.key;
        if !key.is_empty() && key.chars().all(is_bare) {
            let is_same = self.sources.get(entry.key_span.clone()) == Some(key);
            let kind = if is_same { PieceKind::Same } else { PieceKind::Whole };
            self.piece(key, &entry.key_span, kind);
        } else {
            self.piece(&quoted(key), &entry.key_span, PieceKind::Whole);
        }
    }

    fn node(&mut self, node: &Node) {
        match &node.value {
            Value::Text(text) => self.text_value(node, text),
            Value::Number { .. } | Value::Bool(_) | Value::Date => {
                let raw = self.sources.get(node.span.clone()).unwrap_or_default();
                let is_toml = toml::from_str::<toml::Table>(&format!("x = {raw}")).is_ok();
                match &node.value {
                    Value::Number { value, .. } if !is_toml => {
                        self.piece(&format!("{value:?}"), &node.span, PieceKind::Whole);
                    }
                    _ => self.piece(raw, &node.span, PieceKind::Same),
                }
            }
            Value::Array(nodes) => {
                self.open('[', &node.span);
                for (idx, node) in nodes.iter().enumerate() {
                    if idx > 0 {
                        self.text.push_str(", ");
                    }
                    self.node(node);
                }
                self.text.push(']');
            }
            Value::Table(table) => {
                self.open('{', &node.span);
                for (idx, entry) in table.entries.iter().enumerate() {
                    self.text.push_str(if idx == 0 { " " } else { ", " });
                    self.key(entry);
                    self.text.push_str(" = ");
                    self.node(&entry.node);
                }
                self.text.push(' ');
                self.text.push('}');
            }
        }
    }

    /// A text in quotes, of which the parts that stand in its file keep their places.
    fn text_value(&mut self, node: &Node, text: &str) {
        let raw = self.sources.get(node.span.clone()).unwrap_or_default();
        let inside = raw.strip_prefix('"').and_then(|raw| raw.strip_suffix('"'));
        let is_plain = |text: &str| !text.contains(['"', '\\']) && !text.contains(char::is_control);
        let Some(inside) = inside.filter(|inside| is_plain(inside) && is_plain(text)) else {
            return self.piece(&quoted(text), &node.span, PieceKind::Whole);
        };
        self.piece("\"", &node.span, PieceKind::Whole);
        let start = node.span.start + 1;
        for (part, source) in aligned(inside, text) {
            let kind =
                if source.start == source.end { PieceKind::Inserted } else { PieceKind::Same };
            self.piece(part, &(start + source.start..start + source.end), kind);
        }
        self.text.push('"');
    }

    fn piece(&mut self, text: &str, source: &Span, kind: PieceKind) {
        let start = self.text.len();
        self.text.push_str(text);
        self.pieces.push(Piece { at: start..self.text.len(), source: source.clone(), kind });
    }

    /// The bracket stands for the whole value: a span that begins with it is of the whole.
    fn open(&mut self, bracket: char, source: &Span) {
        self.piece(bracket.encode_utf8(&mut [0; 4]), source, PieceKind::Whole);
    }
}

/// A text in the quotes of TOML.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// The parts of a text that was made of another one, with where they stand there; an empty place is where a part
/// was put in. Names get something before them, so equal ends are looked for from behind.
fn aligned<'t>(old: &str, new: &'t str) -> Vec<(&'t str, Span)> {
    let common = old.char_indices().zip(new.chars()).find(|((_, a), b)| a != b);
    let n_same = common.map_or(old.len().min(new.len()), |((at, _), _)| at);
    // Backwards: what is equal, and what is new.
    let (mut old_end, mut new_end) = (old.len(), new.len());
    let mut parts: Vec<(Span, Span)> = Vec::new();
    while new_end > n_same {
        let last = |text: &str| text.chars().next_back();
        let width = last(&new[..new_end]).map_or(1, char::len_utf8);
        let is_equal = old_end > n_same && last(&old[..old_end]) == last(&new[..new_end]);
        let from = if is_equal { old_end - width } else { old_end };
        let start = new_end - width;
        match parts.last_mut() {
            Some((part, source))
                if (source.start < source.end) == is_equal && part.start == new_end =>
            {
                (part.start, source.start) = (start, from);
            }
            _ => parts.push((start..new_end, from..old_end)),
        }
        (new_end, old_end) = (start, from);
    }
    let head = (n_same > 0).then_some((0..n_same, 0..n_same));
    let parts = head.into_iter().chain(parts.into_iter().rev());
    parts.map(|(part, source)| (&new[part], source)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_text_keep_their_places() {
        type Parts = &'static [(&'static str, Span)];
        let cases: [(&str, &str, Parts); 5] = [
            ("2*r", "2*r", &[("2*r", 0..3)]),
            (
                "m*r",
                "left_m*left_r",
                &[("left_", 0..0), ("m*", 0..2), ("left_", 2..2), ("r", 2..3)],
            ),
            ("ground.D", "arm.u_D", &[("arm", 6..6), (".", 6..7), ("u_", 7..7), ("D", 7..8)]),
            ("a{i}.b", "a12.b", &[("a", 0..1), ("12", 4..4), (".b", 4..6)]),
            ("é{i}", "é1", &[("é", 0..2), ("1", 5..5)]),
        ];
        for (old, new, expected) in cases {
            assert_eq!(aligned(old, new), expected, "{old}, {new}");
        }
    }
}
