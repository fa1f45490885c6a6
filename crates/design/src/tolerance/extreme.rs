//! Greatest and least values over a range of a prescribed measure: limits of a rocker, the stroke of a piston.
//!
//! ```text
//! v(p) = max over u of h(q(p, u), p)      ∂h/∂u = 0 at the pose u* where it is        dv/dp = ∂h/∂p at u*
//! ```
//!
//! The last one is the envelope theorem: as the pose of the greatest value moves with a part, that does not count to first
//! order. In every sample, and at every corner of the limits, the pose is found anew, by Newton's iteration on ∂h/∂u.

use bksim::analysis::Drive;

use super::Job;
use crate::poses::{Pose, Solver};

/// A pose in which a result is greatest or least.
#[derive(Clone, Debug)]
pub(super) struct Extreme {
    /// The result, which is to be multiplied by `factor`.
    pub(super) k: usize,
    pub(super) factor: f64,
    pub(super) pose: Pose,
    /// Distance of two values of the range, and its ends.
    step: f64,
    ends: [f64; 2],
}

/// What a result over a range is made of: the text of the quantity, and 1 for its greatest, −1 for its least value with
/// their factors; none of other texts.
pub(super) fn parts_of(text: &str) -> Option<(&str, Vec<(f64, f64)>)> {
    let inside = |name: &str| {
        let rest = text.trim().strip_prefix(name)?.trim_start().strip_prefix('(')?;
        rest.strip_suffix(')').filter(|of| is_one(of))
    };
    let kinds = [
        ("max", vec![(1.0, 1.0)]),
        ("min", vec![(-1.0, 1.0)]),
        ("peak_to_peak", vec![(1.0, 1.0), (-1.0, -1.0)]),
    ];
    kinds.into_iter().find_map(|(name, parts)| Some((inside(name)?, parts)))
}

/// True of one argument: no comma and no closing parenthesis outside of parentheses.
fn is_one(text: &str) -> bool {
    let mut depth = 0;
    text.chars().all(|c| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        depth >= 0 && (c != ',' || depth > 0)
    })
}

/// Poses at all values of a range in which a result is greatest (1) or least (−1).
pub(super) fn greatest(
    solver: &mut Solver<'_>,
    start: &Pose,
    drive: &Drive,
    (k, sign, factor): (usize, f64, f64),
) -> Option<Extreme> {
    let values = drive.range.values();
    let (first, last) = (*values.first()?, *values.last()?);
    let mut pose = start.clone();
    let mut best: Option<(f64, Pose)> = None;
    for value in &values {
        let p = pose.p.clone();
        pose = solver.follow(&pose, &p, &[*value]).ok()?;
        let found = sign * solver.raw(&pose.q, &pose.p, &pose.u).2[k];
        if best.as_ref().is_none_or(|(known, _)| found > *known) {
            best = Some((found, pose.clone()));
        }
    }
    let step = (last - first).abs() / (values.len().max(2) - 1) as f64;
    let ends = [first.min(last), first.max(last)];
    let begun = Extreme { k, factor, pose: best?.1, step, ends };
    let pose = begun.turned(solver, begun.pose.clone())?;
    Some(Extreme { pose, ..begun })
}

impl Extreme {
    /// The pose next to one at which the result turns back; the end of the range where it does not.
    fn turned(&self, solver: &mut Solver<'_>, from: Pose) -> Option<Pose> {
        /// Part of a step by which the slope of the slope is found.
        const PROBE: f64 = 1e-3;
        let span = self.ends[1] - self.ends[0];
        let is_turn = (span - std::f64::consts::TAU).abs() < 1e-9;
        let mut pose = from;
        for _ in 0..30 {
            let p = pose.p.clone();
            let aside = solver.follow(&pose, &p, &[pose.u[0] + PROBE * self.step]).ok()?;
            let here = solver.outputs(&pose, &[])?.by_u[(self.k, 0)];
            let next = solver.outputs(&aside, &[])?.by_u[(self.k, 0)];
            let wanted = -here * PROBE * self.step / (next - here);
            let wanted = if wanted.is_finite() { wanted } else { 0.0 };
            let mut u = pose.u[0] + wanted.clamp(-self.step, self.step);
            if !is_turn {
                u = u.clamp(self.ends[0], self.ends[1]);
            }
            let moved = (u - pose.u[0]).abs();
            pose = solver.follow(&pose, &p, &[u]).ok()?;
            if moved < 1e-9 * self.step {
                break;
            }
        }
        Some(pose)
    }

    /// The extreme value at other parts, times its factor; none where they do not assemble.
    fn value(&self, solver: &mut Solver<'_>, p: &[f64]) -> Option<f64> {
        let found = solver.follow(&self.pose, p, &self.pose.u).ok()?;
        let found = self.turned(solver, found)?;
        Some(self.factor * solver.raw(&found.q, &found.p, &found.u).2[self.k])
    }
}

impl Job<'_> {
    /// A result over a range at values of parts and plays.
    pub(super) fn over_range(
        &self,
        solver: &mut Solver<'_>,
        extremes: &[Extreme],
        point: &[f64],
    ) -> Option<f64> {
        let p = (self.parameters)(point)?;
        extremes.iter().map(|extreme| extreme.value(solver, &p)).sum()
    }
}
