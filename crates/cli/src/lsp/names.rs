//! Names of a model: where they are defined and where they are used.

use std::ops::Range;

use bksim::model::file::names_in;
use serde_json::{Value, json};

use super::document::{Document, header};

/// Sections whose keys are names.
const NAMED: [&str; 9] =
    ["parameters", "bodies", "joints", "loads", "drives", "states", "signals", "outputs", "clocks"];

/// Keys whose texts are no names of the model.
const WORDS: [&str; 14] = [
    "type",
    "file",
    "part",
    "units",
    "interpolation",
    "extrapolate",
    "kind",
    "sense",
    "side",
    "method",
    "formulation",
    "jit",
    "space",
    "law",
];

/// The section of names that joints give to their coordinates.
pub(super) const COORDINATES: &str = "coordinates";

/// A name that the author gave, with the place where he did.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Defined {
    /// Section of the definition, `joints` or `parameters`, or [`COORDINATES`].
    pub(super) section: String,
    pub(super) name: String,
    pub(super) span: Range<usize>,
}

/// The lines of a text with their first bytes.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.split_inclusive('\n').scan(0, |start, line| {
        *start += line.len();
        Some((*start - line.len(), line))
    })
}

/// All names: those of headers, and the keys of sections of values.
pub(super) fn defined(text: &str) -> Vec<Defined> {
    let mut found = Vec::new();
    let mut section: Vec<String> = Vec::new();
    for (start, line) in lines(text) {
        if let Some(parts) = header(line) {
            if let [of, name, ..] = parts.as_slice()
                && !found.iter().any(|known: &Defined| known.section == *of && known.name == *name)
                && let Some(at) = line.find(&format!(".{name}"))
            {
                let span = start + at + 1..start + at + 1 + name.len();
                found.push(Defined { section: of.clone(), name: name.clone(), span });
            }
            section = parts;
            continue;
        }
        let Some((key, _)) = line.split_once('=') else { continue };
        if section.first().is_some_and(|of| of == "joints") {
            let named = coordinates(line).into_iter();
            found.extend(named.map(|at| Defined {
                section: COORDINATES.to_owned(),
                name: line[at.clone()].to_owned(),
                span: start + at.start..start + at.end,
            }));
        }
        let name = key.trim();
        let is_name = !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || c == '_');
        // `rod = { … }` below `[bodies]` names a body, too.
        if let ([of], true) = (section.as_slice(), is_name)
            && NAMED.contains(&of.as_str())
        {
            let from = start + key.len() - key.trim_start().len();
            let span = from..from + name.len();
            found.push(Defined { section: of.clone(), name: name.to_owned(), span });
        }
    }
    found
}

/// The names after `coordinate =` in a line, one or several in brackets.
fn coordinates(line: &str) -> Vec<Range<usize>> {
    const KEY: &str = "coordinate";
    let mut found = Vec::new();
    let Some(at) = line.find(KEY) else { return found };
    let rest = &line[at + KEY.len()..];
    let Some(value) = rest.trim_start().strip_prefix('=') else { return found };
    let value_at = line.len() - value.len();
    let is_list = value.trim_start().starts_with('[');
    let end = if is_list { value.find(']') } else { None };
    let end = end.map_or(line.len(), |end| value_at + end);
    let mut from = value_at;
    while let Some(open) = line.get(from..end).and_then(|rest| rest.find('"')) {
        let first = from + open + 1;
        let Some(length) = line[first..].find('"') else { break };
        found.push(first..first + length);
        from = first + length + 1;
        if !is_list {
            break;
        }
    }
    found
}

/// The place where a point of a body is named.
fn point(text: &str, body: &str, point: &str) -> Option<Range<usize>> {
    let mut is_inside = false;
    for (start, line) in lines(text) {
        if let Some(parts) = header(line) {
            is_inside = parts.get(1).is_some_and(|name| name == body)
                || parts.first().is_some_and(|section| section == body && body == "ground");
            continue;
        }
        let bytes = line.match_indices(point).find(|(at, _)| {
            let before = line[..*at].trim_end();
            let after = line[at + point.len()..].trim_start();
            let begins = before.is_empty() || before.ends_with(['{', ',']);
            begins && after.starts_with('=')
        });
        if let Some((at, _)) = bytes.filter(|_| is_inside) {
            return Some(start + at..start + at + point.len());
        }
    }
    None
}

/// The place where the name at a byte is defined.
pub(super) fn definition(document: &Document, byte: usize) -> Option<Range<usize>> {
    let text = &document.text;
    let place = document.place(byte);
    let (before, part) = document.part(&place.word, byte);
    let name = text.get(part)?;
    match before.as_slice() {
        [body] => point(text, body, name),
        [] => {
            let all = defined(text);
            let name = owner_of_rate(&all, name);
            all.into_iter().find(|known| known.name == name).map(|known| known.span)
        }
        _ => None,
    }
}

/// The coordinate whose rate a name is, `phi` of `phi_dot`; other names as they are.
fn owner_of_rate<'n>(all: &[Defined], name: &'n str) -> &'n str {
    let is_known = |name: &str| all.iter().any(|known| known.name == name);
    let stem = name.strip_suffix("_dot").filter(|stem| !is_known(name) && is_known(stem));
    stem.unwrap_or(name)
}

/// The places where a name stands: its definition, headers, keys of `[initial]`, and texts.
fn uses(text: &str, name: &str) -> Vec<Range<usize>> {
    let all = defined(text);
    let is_own = |word: &str| all.iter().any(|known| known.name == word);
    let mut found: Vec<Range<usize>> = Vec::new();
    let mut section: Vec<String> = Vec::new();
    for (start, line) in lines(text) {
        if let Some(parts) = header(line) {
            if parts.len() > 1
                && parts[1] == name
                && let Some(at) = line.find(&format!(".{name}"))
            {
                found.push(start + at + 1..start + at + 1 + name.len());
            }
            section = parts;
            continue;
        }
        let (key, mut value_at) = match line.split_once('=') {
            Some((key, _)) => (key.trim(), key.len() + 1),
            None => ("", 0),
        };
        let of = section.first().map_or("", String::as_str);
        let is_name_here = section.len() == 1 && !["solve", "units", "io", "ground"].contains(&of);
        if key == name && is_name_here {
            let from = start + line.find(name).unwrap_or(0);
            found.push(from..from + name.len());
        }
        // Texts in quotes, up to a comment.
        let is_word = WORDS.contains(&key);
        while let Some(open) = line[value_at..].find(['"', '\'', '#']) {
            let quote = &line[value_at + open..=value_at + open];
            let inside = value_at + open + 1;
            if quote == "#" {
                break;
            }
            let Some(length) = line[inside..].find(quote) else { break };
            let quoted = &line[inside..inside + length];
            if !is_word {
                let names = names_in(quoted, &is_own).into_iter();
                found.extend(names.filter_map(|span| {
                    let first = quoted.get(span.clone())?.split('.').next()?;
                    let own = first == name || first.strip_suffix("_dot") == Some(name);
                    let from = start + inside + span.start;
                    own.then(|| from..from + name.len())
                }));
            }
            value_at = inside + length + 1;
        }
    }
    found.sort_by_key(|span| span.start);
    found.dedup();
    found
}

/// The edits that give the name at a byte a new one.
///
/// # Errors
/// A sentence about a place without a name of the author's, or about the new name.
pub(super) fn rename(document: &Document, byte: usize, new: &str) -> Result<Value, String> {
    let text = &document.text;
    let place = document.place(byte);
    let (before, part) = document.part(&place.word, byte);
    let all = defined(text);
    let name = owner_of_rate(&all, text.get(part).unwrap_or_default());
    if !before.is_empty() && !all.iter().any(|known| known.span.contains(&byte))
        || !all.iter().any(|known| known.name == name)
    {
        return Err(format!("`{name}` is no name that this file gives"));
    }
    let is_usable = new.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && new.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if !is_usable {
        return Err(format!(
            "`{new}` is no name: letters a–z, digits and `_`, not starting with a digit"
        ));
    }
    if all.iter().any(|known| known.name == new) {
        return Err(format!("the name `{new}` is already taken"));
    }
    let edits = uses(text, name);
    Ok(edits.iter().map(|span| json!({ "range": document.range(span), "newText": new })).collect())
}
