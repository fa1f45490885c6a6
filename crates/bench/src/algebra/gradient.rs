//! Reverse mode on a large sum: 8400 products of four sines in 60 symbols.

use bksim_expr::{Expr, Pool, SymbolId, Tape};
use serde_json::{Value, json};

use crate::context::Context;
use crate::error::BenchError;
use crate::report::{Check, Report, Table, ratio, seconds};
use crate::timing::{Paired, Samples, repeat};

/// Number of symbols.
const N_SYMBOLS: usize = 60;
/// Number of terms.
const N_TERMS: usize = 8400;
/// Number of terms of a quick run.
const N_QUICK_TERMS: usize = 120;

/// The weights of the sines, which decide which of them are equal.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Weights {
    /// Equal in 60 terms in a row, so that terms share sines.
    Layered,
    /// Different in every sine.
    Different,
}

impl Weights {
    fn name(self) -> &'static str {
        match self {
            Self::Layered => "sines shared",
            Self::Different => "no two sines equal",
        }
    }

    /// w of sine `step` in term k.
    fn weight(self, pool: &Pool, k: usize, step: usize) -> Expr {
        let integer = |n: usize| i64::try_from(n).expect("weights are small numbers");
        match self {
            Self::Layered => pool.int(integer(2 + k / N_SYMBOLS)),
            Self::Different => pool.rational(integer(20 * k + step), 200_000),
        }
    }
}

/// Σ_k Π_s sin(x_a + w x_b x_c + x_d + x_e), where a … e follow from k and s.
///
/// `peers/gradient.py` builds the same.
fn large(pool: &Pool, n_terms: usize, weights: Weights) -> (Expr, Vec<SymbolId>) {
    let xs: Vec<Expr> = (0..N_SYMBOLS).map(|i| pool.symbol(&format!("x{i}"))).collect();
    let ids = xs.iter().filter_map(|&x| pool.symbol_id(x)).collect();
    let term = |k: usize| {
        let sine = |step: usize| {
            let at = |i: usize| xs[(k * step + i * i + k / N_SYMBOLS) % N_SYMBOLS];
            let weight = weights.weight(pool, k, step);
            pool.sin(pool.sum([at(1), pool.product([weight, at(2), at(3)]), at(4), at(5)]))
        };
        pool.product([1, 7, 11, 13].map(sine))
    };
    (pool.sum((0..n_terms).map(term)), ids)
}

/// Differentiates both sums.
pub(crate) fn run(context: &Context) -> Result<Report, BenchError> {
    let mut report = Report::new("gradient", "reverse mode on a large sum, CPU time");
    let header = ["", "instructions", "CasADi", "of gradient", "CasADi", "time", "CasADi", "ratio"];
    let mut table = Table::new(header);
    for weights in [Weights::Layered, Weights::Different] {
        differentiate(context, weights, &mut report, &mut table)?;
    }
    report.tables.push(table);
    report.notes.dedup();
    Ok(report)
}

/// Differentiates one sum: a row of the table, a check, and numbers.
fn differentiate(
    context: &Context,
    weights: Weights,
    report: &mut Report,
    table: &mut Table,
) -> Result<(), BenchError> {
    // Our gradient, its size and its values.
    let n_terms = if context.effort.is_quick { N_QUICK_TERMS } else { N_TERMS };
    let pool = Pool::new();
    let (e, ids) = large(&pool, n_terms, weights);
    let gradient = pool.gradient(e, &ids);
    let length = |outputs: &[Expr]| Tape::compile(&pool, outputs, &ids, &[]).map(|t| t.len());
    let (n_function, n_gradient) = (length(&[e])?, length(&gradient)?);
    let values = values(&pool, &gradient, &ids)?;

    // Rounds of ours and theirs; both gradients have the same values.
    let mut pair = Paired::default();
    let mut casadi = json!(null);
    let are_different = weights == Weights::Different;
    let request = json!({ "n_terms": n_terms, "different": are_different, "runs": 5 });
    for _ in 0..context.effort.rounds {
        let theirs = context.peers.python("gradient", &request);
        let prepare = || {
            let pool = Pool::new();
            let (e, ids) = large(&pool, n_terms, weights);
            (pool, e, ids)
        };
        let own = repeat(context.effort, prepare, |(pool, e, ids)| pool.gradient(*e, ids));
        let their = theirs.as_ref().map(|t| numbers(&t["samples"])).unwrap_or_default();
        pair.push(&own, &Samples::new(their));
        match theirs {
            Ok(value) => casadi = value,
            Err(absent) => report.notes.push(format!("CasADi: {absent}")),
        }
    }
    compare(&values, &numbers(&casadi["gradient"]))?;

    // The row of the table, the goal and the numbers.
    let count = |n: &Value| n.as_u64().map_or("-".to_owned(), |n| n.to_string());
    let (own, their) = (pair.ours.minimum(), pair.theirs.minimum());
    table.push([
        weights.name().to_owned(),
        n_function.to_string(),
        count(&casadi["n_function"]),
        n_gradient.to_string(),
        count(&casadi["n_gradient"]),
        seconds(own),
        seconds(their),
        ratio(pair.ratio()),
    ]);
    let what = format!("time over CasADi's, {}", weights.name());
    report.checks.push(Check::at_most(what, pair.ratio(), 1.0));
    let numbers = json!({
        "n_terms": n_terms, "n_function": n_function, "n_gradient": n_gradient, "ours_s": own,
        "casadi_s": their, "ratio": pair.ratio(), "spread": pair.spread(),
    });
    report.numbers.insert(weights.name().to_owned(), numbers);
    Ok(())
}

/// Values of the gradient where symbol number i is 0.1 + i/100.
fn values(pool: &Pool, gradient: &[Expr], ids: &[SymbolId]) -> Result<Vec<f64>, BenchError> {
    let tape = Tape::compile(pool, gradient, ids, &[])?;
    let inputs: Vec<f64> = (0..ids.len()).map(|i| 0.1 + 0.01 * i as f64).collect();
    let mut out = vec![0.0; gradient.len()];
    tape.evaluate(&mut tape.workspace(&[]), &inputs, &mut out);
    Ok(out)
}

/// Compares CasADi's gradient with ours.
fn compare(ours: &[f64], theirs: &[f64]) -> Result<(), BenchError> {
    for (i, (&expected, &found)) in ours.iter().zip(theirs).enumerate() {
        if (found - expected).abs() > 1e-9 * expected.abs().max(1.0) {
            let (who, what) = ("CasADi".to_owned(), format!("derivative {i}"));
            return Err(BenchError::Disagreement { who, what, found, expected });
        }
    }
    Ok(())
}

fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().into_iter().flatten().filter_map(Value::as_f64).collect()
}
