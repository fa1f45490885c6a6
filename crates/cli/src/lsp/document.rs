//! A text that is open in an editor.

use std::ops::Range;
use std::path::PathBuf;

use bksim::edit::scan::places;
use bksim::model::file::sections;
use serde_json::{Value, json};

/// A model file as the editor has it.
#[derive(Clone, Debug)]
pub(super) struct Document {
    /// File of the document.
    pub(super) path: PathBuf,
    pub(super) text: String,
    /// True if the editor has it as a model, whatever its text is.
    is_declared: bool,
}

/// Sections with names that other files have, too.
const COMMON: [&str; 8] =
    ["name", "use", "units", "parameters", "tables", "outputs", "io", "solve"];

fn is_letter(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

impl Document {
    /// A text that the editor has opened in this language.
    pub(super) fn new(uri: &str, language: &str, text: &str) -> Self {
        Self { path: path_of(uri), text: text.to_owned(), is_declared: language == "bksim" }
    }

    /// This document with another text.
    pub(super) fn with(&self, text: &str) -> Self {
        Self { path: self.path.clone(), text: text.to_owned(), ..*self }
    }

    /// True if the text is a model: TOML files of other programs are left alone.
    pub(super) fn is_model(&self) -> bool {
        let first = self.text.lines().next().unwrap_or_default();
        if self.is_declared || first.starts_with("#:schema") && first.contains("bksim") {
            return true;
        }
        // Names that other programs give their tables, too, decide nothing beside unknown ones.
        let is_common = |name: &str| COMMON.contains(&name);
        let forms = sections();
        let mut names: Vec<String> = places(&self.text)
            .into_iter()
            .filter_map(|place| place.path.into_iter().next())
            .collect();
        names.dedup();
        let (known, unknown): (Vec<_>, Vec<_>) =
            names.iter().partition(|name| forms.iter().any(|form| form.name == name.as_str()));
        let n_own = known.iter().filter(|name| !is_common(name)).count();
        if unknown.is_empty() {
            !known.is_empty()
        } else {
            n_own > 0 && known.len() >= unknown.len()
        }
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

    /// The name around a byte, with dots: `rod.B.x`.
    pub(super) fn word(&self, byte: usize) -> Range<usize> {
        let joins = |c: char| is_letter(c) || c == '.';
        let before = &self.text[..byte];
        let from = before
            .rfind(|c| !joins(c))
            .map_or(0, |at| at + self.text[at..].chars().next().map_or(1, char::len_utf8));
        let to = self.text[byte..].find(|c| !joins(c)).map_or(self.text.len(), |at| byte + at);
        from..to
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
        let document = Document::new("file:///a%20b/m.toml", "toml", "é = \"𝑥 m\"\nb = 2\n");
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
    fn a_dotted_name_has_parts() {
        let text = "vector = [\"k*rod.B.x\", 0]";
        let document = Document::new("m.toml", "bksim", text);
        let byte = text.find("B.x").expect("it");
        let word = document.word(byte);
        assert_eq!(&text[word.clone()], "rod.B.x");
        let (before, part) = document.part(&word, byte);
        assert_eq!((before, &text[part]), (vec!["rod"], "B"));
    }

    #[test]
    fn a_model_is_told_from_other_toml() {
        for (language, text, is_model) in [
            ("toml", "[bodies.rod]\nmass = 1\n", true),
            ("toml", "[parameters]\nl = 1\n", true),
            ("toml", "name = \"x\"\n[bodies]\nrod = { mass = 1 }\n[jonts.A]\n", true),
            ("toml", "[package]\nname = \"x\"\n[dependencies]\n", false),
            ("toml", "[project]\nname = \"x\"\n[tool.x]\n[parameters]\n", false),
            ("toml", "[outputs]\nhome = [\"HTML\"]\n[params]\n", false),
            ("toml", "#:schema ./bksim.schema.json\n[bodis.rod]\n", true),
            ("toml", "", false),
            ("bksim", "", true),
        ] {
            assert_eq!(Document::new("m.toml", language, text).is_model(), is_model, "{text}");
        }
    }
}
