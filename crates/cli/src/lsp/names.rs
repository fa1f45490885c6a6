//! Names: where they are given and where they are used.

use std::ops::Range;

use bksim::model::file::{NAMED, is_name, is_word, names_in};
use serde_json::{Value, json};

use super::document::Document;
use super::scan::{Kind, Piece, pieces};

/// The section of names that joints give to their coordinates.
pub(super) const COORDINATES: &str = "coordinates";
/// The section of points, whose names have those of their bodies before them.
pub(super) const POINTS: &str = "points";

/// A name that the author gave, with the place where he did.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Defined {
    /// Section of the definition, `joints` or `parameters`, or [`COORDINATES`] or [`POINTS`].
    pub(super) section: String,
    /// Name, of a point with its body: `rod.B`.
    pub(super) name: String,
    pub(super) span: Range<usize>,
}

impl Defined {
    /// True of names that stand alone: all but points.
    pub(super) fn is_plain(&self) -> bool {
        self.section != POINTS
    }
}

/// All names, each where it is given first.
pub(super) fn defined(text: &str) -> Vec<Defined> {
    let mut found: Vec<Defined> = Vec::new();
    for piece in pieces(text) {
        let path: Vec<&str> = piece.path.iter().map(String::as_str).collect();
        let (section, name, span) = match path.as_slice() {
            ["joints", _, "coordinate"] | ["joints", _, "coordinate", _] => {
                let Some(inside) = piece.inside(text) else { continue };
                (COORDINATES, text[inside.clone()].to_owned(), Some(inside))
            }
            ["bodies", body, "points", point] => {
                (POINTS, format!("{body}.{point}"), piece.key(3).cloned())
            }
            ["ground", "points", point] => {
                (POINTS, format!("ground.{point}"), piece.key(2).cloned())
            }
            [section, name, ..] if NAMED.contains(section) => {
                (*section, (*name).to_owned(), piece.key(1).cloned())
            }
            _ => continue,
        };
        let is_new = |span: &Range<usize>| {
            !found.iter().any(|known| {
                known.section == section && (known.name == name || known.span == *span)
            })
        };
        if let Some(span) = span.filter(is_new) {
            found.push(Defined { section: section.to_owned(), name, span });
        }
    }
    found
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
        ["reactions"] => named(name, true).filter(|known| known.section == "joints"),
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

/// The places of the name at a byte: where it is given, and all texts, headers and keys of `[initial]` that use it.
pub(super) fn references(document: &Document, byte: usize) -> Vec<Range<usize>> {
    at(document, byte).map(|known| uses(&document.text, &known)).unwrap_or_default()
}

fn uses(text: &str, known: &Defined) -> Vec<Range<usize>> {
    let all = defined(text);
    let is_own = |word: &str| all.iter().any(|known| known.name == word);
    let mut found = vec![known.span.clone()];
    for piece in pieces(text) {
        found.extend(of_key(&piece, known));
        if let Some(inside) = piece.inside(text)
            && !is_word(&piece.path)
        {
            let quoted = &text[inside.clone()];
            let names = names_in(quoted, &is_own).into_iter();
            found.extend(names.filter_map(|span| {
                let place = within(quoted.get(span.clone())?, known)?;
                let from = inside.start + span.start;
                Some(from + place.start..from + place.end)
            }));
        }
    }
    found.sort_by_key(|span| span.start);
    found.dedup();
    found
}

/// The place of a name in a key: of a header, of a section of names, of `[initial]`.
fn of_key(piece: &Piece, known: &Defined) -> Option<Range<usize>> {
    let section = piece.path.first()?.as_str();
    let is_here = match section {
        "initial" => true,
        section => section == known.section,
    };
    let key = piece.key(1).filter(|_| is_here && known.is_plain())?;
    let name = piece.path[1].as_str();
    let is_rate = name.strip_suffix("_dot") == Some(&known.name) && section == "initial";
    (name == known.name || is_rate).then(|| key.start..key.start + known.name.len())
}

/// The place of a name within a dotted one: `rod` or `B` in `rod.B.x`, `A` in `reactions.A.fx`, `phi` in `phi_dot`.
fn within(dotted: &str, known: &Defined) -> Option<Range<usize>> {
    let parts: Vec<&str> = dotted.split('.').collect();
    if let Some((body, point)) = known.name.split_once('.') {
        let from = body.len() + 1;
        return (parts.len() > 1 && parts[0] == body && parts[1] == point)
            .then(|| from..from + point.len());
    }
    let first = match (parts[0], known.section.as_str()) {
        ("reactions", "joints") | ("drives", "drives") if parts.len() > 1 => 1,
        _ => 0,
    };
    let from = parts[..first].iter().map(|part| part.len() + 1).sum::<usize>();
    let is_own =
        parts[first] == known.name || parts[first].strip_suffix("_dot") == Some(&known.name);
    is_own.then(|| from..from + known.name.len())
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
    if !is_name(new) {
        return Err(format!(
            "`{new}` is no name: letters a–z, digits and `_`, not starting with a digit"
        ));
    }
    let whole = known.name.split_once('.').map(|(body, _)| format!("{body}.{new}"));
    let whole = whole.as_deref().unwrap_or(new);
    if defined(&document.text).iter().any(|other| other.name == whole) {
        return Err(format!("the name `{new}` is already taken"));
    }
    let edits = uses(&document.text, &known);
    Ok(edits.iter().map(|span| json!({ "range": document.range(span), "newText": new })).collect())
}

/// The names of a text as an outline: a symbol for each header or value of its own, with its points or parameters.
pub(super) fn outline(document: &Document) -> Value {
    let text = &document.text;
    let all = pieces(text);
    let headers: Vec<&Piece> = all.iter().filter(|piece| piece.kind == Kind::Header).collect();
    let symbols = headers.iter().enumerate().map(|(i, header)| {
        let end = headers.get(i + 1).map_or(text.len(), |next| next.span.start);
        let end = header.span.start + text[header.span.start..end].trim_end().len();
        let is_inside = |piece: &&Piece| (header.span.start..end).contains(&piece.span.start);
        let own = all.iter().filter(is_inside);
        let children = own.clone().filter_map(|piece| {
            let name = match piece.path.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
                [_, name] if header.path.len() == 1 && piece.kind != Kind::Header => {
                    (*name).to_owned()
                }
                ["bodies", _, "points", point] | ["ground", "points", point] => (*point).to_owned(),
                _ => return None,
            };
            let key = piece.keys.first()?;
            let detail = text[piece.span.clone()].lines().next().unwrap_or_default();
            Some(symbol(
                document,
                (&name, detail),
                CONSTANT,
                (&(key.start..piece.span.end), key),
                json!([]),
            ))
        });
        let of_type = own.clone().find(|piece| piece.path.len() == 3 && piece.path[2] == "type");
        let of_type = of_type.and_then(|piece| piece.inside(text)).map(|at| &text[at]);
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
