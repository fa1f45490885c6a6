//! Answers about a mechanism: freedoms, equations, the ways in which it closes.

use bksim_analysis::assemblies;
use bksim_expr::{Notation, Printer, SymbolId};
use bksim_mbs::coordinate::Owner;
use bksim_mbs::equations::page::{Page, Style, Subject};
use bksim_mbs::equations::{ReadingForm, proof};
use bksim_model::diagnostic::Diagnostic;
use bksim_model::{Body, Model};
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
    json!({ "sections": sections, "remark": remark, "symbols": symbols(mechanism) })
}

/// Parameters, coordinates and rates as they are written in the equations, with the bodies that they belong to.
fn symbols(mechanism: &Mechanism) -> Vec<Value> {
    let Mechanism { model, system, parameters, .. } = mechanism;
    let pool = &model.pool;
    let printer = Printer::new(pool, Notation::MathMl);
    let users: Vec<Vec<SymbolId>> =
        model.bodies.iter().map(|body| symbols_of(model, body)).collect();
    let using = |symbol: SymbolId| -> Vec<usize> {
        (1..users.len()).filter(|body| users[*body].contains(&symbol)).collect()
    };
    let mut all = Vec::new();
    for (parameter, value) in model.parameters.iter().zip(parameters) {
        let symbol = parameter.symbol;
        all.push(json!({
            "html": printer.symbol(symbol), "name": parameter.name, "value": value,
            "bodies": using(symbol),
        }));
    }
    for coordinate in system.coordinates() {
        let body = match coordinate.owner {
            Owner::Joint(joint, _) => Some(model.joints[joint.0].successor.body.0),
            Owner::Body(body, _) | Owner::Quaternion(body, _) => Some(body.0),
            Owner::State(_) => None,
        };
        let pair = [(coordinate.q, &coordinate.name), (coordinate.v, &coordinate.rate_name)];
        for (symbol, name) in pair {
            all.push(json!({ "html": printer.symbol(symbol), "name": name, "bodies": Vec::from_iter(body) }));
        }
    }
    all
}

/// Symbols in the mass, inertia and points of a body.
fn symbols_of(model: &Model, body: &Body) -> Vec<SymbolId> {
    let points = body.points.iter().flat_map(|point| point.position);
    let inertia = body.inertia.moments.into_iter().chain(body.inertia.products);
    let all = std::iter::once(body.mass).chain(body.com).chain(inertia).chain(points);
    all.flat_map(|e| model.pool.symbols_of(e)).collect()
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
