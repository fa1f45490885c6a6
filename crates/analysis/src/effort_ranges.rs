//! Ranges of efforts that inner forces, friction at rest and stops that bear leave open.
//!
//! ```text
//! τ + N s,  c + C s       least and most of every τ, while τ keeps to its limits and c to its bounds
//! ```
//!
//! One linear program for each end, where the bounds are numbers. Friction that follows reactions bends them: then the ends are
//! found by linear programs along the slopes where the one before has led, until they stay.

use microlp::OptimizationDirection::{Maximize, Minimize};
use nalgebra::{DMatrix, DVector};

use crate::effort_forces::{EffortInstant, FoundEfforts, Wanted};
use crate::ranges::{Bounded, extreme_at, ranges};

/// Linear programs for one end of a range.
const MAX_PROGRAMS: usize = 30;
/// Ends that stay to this part of the efforts are found.
const STAYS: f64 = 1e-11;
/// Part of a combination of efforts that is rounding.
const ROUNDING: f64 = 1e-9;
/// Way along an open direction for slopes, as a part of the largest effort.
const STEP: f64 = 1e-6;

/// Least and largest value of each effort.
pub(crate) type Ends = Vec<[f64; 2]>;

/// Outcome of the ranges of one instant.
pub(crate) enum EffortRanges {
    /// Nothing is open.
    Unique,
    /// The ends of all efforts.
    Open(Ends),
    /// No efforts keep to the limits.
    Impossible,
}

/// The ranges of the efforts `found` at an instant, within these limits of the actuators.
pub(crate) fn effort_ranges(
    instant: &mut EffortInstant<'_>,
    found: &FoundEfforts,
    limits: &[f64],
) -> EffortRanges {
    let inner = instant.equations.inner();
    let n = limits.len();
    let moves_effort =
        |k: usize| inner.column(k).rows(0, n).amax() > ROUNDING * inner.column(k).amax();
    if n == 0 || !(0..inner.ncols()).any(moves_effort) {
        return EffortRanges::Unique;
    }
    let quantities = quantities(found, limits, &inner);
    let Some(straight) = ranges(&quantities) else { return EffortRanges::Impossible };
    if instant.contacts.pressing.is_empty() {
        return EffortRanges::Open(straight[..n].to_vec());
    }
    let mut ends = Ends::with_capacity(n);
    for (k, straight) in straight[..n].iter().enumerate() {
        let mut end = |at: usize| {
            if straight[at].is_infinite() {
                return Some(straight[at]);
            }
            bent_end(instant, found, limits, (&inner, k, at == 0))
        };
        match (end(0), end(1)) {
            (Some(least), Some(most)) => ends.push([least, most]),
            _ => return EffortRanges::Impossible,
        }
    }
    EffortRanges::Open(ends)
}

/// Efforts with their limits, then forces of contacts with their bounds.
fn quantities(found: &FoundEfforts, limits: &[f64], inner: &DMatrix<f64>) -> Vec<Bounded> {
    let values = found.efforts.tau.iter().chain(found.efforts.contacts.iter());
    let bounds = limits.iter().map(|limit| [-limit, *limit]).chain(found.bounds.iter().copied());
    let of = |(k, (value, bounds)): (usize, (&f64, [f64; 2]))| Bounded {
        value: *value,
        slopes: inner.row(k).iter().copied().collect(),
        bounds,
    };
    values.zip(bounds).enumerate().map(of).collect()
}

/// One end of the range of an effort where the bounds follow the efforts.
fn bent_end(
    instant: &mut EffortInstant<'_>,
    found: &FoundEfforts,
    limits: &[f64],
    (inner, effort, is_least): (&DMatrix<f64>, usize, bool),
) -> Option<f64> {
    let (n, n_open) = (limits.len(), inner.ncols());
    let direction = if is_least { Minimize } else { Maximize };
    let mut s = DVector::zeros(n_open);
    let mut at = found.clone();
    let size = at.efforts.tau.amax().max(at.size).max(f64::MIN_POSITIVE);
    let mut there = |s: &DVector<f64>| {
        let change = inner * s;
        let tau = &found.efforts.tau + change.rows(0, n);
        let c = &found.efforts.contacts + change.rows(n, inner.nrows() - n);
        instant.efforts(Wanted::Near(&tau, &c))
    };
    for _ in 0..MAX_PROGRAMS {
        // Slack of all bounds, with slopes by differences.
        let slack = |of: &FoundEfforts| slack_of(of, limits);
        let here = slack(&at);
        let step = STEP * size;
        let mut slopes = DMatrix::zeros(here.len() + 1, n_open);
        for i in 0..n_open {
            let mut aside = s.clone();
            aside[i] += step;
            let aside = there(&aside)?;
            for (k, (new, old)) in slack(&aside).iter().zip(&here).enumerate() {
                slopes[(k, i)] = if old.is_finite() { (new - old) / step } else { 0.0 };
            }
            slopes[(here.len(), i)] = (aside.efforts.tau[effort] - at.efforts.tau[effort]) / step;
        }
        let bounded = |(k, value): (usize, &f64)| Bounded {
            value: *value,
            slopes: slopes.row(k).iter().copied().collect(),
            bounds: [0.0, f64::INFINITY],
        };
        let mut all: Vec<Bounded> =
            here.iter().enumerate().filter(|(_, slack)| slack.is_finite()).map(bounded).collect();
        all.push(Bounded {
            value: at.efforts.tau[effort],
            slopes: slopes.row(here.len()).iter().copied().collect(),
            bounds: [f64::NEG_INFINITY, f64::INFINITY],
        });
        let change = extreme_at(&all, all.len() - 1, direction)?;
        s += DVector::from_vec(change);
        let before = at.efforts.tau[effort];
        at = there(&s)?;
        if (at.efforts.tau[effort] - before).abs() <= STAYS * size {
            break;
        }
    }
    Some(at.efforts.tau[effort])
}

/// Distance of every effort and every contact from its bounds, never below zero within them.
fn slack_of(of: &FoundEfforts, limits: &[f64]) -> Vec<f64> {
    let efforts = of.efforts.tau.iter().zip(limits).map(|(x, limit)| (*x, [-limit, *limit]));
    let contacts = of.efforts.contacts.iter().zip(&of.bounds).map(|(x, bounds)| (*x, *bounds));
    efforts.chain(contacts).flat_map(|(x, [least, most])| [x - least, most - x]).collect()
}
