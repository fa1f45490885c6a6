//! Names of a model: whether they are free, and where they are used.

use std::ops::Range;

use bksim_model::file::{NAMED, is_name, is_word, names_in};

use crate::draft::Draft;
use crate::edit::EditError;
use crate::places::{Kind, Place, Places};

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

/// The uses of a name in the texts of values, with the places of the values.
pub(crate) fn uses<'p>(places: &'p Places<'_>, name: &str) -> Vec<(&'p Place, Vec<Range<usize>>)> {
    let all = given(places);
    let is_own = |word: &str| word == name || all.iter().any(|(_, own)| own == word);
    let mut found = Vec::new();
    for place in &places.all {
        // A point of a body may have the name of a joint; after `about` comes a point.
        let is_point = place.path.last().is_some_and(|key| key == "about");
        let is_name = !is_point && !is_word(&place.path);
        let Some(quoted) = places.quoted(place).filter(|_| is_name) else { continue };
        let inside = place.span.start + 1;
        let spans: Vec<Range<usize>> = names_in(quoted, &is_own)
            .into_iter()
            .filter(|span| {
                let first = quoted[span.clone()].split('.').next().unwrap_or_default();
                first == name || first.strip_suffix("_dot") == Some(name)
            })
            .map(|span| inside + span.start..inside + span.start + name.len())
            .collect();
        if !spans.is_empty() {
            found.push((place, spans));
        }
    }
    found
}

/// Gives an element another name wherever it is used.
///
/// # Errors
/// [`EditError`] where there is no such element, or the name cannot be given.
pub(crate) fn rename(draft: &mut Draft, name: &str, to: &str) -> Result<(), EditError> {
    let places = draft.places()?;
    if section_of(&places, name).is_none() {
        return Err(EditError::missing(&[name]));
    }
    if !is_name(to) {
        return Err(EditError::NoName { name: to.to_owned() });
    }
    if to == "ground" || given(&places).iter().any(|(_, own)| own == to) {
        return Err(EditError::Taken { name: to.to_owned() });
    }
    let mut spans: Vec<Range<usize>> =
        uses(&places, name).into_iter().flat_map(|(_, spans)| spans).collect();
    // Headers, and keys below a section: `[bodies.rod]`, `rod = 1`, `rod.mass = 1`.
    for place in &places.all {
        let is_element = place.path.len() >= 2
            && place.path[1] == name
            && (NAMED.contains(&place.path[0].as_str()) || place.path[0] == "initial");
        if !is_element {
            continue;
        }
        if place.kind == Kind::Table {
            let header = places.text_of(place);
            let keyed = header.find(&format!(".{name}")).map(|at| place.span.start + at + 1);
            spans.extend(keyed.map(|at| at..at + name.len()));
        } else {
            spans.extend(key_in_line(&places, place, name));
        }
    }
    spans.extend(in_keys(&places, name));
    spans.sort_by_key(|span| span.start);
    spans.dedup();
    for span in spans.into_iter().rev() {
        draft.text.replace_range(span, to);
    }
    Ok(())
}

/// The name as a key of the line of a value: `rod = 1`, `rod.mass = 1`.
fn key_in_line(places: &Places<'_>, place: &Place, name: &str) -> Option<Range<usize>> {
    let own = place.key.clone().filter(|key| &places.text[key.clone()] == name);
    if own.is_some() {
        return own;
    }
    let start = places.line_start(place.key.as_ref()?.start);
    let line = &places.text[start..place.key.as_ref()?.start];
    let at = line.len() - line.trim_start().len();
    let rest = line[at..].strip_prefix(name)?;
    rest.trim_start().starts_with('.').then(|| start + at..start + at + name.len())
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

/// The name among the keys of such tables.
fn in_keys(places: &Places<'_>, name: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    for (place, at) in keyed(places, name) {
        if place.kind == Kind::Table {
            let header = places.text_of(place);
            let keyed = header.rfind(&format!(".{name}")).map(|at| place.span.start + at + 1);
            found.extend(keyed.map(|at| at..at + name.len()));
            continue;
        }
        let Some((start, idx)) = places.start_of_keys(place, at) else { continue };
        if idx == at && places.text[start..].starts_with(name) {
            found.push(start..start + name.len());
        }
    }
    found
}
