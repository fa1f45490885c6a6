//! Names of a model: where they are given, where they are used, and which are free.

use std::ops::Range;

use bksim_model::file::{NAMED, OWNERS, is_name, is_word, names_in};

use crate::draft::Draft;
use crate::edit::EditError;
use crate::places::Places;
use crate::scan::Place;

/// The section of names that joints and bodies give to their coordinates.
pub const COORDINATES: &str = "coordinates";
/// The section of points, whose names have those of their bodies before them.
pub const POINTS: &str = "points";

/// A name that the author gave, and where.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Defined {
    /// Section of the definition, `joints` or `parameters`, or [`COORDINATES`] or [`POINTS`].
    pub section: String,
    /// Name, of a point with its body: `rod.B`.
    pub name: String,
    /// Span of the definition, of a point without its body.
    pub span: Range<usize>,
}

impl Defined {
    /// True of names that stand alone: all but points.
    pub fn is_plain(&self) -> bool {
        self.section != POINTS
    }
}

/// All names, each where it is given first.
pub fn defined(places: &Places<'_>) -> Vec<Defined> {
    let mut found: Vec<Defined> = Vec::new();
    for place in &places.all {
        let path: Vec<&str> = place.path.iter().map(String::as_str).collect();
        let (section, name, span) = match path.as_slice() {
            ["joints", _, "coordinate"]
            | ["joints" | "bodies", _, "coordinate" | "coordinates", _] => {
                let Some(inside) = place.inside(places.text) else { continue };
                (COORDINATES, places.text[inside.clone()].to_owned(), Some(inside))
            }
            ["bodies", body, "points", point] => {
                (POINTS, format!("{body}.{point}"), bare_key(places, place, 3))
            }
            ["ground", "points", point] => {
                (POINTS, format!("ground.{point}"), bare_key(places, place, 2))
            }
            [section, name, ..] if NAMED.contains(section) => {
                (*section, (*name).to_owned(), bare_key(places, place, 1))
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

/// The span of a part of a path without its quotes, if it is written at this place.
fn bare_key(places: &Places<'_>, place: &Place, idx: usize) -> Option<Range<usize>> {
    let key = place.key(idx)?;
    let is_quoted = places.text[key.start..].starts_with(['"', '\'']);
    Some(if is_quoted { key.start + 1..key.end - 1 } else { key.clone() })
}

/// All spans of a name, ascending: where it is given, and in the keys and values that use it.
pub fn uses(places: &Places<'_>, known: &Defined) -> Vec<Range<usize>> {
    let mut found = vec![known.span.clone()];
    found.extend(in_keys(places, known));
    let values = in_values(places, &known.section, &known.name);
    found.extend(values.into_iter().flat_map(|(_, spans)| spans));
    found.sort_by_key(|span| span.start);
    found.dedup();
    found
}

/// Checks that a name can be replaced by another one, of a point without its body.
///
/// # Errors
/// [`EditError::NoName`], or [`EditError::Taken`].
pub fn check_new(places: &Places<'_>, known: &Defined, new: &str) -> Result<(), EditError> {
    if !is_name(new) {
        return Err(EditError::NoName { name: new.to_owned() });
    }
    let whole = match known.name.split_once('.') {
        Some((body, _)) => format!("{body}.{new}"),
        None => new.to_owned(),
    };
    if whole == "ground" || defined(places).iter().any(|other| other.name == whole) {
        return Err(EditError::Taken { name: whole });
    }
    Ok(())
}

/// All names that the model gives, with their sections.
pub(crate) fn given(places: &Places<'_>) -> Vec<(&'static str, String)> {
    let of = |section: &'static str| {
        places.elements(section).into_iter().map(move |name| (section, name))
    };
    NAMED.into_iter().flat_map(of).collect()
}

/// The section of a name, bodies and joints first.
pub(crate) fn section_of(places: &Places<'_>, name: &str) -> Option<&'static str> {
    let all = given(places);
    let of = |wanted: &str| all.iter().find(|(section, own)| own == name && *section == wanted);
    let first = of("bodies").or_else(|| of("joints"));
    first.or_else(|| all.iter().find(|(_, own)| own == name)).map(|(section, _)| *section)
}

/// A name that nothing has yet: the stem with the first free number.
pub(crate) fn fresh(places: &Places<'_>, stem: &str) -> String {
    fresh_among(places, &[], stem)
}

/// A name that neither the text has yet nor these are.
pub(crate) fn fresh_among(places: &Places<'_>, taken: &[String], stem: &str) -> String {
    let all = given(places);
    let is_free = |name: &String| all.iter().all(|(_, own)| own != name) && !taken.contains(name);
    (1..=all.len() + taken.len() + 1)
        .map(|k| format!("{stem}{k}"))
        .find(is_free)
        .unwrap_or_default()
}

/// A point of a body that has no name yet: letters from A on.
pub(crate) fn fresh_point(places: &Places<'_>, body: &[&str]) -> String {
    let is_taken = |name: &str| {
        let path = [body, &["points", name]].concat();
        places.below(&path).next().is_some()
    };
    let letters = ('A'..='Z').map(|letter| letter.to_string());
    let numbered = (1..=places.all.len() + 1).map(|k| format!("P{k}"));
    letters.chain(numbered).find(|name| !is_taken(name)).unwrap_or_default()
}

/// The uses of a name of a section in the texts of values, with the places of the values.
pub(crate) fn in_values<'p>(
    places: &'p Places<'_>,
    section: &str,
    name: &str,
) -> Vec<(&'p Place, Vec<Range<usize>>)> {
    let all = defined(places);
    let is_own = |word: &str| word == name || all.iter().any(|known| known.name == word);
    let mut found = Vec::new();
    for place in &places.all {
        // A point of a body may have the name of a joint; after `about` comes a point.
        let is_point = place.path.last().is_some_and(|key| key == "about");
        let inside = place.inside(places.text).filter(|_| !is_point && !is_word(&place.path));
        let Some(inside) = inside else { continue };
        let quoted = &places.text[inside.clone()];
        let spans: Vec<Range<usize>> = names_in(quoted, &is_own)
            .into_iter()
            .filter_map(|span| {
                let part = within(quoted.get(span.clone())?, section, name)?;
                let start = inside.start + span.start;
                Some(start + part.start..start + part.end)
            })
            .collect();
        if !spans.is_empty() {
            found.push((place, spans));
        }
    }
    found
}

/// The span of a name within a dotted one: `rod` or `B` in `rod.B.x`, `A` in `reactions.A.fx`, `phi` in `phi_dot`.
fn within(dotted: &str, section: &str, name: &str) -> Option<Range<usize>> {
    let parts: Vec<&str> = dotted.split('.').collect();
    if let Some((body, point)) = name.split_once('.') {
        let from = body.len() + 1;
        return (parts.len() > 1 && parts[0] == body && parts[1] == point)
            .then(|| from..from + point.len());
    }
    let is_owner = |(owner, of): &&(&str, &str)| parts[0] == *owner && section == *of;
    let is_owned = parts.len() > 1 && OWNERS.iter().any(|owner| is_owner(&owner));
    let idx = usize::from(is_owned);
    let from = if is_owned { parts[0].len() + 1 } else { 0 };
    is_it(parts[idx], name).then(|| from..from + name.len())
}

/// True if a word is a name or its rate.
fn is_it(word: &str, name: &str) -> bool {
    word == name || word.strip_suffix("_dot") == Some(name)
}

/// The spans of a name among keys: headers, keys below its section and `[initial]`, and [`keyed`] tables.
fn in_keys(places: &Places<'_>, known: &Defined) -> Vec<Range<usize>> {
    let name = known.name.as_str();
    if !known.is_plain() {
        return Vec::new();
    }
    let of_section = places.all.iter().filter(|place| {
        place.path.first().is_some_and(|own| *own == known.section || own == "initial")
            && place.path.get(1).is_some_and(|own| is_it(own, name))
    });
    let all = of_section.map(|place| (place, 1)).chain(keyed(places, name));
    let keys = all.filter_map(|(place, idx)| bare_key(places, place, idx));
    keys.map(|key| key.start..key.start + name.len()).collect()
}

/// Gives an element another name wherever it is used.
///
/// # Errors
/// [`EditError`] where there is no such element, or the name cannot be given.
pub(crate) fn rename(draft: &mut Draft, name: &str, to: &str) -> Result<(), EditError> {
    let places = draft.places()?;
    let section = section_of(&places, name).ok_or_else(|| EditError::missing(&[name]))?;
    let mut all = defined(&places).into_iter();
    let known = all.find(|known| known.section == section && known.name == name);
    let known = known.ok_or_else(|| EditError::missing(&[name]))?;
    check_new(&places, &known, to)?;
    for span in uses(&places, &known).into_iter().rev() {
        draft.text.replace_range(span, to);
    }
    Ok(())
}

/// Tables whose keys are names or paths of the model, any word in place of `*`.
const KEYED: [&[&str]; 9] = [
    &["cases", "*", "set"],
    &["ranges"],
    &["optimize", "vary"],
    &["optimize", "cases", "*"],
    &["optimize", "from", "*"],
    &["fit", "vary"],
    &["tolerance", "limits"],
    &["tolerance", "play"],
    &["tolerance", "at"],
];

/// Places whose path below such a table begins with a name, with the number of its key: `set = { rod.mass = 1,
/// initial.A.angle = 0 }`.
pub(crate) fn keyed<'p>(
    places: &'p Places<'_>,
    name: &str,
) -> impl Iterator<Item = (&'p Place, usize)> {
    places.all.iter().filter_map(move |place| {
        let is_in = |table: &&&[&str]| {
            let both = table.iter().zip(&place.path);
            place.path.len() > table.len() && both.into_iter().all(|(a, b)| *a == "*" || a == b)
        };
        let start = KEYED.iter().find(is_in)?.len();
        let keys = &place.path[start..];
        let is_section = |key: &String| key == "initial" || NAMED.contains(&key.as_str());
        let at = usize::from(keys.len() > 1 && is_section(&keys[0]) && keys[0] != name);
        (keys.get(at)? == name).then_some((place, start + at))
    })
}
