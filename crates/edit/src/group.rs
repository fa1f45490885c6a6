//! Several elements at once: moved, copied with all that is among them, or deleted.

use bksim_model::file::{NAMED, WrittenUnit, is_word, names_in};

use crate::copy::{keys_below, value};
use crate::delete::delete;
use crate::draft::{Draft, written_text};
use crate::edit::{Deed, EditError};
use crate::names::{fresh_among, fresh_point, given, section_of};
use crate::numbers::{file_unit, length, literal};
use crate::places::Places;
use crate::scan::Place;

/// Does the deed to all elements of these names.
///
/// # Errors
/// [`EditError::Missing`] where there is no such element, or nothing of it can be moved or copied.
pub(crate) fn group(draft: &mut Draft, names: &[String], deed: Deed) -> Result<(), EditError> {
    let places = draft.places()?;
    let unknown = names.iter().find(|name| section_of(&places, name).is_none());
    if let Some(name) = unknown {
        return Err(EditError::missing(&[name]));
    }
    if names.is_empty() {
        return Err(EditError::missing(&["names"]));
    }
    match deed {
        Deed::Delete => {
            for name in names {
                // It may have gone with one before it.
                if section_of(&draft.places()?, name).is_some() {
                    delete(draft, name)?;
                }
            }
            Ok(())
        }
        Deed::Move(by) => move_all(draft, names, by),
        Deed::Copy(by) => copy_all(draft, names, by),
    }
}

/// Moves bodies: the places of the ground where they are attached, and where their start puts them.
fn move_all(draft: &mut Draft, names: &[String], by: [f64; 2]) -> Result<(), EditError> {
    let places = draft.places()?;
    let attached = attached_points(&places, |refs| refs.iter().any(|name| names.contains(name)));
    let in_point = |path: &[String], axis: &str| {
        matches!(path, [ground, points, point, own] if ground == "ground" && points == "points"
            && attached.contains(point) && own == axis)
    };
    let of_start = |path: &[String], key: &str| {
        path.len() > 2
            && path[0] == "initial"
            && names.contains(&path[1])
            && path.last().is_some_and(|last| last == key)
    };
    let mut changes: Vec<(std::ops::Range<usize>, String)> = Vec::new();
    for place in places.all.iter().filter(|place| place.is_value()) {
        for (i, [axis, key]) in [["0", "x"], ["1", "y"]].into_iter().enumerate() {
            if in_point(&place.path, axis) || of_start(&place.path, key) {
                changes.push((place.span.clone(), shifted(&places, place, by[i])));
            }
        }
    }
    if changes.is_empty() {
        return Err(EditError::missing(&["initial", &names[0], "x"]));
    }
    for (span, text) in changes.into_iter().rev() {
        draft.text.replace_range(span, &text);
    }
    Ok(())
}

/// Copies bodies, and what is between them or between them and the ground.
fn copy_all(draft: &mut Draft, names: &[String], by: [f64; 2]) -> Result<(), EditError> {
    let places = draft.places()?;
    let copied = among(&places, names);
    let mut renamed: Vec<[String; 2]> = Vec::new();
    for (_, name) in &copied {
        let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
        let taken: Vec<String> = renamed.iter().map(|[_, new]| new.clone()).collect();
        renamed.push([name.clone(), fresh_among(&places, &taken, stem)]);
    }
    let old = |name: &String| renamed.iter().any(|[old, _]| old == name);
    let attached = attached_points(&places, |refs| refs.iter().any(old) && refs.iter().all(old));

    // Places of the ground for the copies.
    let mut points: Vec<[String; 2]> = Vec::new();
    for point in attached {
        let places = draft.places()?;
        let of = |axis: &str| places.find(&["ground", "points", &point, axis]);
        let (Some(x), Some(y)) = (of("0"), of("1")) else { continue };
        let own = fresh_point(&places, &["ground"]);
        let at = format!("[{}, {}]", shifted(&places, x, by[0]), shifted(&places, y, by[1]));
        draft.set(&["ground", "points", &own], &at)?;
        points.push([point, own]);
    }

    // The elements with their new names, and their starts.
    let places = Draft::new(&draft.text);
    let places = places.places()?;
    let written = |place: &Place| {
        let axis = place.path.last().and_then(|key| ["x", "y"].iter().position(|own| own == key));
        match axis {
            Some(axis) if place.path[0] == "initial" => shifted(&places, place, by[axis]),
            _ => with_names(&places, place, &renamed, &points),
        }
    };
    for ((section, _), [name, own]) in copied.iter().zip(&renamed) {
        let path = [*section, name];
        let keys = keys_below(&places, &path);
        let is_own =
            |key: &&String| !["coordinate", "coordinates", "count"].contains(&key.as_str());
        let pair =
            |key: &String| (key.clone(), value(&places, &[*section, name, key], false, &written));
        let pairs: Vec<(String, String)> = keys.iter().filter(is_own).map(pair).collect();
        draft.add_table(&[section, own], &pairs)?;
        if places.below(&["initial", name]).next().is_some() {
            draft.set(&["initial", own], &value(&places, &["initial", name], false, &written))?;
        }
    }
    Ok(())
}

/// The bodies of these names, and every other element that names some of them, or joints between them, and no others.
fn among(places: &Places<'_>, names: &[String]) -> Vec<(&'static str, String)> {
    let all = given(places);
    let mut found: Vec<(&'static str, String)> = all
        .iter()
        .filter(|(section, name)| *section == "bodies" && names.contains(name))
        .cloned()
        .collect();
    for round in [&["joints"][..], &NAMED[..]] {
        for (section, name) in &all {
            let is_other = ["bodies", "parameters"].contains(section)
                || !round.contains(section)
                || found.iter().any(|(_, known)| known == name);
            if is_other {
                continue;
            }
            let refs = references(places, &[section, name]);
            let is_in = |name: &String| found.iter().any(|(_, known)| known == name);
            if !refs.is_empty() && refs.iter().all(is_in) {
                found.push((section, name.clone()));
            }
        }
    }
    found
}

/// The bodies and joints that an element names.
fn references(places: &Places<'_>, path: &[&str]) -> Vec<String> {
    let all = given(places);
    let is_own = |word: &str| all.iter().any(|(_, own)| own == word);
    let mut found = Vec::new();
    for place in places.below(path).filter(|place| !is_word(&place.path)) {
        let Some(quoted) = places.quoted(place) else { continue };
        for span in names_in(quoted, &is_own) {
            let first = quoted[span].split('.').next().unwrap_or_default();
            let section = section_of(places, first).unwrap_or_default();
            if section != "parameters" && !section.is_empty() {
                found.push(first.to_owned());
            }
        }
    }
    found
}

/// Names of the points of the ground at which joints and loads of some bodies are attached.
fn attached_points(places: &Places<'_>, is_of: impl Fn(&[String]) -> bool) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    let elements = given(places).into_iter().filter(|(section, _)| *section != "parameters");
    for (section, name) in elements {
        if !is_of(&references(places, &[section, &name])) {
            continue;
        }
        let texts = places.below(&[section, &name]).filter_map(|place| places.quoted(place));
        let points = texts.filter_map(|text| text.trim().strip_prefix("ground."));
        for point in points {
            if !found.iter().any(|known| known == point) {
                found.push(point.to_owned());
            }
        }
    }
    found
}

/// A value with the names of the copies in place of those that were copied.
fn with_names(
    places: &Places<'_>,
    place: &Place,
    renamed: &[[String; 2]],
    points: &[[String; 2]],
) -> String {
    let mut text = places.text_of(place).to_owned();
    let Some(quoted) = places.quoted(place).filter(|_| !is_word(&place.path)) else { return text };
    let is_own = |word: &str| renamed.iter().any(|[old, _]| old == word);
    for span in names_in(quoted, &is_own).into_iter().rev() {
        let name = &quoted[span.clone()];
        let (first, rest) = name.split_once('.').map_or((name, None), |(a, b)| (a, Some(b)));
        let of = |all: &[[String; 2]], name: &str| {
            all.iter().find(|[old, _]| old == name).map(|[_, new]| new.clone())
        };
        let new = match (of(renamed, first), rest) {
            (Some(new), Some(rest)) => Some(format!("{new}.{rest}")),
            (Some(new), None) => Some(new),
            (None, Some(rest)) if first == "ground" => {
                of(points, rest).map(|new| format!("ground.{new}"))
            }
            _ => None,
        };
        if let Some(new) = new {
            text.replace_range(span.start + 1..=span.end, &new);
        }
    }
    text
}

/// A coordinate and a length more, as TOML: a length grows, and a formula gets a term.
fn shifted(places: &Places<'_>, place: &Place, by: f64) -> String {
    let text = places.quoted(place).unwrap_or(places.text_of(place)).trim();
    let si = |number: f64, unit: &str| {
        let unit = if unit.is_empty() { file_unit(places, "length") } else { unit.to_owned() };
        WrittenUnit::parse(&unit).map_or(number, |unit| unit.to_si(number))
    };
    if let Some(known) = literal(text) {
        return written_text(&length(si(known.number, &known.unit) + by));
    }
    // A term that was added before grows.
    let ends = [(" + ", 1.0), (" - ", -1.0)];
    let term = ends.iter().find_map(|(sign, factor)| {
        let at = text.rfind(sign)?;
        let known = literal(&text[at + sign.len()..]).filter(|known| !known.unit.is_empty())?;
        Some((at, factor * si(known.number, &known.unit)))
    });
    let (head, known) = term.map_or((text, 0.0), |(at, known)| (&text[..at], known));
    let total = known + by;
    if total.abs() < 5e-7 {
        return written_text(head);
    }
    let sign = if total < 0.0 { '-' } else { '+' };
    written_text(&format!("{head} {sign} {}", length(total.abs())))
}
