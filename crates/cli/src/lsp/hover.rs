//! Hovers: the meaning, value and dimension of a name or a key.

use bksim::Mechanism;
use bksim::edit::names::Defined;
use bksim::edit::scan::{Kind, places, type_of};
use bksim::mbs::coordinate::Owner;
use bksim::model::file::WrittenUnit;
use bksim::model::{Joint, JointId, Measure, Model, Parameter};
use serde_json::{Value, json};

use super::document::Document;
use super::faults::{derived, judge};
use super::names::defined;
use crate::commands::schema::row;
use crate::output::number;

/// More equations than these do not fit next to a text.
const MOST_EQUATIONS: usize = 8;
/// Longer equations are cut.
const MOST_LETTERS: usize = 600;

/// The explanation of the word at a byte, as Markdown.
pub(super) fn at(document: &Document, byte: usize, nesting: usize) -> Option<Value> {
    let range = |span: &std::ops::Range<usize>| document.range(span);
    // A key, as the reference has it.
    let all = places(&document.text);
    let key = all.iter().find_map(|place| {
        let key = place.keys.last().filter(|key| key.contains(&byte) && place.path.len() > 1)?;
        let of_type = type_of(&all, place, &document.text);
        let cells = row(&place.path[0], of_type, place.path.last()?)?;
        let meaning = cells.into_iter().rfind(|cell| !cell.is_empty())?;
        Some(shown(&format!("`{}`: {meaning}", place.path.last()?), range(key)))
    });
    if key.is_some() {
        return key;
    }
    let word = document.word(byte);
    let (before, part) = document.part(&word, byte);
    let name = document.text.get(part.clone()).filter(|name| !name.is_empty())?;
    let is_header =
        all.iter().any(|place| place.kind == Kind::Header && place.span.contains(&byte));
    let words = if before.is_empty() || is_header {
        of_name(document, name, nesting)?
    } else {
        let model = judge(document, nesting).model?;
        let whole = [before.join("."), name.to_owned()].join(".");
        let measure = Measure::named(&model, &whole)?;
        format!("`{whole}`{}", in_unit(measure.unit(&model)))
    };
    Some(shown(&words, range(&part)))
}

#[expect(clippy::needless_pass_by_value, reason = "values of JSON are moved")]
fn shown(text: &str, range: Value) -> Value {
    json!({ "contents": { "kind": "markdown", "value": text }, "range": range })
}

/// `, length in m`
fn in_unit(unit: &str) -> String {
    let noun = WrittenUnit::parse(unit).and_then(|written| written.noun());
    match (unit, noun) {
        ("", _) => ", a pure number".to_owned(),
        (unit, Some(noun)) => format!(", {noun} in {unit}"),
        (unit, None) => format!(", in {unit}"),
    }
}

fn of_name(document: &Document, name: &str, nesting: usize) -> Option<String> {
    let known = defined(&document.text).into_iter().find(|known| known.name == name);
    let model = judge(document, nesting).model;
    if let Some(words) = model.as_ref().and_then(|model| of_coordinate(model, name)) {
        return Some(words);
    }
    if let Some(parameter) =
        model.iter().flat_map(|model| &model.parameters).find(|known| known.name == name)
    {
        let value = value_of(parameter);
        return Some(format!("`{name}` = {value}{}", in_unit(&parameter.unit)));
    }
    let known = known.filter(Defined::is_plain)?;
    let kind = known
        .section
        .strip_suffix("ies")
        .map_or_else(|| known.section.trim_end_matches('s').to_owned(), |stem| format!("{stem}y"));
    let mut words = format!("{kind} `{name}`");
    if ["bodies", "joints"].contains(&known.section.as_str())
        && let Some(mechanism) = derived(document, nesting)
    {
        words.push_str(&equations(&mechanism, &known.section, name));
    }
    Some(words)
}

/// The value of a parameter with its unit: `0.25 m`.
pub(super) fn value_of(parameter: &Parameter) -> String {
    format!("{} {}", number(parameter.value), parameter.unit).trim_end().to_owned()
}

/// A coordinate that a joint names, or its rate.
fn of_coordinate(model: &Model, name: &str) -> Option<String> {
    let (stem, is_rate) = match name.strip_suffix("_dot") {
        Some(stem) => (stem, true),
        None => (name, false),
    };
    let names = |joint: &Joint| joint.coordinate_names.iter().position(|known| known == stem);
    let joints = model.joints.iter().enumerate();
    let (joint, idx) =
        joints.map(|(k, joint)| (k, names(joint))).find_map(|(k, i)| Some((k, i?)))?;
    let of = if is_rate { Measure::JointVelocity } else { Measure::JointPosition };
    let measure = of(JointId(joint), idx);
    let unit = measure.unit(model);
    let (kind, unit) = if is_rate {
        ("rate of coordinate", format!(", in {unit}"))
    } else {
        ("coordinate", in_unit(unit))
    };
    Some(format!("{kind} `{stem}` of joint `{}`{unit}", model.joints[joint].name))
}

/// The Lagrange equations of the coordinates of a body or a joint.
fn equations(mechanism: &Mechanism, section: &str, name: &str) -> String {
    let model: &Model = &mechanism.model;
    let is_own = |owner: Owner| match owner {
        Owner::Joint(joint, _) => {
            let joint = &model.joints[joint.0];
            let moved = &model.bodies[joint.successor.body.0].name;
            if section == "joints" { joint.name == name } else { moved == name }
        }
        Owner::Body(body, _) | Owner::Quaternion(body, _) => {
            section == "bodies" && model.bodies[body.0].name == name
        }
        Owner::State(_) => false,
    };
    let coordinates = mechanism.system.coordinates();
    let own: Vec<usize> =
        (0..coordinates.len()).filter(|&i| is_own(coordinates[i].owner)).collect();
    if own.is_empty() {
        return String::new();
    }
    let all = mechanism.equations().equations;
    let lines = own.iter().take(MOST_EQUATIONS).filter_map(|&i| {
        let line = all.get(i)?;
        let cut: String = line.chars().take(MOST_LETTERS).collect();
        let dots = if cut.len() < line.len() { " …" } else { "" };
        Some(format!("{}:\n  {cut}{dots} = 0", coordinates[i].name))
    });
    format!("\n\n```text\n{}\n```", lines.collect::<Vec<_>>().join("\n"))
}
