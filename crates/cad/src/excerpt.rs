//! Locations in a drawing as lines of its text, and in words.

use std::ops::Range;

use bksim_model::diagnostic::Diagnostic;

use crate::drawing::{Handle, Location};
use crate::geometry::Point;

/// The lines of an ASCII drawing; of a binary one nothing can be shown.
#[derive(Clone, Debug, Default)]
pub struct Excerpts<'a> {
    text: &'a str,
    /// Byte range of each line, without its end.
    lines: Vec<Range<usize>>,
}

impl<'a> Excerpts<'a> {
    /// The lines of a text; empty for a binary drawing.
    pub fn new(text: &'a str) -> Self {
        let mut lines = Vec::new();
        let mut start = 0;
        for line in text.split_inclusive('\n') {
            lines.push(start..start + line.trim_end_matches(['\n', '\r']).len());
            start += line.len();
        }
        Self { text, lines }
    }

    /// Bytes of the first line of an entity: its type.
    pub fn first_line(&self, location: &Location) -> Option<Range<usize>> {
        let [first, _] = location.lines?;
        self.trimmed(first)
    }

    /// The location narrowed to the line of it that says `value`.
    #[must_use]
    pub fn narrowed(&self, location: &Location, value: &str) -> Location {
        let found = location.lines.and_then(|[first, last]| {
            let mut lines = (first..=last).filter(|&line| self.words(line) == Some(value));
            lines.next()
        });
        Location { lines: found.map(|line| [line, line]).or(location.lines), ..location.clone() }
    }

    fn words(&self, line: usize) -> Option<&'a str> {
        let range = self.lines.get(line.checked_sub(1)?)?;
        Some(self.text.get(range.clone())?.trim())
    }

    fn trimmed(&self, line: usize) -> Option<Range<usize>> {
        let range = self.lines.get(line.checked_sub(1)?)?.clone();
        let text = self.text.get(range.clone())?;
        let start = range.start + text.len() - text.trim_start().len();
        Some(start..start + text.trim().len())
    }

    /// Adds a location to a fault: an excerpt where there is a text, a note where not.
    #[must_use]
    pub fn at(&self, fault: Diagnostic, location: &Location, words: &str) -> Diagnostic {
        let what = describe(location);
        match self.first_line(location) {
            Some(span) if words.is_empty() => fault.at(span, what),
            Some(span) => fault.at(span, format!("{words}: {what}")),
            None if words.is_empty() => fault.note(what),
            None => fault.note(format!("{words}: {what}")),
        }
    }
}

/// `CIRCLE, handle 2F, layer BK_JOINTS, at (120.5, 34)`.
pub fn describe(location: &Location) -> String {
    let handle =
        location.handle.map(|handle| format!(", handle {:X}", handle.0)).unwrap_or_default();
    let [x, y] = location.at.map(short);
    format!("{}{handle}, layer {}, at ({x}, {y})", location.kind, location.layer)
}

/// An entity as a diagnostic describes it.
#[derive(Clone, PartialEq, Debug)]
pub struct Place {
    /// Type of the place.
    pub kind: String,
    /// Handle of the place, where it has one.
    pub handle: Option<Handle>,
    /// Layer of the place.
    pub layer: String,
    /// A point of it, in seven digits.
    pub at: Point,
}

/// The entities that a fault is about, in its labels and notes.
pub fn places(fault: &Diagnostic) -> Vec<Place> {
    let labels = fault.labels.iter().map(|label| label.text.as_str());
    labels.chain(fault.notes.iter().map(String::as_str)).filter_map(place).collect()
}

/// The entity of a description as [`describe`] writes it, after other words or alone.
fn place(words: &str) -> Option<Place> {
    let words =
        ["here: ", "and here: "].iter().find_map(|it| words.strip_prefix(it)).unwrap_or(words);
    // Other words before it end with a colon; a kind has none.
    let head =
        words.find(", layer ").map_or(0, |end| words[..end].rfind(": ").map_or(0, |at| at + 2));
    let words = &words[head..];
    let (words, at) = words.strip_suffix(')')?.rsplit_once(", at (")?;
    let (head, layer) = words.split_once(", layer ")?;
    let (kind, handle) = match head.split_once(", handle ") {
        Some((kind, handle)) => (kind, Some(Handle(u64::from_str_radix(handle, 16).ok()?))),
        None => (head, None),
    };
    let (x, y) = at.split_once(", ")?;
    let at = [x.parse().ok()?, y.parse().ok()?];
    Some(Place { kind: kind.to_owned(), handle, layer: layer.to_owned(), at })
}

/// A coordinate in at most seven digits.
pub(crate) fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.6e}").parse().expect("a printed number can be read");
    format!("{rounded}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_read_out_of_its_description() {
        for handle in [None, Some(Handle(0x2F))] {
            let (kind, layer) = ("CIRCLE".to_owned(), "a, layer b: c (d)".to_owned());
            let at = [120.5, -34.0];
            let location = Location { kind, handle, layer: layer.clone(), at, lines: None };
            let words = describe(&location);
            let fault = Diagnostic::error(crate::codes::CUT, "").note(format!("here: {words}"));
            let expected = Place { kind: "CIRCLE".to_owned(), handle, layer, at };
            let plain = fault.clone().note("nothing is here").note(words.clone());
            assert_eq!(place(&words), Some(expected.clone()));
            assert_eq!(places(&plain).last(), Some(&expected));
        }
        let at =
            Diagnostic::error(crate::codes::CUT, "").note("and here: LINE, layer 0, at (1, 2)");
        assert_eq!(places(&at).len(), 1);
    }
}
