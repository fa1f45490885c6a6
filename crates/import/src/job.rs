//! One import under way: the files it reads, what it found wrong, and what it left out.

use std::ops::Range;

use bksim_model::diagnostic::{Code, Diagnostic};

use crate::Files;
use crate::codes;

/// A file that was read.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Source {
    /// Name of the source, as the caller or another file gave it.
    pub name: String,
    /// Text of the source.
    pub text: String,
}

/// A place in one of the files of an import.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Place {
    /// Index of the file.
    pub file: usize,
    /// Range of bytes in its text.
    pub span: Range<usize>,
}

/// A fault with the file that it is about.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Fault {
    /// Index of the file.
    pub file: usize,
    /// The fault; its labels are places in the text of this file.
    pub diagnostic: Diagnostic,
}

/// Part of a file that the model does not have.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct LeftOut {
    /// In a few words: `sensor force_torque`.
    pub what: String,
    /// Where it is written.
    pub place: Place,
}

/// An import under way.
pub(crate) struct Job<'a> {
    pub(crate) sources: Vec<Source>,
    pub(crate) faults: Vec<Fault>,
    pub(crate) left_out: Vec<LeftOut>,
    files: &'a Files<'a>,
}

impl<'a> Job<'a> {
    pub(crate) fn new(files: &'a Files<'a>) -> Self {
        Self { sources: Vec::new(), faults: Vec::new(), left_out: Vec::new(), files }
    }

    /// Keeps the text of a file; bytes that are not UTF-8 are replaced.
    pub(crate) fn add(&mut self, name: &str, bytes: &[u8]) -> usize {
        let text = String::from_utf8_lossy(bytes).into_owned();
        self.sources.push(Source { name: name.to_owned(), text });
        self.sources.len() - 1
    }

    /// The bytes of another file.
    pub(crate) fn bytes(&self, name: &str) -> Option<Vec<u8>> {
        (self.files)(name)
    }

    pub(crate) fn has_errors(&self) -> bool {
        self.faults.iter().any(|fault| fault.diagnostic.is_error())
    }

    pub(crate) fn leave_out(&mut self, what: impl Into<String>, place: &Place) {
        self.left_out.push(LeftOut { what: what.into(), place: place.clone() });
    }

    /// Records an error: message, place with a remark, help.
    pub(crate) fn error(&mut self, code: Code, message: String, at: (&Place, &str), help: &str) {
        self.put(Diagnostic::error(code, message), at, help);
    }

    /// Records a warning: message, place with a remark, help.
    pub(crate) fn warn(&mut self, code: Code, message: String, at: (&Place, &str), help: &str) {
        self.put(Diagnostic::warning(code, message), at, help);
    }

    fn put(&mut self, diagnostic: Diagnostic, (place, label): (&Place, &str), help: &str) {
        let diagnostic = diagnostic.at(place.span.clone(), label).help(help);
        self.faults.push(Fault { file: place.file, diagnostic });
    }

    /// The numbers of a text, divided by blanks; reports those that are none.
    pub(crate) fn numbers(&mut self, text: &str, place: &Place, what: &str) -> Option<Vec<f64>> {
        let mut numbers = Vec::new();
        for word in text.split_whitespace() {
            match word.parse::<f64>() {
                Ok(number) if number.is_finite() => numbers.push(number),
                _ => {
                    let message = format!("{what} has no number in `{}`", short(word));
                    let help = "write numbers with a decimal point, divided by blanks";
                    self.error(codes::NOT_A_NUMBER, message, (place, "expected numbers"), help);
                    return None;
                }
            }
        }
        Some(numbers)
    }

    /// Numbers, exactly this many.
    pub(crate) fn exactly<const N: usize>(
        &mut self,
        text: &str,
        place: &Place,
        what: &str,
    ) -> Option<[f64; N]> {
        let numbers = self.numbers(text, place, what)?;
        let found = numbers.len();
        if let Ok(numbers) = <[f64; N]>::try_from(numbers) {
            return Some(numbers);
        }
        let message = format!("{what} has {found} numbers, and not {N}");
        let help = format!("write {N} numbers, divided by blanks");
        self.error(codes::NOT_A_NUMBER, message, (place, ""), &help);
        None
    }
}

/// A word of a file, cut where it is long.
pub(crate) fn short(word: &str) -> String {
    match word.char_indices().nth(60) {
        Some((end, _)) => format!("{}…", &word[..end]),
        None => word.to_owned(),
    }
}

/// The name among `known` that is most like `word`, as a help.
pub(crate) fn suggestion<'k>(word: &str, known: impl Iterator<Item = &'k str>) -> String {
    let best = known.map(|name| (distance(word, name), name)).min();
    match best {
        Some((far, name)) if far <= 2 + word.len() / 4 => format!("did you mean `{name}`?"),
        _ => "name one that the file has".to_owned(),
    }
}

/// Number of letters to insert, remove or replace between two words.
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) =
        (a.chars().take(80).collect(), b.chars().take(80).collect());
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, of_a) in a.iter().enumerate() {
        let mut corner = row[0];
        row[0] = i + 1;
        for (j, of_b) in b.iter().enumerate() {
            let replaced = corner + usize::from(!of_a.eq_ignore_ascii_case(of_b));
            corner = row[j + 1];
            row[j + 1] = replaced.min(corner + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}
