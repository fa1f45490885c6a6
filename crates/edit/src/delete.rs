//! Taking elements out, with all that cannot be without them.

use bksim_model::file::NAMED;

use crate::draft::Draft;
use crate::edit::EditError;
use crate::names::{COORDINATES, in_values, keyed, section_of};
use crate::places::Places;

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
    let (kept, joined) = (used(&places), bodies_in_joints(&places));
    let mut left = vec![name.to_owned()];
    let mut gone: Vec<String> = Vec::new();
    while let Some(name) = left.pop() {
        let places = draft.places()?;
        let section = section_of(&places, &name);
        if let Some(section) = section {
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
        for dependent in dependents(&places, section.unwrap_or(COORDINATES), &name) {
            if !gone.contains(&dependent) && !left.contains(&dependent) {
                left.push(dependent);
            }
        }
    }
    // A body that lost its last joint floats, as one that is drawn by itself does.
    let places = draft.places()?;
    let still = bodies_in_joints(&places);
    let is_loose = |body: &String| {
        joined.contains(body)
            && !still.contains(body)
            && places.find(&["bodies", body, "free"]).is_none()
    };
    let loose: Vec<String> = places.elements("bodies").into_iter().filter(is_loose).collect();
    for body in &loose {
        draft.set(&["bodies", body, "free"], "true")?;
    }
    remove_idle(draft, &kept)
}

/// Bodies that are in a joint.
fn bodies_in_joints(places: &Places<'_>) -> Vec<String> {
    let ends = places
        .below(&["joints"])
        .filter(|place| place.path.get(2).is_some_and(|key| key == "between"));
    let names = ends.filter_map(|place| places.quoted(place)?.split('.').next());
    names.map(str::to_owned).collect()
}

/// Paths of parameters and points of the ground that something uses.
fn used(places: &Places<'_>) -> Vec<[String; 2]> {
    let parameters = places.elements("parameters").into_iter();
    let parameters = parameters.filter(|name| !in_values(places, "parameters", name).is_empty());
    let points = places.below(&["ground", "points"]).filter_map(|place| place.path.get(2));
    let points = points.filter(|name| {
        let point = format!("ground.{name}");
        places.all.iter().filter_map(|place| places.quoted(place)).any(|text| {
            let rests = text.match_indices(&point).map(|(at, _)| &text[at + point.len()..]);
            rests
                .into_iter()
                .any(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_'))
        })
    });
    let of = |section: &str, name: &String| [section.to_owned(), name.clone()];
    let mut found: Vec<_> = points.map(|name| of("ground", name)).collect();
    found.extend(parameters.map(|name| of("parameters", &name)));
    found.dedup();
    found
}

/// Takes out parameters and points of the ground that were used once and no longer are.
fn remove_idle(draft: &mut Draft, before: &[[String; 2]]) -> Result<(), EditError> {
    let mut known = before.to_vec();
    loop {
        let places = draft.places()?;
        let now = used(&places);
        let is_idle = |[section, name]: &&[String; 2]| {
            !now.iter().any(|own| own[0] == *section && own[1] == *name)
                && keyed(&places, name).next().is_none()
        };
        let Some([section, name]) = known.iter().find(is_idle).cloned() else { return Ok(()) };
        known.retain(|own| own[0] != section || own[1] != name);
        if section == "ground" {
            draft.remove(&["ground", "points", &name])?;
        } else if draft.places()?.below(&["parameters", &name]).next().is_some() {
            draft.remove(&["parameters", &name])?;
        }
    }
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
fn dependents(places: &Places<'_>, section: &str, name: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for (place, _) in in_values(places, section, name) {
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
    if let Some((place, _)) = in_values(&places, "parameters", name).first() {
        return Err(EditError::Used { name: name.to_owned(), by: place.path.join(".") });
    }
    remove_keys(draft, name)?;
    draft.remove(&["parameters", name])
}

/// Takes out what load cases, ranges and questions of design say of a name.
fn remove_keys(draft: &mut Draft, name: &str) -> Result<(), EditError> {
    loop {
        let places = draft.places()?;
        let path =
            keyed(&places, name).map(|(place, _)| place).find(|place| !place.keys.is_empty());
        let Some(path) = path.map(|place| place.path.clone()) else { return Ok(()) };
        let keys: Vec<&str> = path.iter().map(String::as_str).collect();
        draft.remove(&keys)?;
    }
}
