//! [`Places`]: where the tables, keys and values of a text are, in bytes.

use toml_edit::Document;

use crate::scan::{Kind, Place, places};

/// All places of a text.
#[derive(Clone, PartialEq, Debug)]
pub struct Places<'t> {
    pub(crate) text: &'t str,
    pub(crate) all: Vec<Place>,
}

impl<'t> Places<'t> {
    /// Places in `text`, whether it is whole or being written.
    pub fn of(text: &'t str) -> Self {
        Self { text, all: places(text) }
    }

    /// Places in `text`; `None` where it is not TOML.
    pub(crate) fn of_whole(text: &'t str) -> Option<Self> {
        Document::parse(text).is_ok().then(|| Self::of(text))
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
        place.inside(self.text).map(|inside| &self.text[inside])
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

    /// The end of what is directly in a table: its last value, or its header.
    pub(crate) fn end_of_table(&self, table: &Place) -> usize {
        let next = self.all.iter().filter(|place| place.kind == Kind::Header);
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
        let places = Places::of_whole(TEXT).expect("TOML");
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
        assert_eq!(
            (&TEXT[l.own_key().expect("a key").clone()], places.quoted(l)),
            ("l", Some("2 m"))
        );
        assert!(Places::of_whole("[bodies").is_none());
    }
}
