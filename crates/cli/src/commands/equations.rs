//! `bksim equations`: T, V, the Lagrange equations with multipliers, the constraints.

use bksim::Mechanism;
use bksim::mbs::equations::{Equations as Formulas, Notation, equations};
use serde_json::{Value, json};

use crate::args::{Equations, Format};
use crate::exit::{Failure, Status};
use crate::output::{self, number, table};
use crate::render;
use crate::source::{derive, load};

pub(crate) fn run(args: &Equations, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let loaded = load(&args.model, nesting)?;
    let mechanism = derive(&loaded.source, loaded.model)?;
    let write = |notation| equations(&mechanism.model, &mechanism.system, notation);
    if as_json || args.format == Format::Json {
        let mut body = describe(&mechanism, &write(Notation::Text));
        body["diagnostics"] = render::json_all(&loaded.source, &loaded.warnings);
        output::json("equations", body)?;
        return Ok(Status::Done);
    }
    render::print_all(&loaded.source, &loaded.warnings);
    output::text(&match args.format {
        Format::Latex => latex(&write(Notation::Latex)),
        _ => text(&mechanism, &write(Notation::Text)),
    })?;
    Ok(Status::Done)
}

fn text(mechanism: &Mechanism, formulas: &Formulas) -> String {
    let compiled = &mechanism.compiled;
    let mut lines = vec![
        "kinetic energy".to_owned(),
        format!("  T = {}", formulas.kinetic_energy),
        String::new(),
        "potential energy".to_owned(),
        format!("  V = {}", formulas.potential_energy),
        String::new(),
        "equations of motion".to_owned(),
    ];
    for (coordinate, equation) in compiled.coordinates.iter().zip(&formulas.equations) {
        lines.push(format!("  {}:  {equation} = 0", coordinate.name));
    }
    if !formulas.constraints.is_empty() {
        lines.extend([String::new(), "constraints".to_owned()]);
        for (multiplier, constraint) in compiled.multipliers.iter().zip(&formulas.constraints) {
            lines.push(format!("  {}:  {constraint} = 0", multiplier.name));
        }
        let rows = compiled
            .multipliers
            .iter()
            .map(|m| vec![m.name.clone(), m.unit.to_owned(), m.description.clone()]);
        lines.extend([String::new(), "multipliers".to_owned(), table(&rows.collect::<Vec<_>>())]);
    }
    if !mechanism.model.parameters.is_empty() {
        let parameters = &mechanism.model.parameters;
        let values: Vec<String> = parameters.iter().map(|p| number(p.value)).collect();
        let rows = parameters.iter().zip(values);
        let rows = rows.map(|(p, value)| vec![p.name.clone(), value, p.unit.clone()]);
        lines.extend([String::new(), "parameters".to_owned(), table(&rows.collect::<Vec<_>>())]);
    }
    lines.join("\n")
}

fn latex(formulas: &Formulas) -> String {
    let block = |rows: &[String]| {
        let rows = rows.iter().map(|row| format!("  {row} &= 0")).collect::<Vec<_>>();
        format!("\\begin{{align}}\n{}\n\\end{{align}}", rows.join(" \\\\\n"))
    };
    let mut parts = vec![
        format!("\\begin{{equation}}\n  T = {}\n\\end{{equation}}", formulas.kinetic_energy),
        format!("\\begin{{equation}}\n  V = {}\n\\end{{equation}}", formulas.potential_energy),
        block(&formulas.equations),
    ];
    if !formulas.constraints.is_empty() {
        parts.push(block(&formulas.constraints));
    }
    parts.join("\n")
}

fn describe(mechanism: &Mechanism, formulas: &Formulas) -> Value {
    let compiled = &mechanism.compiled;
    let coordinate = |c: &bksim::mbs::compile::Quantity| {
        json!({
            "name": c.name,
            "value": c.name,
            "velocity": format!("{}_dot", c.name),
            "acceleration": format!("{}_ddot", c.name),
            "unit": c.unit,
        })
    };
    let multiplier = |m: &bksim::mbs::compile::Quantity| json!({ "name": m.name, "unit": m.unit, "constraint": m.description });
    let parameters: serde_json::Map<String, Value> = mechanism
        .model
        .parameters
        .iter()
        .map(|p| (p.name.clone(), json!({ "value": p.value, "unit": p.unit })))
        .collect();
    json!({
        "model": mechanism.model.name,
        "kinetic_energy": formulas.kinetic_energy,
        "potential_energy": formulas.potential_energy,
        "equations": formulas.equations,
        "constraints": formulas.constraints,
        "coordinates": compiled.coordinates.iter().map(coordinate).collect::<Vec<_>>(),
        "multipliers": compiled.multipliers.iter().map(multiplier).collect::<Vec<_>>(),
        "parameters": parameters,
        "time": "t",
    })
}
