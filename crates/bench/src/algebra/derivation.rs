//! Time to derive M, h and ∂V/∂q of a chain of N links by Lagrange's equations.
//!
//! Ours are folded and ready to print; CasADi's are an unfolded graph. Relative angles, every
//! length, mass and inertia a parameter of its own.

use std::collections::BTreeMap;

use bksim_mbs::assemble::assemble;
use serde_json::{Value, json};

use crate::context::Context;
use crate::error::BenchError;
use crate::models;
use crate::peers::Absent;
use crate::report::{Check, Report, Table, ratio, seconds};
use crate::timing::{Paired, Samples, repeat};

/// Numbers of links.
const SIZES: [usize; 5] = [2, 5, 10, 20, 50];
/// Largest expected growth with N, as a power, which decides the sizes that are left out.
const WORST_GROWTH: f64 = 4.0;
/// Goal of the time of N = 50 over CasADi's of N = 10.
const LARGE_RATIO_GOAL: f64 = 40.0;

/// Derives all sizes.
pub(crate) fn run(context: &Context) -> Result<Report, BenchError> {
    let mut report = Report::new("derivation", "M, h and dV/dq of an N-link chain, CPU time");
    let sizes = if context.effort.is_quick { &SIZES[..2] } else { &SIZES[..] };

    // Rounds of ours and theirs; the reason of a missing peer is noted once.
    let mut paired: BTreeMap<usize, Paired> = BTreeMap::new();
    let mut large = Paired::default();
    let mut casadi = json!(null);
    for _ in 0..context.effort.rounds {
        let theirs = peer(context, sizes);
        let ours = ours(context, sizes)?;
        let samples = |n: usize| theirs.as_ref().map(|t| times(t, n)).unwrap_or_default();
        for (&n, own) in &ours {
            paired.entry(n).or_default().push(own, &samples(n));
        }
        if let Some(own) = ours.get(&50) {
            large.push(own, &samples(10));
        }
        match theirs {
            Ok(value) => casadi = value,
            Err(absent) if report.notes.is_empty() => {
                report.notes.push(format!("CasADi: {absent}"));
            }
            Err(_) => (),
        }
    }

    // A row for each size, with the growth from the previous one.
    let mut table =
        Table::new(["N", "ours", "growth", "CasADi", "growth", "ours/CasADi", "spread"]);
    let mut last: Option<(usize, f64, f64)> = None;
    for (&n, pair) in &paired {
        let (own, their) = (pair.ours.minimum(), pair.theirs.minimum());
        let growth = |now: f64, before: fn(&(usize, f64, f64)) -> f64| {
            last.map_or(f64::NAN, |l| (now / before(&l)).ln() / (n as f64 / l.0 as f64).ln())
        };
        let power = |p: f64| if p.is_nan() { "-".to_owned() } else { format!("N^{p:.1}") };
        let [low, high] = pair.spread();
        table.push([
            n.to_string(),
            seconds(own),
            power(growth(own, |l| l.1)),
            seconds(their),
            power(growth(their, |l| l.2)),
            ratio(pair.ratio()),
            format!("{} .. {}", ratio(low), ratio(high)),
        ]);
        let numbers = json!({
            "ours_s": own, "ours_median_s": pair.ours.median(),
            "casadi_s": their, "casadi_median_s": pair.theirs.median(), "ratio": pair.ratio(),
            "casadi_instructions": casadi["instructions"][n.to_string()],
        });
        report.numbers.insert(format!("N={n}"), numbers);
        last = Some((n, own, their));
    }

    // Sizes left out, and the goals.
    for n in sizes.iter().filter(|n| !paired.contains_key(n)) {
        report.notes.push(format!("N = {n} was left out: it would take too long"));
    }
    report.tables.push(table);
    if !context.effort.is_quick {
        let ten = paired.get(&10).map_or(f64::NAN, Paired::ratio);
        report.checks.push(Check::at_most("N = 10 over CasADi's N = 10", ten, 1.0));
        let large = Check::at_most("N = 50 over CasADi's N = 10", large.ratio(), LARGE_RATIO_GOAL);
        report.checks.push(large);
    }
    Ok(report)
}

/// Our times, smallest size first, as long as the next size is expected to finish in time.
fn ours(context: &Context, sizes: &[usize]) -> Result<BTreeMap<usize, Samples>, BenchError> {
    let mut found: BTreeMap<usize, Samples> = BTreeMap::new();
    for &n in sizes {
        if let Some((&before, samples)) = found.last_key_value() {
            let growth = (n as f64 / before as f64).powf(WORST_GROWTH);
            if samples.minimum() * growth > context.effort.longest_s {
                break;
            }
        }
        let text = models::chain(n);
        models::model(&text, "chain")?;
        let prepare = || models::model(&text, "chain").expect("the same text was read before");
        let samples = repeat(context.effort, prepare, |model| assemble(model));
        found.insert(n, samples);
    }
    Ok(found)
}

/// CasADi's times.
fn peer(context: &Context, sizes: &[usize]) -> Result<Value, Absent> {
    context.peers.python("derivation", &json!({ "sizes": sizes, "runs": 5 }))
}

/// CasADi's times of one size.
fn times(peer: &Value, n: usize) -> Samples {
    let list = peer["samples"][n.to_string()].as_array();
    Samples::new(list.into_iter().flatten().filter_map(Value::as_f64).collect())
}
