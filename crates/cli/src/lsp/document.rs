//! A text that is open in an editor.

use std::ops::Range;
use std::path::PathBuf;

use serde_json::{Value, json};

/// A model file as the editor has it.
#[derive(Clone, Debug)]
pub(super) struct Document {
    /// File of the document.
    pub(super) path: PathBuf,
    pub(super) text: String,
}

/// A place of a text: its section, key and word.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Place {
    /// The parts of the last header before it: `joints`, `A`.
    pub(super) section: Vec<String>,
    /// The key of its line, with its bytes.
    pub(super) key: Option<(String, Range<usize>)>,
    /// True after the `=` of a line.
    pub(super) is_value: bool,
    /// The name around it, with dots: `rod.B.x`.
    pub(super) word: Range<usize>,
}

fn is_letter(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

impl Document {
    pub(super) fn new(uri: &str, text: &str) -> Self {
        Self { path: path_of(uri), text: text.to_owned() }
    }

    /// The byte of a position: a line and the UTF-16 units in it before the place, both from zero.
    pub(super) fn byte(&self, position: &Value) -> usize {
        let number = |key: &str| position[key].as_u64().and_then(|n| usize::try_from(n).ok());
        let (line, units) = (number("line").unwrap_or(0), number("character").unwrap_or(0));
        let start: usize = self.text.split_inclusive('\n').take(line).map(str::len).sum();
        let mut left = units;
        let mut byte = start;
        for c in self.text[start..].chars() {
            if left == 0 || c == '\n' {
                break;
            }
            left = left.saturating_sub(c.len_utf16());
            byte += c.len_utf8();
        }
        byte
    }

    fn position(&self, byte: usize) -> Value {
        let before = self.text.get(..byte).unwrap_or(&self.text);
        let line = before.matches('\n').count();
        let start = before.rfind('\n').map_or(0, |at| at + 1);
        json!({ "line": line, "character": before[start..].encode_utf16().count() })
    }

    /// A span as editors have it.
    pub(super) fn range(&self, span: &Range<usize>) -> Value {
        json!({ "start": self.position(span.start), "end": self.position(span.end) })
    }

    /// The place of a byte.
    pub(super) fn place(&self, byte: usize) -> Place {
        let before = &self.text[..byte];
        let start = before.rfind('\n').map_or(0, |at| at + 1);
        let end = self.text[byte..].find('\n').map_or(self.text.len(), |at| byte + at);
        let line = &self.text[start..end];
        let mut headers = self.text[..start].lines().chain([line]).filter_map(header);
        let section = headers.next_back().unwrap_or_default();
        let key = line.split_once('=').filter(|_| header(line).is_none()).map(|(key, _)| {
            let from = start + key.len() - key.trim_start().len();
            (key.trim().trim_matches('"').to_owned(), from..from + key.trim().len())
        });
        let is_value = self.text[start..byte].contains('=');
        let joins = |c: char| is_letter(c) || c == '.';
        let from = before
            .rfind(|c| !joins(c))
            .map_or(0, |at| at + self.text[at..].chars().next().map_or(1, char::len_utf8));
        let to = self.text[byte..].find(|c| !joins(c)).map_or(self.text.len(), |at| byte + at);
        Place { section, key, is_value, word: from.max(start)..to.min(end).max(from.max(start)) }
    }

    /// The part of a dotted name that a byte lies in, with the parts before it.
    pub(super) fn part(&self, word: &Range<usize>, byte: usize) -> (Vec<&str>, Range<usize>) {
        let mut before = Vec::new();
        let mut start = word.start;
        for part in self.text[word.clone()].split('.') {
            let end = start + part.len();
            if byte <= end {
                return (before, start..end);
            }
            before.push(part);
            start = end + 1;
        }
        (before, word.end..word.end)
    }
}

/// The parts of a header line: `[joints.A]`, `[[rows]]`.
pub(super) fn header(line: &str) -> Option<Vec<String>> {
    let inside = line.trim().trim_start_matches('[');
    let (inside, _) = inside.split_once(']').filter(|_| line.trim().starts_with('['))?;
    let is_name = |part: &str| {
        !part.is_empty()
            && part.trim_matches('"').chars().all(|c| is_letter(c) || "-{}+".contains(c))
    };
    let parts: Vec<String> = inside.split('.').map(|part| part.trim().to_owned()).collect();
    parts.iter().all(|part| is_name(part)).then_some(parts)
}

/// The path of a `file:` URI, its escapes undone; of another one its text.
fn path_of(uri: &str) -> PathBuf {
    let Some(rest) = uri.strip_prefix("file://") else { return PathBuf::from(uri) };
    let mut bytes = Vec::with_capacity(rest.len());
    let mut left = rest.as_bytes();
    while let [first, others @ ..] = left {
        let escaped = (*first == b'%')
            .then(|| others.get(..2))
            .flatten()
            .and_then(|two| std::str::from_utf8(two).ok())
            .and_then(|two| u8::from_str_radix(two, 16).ok());
        bytes.push(escaped.unwrap_or(*first));
        left = if escaped.is_some() { &others[2..] } else { others };
    }
    PathBuf::from(String::from_utf8_lossy(&bytes).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_count_utf16_units() {
        let document = Document::new("file:///a%20b/m.toml", "é = \"𝑥 m\"\nb = 2\n");
        assert_eq!(document.path, PathBuf::from("/a b/m.toml"));
        for (line, character, byte) in [(0, 0, 0), (0, 1, 2), (0, 7, 10), (1, 0, 14), (9, 9, 20)] {
            let position = json!({ "line": line, "character": character });
            assert_eq!(document.byte(&position), byte, "{position}");
            if line < 9 {
                assert_eq!(document.position(byte), position);
            }
        }
    }

    #[test]
    fn a_place_has_its_section_key_and_name() {
        let text = "[bodies.rod]\nmass = \"2*m1\"\n[loads.f]\nvector = [\"k*rod.B.x\", 0]\n";
        let document = Document::new("m.toml", text);
        let at = |needle: &str| document.place(text.find(needle).expect(needle));
        let place = at("m1");
        assert_eq!(place.section, ["bodies", "rod"]);
        assert_eq!(place.key.expect("a key").0, "mass");
        let place = at("B.x");
        assert_eq!((&text[place.word.clone()], place.is_value), ("rod.B.x", true));
        let (before, part) = document.part(&place.word, text.find("B.x").expect("it"));
        assert_eq!((before, &text[part]), (vec!["rod"], "B"));
        assert!(!at("vector").is_value);
    }
}
