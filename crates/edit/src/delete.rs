//! Taking elements out, with all that cannot be without them.

use bksim_model::file::NAMED;

use crate::draft::Draft;
use crate::edit::EditError;
use crate::names::{keyed, section_of, uses};
use crate::places::{Kind, Place, Places};

/// Takes out an element of this name.
///
/// # Errors
/// [`EditError::Missing`], or [`EditError::Used`] of a parameter that other values use.
pub(crate) fn delete(draft: &mut Draft, name: &str) -> Result<(), EditError> {
    let places = draft.places()?;
    let section = section_of(&places, name).ok_or_else(|| EditError::missing(&[name]))?;
    if section == "parameters" {
        return delete_parameter(draft, name);
    }
    let mut left = vec![name.to_owned()];
    let mut gone: Vec<String> = Vec::new();
    while let Some(name) = left.pop() {
        let places = draft.places()?;
        if let Some(section) = section_of(&places, &name) {
            left.extend(coordinates(&places, section, &name));
            draft.remove(&[section, &name])?;
        }
        remove_keys(draft, &name)?;
        gone.push(name.clone());
        // A point of a body goes with it, and so do its values at the start.
        let places = draft.places()?;
        if places.below(&["initial", &name]).next().is_some() {
            draft.remove(&["initial", &name])?;
        }
        let places = draft.places()?;
        for dependent in dependents(&places, &name) {
            if !gone.contains(&dependent) && !left.contains(&dependent) {
                left.push(dependent);
            }
        }
    }
    Ok(())
}

/// Names of coordinates that go with a joint or body.
fn coordinates(places: &Places<'_>, section: &str, name: &str) -> Vec<String> {
    let of_key = |key: &str| {
        let texts = places
            .below(&[section, name])
            .filter(|place| place.path[2..].first().is_some_and(|k| k == key));
        texts.filter_map(|place| places.quoted(place)).map(str::to_owned).collect::<Vec<_>>()
    };
    [of_key("coordinate"), of_key("coordinates")].concat()
}

/// Elements with a value that uses a name.
fn dependents(places: &Places<'_>, name: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for (place, _) in uses(places, name) {
        let [section, element, ..] = place.path.as_slice() else { continue };
        if NAMED.contains(&section.as_str()) && section != "parameters" && !found.contains(element)
        {
            found.push(element.clone());
        }
    }
    found
}

fn delete_parameter(draft: &mut Draft, name: &str) -> Result<(), EditError> {
    let places = draft.places()?;
    if let Some((place, _)) = uses(&places, name).first() {
        return Err(EditError::Used { name: name.to_owned(), by: place.path.join(".") });
    }
    remove_keys(draft, name)?;
    draft.remove(&["parameters", name])
}

/// Takes out what load cases, ranges and questions of design say of a name.
fn remove_keys(draft: &mut Draft, name: &str) -> Result<(), EditError> {
    loop {
        let places = draft.places()?;
        // Keys before a dot are no values of their own.
        let is_whole = |place: &Place| {
            place.kind == Kind::Table || place.key.as_ref().is_some_and(|key| *key != place.span)
        };
        let path = keyed(&places, name).map(|(place, _)| place).find(|place| is_whole(place));
        let Some(path) = path.map(|place| place.path.clone()) else { return Ok(()) };
        let keys: Vec<&str> = path.iter().map(String::as_str).collect();
        draft.remove(&keys)?;
    }
}
