//! Names at a cursor: where they are given and used, and their edits.

use std::ops::Range;

use bksim::edit::Places;
use bksim::edit::names::{self, Defined};
use bksim::edit::scan::{Kind, Place, places};
use bksim::model::file::{NAMED, OWNERS};
use serde_json::{Value, json};

use super::document::Document;

/// All names of a text, each where it is given first.
pub(super) fn defined(text: &str) -> Vec<Defined> {
    names::defined(&Places::of(text))
}

/// The name of the author's at a byte, and the place where he gave it.
fn at(document: &Document, byte: usize) -> Option<Defined> {
    let text = &document.text;
    let all = defined(text);
    if let Some(own) = all.iter().find(|known| known.span.start <= byte && byte <= known.span.end) {
        return Some(own.clone());
    }
    let word = document.word(byte);
    let (before, part) = document.part(&word, byte);
    let name = text.get(part)?;
    let named = |name: &str, is_plain: bool| {
        all.iter().find(|known| known.name == name && known.is_plain() == is_plain).cloned()
    };
    match before.as_slice() {
        [] => named(owner_of_rate(&all, name), true),
        [owner] if let Some((_, section)) = OWNERS.iter().find(|(own, _)| own == owner) => {
            named(name, true).filter(|known| known.section == *section)
        }
        [body] => named(&format!("{body}.{name}"), false).or_else(|| {
            // In a header the section is before the name.
            let is_section = NAMED.contains(body);
            named(name, true).filter(|known| is_section && known.section == **body)
        }),
        _ => None,
    }
}

/// The place where the name at a byte is given.
pub(super) fn definition(document: &Document, byte: usize) -> Option<Range<usize>> {
    at(document, byte).map(|known| known.span)
}

/// The coordinate whose rate a name is, `phi` of `phi_dot`; other names as they are.
fn owner_of_rate<'n>(all: &[Defined], name: &'n str) -> &'n str {
    let is_known = |name: &str| all.iter().any(|known| known.name == name);
    let stem = name.strip_suffix("_dot").filter(|stem| !is_known(name) && is_known(stem));
    stem.unwrap_or(name)
}

/// The places of the name at a byte: where it is given, and all texts, headers and keys that use it.
pub(super) fn references(document: &Document, byte: usize) -> Vec<Range<usize>> {
    let places = Places::of(&document.text);
    at(document, byte).map(|known| names::uses(&places, &known)).unwrap_or_default()
}

/// The edits that give the name at a byte a new one.
///
/// # Errors
/// A sentence about a place without a name of the author's, or about the new name.
pub(super) fn rename(document: &Document, byte: usize, new: &str) -> Result<Value, String> {
    let Some(known) = at(document, byte) else {
        let word = document.text.get(document.word(byte)).unwrap_or_default();
        return Err(format!("`{word}` is no name that this file gives"));
    };
    let places = Places::of(&document.text);
    names::check_new(&places, &known, new)
        .map_err(|fault| fault.diagnostic(&document.text).message)?;
    let edits = names::uses(&places, &known);
    Ok(edits.iter().map(|span| json!({ "range": document.range(span), "newText": new })).collect())
}

/// The names of a text as an outline: a symbol for each header or value of its own, with its points or parameters.
pub(super) fn outline(document: &Document) -> Value {
    let text = &document.text;
    let all = places(text);
    let headers: Vec<&Place> = all.iter().filter(|place| place.kind == Kind::Header).collect();
    let symbols = headers.iter().enumerate().map(|(i, header)| {
        let end = headers.get(i + 1).map_or(text.len(), |next| next.span.start);
        let end = header.span.start + text[header.span.start..end].trim_end().len();
        let is_inside = |place: &&Place| (header.span.start..end).contains(&place.span.start);
        let own = all.iter().filter(is_inside);
        let children = own.clone().filter_map(|place| {
            let name = match place.path.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
                [_, name] if header.path.len() == 1 && place.kind != Kind::Header => {
                    (*name).to_owned()
                }
                ["bodies", _, "points", point] | ["ground", "points", point] => (*point).to_owned(),
                _ => return None,
            };
            let key = place.keys.first()?;
            let detail = text[place.span.clone()].lines().next().unwrap_or_default();
            Some(symbol(
                document,
                (&name, detail),
                CONSTANT,
                (&(key.start..place.span.end), key),
                json!([]),
            ))
        });
        let of_type = own.clone().find(|place| place.path.len() == 3 && place.path[2] == "type");
        let of_type = of_type.and_then(|place| place.inside(text)).map(|at| &text[at]);
        let section = header.path.first().map_or("", String::as_str);
        let (name, detail) = match header.path.as_slice() {
            [_, names @ ..] if !names.is_empty() => {
                (names.join("."), format!("{section} {}", of_type.unwrap_or_default()))
            }
            _ => (section.to_owned(), String::new()),
        };
        let name = if name.is_empty() { "?" } else { name.as_str() };
        let kind = if header.path.len() > 1 { OBJECT } else { MODULE };
        symbol(
            document,
            (name, detail.trim()),
            kind,
            (&(header.span.start..end), &header.span),
            children.collect(),
        )
    });
    symbols.collect()
}

/// Kinds of symbols, as the protocol numbers them.
const MODULE: u32 = 2;
const CONSTANT: u32 = 14;
const OBJECT: u32 = 19;

#[expect(clippy::needless_pass_by_value, reason = "values of JSON are moved")]
fn symbol(
    document: &Document,
    (name, detail): (&str, &str),
    kind: u32,
    (whole, own): (&Range<usize>, &Range<usize>),
    children: Value,
) -> Value {
    json!({
        "name": name,
        "detail": detail,
        "kind": kind,
        "range": document.range(whole),
        "selectionRange": document.range(own),
        "children": children,
    })
}
