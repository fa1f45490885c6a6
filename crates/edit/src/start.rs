//! A pose as the start of the motion: edits of `[initial]`, and of drives that begin elsewhere.

use bksim_model::{Measure, Model, MotionKind, motion_words};

use crate::edit::Edit;
use crate::numbers::{in_unit, literal, rounded, written};
use crate::places::Places;
use crate::pose::Posed;

/// The edits that make the pose of `posed` the start of a text.
pub(crate) fn start_here(places: &Places<'_>, posed: &mut Posed) -> Vec<Edit> {
    let mut edits = Vec::new();
    let model = posed.model();
    // What the start says about positions, in the form in which it does.
    let stated: Vec<(String, Measure)> = model
        .initial
        .iter()
        .filter(|initial| !initial.measure.is_velocity())
        .filter_map(|initial| Some((path_of(places, &initial.name)?, initial.measure)))
        .collect();
    let drives: Vec<(String, Measure)> = model
        .drives
        .iter()
        .map(|drive| {
            let path = format!("drives.{}.motion", drive.name);
            (path, Measure::JointPosition(drive.joint, drive.motion_idx))
        })
        .collect();
    for (path, measure) in &stated {
        if let Some(value) = posed.value(*measure) {
            let unit = measure.unit(posed.model());
            edits.push(Edit::Set { path: path.clone(), value: of_unit(places, path, value, unit) });
        }
    }
    for (path, measure) in drives {
        let Some(value) = posed.value(measure) else { continue };
        let unit = measure.unit(posed.model());
        edits.extend(drive_from(places, path, value, unit));
    }
    // Whatever else fixes the pose is stated too.
    for measure in posed.independent() {
        let is_known = stated.iter().any(|(_, known)| *known == measure);
        let path = new_path(posed.model(), measure).filter(|_| !is_known);
        if let (Some(path), Some(value)) = (path, posed.value(measure)) {
            let unit = measure.unit(posed.model());
            edits.push(Edit::Set { path, value: shown(value, unit) });
        }
    }
    edits
}

/// Where the start has a value of this name: `A.angle`, `theta`, guessed or stated.
fn path_of(places: &Places<'_>, name: &str) -> Option<String> {
    let parts: Vec<&str> = name.split('.').collect();
    let (first, rest) = parts.split_first()?;
    let with_guess = [&["initial", first, "guess"][..], rest].concat();
    let plain = [&["initial", first][..], rest].concat();
    let found = [plain, with_guess]
        .into_iter()
        .find(|path| places.find(path).is_some_and(crate::scan::Place::is_value));
    found.map(|path| path.join("."))
}

/// A value in the unit in which a place has it.
fn of_unit(places: &Places<'_>, path: &str, value: f64, unit: &str) -> String {
    let keys: Vec<&str> = path.split('.').collect();
    let old = places.find(&keys).and_then(|place| literal(places.quoted(place)?));
    match old.filter(|old| !old.unit.is_empty()) {
        Some(old) => format!("{} {}", written(rounded(in_unit(value, &old.unit))), old.unit),
        None => shown(value, unit),
    }
}

/// A value of a measure in degrees or millimetres.
fn shown(value: f64, unit: &str) -> String {
    let shown = if unit == "rad" { "deg" } else { "mm" };
    format!("{} {shown}", written(rounded(in_unit(value, shown))))
}

/// A drive that begins at another value: its motion is `60 deg + …`, or the rest alone.
fn drive_from(places: &Places<'_>, path: String, value: f64, unit: &str) -> Option<Edit> {
    let keys: Vec<&str> = path.split('.').collect();
    let motion = places.quoted(places.find(&keys)?)?;
    let first = shown(value, unit);
    let (head, rest) =
        motion.split_once('+').map_or((motion, ""), |(head, rest)| (head, rest.trim()));
    let value = match literal(head.trim()) {
        Some(_) if !rest.is_empty() => format!("{first} + {rest}"),
        Some(_) => first,
        None if motion.trim_start().starts_with('-') => format!("{first} {}", motion.trim_start()),
        None => format!("{first} + {motion}"),
    };
    Some(Edit::Set { path, value })
}

/// The path of a value that the start has not yet.
fn new_path(model: &Model, measure: Measure) -> Option<String> {
    use bksim_model::Axis;
    Some(match measure {
        Measure::JointPosition(joint, motion_idx) => {
            let joint = &model.joints[joint.0];
            let motions: &[MotionKind] = joint.kind.motions();
            format!("initial.{}.{}", joint.name, motion_words(motions, motion_idx)[0])
        }
        Measure::PointPosition(body, None, Axis::X) => {
            format!("initial.{}.x", model.bodies[body.0].name)
        }
        Measure::PointPosition(body, None, Axis::Y) => {
            format!("initial.{}.y", model.bodies[body.0].name)
        }
        Measure::BodyAngle(body) => format!("initial.{}.angle", model.bodies[body.0].name),
        _ => return None,
    })
}
