//! The equations in their forms, with their certificate.

use bksim_expr::{Certificate, Operations};
use bksim_mbs::equations::{
    ContactText, Counts, Equations as Formulas, FunctionText, Group, Notation, Proof, ReadingForm,
    contact_texts, functions,
};
use bksim_mbs::quantity::{Quantity, coordinate_quantities};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::NamedSignal;
use serde_json::{Map, Value, json};

use bksim_sim::Mechanism;

/// Formulas in full and as they are read, coordinates, multipliers, contacts, operations, certificate.
///
/// `system` is that of the mechanism, or the same in other coordinates.
pub fn equations(
    mechanism: &Mechanism,
    system: &SymbolicSystem,
    form: &ReadingForm,
    proof: &Proof,
) -> Value {
    let Mechanism { model, compiled, .. } = mechanism;
    let plain = ReadingForm::plain(model, system).write(model, Notation::Text);
    // The parts: names of the motion, multipliers, parameters.
    let coordinate = |c: &Quantity| {
        json!({
            "name": c.name,
            "value": c.name,
            "velocity": c.rates[0][0],
            "acceleration": c.rates[1][0],
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
    // The laws of contacts, in the symbols of the formulas.
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
    // The functions by name, piece by piece.
    let end = |value: f64| value.is_finite().then_some(value);
    let piece = |piece: FunctionText| {
        json!({
            "call": printer.expr(piece.call),
            "formula": printer.terms(&piece.terms),
            "from": piece.ranges.iter().map(|range| end(range[0])).collect::<Vec<_>>(),
            "to": piece.ranges.iter().map(|range| end(range[1])).collect::<Vec<_>>(),
        })
    };
    let pieces: Vec<Value> = functions(model, form).into_iter().map(piece).collect();
    // The outputs, in the measures that they are written in.
    let outputs = model.named_signals.iter().filter(|signal| signal.is_output);
    let output = |s: &NamedSignal| json!({ "name": s.name, "formula": printer.expr(s.value), "unit": s.unit });
    let outputs: Vec<Value> = outputs.map(output).collect();
    // The object, formulas first.
    let mut body = formulas(&plain);
    body.extend([
        ("model".to_owned(), json!(model.name)),
        ("reading".to_owned(), reading(mechanism, form)),
        (
            "coordinates".to_owned(),
            coordinate_quantities(model, system).iter().map(coordinate).collect(),
        ),
        ("multipliers".to_owned(), compiled.multipliers.iter().map(multiplier).collect()),
        ("contacts".to_owned(), contacts.into_iter().map(contact).collect()),
        ("functions".to_owned(), pieces.into()),
        ("outputs".to_owned(), outputs.into()),
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
    let group = |group: &Group| {
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
        "equal": (certificate.n_points > 0).then(|| certificate.is_equal()),
        "points": certificate.n_points,
        "worst_f64": certificate.worst_double,
        "worst_106_bits": certificate.worst_extended,
    })
}
