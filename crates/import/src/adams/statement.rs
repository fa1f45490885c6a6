//! Statements: a keyword, an id, and arguments with values.

use crate::codes;
use crate::job::{Job, Place};
use crate::spatial::Vector;

/// A statement of the file.
#[derive(Clone, Debug)]
pub(super) struct Statement {
    /// In capitals: `MARKER`.
    pub(super) keyword: String,
    pub(super) id: Option<u64>,
    /// Arguments with their values, in capitals and as written.
    arguments: Vec<(String, String)>,
    pub(super) place: Place,
    /// The name that a comment before it states.
    pub(super) name: Option<String>,
}

/// Most statements of a file.
const MAX_STATEMENTS: usize = 1_000_000;

/// All statements of a file.
pub(super) fn statements(job: &mut Job<'_>, file: usize) -> Vec<Statement> {
    let text = job.sources[file].text.clone();
    let mut found: Vec<Statement> = Vec::new();
    let mut current: Option<(String, Place)> = None;
    let mut name: Option<String> = None;
    let mut goes_on = false;
    let mut at = 0;
    for (idx, line) in text.split_inclusive('\n').enumerate() {
        let start = at;
        at += line.len();
        let code = line.split('!').next().unwrap_or_default();
        let trimmed = code.trim();
        let is_continuation = goes_on || trimmed.starts_with(',');
        if trimmed.is_empty() {
            if let Some(stated) = stated_name(line) {
                finish(job, &mut found, current.take(), &mut name);
                name = Some(stated);
            }
            continue;
        }
        // The first line is a title.
        if idx == 0 && !["UNITS/", "PART/", "MARKER/"].iter().any(|word| trimmed.starts_with(word))
        {
            continue;
        }
        goes_on = trimmed.ends_with('&');
        let part = trimmed.trim_end_matches('&').trim_end_matches(';');
        let place = Place { file, span: start..start + line.trim_end().len() };
        match &mut current {
            Some((statement, _)) if is_continuation => {
                statement.push(' ');
                statement.push_str(part);
            }
            _ => {
                let last = current.take();
                finish(job, &mut found, last, &mut name);
                current = Some((part.to_owned(), place));
            }
        }
        if found.len() > MAX_STATEMENTS {
            break;
        }
    }
    finish(job, &mut found, current, &mut name);
    found
}

/// `adams_view_name='crank'` in a comment.
fn stated_name(line: &str) -> Option<String> {
    let rest = line.split("adams_view_name").nth(1)?;
    let quoted = rest.split('\'').nth(1)?;
    Some(quoted.to_owned())
}

fn finish(
    job: &mut Job<'_>,
    found: &mut Vec<Statement>,
    of: Option<(String, Place)>,
    name: &mut Option<String>,
) {
    let Some((text, place)) = of else { return };
    let stated = name.take();
    let Some((head, rest)) = text.split_once('/') else {
        if text.trim().eq_ignore_ascii_case("END") {
            return;
        }
        let message = format!("`{}` is no statement", crate::job::short(text.trim()));
        let help =
            "begin each statement with a keyword and `/`; a line that goes on begins with a comma";
        job.error(codes::BAD_STATEMENT, message, (&place, "no keyword"), help);
        return;
    };
    let mut words = split(rest).into_iter().peekable();
    let id = words.peek().and_then(|word| word.trim().parse().ok());
    if id.is_some() {
        words.next();
    }
    let mut arguments: Vec<(String, String)> = Vec::new();
    for word in words {
        let word = word.trim();
        if word.is_empty() {
            continue;
        }
        match word.split_once('=') {
            Some((key, value)) => {
                arguments.push((key.trim().to_ascii_uppercase(), value.trim().to_owned()));
            }
            // A value of a list, or a word by itself.
            None => {
                match arguments.last_mut().filter(|(_, value)| !value.is_empty() && is_value(word))
                {
                    Some((_, value)) => {
                        value.push(',');
                        value.push_str(word);
                    }
                    None => arguments.push((word.to_ascii_uppercase(), String::new())),
                }
            }
        }
    }
    found.push(Statement {
        keyword: head.trim().to_ascii_uppercase(),
        id,
        arguments,
        place,
        name: stated,
    });
}

/// Whether a word goes on with the value before it: a number, or the rest of an expression.
fn is_value(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '+' | '.' | '('))
}

/// Words between commas and backslashes outside of parentheses.
fn split(text: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut depth = 0_i32;
    for c in text.chars() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            ',' | '\\' if depth <= 0 => {
                words.push(String::new());
                continue;
            }
            _ => (),
        }
        if let Some(word) = words.last_mut() {
            word.push(c);
        }
    }
    words
}

/// A number, in radians where it ends in `D`.
pub(super) fn number(text: &str) -> Option<f64> {
    let text = text.trim();
    match text.strip_suffix(['D', 'd']) {
        Some(degrees) => degrees.trim().parse::<f64>().ok().map(f64::to_radians),
        None => text.parse::<f64>().ok().filter(|value| value.is_finite()),
    }
}

impl Statement {
    /// The value of an argument; its name may be cut short.
    pub(super) fn text(&self, key: &str) -> Option<&str> {
        let exact = self.arguments.iter().find(|(known, _)| known == key);
        let cut = || {
            self.arguments
                .iter()
                .find(|(known, _)| known.len() >= 3 && key.starts_with(known.as_str()))
        };
        exact.or_else(cut).map(|(_, value)| value.as_str())
    }

    /// True if a word is among the arguments, perhaps cut short.
    pub(super) fn has(&self, word: &str) -> bool {
        self.arguments.iter().any(|(known, value)| {
            value.is_empty() && known.len() >= 3 && word.starts_with(known.as_str())
        })
    }

    pub(super) fn number(&self, key: &str) -> Option<f64> {
        number(self.text(key)?)
    }

    pub(super) fn numbers(&self, key: &str) -> Option<Vec<f64>> {
        self.text(key)?.split(',').map(number).collect()
    }

    pub(super) fn vector(&self, key: &str) -> Option<Vector> {
        let mut numbers = self.numbers(key)?;
        numbers.resize(3, 0.0);
        numbers.try_into().ok()
    }

    /// An expression; lines that went on have left commas in it, which are taken out before signs.
    pub(super) fn expression(&self, key: &str) -> Option<String> {
        let text = self.text(key)?;
        let mut out = String::new();
        let mut depth = 0_i32;
        for c in text.chars() {
            match c {
                '(' => depth += 1,
                ')' => depth -= 1,
                ',' if depth <= 0 => continue,
                _ => (),
            }
            out.push(c);
        }
        Some(out)
    }
}
