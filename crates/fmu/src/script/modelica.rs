//! A flat model of Modelica: the equations with index 1, which every tool takes.

use std::collections::BTreeSet;
use std::fmt::Write;

use bksim_expr::{Quantity, ScriptBody, ScriptLanguage};

use super::Parts;
use crate::source::comment;

/// Largest difference that the test allows, relative to one and the value.
const ALLOWED: &str = "1e-6";

/// The model, and a test that extends it.
pub(super) fn files(parts: &Parts<'_>, id: &str, t_end: f64) -> Vec<(String, String)> {
    let body = parts.program.body(ScriptLanguage::Modelica);
    let names = Names::of(parts, &body);
    let model = model(parts, id, (&body, &names), t_end);
    let mut files = vec![(format!("{id}.mo"), model)];
    if !parts.motion.is_empty() {
        files.push((format!("{id}_test.mo"), test(parts, id, &names)));
    }
    files
}

/// Names of all variables.
struct Names<'b> {
    q: &'b [String],
    v: &'b [String],
    u: &'b [String],
    a: Vec<String>,
    multipliers: Vec<String>,
}

impl<'b> Names<'b> {
    fn of(parts: &Parts<'_>, body: &'b ScriptBody) -> Self {
        let n = parts.equations.coordinates.len();
        let (q, rest) = body.inputs[1..].split_at(n);
        let (v, rest) = rest.split_at(n);
        let (u, pressing) = rest.split_at(parts.equations.inputs.len());
        let mut taken: BTreeSet<&str> =
            body.inputs.iter().chain(&body.parameters).map(String::as_str).collect();
        taken.extend(body.operations.iter().map(|(name, _)| name.as_str()));
        let fresh = |stem: &str, n: usize| -> Vec<String> {
            let named = |k: usize| {
                let mut name = format!("{stem}{}", k + 1);
                while taken.contains(name.as_str()) {
                    name.push('_');
                }
                name
            };
            (0..n).map(named).collect()
        };
        let mut multipliers = fresh("lambda", parts.equations.multipliers.len());
        for (name, &place) in pressing.iter().zip(&parts.equations.pressing) {
            multipliers[place].clone_from(name);
        }
        Self { q, v, u, a: fresh("acceleration", n), multipliers }
    }
}

fn text(text: &str) -> String {
    format!("\"{}\"", comment(text).replace('"', "'"))
}

fn number(value: f64) -> String {
    format!("{value:?}").replace("inf", "1e300").replace("NaN", "0")
}

/// A declaration with unit and description.
fn declared(kind: &str, name: &str, quantity: &Quantity, value: &str) -> String {
    // Units of Modelica have points between their factors, and no sign `^`.
    let unit = quantity.unit.replace(['*', ' '], ".").replace('^', "");
    let is_known = |c: char| c.is_ascii_alphanumeric() || "./()-".contains(c);
    let unit = if unit.is_empty() || !unit.chars().all(is_known) {
        String::new()
    } else {
        format!("unit = {}", text(&unit))
    };
    let attributes: Vec<&str> =
        [unit.as_str(), value].into_iter().filter(|part| !part.is_empty()).collect();
    let attributes =
        if attributes.is_empty() { String::new() } else { format!("({})", attributes.join(", ")) };
    format!("  {kind}Real {name}{attributes}")
}

fn model(
    parts: &Parts<'_>,
    id: &str,
    (body, names): (&ScriptBody, &Names<'_>),
    t_end: f64,
) -> String {
    let equations = parts.equations;
    let mut out = format!(
        "model {id} {}\n  \
         // q' = v,  M(q) a + G(t, q)^T lambda = f(t, q, v, u, lambda),  G a = -gamma - 2 s (G v + g_t) - s^2 g\n  \
         // All numbers are in SI units and radians; the start is consistent for these parameters.\n",
        text(&format!("Equations of motion of {}", parts.name))
    );
    for note in parts.notes() {
        let _ = writeln!(out, "  // {note}");
    }
    out.push_str("  parameter Real stabilisation = 10.0 \"1/s: how fast the conditions g go back to zero\";\n");
    let values = &equations.function.parameters;
    let quantities = &equations.function.signature.parameters;
    for ((name, quantity), value) in body.parameters.iter().zip(quantities).zip(values) {
        let line = declared("parameter ", name, quantity, "");
        let _ = writeln!(out, "{line} = {} {};", number(*value), text(&quantity.name));
    }
    for (name, (quantity, value)) in names.u.iter().zip(&equations.inputs) {
        let start = format!("start = {}", number(*value));
        let line = declared("input ", name, quantity, &start);
        let _ = writeln!(out, "{line} {};", text(&quantity.name));
    }
    let (_, q, v) = &equations.start;
    let states = [(names.q, &equations.coordinates, q), (names.v, &equations.rates, v)];
    for (names, quantities, values) in states {
        for ((name, quantity), value) in names.iter().zip(quantities).zip(values) {
            let start = format!("start = {}, fixed = true", number(*value));
            let line = declared("", name, quantity, &start);
            let _ = writeln!(out, "{line} {};", text(&quantity.name));
        }
    }
    for (name, quantity) in names.a.iter().zip(&equations.rates) {
        let description = text(&format!("rate of {}", quantity.name));
        let _ = writeln!(out, "  Real {name} {description};");
    }
    for (name, quantity) in names.multipliers.iter().zip(&equations.multipliers) {
        let _ = writeln!(out, "{} {};", declared("", name, quantity, ""), text(&quantity.name));
    }
    out.push_str("protected\n");
    let _ = writeln!(out, "  Real {};", body.inputs[0]);
    for (name, _) in &body.operations {
        let _ = writeln!(out, "  Real {name};");
    }
    let _ = writeln!(out, "equation\n  {} = time;", body.inputs[0]);
    for (_, statement) in &body.operations {
        let _ = writeln!(out, "  {statement}");
    }
    dynamics(parts, body, names, &mut out);
    let start = number(equations.start.0);
    let _ = writeln!(
        out,
        "  annotation(experiment(StartTime = {start}, StopTime = {}, Tolerance = 1e-9));\nend {id};",
        number(t_end)
    );
    out
}

/// The equations of states, of motion, and of the conditions.
fn dynamics(parts: &Parts<'_>, body: &ScriptBody, names: &Names<'_>, out: &mut String) {
    let equations = parts.equations;
    let (n, r) = (names.q.len(), names.multipliers.len());
    let mut results = body.results.iter();
    let mut rows = vec![Vec::new(); n];
    for &[i, j] in &equations.mass {
        let entry = results.next().map_or("0", String::as_str);
        rows[i].push(format!("({entry}) * {}", names.a[j]));
        if i != j {
            rows[j].push(format!("({entry}) * {}", names.a[i]));
        }
    }
    let forces: Vec<&String> = results.by_ref().take(n).collect();
    let (mut aims, mut along) = (vec![Vec::new(); r], vec![Vec::new(); r]);
    for &[row, column] in &equations.jacobian {
        let entry = results.next().map_or("0", String::as_str);
        rows[column].push(format!("({entry}) * {}", names.multipliers[row]));
        aims[row].push(format!("({entry}) * {}", names.a[column]));
        along[row].push(format!("({entry}) * {}", names.v[column]));
    }
    let [gamma, closed, rate] = [(); 3].map(|()| results.by_ref().take(r).collect::<Vec<_>>());
    for i in 0..n {
        let _ = writeln!(out, "  der({}) = {};", names.q[i], names.v[i]);
        let _ = writeln!(out, "  der({}) = {};", names.v[i], names.a[i]);
    }
    for (row, force) in rows.iter().zip(forces) {
        let _ = writeln!(out, "  {} = {force};", sum(row));
    }
    for row in 0..r {
        let _ = writeln!(
            out,
            "  {} = -({}) - 2 * stabilisation * ({} + ({})) - stabilisation ^ 2 * ({});",
            sum(&aims[row]),
            gamma[row],
            sum(&along[row]),
            rate[row],
            closed[row]
        );
    }
}

fn sum(terms: &[String]) -> String {
    if terms.is_empty() { "0".to_owned() } else { terms.join(" + ") }
}

/// A model that fails where the motion is not that of bksim.
fn test(parts: &Parts<'_>, id: &str, names: &Names<'_>) -> String {
    let mut out = format!(
        "model {id}_test \"Fails where the motion is not as bksim computed it\"\n  extends {id};\nequation\n"
    );
    for (t, q, v) in &parts.motion {
        let _ = writeln!(out, "  when time >= {} then", number(*t));
        for (name, value) in names.q.iter().chain(names.v).zip(q.iter().chain(v)) {
            let value = number(*value);
            let _ = writeln!(
                out,
                "    assert(abs({name} - ({value})) <= {ALLOWED} * (1 + abs({value})), \"{name} is wrong\");"
            );
        }
        out.push_str("  end when;\n");
    }
    let _ = writeln!(out, "end {id}_test;");
    out
}
