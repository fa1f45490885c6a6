//! Joints, points and faults as JSON for a page.

use bksim_model::diagnostic::{Diagnostic, Severity};
use bksim_model::{JointId, Measure};
use serde_json::{Value, json};

use crate::pose::Posed;

/// Joints with their ends and first angles or positions.
pub(crate) fn joints(posed: &Posed) -> Value {
    let model = posed.model();
    let all = model.joints.iter().enumerate().map(|(idx, joint)| {
        let has_motion = !joint.kind.motions().is_empty();
        let measure = Measure::JointPosition(JointId(idx), 0);
        let value = has_motion.then(|| posed.value(measure)).flatten();
        json!({
            "name": joint.name,
            "kind": joint.kind.word(),
            "bodies": [joint.predecessor.body.0, joint.successor.body.0],
            "value": value,
            "is_driven": model.drives.iter().any(|drive| drive.joint.0 == idx),
        })
    });
    Value::Array(all.collect())
}

/// Named points with their bodies and places there.
pub(crate) fn points(posed: &mut Posed) -> Value {
    let model = posed.model();
    let known: Vec<(bksim_expr::SymbolId, f64)> =
        model.parameters.iter().map(|p| (p.symbol, p.value)).collect();
    let value = |e| {
        let of = |symbol| known.iter().find(|(known, _)| *known == symbol).map(|(_, x)| *x);
        model.pool.evaluate(e, &of).unwrap_or(f64::NAN)
    };
    let all = model.bodies.iter().enumerate().flat_map(|(idx, body)| {
        body.points.iter().map(move |point| (idx, body.name.clone(), point))
    });
    let written = all.map(|(idx, body, point)| {
        json!({
            "name": format!("{body}.{}", point.name),
            "body": idx,
            "at": point.position.map(value),
        })
    });
    Value::Array(written.collect())
}

/// Forces that stay as they are, with their bodies, points and vectors, in the axes of the world or of the body.
pub(crate) fn forces(posed: &Posed) -> Value {
    let model = posed.model();
    let known = |symbol| model.parameters.iter().find(|p| p.symbol == symbol).map(|p| p.value);
    let three = |of: &[bksim_expr::Expr; 3]| {
        let numbers = of.iter().map(|e| model.pool.evaluate(*e, &known).ok());
        numbers.collect::<Option<Vec<f64>>>()
    };
    let all = model.loads.iter().filter_map(|load| {
        let (on, vector, follows_body) = load.kind.point_force()?;
        let point = on.point.map(|point| three(&model.bodies[on.body.0].points[point.0].position));
        let at = point.unwrap_or_else(|| Some(vec![0.0; 3]))?;
        let vector = three(&vector)?;
        Some(json!({ "body": on.body.0, "at": at, "vector": vector, "follows": follows_body }))
    });
    Value::Array(all.collect())
}

/// Faults as a page shows them; places count UTF-16 units, as its script does.
pub(crate) fn faults(text: &str, all: &[Diagnostic]) -> Vec<Value> {
    all.iter().map(|fault| written_fault(text, fault)).collect()
}

/// A fault with its labels, as a page shows it.
pub(crate) fn written_fault(text: &str, fault: &Diagnostic) -> Value {
    let units = |byte: usize| {
        let before = text.get(..byte.min(text.len())).unwrap_or(text);
        before.encode_utf16().count()
    };
    let labels: Vec<Value> = fault
        .labels
        .iter()
        .map(|label| {
            json!({
                "from": units(label.span.start), "to": units(label.span.end), "text": label.text,
                "line": text.get(..label.span.start).map_or(1, |before| before.matches('\n').count() + 1),
            })
        })
        .collect();
    json!({
        "code": fault.code.0,
        "is_error": fault.severity == Severity::Error,
        "message": fault.message,
        "labels": labels,
        "notes": fault.notes,
        "help": fault.help,
    })
}
