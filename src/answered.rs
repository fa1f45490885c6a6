//! Answers in another language than English: their headings, labels and sentences by the catalogue `docs/vi/answers.toml`.
//!
//! ```text
//! four-bar: 4 modes, stable   →  # modes | stable  →  # dạng dao động | ổn định  →  four-bar: 4 dạng dao động, ổn định
//! ```
//!
//! A text is looked up whole, its numbers and names apart, and where it is not there, by its parts. Names of a model are
//! never translated: a single word is looked up only where it is a heading or a label, or is kept as a word of columns.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use crate::pieces::{filled, key_of, pieces};
use crate::translation::Language;

struct Catalogue {
    /// Words that no column has as a name.
    cells: BTreeMap<String, String>,
    words: BTreeMap<String, String>,
}

static VIETNAMESE: LazyLock<Catalogue> = LazyLock::new(|| {
    let text = include_str!("../docs/vi/answers.toml");
    let mut tables: BTreeMap<String, BTreeMap<String, String>> =
        toml::from_str(text).expect("a catalogue of the repository, which a test reads");
    let mut table = |name: &str| tables.remove(name).unwrap_or_default();
    Catalogue { cells: table("cells"), words: table("words") }
});

/// Separators of the parts of a text, the widest first.
const BETWEEN: [&str; 5] = ["; ", ": ", ", ", " = ", " + "];

/// Place of a text in an answer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Role {
    /// A heading or a label, which is no name of a model.
    Heading,
    /// A line, or an entry of a column.
    Cell,
}

/// A text of an answer in a language; the English where the catalogue does not have it.
pub fn answered(text: &str, role: Role, language: Language) -> String {
    let known = || found(text, role, &VIETNAMESE);
    let other = (language == Language::Vietnamese).then(known).flatten();
    other.unwrap_or_else(|| text.to_owned())
}

fn found(text: &str, role: Role, catalogue: &Catalogue) -> Option<String> {
    let pieces = pieces(text);
    let (key, values) = key_of(&pieces);
    let is_open = role == Role::Heading || key.contains([' ', '#', '*']);
    let of_words = || is_open.then(|| catalogue.words.get(&key)).flatten();
    if let Some(words) = catalogue.cells.get(&key).or_else(of_words) {
        return Some(filled(words, &values));
    }
    // What stands before a colon may be a name.
    BETWEEN.iter().filter(|between| text.contains(**between)).find_map(|between| {
        let parts: Vec<Option<String>> =
            text.split(between).map(|part| found(part, Role::Cell, catalogue)).collect();
        let is_any = parts.iter().any(Option::is_some);
        let own = text.split(between).zip(parts);
        let all = own.map(|(part, words)| words.unwrap_or_else(|| part.to_owned()));
        is_any.then(|| all.collect::<Vec<_>>().join(between))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_names_stay_and_words_change() {
        let words = |text: &str| answered(text, Role::Cell, Language::Vietnamese);
        assert_eq!(
            words("4 modes, stable; no other"),
            "4 dạng dao động, ổn định; không còn vị trí nào khác"
        );
        assert_eq!(words("work -9.1e-12 J"), "công -9.1e-12 J");
        assert_eq!(words("`hit` hit 3×"), "`hit` chạm 3×");
        // Names are no words, alone or among others.
        for text in ["load", "motor, drag", "l1_2", "A = 3 deg"] {
            assert_eq!(words(text), text);
        }
        assert_eq!(answered("load", Role::Heading, Language::Vietnamese), "tải");
        assert_eq!(answered("load", Role::Heading, Language::English), "load");
    }

    #[test]
    fn every_text_has_the_places_of_its_english() {
        for (english, words) in VIETNAMESE.words.iter().chain(&VIETNAMESE.cells) {
            let places = |text: &str| text.matches(['#', '*']).collect::<String>();
            assert_eq!(places(english), places(words), "{english}");
            assert!(!words.trim().is_empty() && words != english, "{english}");
            assert_eq!(key_of(&pieces(english)).0, *english, "{english} has a number");
        }
    }
}
