//! Answers about a mechanism: freedoms, equations, the ways in which it closes.

use bksim_analysis::assemblies;
use bksim_mbs::equations::page::{Page, Style, Subject};
use bksim_mbs::equations::{ReadingForm, proof};
use bksim_model::Model;
use bksim_model::diagnostic::Diagnostic;
use bksim_sim::Mechanism;
use bksim_sim::mobility::mobility;
use serde_json::{Value, json};

use crate::pose::Posed;
use crate::reading::rejected;

/// Largest number of coordinates of a mechanism whose equations are readable on a page.
const MOST_COORDINATES: usize = 30;
/// Bytes of the formulas of one section.
const BYTES: usize = 60_000;

/// Degrees of freedom, counted and found, with redundant conditions.
pub(crate) fn freedoms(mechanism: &Mechanism) -> Result<Value, Vec<Diagnostic>> {
    let start = mechanism.start().map_err(|rejected| rejected.0)?;
    let found = mobility(&mechanism.model, &mechanism.system, &start);
    let redundant: Vec<&str> =
        found.redundant.iter().map(|id| mechanism.model.joints[id.0].name.as_str()).collect();
    Ok(json!({
        "gruebler": found.gruebler,
        "mobility": found.mobility,
        "redundant_conditions": found.n_redundant,
        "redundant_joints": redundant,
        "coordinates": mechanism.system.coordinates().iter().map(|c| &c.name).collect::<Vec<_>>(),
        "drives": mechanism.model.drives.len(),
    }))
}

/// The equations as sections of HTML with MathML, and a remark where some is left out.
pub(crate) fn equations(mechanism: &Mechanism) -> Value {
    let Mechanism { model, system, compiled, .. } = mechanism;
    let n = system.coordinates().len();
    if n > MOST_COORDINATES {
        let remark = format!("The equations of {n} coordinates are too long for a page.");
        return json!({ "sections": [], "remark": remark });
    }
    let form = ReadingForm::grouped(model, system);
    let proof = proof(model, system, &form);
    let (coordinates, multipliers) = (&compiled.coordinates, &compiled.multipliers);
    let subject = Subject { model, system, coordinates, multipliers, form: &form, proof: &proof };
    let sections = Page::new(&subject, Style::MathMl).excerpts(BYTES);
    let n_left_out: usize = sections.iter().map(|section| section.n_left_out).sum();
    let sections: Vec<Value> = sections
        .iter()
        .filter(|section| !["Bodies", "Joints", "Parameters"].contains(&section.title.as_str()))
        .map(|section| json!({ "title": section.title, "html": section.html }))
        .collect();
    let remark = (n_left_out > 0).then(|| format!("{n_left_out} lines are left out."));
    json!({ "sections": sections, "remark": remark })
}

/// The ways in which a model closes, each with the poses of its bodies.
pub(crate) fn ways(model: Model, posed: &mut Posed) -> Result<(Value, Vec<f64>), Vec<Diagnostic>> {
    let found = assemblies(model).map_err(|error| rejected(&error))?;
    let before = posed.q();
    let mut numbers = Vec::new();
    for assembly in &found.assemblies {
        if assembly.q.len() == before.len() {
            posed.set_q(&assembly.q);
            numbers.extend(posed.numbers());
        }
    }
    posed.set_q(&before);
    let all: Vec<Value> = found
        .assemblies
        .iter()
        .map(|assembly| json!({ "number": assembly.number, "name": assembly.name }))
        .collect();
    let held: Vec<&str> = found.held.iter().map(|(name, ..)| name.as_str()).collect();
    Ok((json!({ "assemblies": all, "held": held }), numbers))
}
