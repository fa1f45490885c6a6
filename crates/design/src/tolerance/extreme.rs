//! Greatest and least values over a range of a prescribed measure: limits of a rocker, the stroke of a piston.
//!
//! ```text
//! v(p) = max over u of h(q(p, u), p)      ∂h/∂u = 0 at the pose u* where it is        dv/dp = ∂h/∂p at u*
//! ```
//!
//! The last one is the envelope theorem: as the pose of the greatest value moves with a part, that does not count to first
//! order. In every sample, and at every corner of the limits, the pose is found anew, by Newton's iteration on ∂h/∂u.

use std::collections::BTreeMap;

use bksim::Mechanism;
use bksim::analysis::Drive;
use bksim::expr::Expr;

use super::job::Ends;
use super::{Job, PoseTolerance, ToleranceWish};
use crate::base::Source;
use crate::codes;
use crate::error::DesignError;
use crate::formula::{Formula, argument};
use crate::poses::{Pose, Poses, Solver};
use crate::spec::located;

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

/// Parts of a result over a range: the text of the quantity, and 1 for its greatest, −1 for its least value with
/// their factors; none of other texts.
pub(super) fn parts_of(text: &str) -> Option<(&str, Vec<(f64, f64)>)> {
    let kinds = [
        ("max", vec![(1.0, 1.0)]),
        ("min", vec![(-1.0, 1.0)]),
        ("peak_to_peak", vec![(1.0, 1.0), (-1.0, -1.0)]),
    ];
    kinds.into_iter().find_map(|(name, parts)| Some((argument(text, name)?, parts)))
}

/// The fault of a formula with extremes over a range in it, which are results by themselves; `None` without any.
pub(super) fn in_formula(text: &str) -> Option<DesignError> {
    // A call with one argument, among other things.
    let call = |name: &str| {
        let begin = format!("{name}(");
        let calls = text.match_indices(&begin).map(|(at, _)| at);
        calls
            .filter(|&at| !text[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_'))
            .find_map(|at| {
                let mut ends = text[at..].match_indices(')').map(|(end, _)| at + end + 1);
                ends.find_map(|end| argument(&text[at..end], name))
            })
    };
    let [most, least, span] = ["max", "min", "peak_to_peak"].map(call);
    let help = match (most, least, span) {
        (Some(most), Some(least), _) if most == least => format!("write `peak_to_peak({most})`"),
        (Some(of), ..) => format!("ask for `max({of})` by itself"),
        (_, Some(of), _) => format!("ask for `min({of})` by itself"),
        (.., Some(of)) => format!("ask for `peak_to_peak({of})` by itself"),
        _ => return None,
    };
    let message = format!("`{text}` has extremes over a range in a formula");
    Some(DesignError::fault(codes::BAD_QUESTION, message, help))
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
    /// The greatest and least values of results over a range of a measure.
    fn ranged(
        &self,
        over: &str,
        results: &[Vec<Extreme>],
        n_samples: u64,
    ) -> Result<PoseTolerance, DesignError> {
        let mut solver = self.poses.solver();
        let by = self.by_parts()?;
        let nominal: Vec<f64> = results
            .iter()
            .map(|extremes| self.over_range(&mut solver, extremes, &self.nominal()))
            .collect::<Option<_>>()
            .ok_or_else(Self::singular)?;
        let value = |solver: &mut Solver<'_>, point: &[f64]| -> Option<Vec<f64>> {
            results.iter().map(|extremes| self.over_range(solver, extremes, point)).collect()
        };
        let sums = self.samples_of(n_samples, &nominal, &value);
        if (self.watch.stop)() {
            return Err(DesignError::Stopped);
        }
        let (n, n_open) = (sums.n as f64, sums.n_open as f64);
        let share = n_open / n;
        let mut bands = Vec::new();
        let mut is_open = sums.n_open > 0;
        for (k, extremes) in results.iter().enumerate() {
            let mut slopes = vec![0.0; self.parts.len()];
            let mut of_plays = vec![[0.0; 2]; self.plays.len()];
            for extreme in extremes {
                let here = solver.outputs(&extreme.pose, &[]).ok_or_else(Self::singular)?;
                let by_parts = here.by_p.row(extreme.k) * &by;
                for (sum, slope) in slopes.iter_mut().zip(by_parts.iter()) {
                    *sum += extreme.factor * slope;
                }
                for (sum, play) in of_plays.iter_mut().zip(self.plays) {
                    for (axis, sum) in sum.iter_mut().enumerate() {
                        *sum += extreme.factor * here.by_p[(extreme.k, play.place + axis)];
                    }
                }
            }
            let mut ends = self.corners(&of_plays, &mut |point| {
                self.over_range(&mut solver, extremes, point).ok_or(None)
            });
            ends.1 |= sums.n_open > 0;
            is_open |= ends.1;
            let [low, high] = ends.0.map(|end| (end.0, end.1.map_or_else(Vec::new, |at| at.2)));
            let ends = Ends {
                interval: [low.0, high.0],
                at: [low.1, high.1],
                proved: false,
                is_open: ends.1,
            };
            let sampled = (&sums.of[k], n - n_open);
            bands.push(self.band(nominal[k], (&slopes, &of_plays), ends, sampled));
        }
        Ok(PoseTolerance {
            at: BTreeMap::new(),
            over: Some(over.to_owned()),
            assembles: is_open.then_some(false),
            share_without_assembly: [share, (share * (1.0 - share) / n).sqrt()],
            bands,
            paths: Vec::new(),
        })
    }

    /// A result over a range at values of parts and plays.
    fn over_range(
        &self,
        solver: &mut Solver<'_>,
        extremes: &[Extreme],
        point: &[f64],
    ) -> Option<f64> {
        let p = (self.parameters)(point)?;
        extremes.iter().map(|extreme| extreme.value(solver, &p)).sum()
    }
}

/// Reads a formula of a result.
type Reader<'a> = dyn Fn(&String) -> Result<Formula, DesignError> + 'a;

/// Greatest and least values over the range of the question.
pub(super) fn ranged(
    mechanism: &Mechanism,
    job: Job<'_>,
    (of, wish, n_samples): (&[&String], &ToleranceWish, u64),
    (read, source): (&Reader<'_>, &Source),
) -> Result<PoseTolerance, DesignError> {
    let [(name, values)] = wish.at.as_slice() else {
        let message = format!("`{}` is of the range of one measure", of[0]);
        let help = "say over which: `at = { \"A.angle\" = \"0:360 deg:181\" }`";
        let fault = DesignError::fault(codes::NOTHING_ASKED, message, help);
        return Err(located(fault, &source.text, of[0]));
    };
    let over = format!("{}={}", name.trim(), values.trim());
    let drive = Drive::parse(&mechanism.model, name, values)?;
    if drive.range.n < 3 {
        let message = format!("`{over}` is no range in which `{}` can be", of[0]);
        let help = "give both ends and the number of poses: `\"0:360 deg:181\"`";
        return Err(located(
            DesignError::fault(codes::BAD_QUESTION, message, help),
            &source.text,
            values,
        ));
    }
    let parts: Vec<(&str, Vec<(f64, f64)>)> = of.iter().filter_map(|text| parts_of(text)).collect();
    let results =
        parts.iter().map(|(text, _)| read(&(*text).to_owned())).collect::<Result<Vec<_>, _>>()?;
    let outputs: Vec<Expr> = results.iter().map(|result| result.expr).collect();
    let poses = Poses::new(mechanism, &[(drive.name.clone(), drive.measure)], &outputs, &[])?;
    let mut solver = poses.solver();
    let mut extremes = Vec::new();
    for (k, (_, parts)) in parts.iter().enumerate() {
        let one = |(sign, factor): &(f64, f64)| {
            greatest(&mut solver, &poses.start, &drive, (k, *sign, *factor))
        };
        let own: Option<Vec<_>> = parts.iter().map(one).collect();
        extremes.push(own.ok_or_else(|| {
            let message = format!("the mechanism does not go through `{over}` from the start");
            let help = "choose a range that it can go through: `bksim kinematics MODEL --limits`";
            located(DesignError::fault(codes::NOT_ASSEMBLED, message, help), &source.text, values)
        })?);
    }
    let job = Job { poses: &poses, steps: None, n_outputs: outputs.len(), ..job };
    let mut found = job.ranged(&over, &extremes, n_samples)?;
    for (band, (text, result)) in found.bands.iter_mut().zip(of.iter().zip(&results)) {
        band.of.clone_from(text);
        band.unit.clone_from(&result.unit);
    }
    Ok(found)
}
