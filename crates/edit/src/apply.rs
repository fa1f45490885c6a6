//! Edits applied to a text.

use crate::copy::copy;
use crate::delete::delete;
use crate::draft::{Draft, typed};
use crate::draw;
use crate::edit::{Edit, EditError};
use crate::group::group;
use crate::names::rename;
use crate::numbers::{Literal, file_unit, in_unit, literal, rounded, written};
use crate::places::Places;
use crate::scan::Kind;

/// The text after an edit; all that the edit is not about stays byte for byte.
///
/// # Errors
/// [`EditError`] says why the edit cannot be made.
///
/// ```
/// use bksim_edit::{Edit, edited};
///
/// let text = "[parameters]\nl = \"2 m\"   # long\n";
/// let edit = Edit::Set { path: "parameters.l".to_owned(), value: "250 mm".to_owned() };
/// assert_eq!(edited(text, &edit)?, "[parameters]\nl = \"250 mm\"   # long\n");
/// # Ok::<(), bksim_edit::EditError>(())
/// ```
pub fn edited(text: &str, edit: &Edit) -> Result<String, EditError> {
    let mut draft = Draft::new(text);
    apply(&mut draft, edit)?;
    Ok(draft.text)
}

fn apply(draft: &mut Draft, edit: &Edit) -> Result<(), EditError> {
    match edit {
        Edit::Text { text } => {
            text.clone_into(&mut draft.text);
            return Ok(());
        }
        Edit::Set { path, value } => draft.set(&keys(path), &typed(value))?,
        Edit::Remove { path } => draft.remove(&keys(path))?,
        Edit::Move { point, to } => move_point(draft, point, *to)?,
        Edit::Point { body, at } => draw::point(draft, body, *at).map(drop)?,
        Edit::Link { from, to } => draw::link(draft, from, to)?,
        Edit::Plate { corners } => draw::plate(draft, corners)?,
        Edit::Pin { from, to } => draw::pin(draft, from, to)?,
        Edit::Ground { at } => draw::ground(draft, at)?,
        Edit::Length { from, to, value } => set_length(draft, from, to, value)?,
        Edit::Slide { at, angle, guide } => draw::slide(draft, at, *angle, guide.as_ref())?,
        Edit::Gear { between, distance, phase } => draw::gear(draft, between, *distance, *phase)?,
        Edit::Copy { name, at, mirrored } => copy(draft, name, *at, *mirrored)?,
        Edit::Spring { from, to } => draw::spring(draft, from, to)?,
        Edit::Damper { from, to } => draw::damper(draft, from, to)?,
        Edit::Force { at, vector } => draw::force(draft, at, *vector)?,
        Edit::Gravity {} => draw::gravity(draft)?,
        Edit::Motor { joint, angle } => draw::motor(draft, joint, *angle)?,
        Edit::Rename { name, to } => rename(draft, name, to)?,
        Edit::Delete { name } => delete(draft, name)?,
        Edit::Group { names, to } => group(draft, names, *to)?,
        Edit::Several { edits } => {
            for edit in edits {
                apply(draft, edit)?;
            }
        }
    }
    // What was TOML stays TOML.
    draft.places().map(drop)
}

/// The keys of a path.
fn keys(path: &str) -> Vec<&str> {
    path.split('.').collect()
}

/// Writes a place into the coordinates of a point, each as it was written: in its unit, or in the parameter that it is.
fn move_point(draft: &mut Draft, point: &str, to: [f64; 2]) -> Result<(), EditError> {
    let path = point_path(&draft.places()?, point)?;
    let coordinate = |draft: &Draft, axis: &str| -> Result<Coordinate, EditError> {
        let places = draft.places()?;
        let keys: Vec<&str> = path.iter().map(String::as_str).chain([axis]).collect();
        Coordinate::of(&places, &keys).map_err(|formula| EditError::Formula {
            point: point.to_owned(),
            formula,
            path: keys.join("."),
        })
    };
    let [x, y] = [coordinate(draft, "0")?, coordinate(draft, "1")?];
    if x == Coordinate::Zero
        && y == Coordinate::Zero
        && let Some((other, end)) = only_length(&draft.places()?, &path)
    {
        // The origin of a link is moved: the frame goes with it, and the length is what is left.
        let length = (to[0] - end[0]).hypot(to[1] - end[1]);
        let keys: Vec<&str> = other.iter().map(String::as_str).collect();
        let written = Coordinate::of(&draft.places()?, &keys);
        return match written {
            Ok(known @ Coordinate::Parameter { sign, .. }) => {
                known.write(draft, &keys, sign * length)
            }
            _ => Ok(()),
        };
    }
    let length = to[0].hypot(to[1]);
    // The end of a link along an axis of its frame: its length is a parameter, and its direction the frame's.
    let [x_to, y_to] = match (&x, &y) {
        (Coordinate::Parameter { sign, .. }, Coordinate::Zero) => [sign * length, 0.0],
        (Coordinate::Zero, Coordinate::Parameter { sign, .. }) => [0.0, sign * length],
        _ => to,
    };
    for (axis, coordinate, value) in [("0", x, x_to), ("1", y, y_to)] {
        let keys: Vec<&str> = path.iter().map(String::as_str).chain([axis]).collect();
        coordinate.write(draft, &keys, value)?;
    }
    Ok(())
}

/// Writes another distance between two points of a body.
fn set_length(draft: &mut Draft, from: &str, to: &str, value: &str) -> Result<(), EditError> {
    let bodies = [from, to].map(|name| name.split('.').next().unwrap_or_default());
    if bodies[0] != bodies[1] || from == to {
        return Err(EditError::missing(&[from, to]));
    }
    let places = draft.places()?;
    let [from_path, to_path] = [point_path(&places, from)?, point_path(&places, to)?];
    let of = |path: &[String]| -> [Result<Coordinate, String>; 2] {
        ["0", "1"].map(|axis| {
            let keys: Vec<&str> = path.iter().map(String::as_str).chain([axis]).collect();
            Coordinate::of(&places, &keys)
        })
    };
    let formula = |point: &str, path: &[String]| EditError::Formula {
        point: point.to_owned(),
        formula: value.to_owned(),
        path: path.join("."),
    };
    let wanted = literal(value).and_then(|known| length_of(&places, &known));
    let wanted = wanted.filter(|wanted| *wanted > 0.0).ok_or_else(|| formula(to, &to_path))?;
    // One of them is the origin, the other one on an axis by a parameter: the parameter is the distance.
    for (origin, end) in [(&from_path, &to_path), (&to_path, &from_path)] {
        let is_origin = of(origin).iter().all(|c| *c == Ok(Coordinate::Zero));
        let ([Ok(Coordinate::Parameter { name, .. }), Ok(Coordinate::Zero)]
        | [Ok(Coordinate::Zero), Ok(Coordinate::Parameter { name, .. })]) = of(end)
        else {
            continue;
        };
        if is_origin {
            // A parameter below zero stays so.
            let is_below = places.find(&["parameters", &name]).is_some_and(|place| {
                places.text_of(place).trim_start_matches(['"', '\'']).starts_with('-')
            });
            let minus = if is_below { "-" } else { "" };
            return draft
                .replace(&["parameters", &name], &typed(&format!("{minus}{}", value.trim())));
        }
    }
    let [a, b] = [(from, &from_path), (to, &to_path)].map(|(point, path)| {
        let values = of(path).map(|c| c.ok().and_then(|c| c.value(&places)));
        let [Some(x), Some(y)] = values else { return Err(formula(point, path)) };
        Ok([x, y])
    });
    let (a, b) = (a?, b?);
    // A point on an axis, by a parameter, stays on it.
    let axis = match of(&to_path) {
        [Ok(Coordinate::Parameter { .. }), Ok(Coordinate::Zero)] => Some(0),
        [Ok(Coordinate::Zero), Ok(Coordinate::Parameter { .. })] => Some(1),
        _ => None,
    };
    let place = if let Some(axis) = axis {
        let along = (wanted * wanted - a[1 - axis] * a[1 - axis]).sqrt();
        if along.is_nan() {
            return Err(formula(to, &to_path));
        }
        let along = if b[axis] < a[axis] { -along } else { along };
        let mut place = [0.0; 2];
        place[axis] = a[axis] + along;
        place
    } else {
        let distance = (b[0] - a[0]).hypot(b[1] - a[1]);
        let unit =
            [0, 1].map(|i| if distance > 0.0 { (b[i] - a[i]) / distance } else { [1.0, 0.0][i] });
        [0, 1].map(|i| a[i] + wanted * unit[i])
    };
    move_point(draft, to, place)
}

/// A length as it is written, m; a bare number is in the unit of the file.
fn length_of(places: &Places<'_>, known: &Literal) -> Option<f64> {
    let bare = file_unit(places, "length");
    let unit = if known.unit.is_empty() { &bare } else { &known.unit };
    let unit = bksim_model::file::WrittenUnit::parse(unit)?;
    (unit.si() == "m").then(|| unit.to_si(known.number))
}

/// The path of the list of coordinates of a point.
fn point_path(places: &Places<'_>, point: &str) -> Result<Vec<String>, EditError> {
    let missing = || EditError::missing(&[point]);
    let (body, name) = point.split_once('.').ok_or_else(missing)?;
    let mut path: Vec<String> = match body {
        "ground" => vec!["ground".to_owned()],
        body => vec!["bodies".to_owned(), body.to_owned()],
    };
    path.extend(["points".to_owned(), name.to_owned()]);
    let kind = |path: &[String]| {
        let keys: Vec<&str> = path.iter().map(String::as_str).collect();
        places.find(&keys).map(|place| place.kind)
    };
    if kind(&path).ok_or_else(missing)? != Kind::Array {
        path.push("at".to_owned());
        kind(&path).ok_or_else(missing)?;
    }
    Ok(path)
}

/// The only other point of a body, where it is a parameter along an axis: the path of that coordinate, and the place.
fn only_length(places: &Places<'_>, path: &[String]) -> Option<(Vec<String>, [f64; 2])> {
    let (_, table) = path.split_last()?;
    let keys: Vec<&str> = table.iter().map(String::as_str).collect();
    if keys.first() != Some(&"bodies") {
        return None;
    }
    let points: Vec<&Vec<String>> = places
        .below(&keys)
        .filter(|place| place.path.len() == path.len() && place.kind == Kind::Array)
        .map(|place| &place.path)
        .collect();
    let [other] = points.into_iter().filter(|other| *other != path).collect::<Vec<_>>()[..] else {
        return None;
    };
    let coordinate = |axis: &str| {
        let keys: Vec<&str> = other.iter().map(String::as_str).chain([axis]).collect();
        Some((
            keys.iter().map(|key| (*key).to_owned()).collect::<Vec<_>>(),
            Coordinate::of(places, &keys).ok()?,
        ))
    };
    let [x, y] = [coordinate("0")?, coordinate("1")?];
    match (x, y) {
        ((path, x @ Coordinate::Parameter { .. }), (_, Coordinate::Zero)) => {
            Some((path, [x.value(places)?, 0.0]))
        }
        ((_, Coordinate::Zero), (path, y @ Coordinate::Parameter { .. })) => {
            Some((path, [0.0, y.value(places)?]))
        }
        _ => None,
    }
}

/// How a coordinate is written.
#[derive(Clone, PartialEq, Debug)]
enum Coordinate {
    /// `0`, without a unit.
    Zero,
    /// A number with its unit; empty where it is bare.
    Number { number: f64, unit: String, is_quoted: bool },
    /// A parameter or its opposite, with the unit of its value.
    Parameter { name: String, sign: f64, unit: String, is_quoted: bool },
}

impl Coordinate {
    /// That of a place; the formula where it is none of these.
    fn of(places: &Places<'_>, keys: &[&str]) -> Result<Self, String> {
        let Some(place) = places.find(keys) else { return Ok(Self::Zero) };
        let raw = places.text_of(place);
        let Some(text) = places.quoted(place) else {
            return Ok(match literal(raw) {
                Some(known) if known.number == 0.0 => Self::Zero,
                Some(Literal { number, .. }) => {
                    Self::Number { number, unit: String::new(), is_quoted: false }
                }
                None => return Err(raw.to_owned()),
            });
        };
        if let Some(known) = literal(text) {
            let Literal { number, unit } = known;
            return Ok(Self::Number { number, unit, is_quoted: true });
        }
        let (sign, name) = match text.trim().strip_prefix('-') {
            Some(name) => (-1.0, name.trim()),
            None => (1.0, text.trim()),
        };
        let definition = places.find(&["parameters", name]);
        let value = definition.and_then(|place| {
            let quoted = places.quoted(place);
            Some((literal(quoted.unwrap_or(places.text_of(place)))?, quoted.is_some()))
        });
        let (value, is_quoted) = value.ok_or_else(|| text.to_owned())?;
        Ok(Self::Parameter { name: name.to_owned(), sign, unit: value.unit, is_quoted })
    }

    /// The length that it is, m.
    fn value(&self, places: &Places<'_>) -> Option<f64> {
        match self {
            Self::Zero => Some(0.0),
            Self::Number { number, unit, .. } => {
                length_of(places, &Literal { number: *number, unit: unit.clone() })
            }
            Self::Parameter { name, sign, .. } => {
                let place = places.find(&["parameters", name])?;
                let known = literal(places.quoted(place).unwrap_or(places.text_of(place)))?;
                Some(sign * length_of(places, &known)?)
            }
        }
    }

    /// Writes a length into it, m.
    fn write(&self, draft: &mut Draft, keys: &[&str], value: f64) -> Result<(), EditError> {
        let bare = file_unit(&draft.places()?, "length");
        let in_unit_of = |unit: &str, value: f64| {
            let number = in_unit(value, if unit.is_empty() { &bare } else { unit });
            written(rounded(number))
        };
        let with = |number: String, unit: &str, is_quoted: bool| {
            let spaced = if unit.is_empty() { number } else { format!("{number} {unit}") };
            if is_quoted { crate::draft::written_text(&spaced) } else { spaced }
        };
        match self {
            Self::Zero if value == 0.0 => Ok(()),
            Self::Zero => {
                let text = crate::numbers::length(value);
                draft.replace(keys, &crate::draft::written_text(&text))
            }
            Self::Number { unit, is_quoted, .. } => {
                let text = with(in_unit_of(unit, value), unit, *is_quoted);
                draft.replace(keys, &text)
            }
            Self::Parameter { name, sign, unit, is_quoted } => {
                let text = with(in_unit_of(unit, sign * value), unit, *is_quoted);
                draft.replace(&["parameters", name], &text)
            }
        }
    }
}
