//! Noticing singular poses: where the constraint rows lose rank for an instant and branches of
//! motion meet, as at the change point of a parallelogram.
//!
//! The pivots of the multiplier system, which are known at every stage of an explicit step, tell
//! where rows are weak. There the motion is searched for the weakest instant, and the singular
//! values of G at that instant decide.

use bksim_dae::Step;

use crate::dependence::{Smallness, sparse_dependent_rows};
use crate::evaluator::Evaluator;
use crate::multiplier::MultiplierSystem;
use crate::rows::{Inverse, LARGEST_DENSE, SparseRows};

/// Weakness, see [`MultiplierSystem::weakness`], below which Radau's steps end: a tenth of the
/// regular singular value.
pub(crate) const WEAK: f64 = 1e-2;
/// Weakness above which a state has left a singular pose behind.
pub(crate) const REGULAR: f64 = 4.0 * WEAK;
/// Weakness of a stage that calls for a search. Two stages lie at most a third of a step apart, so
/// that a step as long as a radian has one this near to a pose that it passes.
pub(crate) const NOTICEABLE: f64 = 0.1;
/// Part of its regular value below which a singular value is that of a singular pose; states of a
/// run miss the pose by their tolerance.
const SINGULAR: f64 = 1e-3;
/// Instants of a step looked at first, and shrinkings of the bracket around the weakest.
const SAMPLES: usize = 16;
const SHRINKINGS: usize = 40;
/// Rows with this part in the vanishing combination are named.
const PART: f64 = 0.1;

/// A pose in which constraint rows have lost rank.
#[derive(Clone, PartialEq, Debug)]
pub struct SingularPose {
    /// s.
    pub t: f64,
    /// Rank of the constraints there.
    pub rank: usize,
    /// Rows that take part in the loss, those of the system's constraints.
    pub rows: Vec<usize>,
}

/// Looks for singular poses in the steps of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Watch {
    /// The largest smallest singular value met.
    regular: f64,
    /// When the last pose was passed.
    last: Option<f64>,
}

impl Watch {
    /// The singular pose within a step, if there is one that the step before did not end in.
    pub(crate) fn search(
        &mut self,
        evaluator: &mut Evaluator,
        multipliers: &mut MultiplierSystem,
        step: &Step<'_>,
    ) -> Option<SingularPose> {
        let nq = evaluator.shape().nq;
        let (t0, h) = (step.t0(), step.t1() - step.t0());
        let mut y = vec![0.0; step.y1().len()];
        let mut weakness_at = |part: f64| {
            let t = t0 + part * h;
            step.at(t, &mut y);
            let (q, v) = y[..2 * nq].split_at(nq);
            multipliers.weakness_at(&evaluator.dynamics(t, q, v))
        };

        // The weakest of some instants, then golden sections around it.
        let at = |k: usize| k as f64 / SAMPLES as f64;
        let weakness: Vec<f64> = (0..=SAMPLES).map(|k| weakness_at(at(k))).collect();
        let weakest = (0..=SAMPLES).min_by(|&a, &b| weakness[a].total_cmp(&weakness[b]))?;
        let (low, high) = (at(weakest.saturating_sub(1)), at((weakest + 1).min(SAMPLES)));
        let part = golden_section(low, high, &mut weakness_at);
        let t = t0 + part * h;

        // What the singular values say, there and at the ends.
        let mut rows_at = |t: f64| {
            step.at(t, &mut y);
            let jacobian = evaluator.constraints(t, &y[..nq]).jacobian_rows();
            jacobian.select(multipliers.kept())
        };
        for end in [t0, step.t1()] {
            self.regular = self.regular.max(smallest_singular_value(rows_at(end)));
        }
        let (rank, taking_part) = weak_rows(&finite(rows_at(t))?, SINGULAR * self.regular)?;
        let is_known = self.last.is_some_and(|last| (t - last).abs() < h.abs() / SAMPLES as f64);
        let kept = multipliers.kept();
        if rank == kept.len() || is_known {
            return None;
        }
        self.last = Some(t);
        Some(SingularPose { t, rank, rows: taking_part.into_iter().map(|k| kept[k]).collect() })
    }
}

fn finite(rows: SparseRows) -> Option<SparseRows> {
    (rows.n_rows() > 0 && rows.n_columns > 0 && rows.is_finite()).then_some(rows)
}

fn smallest_singular_value(rows: SparseRows) -> f64 {
    let Some(rows) = finite(rows) else { return 0.0 };
    if rows.n_columns > LARGEST_DENSE {
        return Inverse::of(rows).map_or(0.0, |mut inverse| inverse.weakest_combination().1);
    }
    rows.dense().singular_values().min()
}

/// The rank of finite rows but for singular values below `smallest`, and the rows that take part
/// in what is lost.
fn weak_rows(rows: &SparseRows, smallest: f64) -> Option<(usize, Vec<usize>)> {
    if rows.n_columns > LARGEST_DENSE {
        let longest = rows.norms().into_iter().fold(0.0, f64::max);
        let smallness = Smallness { rest: smallest / longest, part: PART };
        let found = sparse_dependent_rows(rows, smallness);
        return Some((found.rank, found.involved));
    }
    let svd = rows.dense().svd(true, false);
    let (left, values) = (svd.u?, svd.singular_values);
    let lost: Vec<usize> = (0..values.len()).filter(|&k| values[k] < smallest).collect();
    let takes_part = |&row: &usize| lost.iter().any(|&k| left[(row, k)].abs() > PART);
    let taking_part = (0..rows.n_rows()).filter(takes_part).collect();
    Some((rows.n_rows() - lost.len(), taking_part))
}

/// The argument between `low` and `high` of the least value, by golden sections.
fn golden_section(mut low: f64, mut high: f64, value: &mut dyn FnMut(f64) -> f64) -> f64 {
    const SECTION: f64 = 0.381_966_011_250_105_15; // (3 − √5)/2
    let mut left = low + SECTION * (high - low);
    let mut right = high - SECTION * (high - low);
    let (mut at_left, mut at_right) = (value(left), value(right));
    for _ in 0..SHRINKINGS {
        if at_left < at_right {
            (high, right, at_right) = (right, left, at_left);
            left = low + SECTION * (high - low);
            at_left = value(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = high - SECTION * (high - low);
            at_right = value(right);
        }
    }
    0.5 * (low + high)
}
