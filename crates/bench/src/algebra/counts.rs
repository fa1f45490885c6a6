//! Operation counts of equations of motion, as printed and as run.
//!
//! Counted are M (lower triangle), h and ∂V/∂q, for closed mechanisms also g and G. Printed: every
//! formula in full, see [`work`]. Shared: operations of one tape with all these
//! outputs, each common part once, its parameter-only prologue left out.

use bksim_expr::{Expr, Tape};
use bksim_mbs::assemble::assemble;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;
use serde_json::json;

use super::chain::{Bias, Equations, with_equations};
use super::work;
use crate::context::Context;
use crate::error::BenchError;
use crate::models::{self, Cut};
use crate::report::{Check, Report, Table};

/// Numbers of operations of some equations.
#[derive(Clone, Copy)]
struct Counts {
    printed: u64,
    shared: u64,
}

/// Counts the operations of all outputs together.
fn counts(equations: &Equations<'_>) -> Result<Counts, BenchError> {
    let Equations { pool, outputs, state, parameters } = equations;
    let names: Vec<String> = state.iter().map(|&s| pool.symbol_name(s)).collect();
    let is_state = |name: &str| names.iter().any(|n| n == name);
    let tape = Tape::compile(pool, outputs, state, parameters)?;
    let printed = work::printed(pool, outputs, &is_state)?;
    Ok(Counts { printed, shared: tape.operation_count() as u64 })
}

/// The assembled M, h, ∂V/∂q, g and G of a model.
fn equations<'m>(model: &'m Model, system: &SymbolicSystem) -> Equations<'m> {
    let mut outputs: Vec<Expr> = system.mass_matrix.lower().map(|(.., entry)| entry).collect();
    outputs.extend(&system.bias);
    outputs.extend(&system.potential_gradient);
    outputs.extend(system.constraints.iter().map(|c| c.expression));
    outputs.extend(system.constraint_jacobian.entries().map(|(.., entry)| entry));
    let mut state = vec![model.time];
    state.extend(system.coordinates().iter().flat_map(|c| [c.q, c.v]));
    let parameters = model.parameters.iter().map(|p| p.symbol).collect();
    Equations { pool: &model.pool, outputs, state, parameters }
}

/// A mechanism with its goals, which one of its forms must meet.
struct Counted {
    name: &'static str,
    printed_goal: Option<u64>,
    shared_goal: u64,
    forms: Vec<Form>,
}

/// One form of the equations of a mechanism.
struct Form {
    name: &'static str,
    counts: Counts,
}

/// The form of an assembled model.
fn assembled(name: &'static str, text: &str) -> Result<Form, BenchError> {
    let model = models::model(text, name)?;
    let system = assemble(&model);
    Ok(Form { name, counts: counts(&equations(&model, &system))? })
}

/// All mechanisms in all forms.
fn mechanisms(context: &Context) -> Result<Vec<Counted>, BenchError> {
    let closed_at_coupler =
        assembled("pin of coupler and rocker cut", &models::four_bar(Cut::Coupler))?;
    let closed_at_ground =
        assembled("pin of rocker and ground cut", &models::four_bar(Cut::Ground))?;
    let mut mechanisms = vec![
        Counted {
            name: "slider-crank",
            printed_goal: Some(65),
            shared_goal: 42,
            forms: vec![assembled("pin of the slider cut", models::SLIDER_CRANK)?],
        },
        Counted {
            name: "four-bar",
            printed_goal: Some(176),
            shared_goal: 99,
            forms: vec![closed_at_coupler, closed_at_ground],
        },
    ];
    let sizes = [
        ("two-link chain", 2, Some(52), 33),
        ("five-link chain", 5, None, 169),
        ("ten-link chain", 10, None, 374),
    ];
    let n_sizes = if context.effort.is_quick { 1 } else { sizes.len() };
    for (name, n, printed_goal, shared_goal) in sizes.into_iter().take(n_sizes) {
        let absolute = |name, bias| {
            Ok::<_, BenchError>(Form { name, counts: with_equations(n, bias, counts)? })
        };
        let forms = vec![
            assembled("relative angles", &models::chain(n))?,
            absolute("absolute angles", Bias::Folded)?,
            absolute("absolute angles, h unfolded", Bias::Unfolded)?,
        ];
        mechanisms.push(Counted { name, printed_goal, shared_goal, forms });
    }
    Ok(mechanisms)
}

/// Counts all mechanisms.
pub(crate) fn run(context: &Context) -> Result<Report, BenchError> {
    let title = "operations of M, h, dV/dq (and g, G), grouped constants precomputed";
    let mut report = Report::new("counts", title);
    let mut table = Table::new(["mechanism", "form", "printed", "goal", "shared", "goal"]);
    for item in mechanisms(context)? {
        let mut numbers = serde_json::Map::new();
        for Form { name, counts } in &item.forms {
            table.push([
                item.name.to_owned(),
                (*name).to_owned(),
                counts.printed.to_string(),
                item.printed_goal.map_or("-".to_owned(), |goal| goal.to_string()),
                counts.shared.to_string(),
                item.shared_goal.to_string(),
            ]);
            let value = json!({ "printed": counts.printed, "shared": counts.shared });
            numbers.insert((*name).to_owned(), value);
        }
        let least = |count: fn(&Counts) -> u64| {
            let counts = item.forms.iter().map(|form| count(&form.counts));
            counts.min().expect("a mechanism has at least one form") as f64
        };
        if let Some(bound) = item.printed_goal {
            let what = format!("{} as printed", item.name);
            report.checks.push(Check::at_most(what, least(|c| c.printed), bound as f64));
        }
        let what = format!("{} shared", item.name);
        report.checks.push(Check::at_most(what, least(|c| c.shared), item.shared_goal as f64));
        report.numbers.insert(item.name.to_owned(), numbers.into());
    }
    report.tables.push(table);
    Ok(report)
}
