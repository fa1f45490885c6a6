//! Letters that look like others, or like nothing: their numbers, and the letters that were probably meant.
//!
//! Texts that were copied from pages, tables and word processors bring them along, and no editor shows them. So a
//! message names them by their number in Unicode.

use any_ascii::any_ascii_char;

use super::codes;
use super::marks::is_typographic;
use super::token::token_length;
use crate::diagnostic::Diagnostic;

/// Lines with such letters that are reported, at most.
const MAX_LINES: usize = 20;

/// Letters of other scripts that look like Latin ones.
const ALIKE: [(&str, &str); 2] = [
    ("АВЕЅЗІЈКМНОРСТУХаеѕіјкорсухԁһ", "ABES3IJKMHOPCTYXaesijkopcyxdh"),
    ("ΑΒΕΖΗΙΚΜΝΟΡΤΥΧο", "ABEZHIKMNOPTYXo"),
];

/// A letter that is out of place, and its place in a text.
#[derive(Clone, Debug)]
pub(super) struct Foreign {
    /// Bytes before it.
    pub(super) at: usize,
    /// Number among the characters, from one.
    pub(super) character: usize,
    /// The letter.
    pub(super) letter: char,
    /// The kind of letter: "a no-break space".
    kind: &'static str,
}

impl Foreign {
    /// The letter by its number and kind: "U+00A0, a no-break space".
    pub(super) fn named(&self) -> String {
        format!("U+{:04X}, {}", u32::from(self.letter), self.kind)
    }
}

/// The kind of a letter that looks like another one or like nothing; `None` for all others.
fn kind(c: char) -> Option<&'static str> {
    Some(match c {
        '\u{A0}' | '\u{202F}' | '\u{2007}' => "a no-break space",
        '\u{1680}' | '\u{2000}'..='\u{200A}' | '\u{205F}' | '\u{3000}' => "a wide or narrow space",
        '\u{2028}' | '\u{2029}' | '\u{85}' => "a line separator",
        '\u{200B}' => "a zero-width space",
        '\u{FEFF}' => "a byte order mark",
        '\u{AD}' => "a soft hyphen",
        '\u{200C}' | '\u{200D}' | '\u{2060}'..='\u{2064}' => "a letter of no width",
        '\u{200E}' | '\u{200F}' | '\u{202A}'..='\u{202E}' | '\u{2066}'..='\u{2069}' => {
            "a mark of the direction of writing"
        }
        '\u{2212}' => "a minus sign of books",
        '\u{2010}'..='\u{2015}' | '\u{FE58}' | '\u{FE63}' => "a dash",
        '\u{FF01}'..='\u{FF5E}' => "a full-width letter",
        '\u{3001}' | '\u{3002}' => "a full-width mark",
        '\u{400}'..='\u{52F}' => "a Cyrillic letter",
        _ if ALIKE[1].0.contains(c) => "a Greek letter",
        '\0'..='\u{8}' | '\u{B}' | '\u{C}' | '\u{E}'..='\u{1F}' | '\u{7F}' => "a control character",
        _ => return None,
    })
}

/// True of letters that nobody sees.
fn is_invisible(c: char) -> bool {
    matches!(c, '\u{200B}'..='\u{200F}' | '\u{202A}'..='\u{202E}' | '\u{2060}'..='\u{2069}' | '\u{FEFF}' | '\u{AD}')
        || c.is_control() && c != '\t'
}

/// The first letter of a text that looks like another one or like nothing.
pub(super) fn first_foreign(text: &str) -> Option<Foreign> {
    text.char_indices().enumerate().find_map(|(idx, (at, letter))| {
        Some(Foreign { at, character: idx + 1, letter, kind: kind(letter)? })
    })
}

/// A Latin letter that looks like this one.
fn alike(c: char) -> Option<char> {
    ALIKE.iter().find_map(|(others, latin)| {
        let place = others.chars().position(|other| other == c)?;
        latin.chars().nth(place)
    })
}

/// The letters that were probably meant: those that look alike, then those that sound alike.
pub(super) fn meant(text: &str) -> [String; 2] {
    let plain = |c: char| match c {
        _ if is_invisible(c) => String::new(),
        _ if c.is_whitespace() && !c.is_ascii() => " ".to_owned(),
        // Books write it, and expressions read it.
        '°' | 'µ' | 'μ' => c.to_string(),
        _ if c.is_ascii() => c.to_string(),
        _ => any_ascii_char(c).to_owned(),
    };
    let looks = text.chars().map(|c| alike(c).map_or_else(|| plain(c), String::from)).collect();
    [looks, text.chars().map(plain).collect()]
}

/// A text with its invisible letters and blanks by their numbers, as messages show it.
pub(super) fn visible(text: &str) -> String {
    let shown = |c: char| match kind(c) {
        Some(_) if is_invisible(c) || c.is_whitespace() => format!("<U+{:04X}>", u32::from(c)),
        _ => c.to_string(),
    };
    text.chars().map(shown).collect()
}

/// The help for a word of such letters: the candidate that it looks like.
pub(super) fn suggest_plain(word: &str, candidates: &[&str]) -> Option<String> {
    let found = first_foreign(word)?;
    let meant = meant(word);
    let known = meant.iter().find_map(|meant| candidates.iter().find(|known| *known == meant));
    let (character, named) = (found.character, found.named());
    let written = known.map_or(meant[0].trim(), |known| *known);
    Some(format!("write `{written}`: character {character} is {named}"))
}

/// A name in the letters that names have, and one that begins with a letter: `b` if there is none.
pub(super) fn spelled(name: &str, start: char) -> String {
    let [_, plain] = meant(name.trim());
    let is_letter = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut better: String = plain.chars().map(|c| if is_letter(c) { c } else { '_' }).collect();
    better.truncate(30);
    if !better.starts_with(|c: char| c.is_ascii_alphabetic()) {
        better.insert(0, start);
    }
    better
}

/// The parts of a line that are no texts and no comments.
pub(super) fn bare_parts(line: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut at = 0;
    std::iter::from_fn(move || {
        while at < line.len() {
            let start = at;
            let tail = &line[start..];
            if tail.starts_with(['"', '\'', '#']) {
                at += token_length(tail).max(1);
                continue;
            }
            at += tail.find(['"', '\'', '#']).unwrap_or(tail.len());
            return Some((start, &line[start..at]));
        }
        None
    })
}

/// A line with plain letters for those that look like others; in texts only where nobody sees them.
fn plain_line(line: &str) -> String {
    let mut plain = String::new();
    let mut end = 0;
    let unseen = |text: &str| -> String {
        let shown = |c: char| match c {
            _ if is_invisible(c) => String::new(),
            _ if c.is_whitespace() => " ".to_owned(),
            _ => c.to_string(),
        };
        text.chars().map(shown).collect()
    };
    for (start, part) in bare_parts(line) {
        plain.push_str(&unseen(&line[end..start]));
        plain.push_str(&meant(part)[0]);
        end = start + part.len();
    }
    plain + &unseen(&line[end..])
}

/// The faults of all lines that have such letters outside of texts and comments, one for each line.
pub(super) fn foreign_letters(text: &str) -> Vec<Diagnostic> {
    let mut faults = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let here = start;
        start += line.len();
        let line = line.trim_end_matches(['\n', '\r']);
        // A mark at the start of a file says that it is UTF-8.
        let skipped =
            if here == 0 && line.starts_with('\u{FEFF}') { '\u{FEFF}'.len_utf8() } else { 0 };
        let line = &line[skipped..];
        if line.is_ascii() && !line.contains(char::is_control) {
            continue;
        }
        let places = bare_parts(line).flat_map(|(start, part)| {
            part.char_indices().map(move |(at, letter)| (start + at, letter))
        });
        let foreign = places.filter(|(_, c)| !is_typographic(*c) && kind(*c).is_some());
        let foreign: Vec<(usize, char)> = foreign.collect();
        let Some(&(at, letter)) = foreign.first() else { continue };
        let character = line[..at].chars().count() + 1;
        let named =
            Foreign { at, character, letter, kind: kind(letter).unwrap_or_default() }.named();
        let others = match foreign.len() {
            1 => String::new(),
            n => format!(", the first of {n} letters of this kind in the line"),
        };
        let message = format!("the letter at column {character} is {named}{others}");
        let at = here + skipped + at;
        faults.push(
            Diagnostic::error(codes::SYNTAX, message)
                .at(at..at + letter.len_utf8(), "only in texts and comments")
                .help(format!("write the line as `{}`", plain_line(line).trim())),
        );
        if faults.len() == MAX_LINES {
            break;
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_letters_that_look_alike_are_of_one_length() {
        for (others, latin) in ALIKE {
            assert_eq!(others.chars().count(), latin.chars().count(), "{others}");
        }
    }

    #[test]
    fn letters_are_named_by_number_and_replaced_by_those_that_were_meant() {
        let found = first_foreign("cra\u{200B}nk").expect("a letter of no width");
        assert_eq!((found.character, found.named().as_str()), (4, "U+200B, a zero-width space"));
        for (text, looks) in [
            ("cra\u{200B}nk", "crank"),
            ("1\u{A0}kg", "1 kg"),
            ("\u{FF11}\u{FF0E}5\u{3000}ｋｇ", "1.5 kg"),
            ("\u{2212}5", "-5"),
            ("сrаnk", "crank"),
        ] {
            assert_eq!(meant(text)[0], looks, "{text:?}");
        }
        assert_eq!(meant("мм")[1], "mm");
        assert_eq!(spelled("thanh truyền", 'b'), "thanh_truyen");
    }
}
