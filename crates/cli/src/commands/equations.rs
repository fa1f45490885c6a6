//! `bksim equations`: T, V, the Lagrange equations with multipliers, the constraints; how much they
//! compute, and a certificate that they are right.

use bksim::Mechanism;
use bksim::expr::{Certificate, Operations};
use bksim::mbs::compile::Quantity;
use bksim::mbs::equations::page::{Page, Style, Subject};
use bksim::mbs::equations::{
    ContactText, Counts, Equations as Formulas, Notation, Proof, ReadingForm, contact_texts, proof,
};
use serde_json::{Map, Value, json};

use crate::args::{Equations, Format, Switch};
use crate::exit::{Failure, Status};
use crate::output;
use crate::render;
use crate::source::{derive, load};

/// Characters of a line where there is no terminal to ask.
const WIDTH: usize = 100;

pub(crate) fn run(args: &Equations, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let as_json = as_json || args.format == Format::Json;
    if as_json && args.document {
        let help = "`--format` is one of text, aligned, latex, typst and mathml";
        return Err(Failure::usage("a document has a format to be written in", help));
    }
    let loaded = load(&args.model, nesting)?;
    let mechanism = derive(&loaded.source, loaded.model)?;
    let Mechanism { model, system, compiled, .. } = &mechanism;
    let form = match args.groups {
        Switch::On => ReadingForm::grouped(model, system),
        Switch::Off => ReadingForm::plain(model, system),
    };
    let proof = proof(model, system, &form);
    if as_json {
        let mut body = describe(&mechanism, &form, &proof);
        body["diagnostics"] = render::json_all(&loaded.source, &loaded.warnings);
        output::json("equations", body)?;
        return Ok(Status::Done);
    }
    render::print_all(&loaded.source, &loaded.warnings);
    let (coordinates, multipliers) = (&compiled.coordinates, &compiled.multipliers);
    let subject = Subject { model, system, coordinates, multipliers, form: &form, proof: &proof };
    let page = Page::new(&subject, style(args));
    output::text(&if args.document { page.document() } else { page.formulas() })?;
    Ok(Status::Done)
}

fn style(args: &Equations) -> Style {
    match args.format {
        Format::Text | Format::Json => Style::Text,
        Format::Aligned => {
            let width = args.width.map_or_else(terminal_width, usize::from);
            Style::Aligned { width, unicode: args.unicode }
        }
        Format::Latex => Style::Latex,
        Format::Typst => Style::Typst,
        Format::Mathml => Style::MathMl,
    }
}

/// Columns of the terminal, if stdout is one or `COLUMNS` says so.
fn terminal_width() -> usize {
    let stated = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    let found = || terminal_size::terminal_size().map(|(width, _)| usize::from(width.0));
    stated.or_else(found).filter(|&width| width >= 20).unwrap_or(WIDTH)
}

fn describe(mechanism: &Mechanism, form: &ReadingForm, proof: &Proof) -> Value {
    let Mechanism { model, system, compiled, .. } = mechanism;
    let plain = ReadingForm::plain(model, system).write(model, Notation::Text);
    let coordinate = |c: &Quantity| {
        json!({
            "name": c.name,
            "value": c.name,
            "velocity": format!("{}_dot", c.name),
            "acceleration": format!("{}_ddot", c.name),
            "unit": c.unit,
        })
    };
    let multiplier =
        |m: &Quantity| json!({ "name": m.name, "unit": m.unit, "constraint": m.description });
    let parameters: Map<String, Value> = model
        .parameters
        .iter()
        .map(|p| (p.name.clone(), json!({ "value": p.value, "unit": p.unit })))
        .collect();
    let printer = form.printer(model, Notation::Text);
    let multipliers: Vec<String> = compiled.multipliers.iter().map(|m| m.name.clone()).collect();
    let contact = |c: ContactText| {
        let ContactText { name, law, quantity, multiplier, limits } = c;
        json!({
            "name": name,
            "law": law,
            "of": quantity,
            "multiplier": multiplier,
            "limits": limits,
        })
    };
    let contacts = contact_texts(model, system, &printer, &multipliers);
    let mut body = formulas(&plain);
    body.extend([
        ("model".to_owned(), json!(model.name)),
        ("reading".to_owned(), reading(mechanism, form)),
        ("coordinates".to_owned(), compiled.coordinates.iter().map(coordinate).collect()),
        ("multipliers".to_owned(), compiled.multipliers.iter().map(multiplier).collect()),
        ("contacts".to_owned(), contacts.into_iter().map(contact).collect()),
        ("parameters".to_owned(), parameters.into()),
        ("time".to_owned(), json!("t")),
        (
            "operations".to_owned(),
            json!({
                "derived": counts(proof.work.derived),
                "simplified": counts(proof.work.simplified),
                "reading": counts(proof.work.shown),
            }),
        ),
        (
            "certificate".to_owned(),
            json!({
                "derivation": certificate(proof.derivation),
                "reading": certificate(proof.grouping),
            }),
        ),
    ]);
    body.into()
}

fn formulas(formulas: &Formulas) -> Map<String, Value> {
    Map::from_iter([
        ("kinetic_energy".to_owned(), json!(formulas.kinetic_energy)),
        ("potential_energy".to_owned(), json!(formulas.potential_energy)),
        ("equations".to_owned(), json!(formulas.equations)),
        ("constraints".to_owned(), json!(formulas.constraints)),
    ])
}

/// The formulas with named constants, and the names.
fn reading(mechanism: &Mechanism, form: &ReadingForm) -> Value {
    let model = &mechanism.model;
    let pool = &model.pool;
    let printer = form.printer(model, Notation::Text);
    let value = |symbol| model.parameters.iter().find(|p| p.symbol == symbol).map(|p| p.value);
    let group = |group: &bksim::mbs::equations::Group| {
        json!({
            "name": pool.symbol_name(group.symbol),
            "definition": printer.terms(&group.terms),
            "unit": group.unit,
            "value": pool.evaluate(group.definition(pool), &value).ok(),
        })
    };
    let mut body = formulas(&form.write(model, Notation::Text));
    body.insert("names".to_owned(), form.groups.iter().map(group).collect());
    body.into()
}

fn counts(counts: Counts) -> Value {
    let kinds = |o: Operations| {
        json!({
            "multiply": o.multiplications, "add": o.additions, "divide": o.divisions,
            "call": o.calls, "total": o.total(),
        })
    };
    json!({ "shared": kinds(counts.shared), "written_out": kinds(counts.printed) })
}

fn certificate(certificate: Certificate) -> Value {
    json!({
        "equal": certificate.is_equal(),
        "points": certificate.n_points,
        "worst_f64": certificate.worst_double,
        "worst_106_bits": certificate.worst_extended,
    })
}
