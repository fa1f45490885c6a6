//! Questions of design as a model states them: the sections `[optimize]`, `[fit]` and `[tolerance]`.

use std::collections::BTreeMap;
use std::ops::Range;

use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{did_you_mean, stated_ranges};
use serde::Deserialize;
use serde_spanned::Spanned;
use toml::de::{DeTable, DeValue};

use crate::codes;
use crate::error::DesignError;

/// A text or a number, as values of models are written.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged, expecting = "a quantity in quotes, or a number")]
pub(crate) enum Written {
    Text(String),
    Number(f64),
    Whole(i64),
}

impl Written {
    pub(crate) fn text(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Number(number) => number.to_string(),
            Self::Whole(number) => number.to_string(),
        }
    }
}

/// The section of a text, and where it is; `None` of a text that has none.
///
/// # Errors
/// [`codes::BAD_QUESTION`] for keys and values that the section does not have.
pub(crate) fn section<T: for<'d> Deserialize<'d>>(
    text: &str,
    name: &str,
    example: &str,
) -> Result<Option<T>, DesignError> {
    let bad = |message: String, span: Option<std::ops::Range<usize>>| {
        let message = message.lines().next().unwrap_or_default().to_owned();
        let what = format!("`[{name}]` cannot be read: {}", in_own_words(&message));
        let help = meant_key(&message).unwrap_or_else(|| example.to_owned());
        let fault = Diagnostic::error(codes::BAD_QUESTION, what).help(help);
        DesignError::from(match span {
            Some(span) => fault.at(span, ""),
            None => fault,
        })
    };
    let sections: BTreeMap<String, Spanned<toml::Value>> =
        toml::from_str(text).map_err(|error| bad(error.message().to_owned(), error.span()))?;
    if !sections.contains_key(name) {
        return Ok(None);
    }
    // Read from the text, so that faults have their places.
    let mut all: BTreeMap<String, Section<T>> = {
        let only = only(text, name);
        toml::from_str(&only).map_err(|error| bad(error.message().to_owned(), error.span()))?
    };
    Ok(all.remove(name).map(|section| section.0))
}

/// The help for an unknown key that is nearly one of those which the message lists.
fn meant_key(message: &str) -> Option<String> {
    let mut words = message.strip_prefix("unknown field")?.split('`').skip(1).step_by(2);
    let unknown = words.next()?;
    did_you_mean(unknown, &words.collect::<Vec<_>>())
}

/// A message about a section in the words of its author: texts, lists and tables.
fn in_own_words(message: &str) -> String {
    let kinds = [
        ("a sequence", "a list"),
        ("sequence", "a list"),
        ("a map", "a table"),
        ("map", "a table"),
        ("floating point", "the number"),
        ("integer", "the number"),
        ("string \"", "the text \""),
        ("a string", "a text"),
        ("f64", "a number"),
        ("u64", "a whole number"),
        ("usize", "a whole number"),
        ("an array of length", "a list of length"),
    ];
    let word = |text: &str| {
        let known = kinds.iter().find(|(theirs, _)| text.starts_with(theirs));
        known.map_or(text.to_owned(), |(theirs, own)| text.replacen(theirs, own, 1))
    };
    let parts = |start: &str| message.strip_prefix(start)?.split_once(", expected ");
    if let Some((found, expected)) = parts("invalid type: ").or(parts("invalid value: ")) {
        return format!("found {} in place of {}", word(found), word(expected));
    }
    if let Some((found, expected)) = parts("invalid length ") {
        return format!("found a list of length {found} in place of {}", word(expected));
    }
    if let Some((found, expected)) = parts("unknown field ") {
        return format!("there is no key {found}: write {expected}");
    }
    if let Some((found, expected)) = parts("unknown variant ") {
        return format!("there is no {found}: write {expected}");
    }
    match message.strip_prefix("missing field ") {
        Some(key) => format!("the key {key} is missing"),
        // What our own types expect.
        None if ["a ", "an ", "names "].iter().any(|start| message.starts_with(start)) => {
            format!("expected {message}")
        }
        None => message.to_owned(),
    }
}

/// One section.
#[derive(Deserialize)]
#[serde(transparent)]
struct Section<T>(T);

/// The text with blanks in place of all other sections, so that positions stay.
fn only(text: &str, name: &str) -> String {
    let mut is_own = false;
    let mut depth = 0;
    let mut out = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        // A row of an array over several lines is no header.
        let is_outside = depth == 0;
        depth += opened(line);
        if let Some(header) = line.trim_start().strip_prefix('[').filter(|_| is_outside) {
            let header = header.trim_start_matches('[').trim_start();
            let rest = header.strip_prefix(name).map(str::trim_start);
            is_own = rest.is_some_and(|rest| rest.starts_with([']', '.']));
        }
        if is_own {
            out.push_str(line);
        } else {
            out.extend(
                line.chars()
                    .flat_map(|c| if c == '\n' { vec!['\n'] } else { vec![' '; c.len_utf8()] }),
            );
        }
    }
    out
}

/// Brackets that a line opens less those that it closes, outside of texts and comments.
fn opened(line: &str) -> i32 {
    let (mut quote, mut is_escaped, mut n) = (None, false, 0);
    for c in line.chars() {
        match (quote, c) {
            (Some('"'), '\\') if !is_escaped => {
                is_escaped = true;
                continue;
            }
            (Some(open), c) if c == open && !is_escaped => quote = None,
            (None, '"' | '\'') => quote = Some(c),
            (None, '#') => break,
            (None, '[') => n += 1,
            (None, ']') => n -= 1,
            _ => (),
        }
        is_escaped = false;
    }
    n
}

/// A fault with its place, where a question of the text has what it is about.
pub(crate) fn located(fault: DesignError, text: &str, about: &str) -> DesignError {
    let DesignError::Rejected(bksim::Rejected(mut faults)) = fault else { return fault };
    if let [only] = faults.as_mut_slice()
        && only.labels.is_empty()
        && let Some(span) = place(text, about)
    {
        *only = only.clone().at(span, "");
    }
    bksim::Rejected(faults).into()
}

/// Sections that ask a question, and that of ranges, which they may refer to.
const QUESTIONS: [&str; 5] = ["optimize", "fit", "tolerance", "synthesize", "ranges"];

/// The place of a key or value of a question: the first that is `about`, or else the first that contains it.
pub(crate) fn place(text: &str, about: &str) -> Option<Range<usize>> {
    let root = DeTable::parse(text).ok()?;
    let mut found = Vec::new();
    for name in QUESTIONS {
        if let Some(section) = root.get_ref().get(name) {
            tokens(section.get_ref(), &mut found);
        }
    }
    let written = |span: &Range<usize>| text[span.clone()].trim_matches(['"', '\'']);
    let exact = found.iter().find(|span| written(span) == about);
    let part = || {
        let of =
            found.iter().find(|span| !about.is_empty() && text[(*span).clone()].contains(about))?;
        let at = of.start + text[of.clone()].find(about)?;
        Some(at..at + about.len())
    };
    exact.cloned().or_else(part)
}

/// Spans of all keys and plain values below a value, in their order.
fn tokens(value: &DeValue<'_>, out: &mut Vec<Range<usize>>) {
    match value {
        DeValue::Table(table) => {
            for (key, value) in table {
                out.push(key.span());
                if !matches!(value.get_ref(), DeValue::Table(_) | DeValue::Array(_)) {
                    out.push(value.span());
                }
                tokens(value.get_ref(), out);
            }
        }
        DeValue::Array(all) => {
            for value in all {
                if !matches!(value.get_ref(), DeValue::Table(_) | DeValue::Array(_)) {
                    out.push(value.span());
                }
                tokens(value.get_ref(), out);
            }
        }
        _ => (),
    }
}

/// Names with the ranges that the model states of them.
pub(crate) fn ranges_of(
    text: &str,
    names: &[String],
) -> Result<Vec<(String, [String; 2])>, DesignError> {
    let stated = stated_ranges(text);
    let of = |name: &String| {
        stated.iter().find(|(known, _)| known == name).cloned().ok_or_else(|| {
            let message = format!("`{name}` varies, but the model states no range of it");
            let help =
                format!("add one below `[ranges]`, such as `{name} = [\"80 mm\", \"120 mm\"]`");
            located(
                DesignError::fault(codes::BAD_QUESTION, message, help),
                text,
                &format!("\"{name}\""),
            )
        })
    };
    names.iter().map(of).collect()
}
