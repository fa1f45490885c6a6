//! Trigonometric identities: cost and time of `simplify` against SymPy's `trigsimp`.
//!
//! The cost of an expression weighs the operations on its shared graph: addition and
//! multiplication 1, division 4, sine, cosine and tangent 12, any other function 8.

use bksim_expr::{Expr, Pool, SymbolId};
use serde_json::{Value, json};

use crate::context::Context;
use crate::error::BenchError;
use crate::report::{Check, Report, Table, ratio, seconds};
use crate::timing::{Samples, median, repeat};

/// The suite: inputs, ideal forms, their costs, and a point with its value.
const SUITE: &str = include_str!("../../../expr/tests/data/identities.json");
/// Goal of our median time over SymPy's.
const RATIO_GOAL: f64 = 1.0 / 500.0;

/// One identity of the suite, with our result.
struct Identity {
    id: String,
    input: String,
    ideal_cost: u64,
    cost: u64,
    times: Samples,
}

/// Folds all identities.
pub(crate) fn run(context: &Context) -> Result<Report, BenchError> {
    let mut report = Report::new("folding", "trigonometric identities, cost and CPU time");

    // Our results.
    let suite: Value = serde_json::from_str(SUITE).map_err(|_| BenchError::Data("identities"))?;
    let list = suite["items"].as_array().ok_or(BenchError::Data("identities"))?;
    let list = if context.effort.is_quick { &list[..list.len().min(5)] } else { list };
    let items: Vec<Identity> =
        list.iter().map(|item| fold(context, item)).collect::<Result<_, _>>()?;

    // SymPy's results.
    let inputs: Vec<Value> =
        items.iter().map(|item| json!({ "id": item.id, "input": item.input })).collect();
    let theirs = match context.peers.python("folding", &json!({ "items": inputs, "runs": 3 })) {
        Ok(value) => value,
        Err(absent) => {
            report.notes.push(format!("SymPy: {absent}"));
            json!({})
        }
    };

    // A row for each identity.
    let mut table = Table::new(["item", "ideal", "ours", "SymPy", "ours", "SymPy", "ours/SymPy"]);
    let (mut own_times, mut their_times) = (Vec::new(), Vec::new());
    let mut n_theirs_folded = 0;
    for item in &items {
        let their = &theirs["items"][&item.id];
        let their_time = numbers(&their["samples"]).minimum();
        let their_cost = their["cost"].as_u64();
        n_theirs_folded += usize::from(their_cost.is_some_and(|cost| cost <= item.ideal_cost));
        own_times.push(item.times.minimum());
        their_times.extend(Some(their_time).filter(|t| !t.is_nan()));
        table.push([
            item.id.clone(),
            item.ideal_cost.to_string(),
            item.cost.to_string(),
            their_cost.map_or("-".to_owned(), |cost| cost.to_string()),
            seconds(item.times.minimum()),
            seconds(their_time),
            ratio(item.times.minimum() / their_time),
        ]);
        let numbers = json!({
            "ideal_cost": item.ideal_cost, "cost": item.cost, "time_s": item.times.minimum(),
            "sympy_cost": their_cost, "sympy_time_s": their_time,
        });
        report.numbers.insert(item.id.clone(), numbers);
    }
    report.tables.push(table);

    // The goals, and notes on medians and extremes.
    let n_folded = items.iter().filter(|item| item.cost <= item.ideal_cost).count();
    let (own, their) = (median(&own_times), median(&their_times));
    let n = items.len() as f64;
    report.checks.push(Check::at_least("items at their ideal cost", n_folded as f64, n));
    report.checks.push(Check::at_most("median time over SymPy's", own / their, RATIO_GOAL));
    report.notes.push(format!("medians: ours {}, SymPy {}", seconds(own), seconds(their)));
    if !their_times.is_empty() {
        let slowest = own_times.iter().copied().fold(0.0, f64::max);
        let note = format!(
            "SymPy folds {n_theirs_folded} of {}; our slowest takes {}",
            items.len(),
            seconds(slowest)
        );
        report.notes.push(note);
    }
    let summary = json!({ "n_folded": n_folded, "median_s": own, "sympy_median_s": their });
    report.numbers.insert("all".to_owned(), summary);
    Ok(report)
}

/// Simplifies one identity, checks its value and times it on a fresh pool.
fn fold(context: &Context, item: &Value) -> Result<Identity, BenchError> {
    let text = |key: &str| item[key].as_str().ok_or(BenchError::Data("identities"));
    let (id, input) = (text("id")?.to_owned(), text("input")?.to_owned());
    let pool = Pool::new();
    let e = pool.parse(&input)?;
    let simple = pool.simplify(e);
    let sample = |symbol: SymbolId| item["sample"][pool.symbol_name(symbol)].as_f64();
    let found = pool.evaluate(simple, &sample)?;
    let expected = item["value"].as_f64().ok_or(BenchError::Data("identities"))?;
    if (found - expected).abs() > 1e-12 * expected.abs().max(1.0) {
        let who = "simplify".to_owned();
        return Err(BenchError::Disagreement { who, what: id, found, expected });
    }
    let prepare = || {
        let pool = Pool::new();
        let e = pool.parse(&input).expect("the same text was parsed before");
        (pool, e)
    };
    let times = repeat(context.effort, prepare, |(pool, e)| pool.simplify(*e));
    let ideal_cost = item["cost_ideal"].as_u64().ok_or(BenchError::Data("identities"))?;
    Ok(Identity { cost: cost(&pool, simple), id, input, ideal_cost, times })
}

/// Weighted operations on the shared graph.
fn cost(pool: &Pool, e: Expr) -> u64 {
    let count = pool.operation_count(&[e]);
    let n_trig = trigonometric_calls(&pool.to_text(e));
    count.multiplications
        + count.additions
        + 4 * count.divisions
        + 8 * (count.calls - n_trig)
        + 12 * n_trig
}

/// Number of different sines, cosines and tangents in a printed expression.
fn trigonometric_calls(text: &str) -> u64 {
    let mut calls = std::collections::BTreeSet::new();
    for name in ["sin(", "cos(", "tan("] {
        for (at, _) in text.match_indices(name) {
            let mut depth = 0;
            let end = text[at..].find(|c| {
                depth += i32::from(c == '(') - i32::from(c == ')');
                c == ')' && depth == 0
            });
            let end = at + end.expect("a printed call is closed");
            calls.insert(&text[at..=end]);
        }
    }
    calls.len() as u64
}

/// SymPy's times.
fn numbers(list: &Value) -> Samples {
    Samples::new(list.as_array().into_iter().flatten().filter_map(Value::as_f64).collect())
}
