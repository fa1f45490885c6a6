//! Catalogues: every combination of their rows, each with the best of what varies continuously.

use std::collections::{BTreeMap, BTreeSet};

use super::{Choice, NamedCase, OptimizeWish, Optimized, continuous, is_geometry};
use crate::base::{Source, Watch};
use crate::codes;
use crate::error::DesignError;
use crate::spec::located;

/// Most combinations that are tried.
const MOST: usize = 2000;

/// The optimum over all combinations of rows; that of the model's own values where there is no catalogue.
pub(super) fn best(
    source: &Source,
    wish: &OptimizeWish,
    watch: Watch<'_>,
) -> Result<Optimized, DesignError> {
    if wish.choose.is_empty() {
        return continuous(source, wish, watch);
    }
    let n: usize = wish.choose.iter().map(|(_, rows)| rows.len()).product();
    if n == 0 || n > MOST {
        let (name, _) = &wish.choose[0];
        let message = format!("`choose` has {n} combinations of rows");
        let help = format!("give each catalogue rows, and at most {MOST} combinations in all");
        return Err(located(
            DesignError::fault(codes::BAD_QUESTION, message, help),
            &source.text,
            name,
        ));
    }
    check(source, wish)?;
    let mut choices = Vec::new();
    let mut found: Option<Optimized> = None;
    let (mut evaluations, mut first_fault) = (0, None);
    for k in 0..n {
        if (watch.stop)() && found.is_some() {
            break;
        }
        let rows = combination(&wish.choose, k);
        let named = wish.choose.iter().zip(&rows);
        let named: BTreeMap<String, String> =
            named.map(|((name, _), (row, _))| (name.clone(), row.clone())).collect();
        let values: Vec<(String, String)> =
            rows.iter().flat_map(|(_, values)| values.iter().cloned()).collect();
        let chosen = Source { text: source.with_values(&values)?, ..source.clone() };
        let (after, why_not) = match continuous(&chosen, wish, watch) {
            Ok(one) => {
                evaluations += one.evaluations;
                let after = one.after;
                if found.as_ref().is_none_or(|best| is_better(&one, best)) {
                    found = Some(one);
                }
                (Some(after), None)
            }
            // Other rows may close, and meet the conditions.
            Err(error @ DesignError::Rejected(_)) => {
                let why = error.diagnostics().first().map(|fault| fault.message.clone());
                first_fault.get_or_insert(error);
                (None, why)
            }
            Err(error) => return Err(error),
        };
        choices.push(Choice { rows: named, after, why_not });
        (watch.reached)(&format!("{} of {n} combinations", k + 1), (k + 1) as f64 / n as f64);
    }
    let Some(mut best) = found else { return Err(first_fault.unwrap_or(DesignError::Stopped)) };
    let sign = if best.goal == "maximize" { -1.0 } else { 1.0 };
    let key = |choice: &Choice| choice.after.map_or(f64::INFINITY, |after| sign * after);
    choices.sort_by(|a, b| key(a).total_cmp(&key(b)));
    best.ends.clear();
    (best.choices, best.evaluations) = (choices, evaluations);
    Ok(best)
}

/// Refuses rows of values that are no parameters, and parameters that two catalogues set.
fn check(source: &Source, wish: &OptimizeWish) -> Result<(), DesignError> {
    let is_geometry = is_geometry(wish);
    let mut owners: BTreeMap<&str, &str> = BTreeMap::new();
    for (catalogue, rows) in &wish.choose {
        let names: BTreeSet<&str> = rows
            .iter()
            .flat_map(|(_, values)| values.iter().map(|(name, _)| name.as_str()))
            .collect();
        for name in names {
            source.stated(&[name.to_owned()], is_geometry)?;
            if let Some(other) = owners.insert(name, catalogue) {
                let message = format!("catalogues `{other}` and `{catalogue}` both set `{name}`");
                let help = format!("set `{name}` in one of them alone");
                let fault = DesignError::fault(codes::BAD_QUESTION, message, help);
                return Err(located(fault, &source.text, catalogue));
            }
        }
    }
    Ok(())
}

fn is_better(one: &Optimized, best: &Optimized) -> bool {
    if one.goal == "maximize" { one.after > best.after } else { one.after < best.after }
}

/// The `k`-th combination: one row of each catalogue, the last one running fastest.
fn combination(choose: &[(String, Vec<NamedCase>)], k: usize) -> Vec<&NamedCase> {
    let mut left = k;
    let mut rows: Vec<&NamedCase> = choose
        .iter()
        .rev()
        .map(|(_, rows)| {
            let row = &rows[left % rows.len()];
            left /= rows.len();
            row
        })
        .collect();
    rows.reverse();
    rows
}
