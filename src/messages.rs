//! Faults in another language than English: their messages, remarks and helps by the catalogue `docs/vi/messages.toml`.
//!
//! ```text
//! unknown key `color` in joint `A`  →  unknown * in *  →  không nhận ra * trong *  →  không nhận ra khóa `color` trong khớp `A`
//! ```
//!
//! A text is looked up with its names, numbers and lists of them apart, whole or by its parts; what the catalogue does not
//! have stays in English, followed by the meaning and the cure of the code.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use bksim_model::diagnostic::Diagnostic;

use crate::pieces::{Piece, filled, key_of, pieces};
use crate::translation::{Language, Translation, spoken, translation};

struct Catalogue {
    /// Words before messages.
    levels: BTreeMap<String, String>,
    /// Kinds of things that have names, such as `joint`.
    kinds: BTreeMap<String, String>,
    messages: BTreeMap<String, String>,
}

static VIETNAMESE: LazyLock<Catalogue> = LazyLock::new(|| {
    let text = include_str!("../docs/vi/messages.toml");
    let mut tables: BTreeMap<String, BTreeMap<String, String>> =
        toml::from_str(text).expect("a catalogue of the repository, which a test reads");
    let mut table = |name: &str| tables.remove(name).unwrap_or_default();
    Catalogue { levels: table("levels"), kinds: table("kinds"), messages: table("messages") }
});

/// Units after numbers, those before others that they begin with.
const UNITS: [&str; 43] = [
    "kg*m^2", "kg m²", "N m/rad", "N*m/rad", "N s/m", "N m", "N*m", "N/m", "kg/m", "rad/s^",
    "rad/s", "m/s^", "m/s²", "m/s", "deg/s", "°/s", "mm", "cm", "km", "m", "ms", "s", "kg", "g",
    "kN", "N", "J", "W", "Hz", "rad", "°", "%", "deg", "GB", "MB", "kB", "MiB", "rev/s", "rpm",
    "TB", "KiB", "GiB", "MPa",
];

/// Between the names or numbers of a list, with the Vietnamese.
const BETWEEN: [(&str, &str); 5] =
    [(", and ", " và "), (", or ", " hoặc "), (", ", ", "), (" and ", " và "), (" or ", " hoặc ")];

/// A fault in the language that is spoken. What its code means and how it is cured, where a part stays in English.
pub fn worded(fault: &Diagnostic) -> (Diagnostic, Option<&'static Translation>) {
    let mut other = fault.clone();
    let Some(words) = translation(fault.code.0, spoken()) else { return (other, None) };
    let mut is_whole = true;
    let mut put = |text: &mut String| match said(text) {
        Some(words) => *text = words,
        None => is_whole &= text.is_empty(),
    };
    put(&mut other.message);
    other.help.as_mut().into_iter().chain(&mut other.notes).for_each(&mut put);
    other.labels.iter_mut().for_each(|label| put(&mut label.text));
    (other, (!is_whole).then_some(words))
}

/// The word before a message, for `error`, `warning`, `note` and `help`, in the language that is spoken.
pub fn level(english: &'static str) -> &'static str {
    let vietnamese = || VIETNAMESE.levels.get(english).map(String::as_str);
    let other = (spoken() == Language::Vietnamese).then(vietnamese).flatten();
    other.unwrap_or(english)
}

/// A message in the language that is spoken; the English where the catalogue does not have it.
pub fn phrase(text: &str) -> String {
    said(text).unwrap_or_else(|| text.to_owned())
}

fn said(text: &str) -> Option<String> {
    match spoken() {
        Language::English => None,
        Language::Vietnamese => found(text, &VIETNAMESE),
    }
}

fn found(text: &str, catalogue: &Catalogue) -> Option<String> {
    let pieces = listed(text, &catalogue.kinds);
    let (key, values) = key_of(&pieces);
    if !key.contains(char::is_alphabetic) {
        return Some(filled(&key, &values));
    }
    if let Some(words) = catalogue.messages.get(&key) {
        return Some(filled(words, &values));
    }
    ["; ", ": "].into_iter().find_map(|between| {
        let (first, rest) = text.split_once(between)?;
        Some([found(first, catalogue)?, found(rest, catalogue)?].join(between))
    })
}

/// The parts of a message: numbers with their units, names with the words for what they name, lists as one.
fn listed(text: &str, kinds: &BTreeMap<String, String>) -> Vec<Piece> {
    let mut out: Vec<Piece> = Vec::new();
    for piece in pieces(text) {
        match (piece, out.last_mut()) {
            (Piece::Words(words), Some(Piece::Value('#', number))) => {
                let length = length_of_unit(&words);
                number.push_str(&words[..length]);
                if length < words.len() {
                    out.push(Piece::Words(words[length..].to_owned()));
                }
            }
            (Piece::Value('*', name), Some(Piece::Words(words))) => {
                let at = words.strip_suffix(' ').and_then(|before| {
                    let kind = before.rsplit(|c: char| !c.is_alphanumeric() && c != '_').next()?;
                    kinds.contains_key(kind).then_some(before.len() - kind.len())
                });
                let name = match at {
                    Some(at) => {
                        let kind = words.split_off(at);
                        format!("{} {name}", kinds[kind.trim_end()])
                    }
                    None => name,
                };
                if words.is_empty() {
                    out.pop();
                }
                join(&mut out, '*', name);
            }
            (Piece::Value(sign, value), _) => join(&mut out, sign, value),
            (piece, _) => out.push(piece),
        }
    }
    with_ends_of_lists(out)
}

/// Adds a value, to the list of such values where it goes on.
fn join(out: &mut Vec<Piece>, sign: char, value: String) {
    if let [.., Piece::Value(before, list), Piece::Words(words)] = out.as_mut_slice()
        && *before == sign
        && let Some((_, between)) = BETWEEN.iter().find(|(english, _)| words == english)
    {
        list.push_str(between);
        list.push_str(&value);
        out.pop();
        return;
    }
    // The power of a unit.
    if let Some(Piece::Value('#', number)) = out.last_mut()
        && number.ends_with('^')
    {
        number.push_str(&value);
        return;
    }
    out.push(Piece::Value(sign, value));
}

/// Lists that go on with `…` have it too.
fn with_ends_of_lists(pieces: Vec<Piece>) -> Vec<Piece> {
    let mut out: Vec<Piece> = Vec::new();
    for piece in pieces {
        if let (Piece::Words(words), Some(Piece::Value(_, list))) = (&piece, out.last_mut())
            && let Some(rest) = words.strip_prefix(", …")
        {
            list.push_str(", …");
            if !rest.is_empty() {
                out.push(Piece::Words(rest.to_owned()));
            }
        } else {
            out.push(piece);
        }
    }
    out
}

/// Bytes of the unit that words begin with, its space included.
fn length_of_unit(words: &str) -> usize {
    let ends = |rest: &str| {
        !rest.starts_with(|c: char| c.is_alphanumeric() || matches!(c, '_' | '/' | '*' | '^'))
    };
    let of = |words: &str| {
        let units = UNITS.iter().filter_map(|unit| words.strip_prefix(unit));
        units.filter(|rest| ends(rest)).map(|rest| words.len() - rest.len()).next()
    };
    let spaced = words.strip_prefix(' ').and_then(of).map(|length| length + 1);
    spaced.or_else(|| of(words)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::{Path, PathBuf};

    use super::*;

    /// The key of a message in the catalogue.
    fn key(text: &str) -> String {
        key_of(&listed(text, &VIETNAMESE.kinds)).0
    }

    #[test]
    fn names_numbers_and_lists_have_signs() {
        for (text, keyed) in [
            ("unknown key `color` in joint `A`", "unknown * in *"),
            ("loads `a` and `b` both push `C`", "* both push *"),
            ("gravity of 9.81 m/s^2 in body `A`", "gravity of # in *"),
            ("one of `mm`, `cm`, … is meant", "one of * is meant"),
            ("body `rod` of 1.5e-3 kg is -2 mm away", "* of # is # away"),
            ("`l1` = 5 needs its unit", "* = # needs its unit"),
            ("2 metres, 3 or 4 of joint", "# metres, # of joint"),
            ("5 → `A`", "# → *"),
        ] {
            assert_eq!(key(text), keyed);
        }
    }

    #[test]
    fn every_row_has_the_places_of_its_english() {
        for (english, words) in &VIETNAMESE.messages {
            let places = |text: &str| text.matches(['#', '*']).collect::<String>();
            if words.contains("{1}") {
                for at in 1..=places(english).len() {
                    assert_eq!(words.matches(&format!("{{{at}}}")).count(), 1, "{english}: {at}");
                }
                assert_eq!(places(words), "", "{english}");
            } else {
                assert_eq!(places(english), places(words), "{english}");
            }
            assert!(!words.trim().is_empty() && words != english, "{english}");
        }
    }

    /// The texts of the faults in a file: after `error:`, `warning:`, `note:`, `help:` and carets.
    fn texts(path: &Path) -> Vec<String> {
        let text = fs::read_to_string(path).unwrap_or_default();
        let of_line = |line: &str| {
            let line = line.trim_start();
            let after = |word: &str| {
                let rest = line.strip_prefix(word)?;
                let rest = rest
                    .split_once("]: ")
                    .filter(|_| rest.starts_with('['))
                    .map_or(rest.strip_prefix(": "), |(_, rest)| Some(rest));
                rest.map(str::to_owned)
            };
            let remark = || {
                let rest = line.strip_prefix('|')?.trim_start();
                let words = rest.trim_start_matches(['^', '-', '.']);
                (words.len() < rest.len() && !words.contains('|'))
                    .then(|| words.trim_start().to_owned())
            };
            let told = ["error", "warning", "= note", "= help"].into_iter().find_map(after);
            // Assemblies have names that the model takes; labels of one line stand in a row.
            let is_words = |text: &String| {
                !text.is_empty() && !text.starts_with("it has ") && !text.contains("--")
            };
            told.or_else(remark).filter(is_words)
        };
        text.lines().filter_map(of_line).collect()
    }

    fn files(folder: &str, endings: &[&str]) -> Vec<PathBuf> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        let entries = fs::read_dir(&folder).expect("a folder").flatten().map(|entry| entry.path());
        let is_one = |path: &PathBuf| {
            path.extension().is_some_and(|ending| endings.iter().any(|one| ending == *one))
        };
        entries.filter(is_one).collect()
    }

    #[test]
    fn every_fault_of_tests_and_pages_is_translated() {
        let folders = [
            ("tests/faults", "expected"),
            ("crates/cli/tests/faults", "case"),
            ("docs/diagnostics", "md"),
        ];
        let files = folders.into_iter().flat_map(|(folder, ending)| files(folder, &[ending]));
        let texts: Vec<String> = files.flat_map(|path| texts(&path)).collect();
        assert!(texts.len() > 900, "{}", texts.len());
        let mut missing: Vec<String> = texts
            .iter()
            .filter(|text| found(text, &VIETNAMESE).is_none())
            .map(|text| key(text))
            .collect();
        missing.sort();
        missing.dedup();
        assert!(
            missing.is_empty(),
            "docs/vi/messages.toml lacks {} texts: {missing:#?}",
            missing.len()
        );
    }
}
