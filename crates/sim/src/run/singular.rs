//! Noticing singular poses: where the constraint rows lose rank for an instant and branches of
//! motion meet, as at the change point of a parallelogram.
//!
//! The pivots of the multiplier system, which are known at every stage of an explicit step, show
//! where the rank margin is small. There the motion is searched for its least margin, and the singular
//! values of G at that instant decide.

use bksim_dae::{Loader, Saver, SolveError, Step};
use nalgebra::DVector;

use super::summary::SingularPose;
use crate::evaluator::Evaluator;
use crate::linear::rank::{Smallness, best_rows, sparse_dependent_rows};
use crate::linear::rows::{Inverse, LARGEST_DENSE, SparseRows};
use crate::linear::svd::Svd;
use crate::multiplier::MultiplierSystem;

/// Rank margin, see [`MultiplierSystem::rank_margin`], below which a step of Radau's calls for a search:
/// a third of the regular singular value. Handing over later costs digits: what Radau's equations
/// leave of its error near the pose comes out as energy.
const WEAK: f64 = 0.1;
/// Rank margin that only a singular pose has, as far as a motion can be foreseen.
const VANISHING: f64 = 1e-4;
/// Part of a step over which the fall of a margin is measured: too short to pass over a pose, unless the end of the
/// step is as good as in it.
const PROBE: f64 = 1e-3;
/// How many steps ahead a pose must be to be none yet.
const FAR: f64 = 10.0;
/// Rank margin above which a state has left a singular pose.
pub(crate) const REGULAR: f64 = 3.0 * WEAK;
/// Rank margin of a stage that calls for a search. Two stages lie at most a third of a step apart, so
/// that a step as long as a radian has one this near to a pose that it passes.
pub(crate) const NOTICEABLE: f64 = 0.1;
/// Part of the larger rank margin at the ends of a step above which that of no stage is where a pose lies within: it
/// falls as the square of the distance, and of a pose between two stages one is within a third of what the farther end
/// is, so that its margin is a ninth.
pub(crate) const FLAT: f64 = 0.25;
/// Rank margin of a stage that always calls for a search: nearer to a pose stages are taken as limits, and their margins
/// are those of states next to them.
pub(crate) const CLOSE: f64 = 1e-3;
/// Part of its regular value below which a singular value is that of a singular pose; states of a
/// run miss the pose by their tolerance.
const SINGULAR: f64 = 1e-3;
/// Rank margin of a state in which a singular value is lost: a motion may pass by the pose at a distance of its tolerance, in
/// steps so short that none has a dip.
const LOST: f64 = SINGULAR * SINGULAR;
/// Instants of a step looked at first, and shrinkings of the bracket around the least margin.
const SAMPLES: usize = 16;
/// Every how many of these are looked at before the others.
const STRIDE: usize = 4;
/// Part of the margins next to it below which the least one may vanish, of all instants and of the few.
const DEEP: f64 = 0.2;
const SHALLOW: f64 = 0.5;
const SHRINKINGS: usize = 40;
/// Rows with this part in the vanishing combination are named.
const PART: f64 = 0.1;

/// Search for singular poses in the steps of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct SingularMonitor {
    /// The largest smallest singular value met.
    regular: f64,
    /// Smallest singular value of the pose that the motion is near to, once it is known.
    near: Option<f64>,
}

/// Singular pose found in a step.
#[derive(Clone, PartialEq, Debug)]
pub(crate) enum Sighting {
    /// A pose not seen before.
    New(SingularPose),
    /// The pose found last, met more closely: replaces it.
    Better(SingularPose),
}

impl SingularMonitor {
    pub(crate) fn save(&self, saver: &mut Saver) {
        saver.real(self.regular);
        saver.option(self.near);
    }

    pub(crate) fn load(loader: &mut Loader<'_>) -> Result<Self, SolveError> {
        Ok(Self { regular: loader.real()?, near: loader.option()? })
    }

    /// No stage of the last step was weak: the next pose is another one.
    pub(crate) fn leave(&mut self) {
        self.near = None;
    }

    /// Takes the start of a step as regular where nothing else is known.
    pub(crate) fn begin(
        &mut self,
        evaluator: &mut Evaluator,
        multipliers: &MultiplierSystem,
        step: &Step<'_>,
    ) {
        if !self.has_begun() && !multipliers.active_rows().is_empty() {
            let rows = active_rows_at(evaluator, multipliers, step, step.t0());
            self.regular = smallest_singular_value(rows);
        }
    }

    /// True once the singular values of some regular state are known.
    pub(crate) fn has_begun(&self) -> bool {
        self.regular > 0.0
    }

    /// The singular pose within a step, or at its end.
    pub(crate) fn search(
        &mut self,
        evaluator: &mut Evaluator,
        multipliers: &mut MultiplierSystem,
        step: &Step<'_>,
    ) -> Option<Sighting> {
        let nq = evaluator.shape().nq;
        let dip = Dip::of(evaluator, multipliers, step);
        if dip.falls {
            self.near = None;
        }
        // The singular value of regular states: steps may shorten on their way to a pose, so that those which pass it
        // have none.
        let mut rows_at = |t: f64| active_rows_at(evaluator, multipliers, step, t);
        if self.near.is_none() && (dip.falls || dip.rises || dip.t.is_some()) {
            for end in [step.t0(), step.t1()] {
                self.regular = self.regular.max(smallest_singular_value(rows_at(end)));
            }
        }
        let Some(t) = dip.t else {
            if dip.rises {
                self.near = None;
            }
            return None;
        };

        // The singular values there decide.
        let smallest = SINGULAR * self.regular;
        let Loss { least, rank, rows } = Loss::of(&finite(rows_at(t))?, smallest)?;
        let kept = multipliers.active_rows();
        // Rows that depend on these elsewhere may hold what these lose.
        let mut is_held = || {
            let mut y = vec![0.0; step.y1().len()];
            step.at(t, &mut y);
            let all = finite(evaluator.constraints(t, &y[..nq]).jacobian_rows());
            kept.len() < evaluator.shape().nc
                && all.is_some_and(|all| rank_above(&all, smallest) >= kept.len())
        };
        if rank == kept.len() || is_held() || self.near.is_some_and(|known| known <= least) {
            if dip.rises {
                self.near = None;
            }
            return None;
        }
        let is_known = self.near.is_some();
        self.near = (!dip.rises).then_some(least);
        let pose = SingularPose { t, rank, rows: rows.into_iter().map(|row| kept[row]).collect() };
        Some(if is_known { Sighting::Better(pose) } else { Sighting::New(pose) })
    }
}

/// The active rows of G at an instant of a step.
fn active_rows_at(
    evaluator: &mut Evaluator,
    multipliers: &MultiplierSystem,
    step: &Step<'_>,
    t: f64,
) -> SparseRows {
    let nq = evaluator.shape().nq;
    let mut y = vec![0.0; step.y1().len()];
    step.at(t, &mut y);
    evaluator.constraints(t, &y[..nq]).jacobian_rows().select(multipliers.active_rows())
}

/// Whether a step of Radau's, or the motion soon after it, meets a singular pose: its own equations
/// have no unique solution there. Explicit steps had better begin early: their accelerations carry
/// the error of the state they start from, divided by the way that is left to the pose.
pub(crate) fn is_ahead(
    evaluator: &mut Evaluator,
    multipliers: &mut MultiplierSystem,
    step: &Step<'_>,
) -> bool {
    // Three instants of each radian.
    let n = 3 * n_radians(step, evaluator.shape().nq);
    let mut margin = |k: usize| margin_within(evaluator, multipliers, step, k as f64 / n as f64);
    let values: Vec<f64> = (1..=n).map(&mut margin).collect();
    if !values.iter().any(|&value| value < WEAK) {
        return false;
    }
    if let Dip { t: Some(t), .. } = Dip::of(evaluator, multipliers, step) {
        let part = (t - step.t0()) / (step.t1() - step.t0());
        if margin_within(evaluator, multipliers, step, part) < VANISHING {
            return true;
        }
    }
    values[n - 1] < WEAK && is_foreseen(evaluator, multipliers, step)
}

/// The radians, at most so many, that the coordinate that moves farthest turns by in a step, if it is an angle.
fn n_radians(step: &Step<'_>, nq: usize) -> usize {
    const MOST: f64 = 8.0;
    let mut y = vec![0.0; step.y1().len()];
    step.at(step.t0(), &mut y);
    let ways = y.iter().zip(step.y1()).take(nq).map(|(before, after)| (after - before).abs());
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "one to eight")]
    let n = ways.fold(0.0, f64::max).ceil().clamp(1.0, MOST) as usize;
    n
}

/// True if the motion continued by its accelerations comes to a singular pose within some steps.
fn is_foreseen(
    evaluator: &mut Evaluator,
    multipliers: &mut MultiplierSystem,
    step: &Step<'_>,
) -> bool {
    let (nq, h) = (evaluator.shape().nq, step.t1() - step.t0());
    let (q, v) = step.y1()[..2 * nq].split_at(nq);
    let a = &step.ydot1()[nq..2 * nq];
    let mut margin = |ahead: f64| {
        let position = |i: usize| q[i] + ahead * (v[i] + 0.5 * ahead * a[i]);
        let rate = |i: usize| v[i] + ahead * a[i];
        let (q, v): (Vec<f64>, Vec<f64>) = (0..nq).map(|i| (position(i), rate(i))).unzip();
        multipliers.rank_margin_at(&evaluator.dynamics(step.t1() + ahead, &q, &v))
    };
    let here = margin(0.0);
    if here < VANISHING {
        return true;
    }
    // Singular values fall to zero in proportion to the way left.
    let probe = PROBE * h;
    let (now, next) = (here.sqrt(), margin(probe).sqrt());
    let left = probe * now / (now - next);
    if !(left / h > 0.0 && left / h < FAR) {
        return false;
    }
    let t = golden_section(0.5, 1.5, &mut |part| margin(part * left));
    margin(t * left) < VANISHING
}

/// Rank margin at a part of a step.
fn margin_within(
    evaluator: &mut Evaluator,
    multipliers: &mut MultiplierSystem,
    step: &Step<'_>,
    part: f64,
) -> f64 {
    let nq = evaluator.shape().nq;
    let t = step.t0() + part * (step.t1() - step.t0());
    let mut y = vec![0.0; step.y1().len()];
    step.at(t, &mut y);
    let (q, v) = y[..2 * nq].split_at(nq);
    multipliers.rank_margin_of(evaluator, t, (q, v))
}

/// Where the rank margin of a step is least.
struct Dip {
    /// The instant, if the margin may vanish there.
    t: Option<f64>,
    /// True if it has been regular before that, and is again after.
    falls: bool,
    rises: bool,
}

impl Dip {
    /// The least margin of some instants, then golden sections around it.
    fn of(evaluator: &mut Evaluator, multipliers: &mut MultiplierSystem, step: &Step<'_>) -> Self {
        let mut margin = |part: f64| margin_within(evaluator, multipliers, step, part);
        let at = |k: usize| k as f64 / SAMPLES as f64;
        let mut values = [f64::NAN; SAMPLES + 1];
        let is_regular = |values: &[f64]| values.iter().any(|&value| value >= NOTICEABLE);

        // A few instants tell most of the steps that pass no pose.
        (0..=SAMPLES).step_by(STRIDE).for_each(|k| values[k] = margin(at(k)));
        let few: [f64; SAMPLES / STRIDE + 1] = std::array::from_fn(|k| values[STRIDE * k]);
        let least = least_of(&few);
        if !may_vanish(&few, least, SHALLOW) && few[least] >= LOST {
            let [falls, rises] = [is_regular(&few[..least]), is_regular(&few[least..])];
            return Self { t: None, falls, rises };
        }

        // All of them, and golden sections around the least.
        (0..=SAMPLES).filter(|k| k % STRIDE > 0).for_each(|k| values[k] = margin(at(k)));
        let least = least_of(&values);
        let (low, high) = (at(least.saturating_sub(1)), at((least + 1).min(SAMPLES)));
        let t = (may_vanish(&values, least, DEEP) || values[least] < LOST).then(|| {
            let part = golden_section(low, high, &mut margin);
            step.t0() + part * (step.t1() - step.t0())
        });
        Self { t, falls: is_regular(&values[..least]), rises: is_regular(&values[least..]) }
    }
}

/// How many times better conditioned other rows must be to be taken: near a singular pose all lose rank
/// together, and none are by this much.
const BETTER: f64 = 4.0;

/// The rows to be inactive in place of `inactive` at a position where others hold the motion far
/// better; `None` where there are none. Rows of closed contacts bear what their modes ask for: none of `closed` is exchanged.
pub(super) fn better_rows(
    evaluator: &mut Evaluator,
    (t, q): (f64, &[f64]),
    inactive: &[usize],
    closed: &[usize],
) -> Option<Vec<usize>> {
    let (left_out, kept): (Vec<usize>, Vec<usize>) =
        closed.iter().copied().partition(|row| inactive.contains(row));
    let all = finite(evaluator.constraints(t, q).jacobian_rows())?.without(&left_out);
    let now: Vec<usize> = (0..all.n_rows()).filter(|row| !inactive.contains(row)).collect();
    let chosen = best_rows(&all, &kept, now.len());
    if chosen.len() != now.len() || chosen == now {
        return None;
    }
    let [now, then] = [&now, &chosen].map(|rows| smallest_singular_value(all.select(rows)));
    let others = (0..all.n_rows()).filter(|row| !chosen.contains(row)).collect();
    (then > BETTER * now).then_some(others)
}

fn finite(rows: SparseRows) -> Option<SparseRows> {
    (rows.n_rows() > 0 && rows.n_columns > 0 && rows.is_finite()).then_some(rows)
}

fn smallest_singular_value(rows: SparseRows) -> f64 {
    let Some(rows) = finite(rows) else { return 0.0 };
    if rows.n_columns > LARGEST_DENSE {
        return Inverse::of(rows).map_or(0.0, |mut inverse| inverse.weakest_combination().1);
    }
    Svd::values(&rows.dense()).map_or(0.0, |values| values.min())
}

/// Number of singular values above `smallest`.
fn rank_above(rows: &SparseRows, smallest: f64) -> usize {
    if rows.n_columns > LARGEST_DENSE {
        let longest = rows.norms().into_iter().fold(0.0, f64::max);
        let smallness = Smallness { rest: smallest / longest, part: PART };
        return sparse_dependent_rows(rows, smallness).rank;
    }
    let above = |values: DVector<f64>| values.iter().filter(|&&value| value >= smallest).count();
    Svd::values(&rows.dense()).map_or(0, above)
}

/// Loss of rank where the rank margin is least.
struct Loss {
    /// The smallest singular value.
    least: f64,
    rank: usize,
    /// The rows that take part.
    rows: Vec<usize>,
}

impl Loss {
    /// Of finite rows, whose singular values below `smallest` count as lost.
    fn of(rows: &SparseRows, smallest: f64) -> Option<Self> {
        if rows.n_columns > LARGEST_DENSE {
            let longest = rows.norms().into_iter().fold(0.0, f64::max);
            let smallness = Smallness { rest: smallest / longest, part: PART };
            let found = sparse_dependent_rows(rows, smallness);
            let least = smallest_singular_value(rows.clone());
            return Some(Self { least, rank: found.rank, rows: found.involved });
        }
        let Svd { u: left, singular_values: values, .. } = Svd::new(&rows.dense())?;
        let lost: Vec<usize> = (0..values.len()).filter(|&k| values[k] < smallest).collect();
        let takes_part = |&row: &usize| lost.iter().any(|&k| left[(row, k)].abs() > PART);
        Some(Self {
            least: values.min(),
            rank: rows.n_rows() - lost.len(),
            rows: (0..rows.n_rows()).filter(takes_part).collect(),
        })
    }
}

/// Index of the least of some margins.
fn least_of(values: &[f64]) -> usize {
    let least = (0..values.len()).min_by(|&a, &b| values[a].total_cmp(&values[b]));
    least.expect("a step has samples")
}

/// True if margin sampled at equal distances, the `least` of its values known, may vanish in between:
/// it falls as the square of the distance to a singular pose, so the parabola through three values
/// decides.
fn may_vanish(values: &[f64], least: usize, deep: f64) -> bool {
    let middle = least.clamp(1, values.len() - 2);
    let [left, centre, right] = [values[middle - 1], values[middle], values[middle + 1]];
    let (slope, curvature) = (0.5 * (right - left), right - 2.0 * centre + left);
    let low = if curvature > 0.0 {
        // No further than to the ends of the samples.
        let vertex = (-slope / curvature).clamp(-1.0, 1.0);
        centre + vertex * (slope + 0.5 * vertex * curvature)
    } else {
        values[least]
    };
    low < deep * left.max(right)
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
