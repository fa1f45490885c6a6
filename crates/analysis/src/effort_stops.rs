//! [`StopWatch`]: the stops that a given motion keeps to, and the instant at which it goes through one.

use bksim_mbs::contact::{Penetration, penetrations};
use bksim_model::{Measure, MotionKind};

use crate::effort_contacts::CLOSED;
use crate::effort_faults::through_stop;
use crate::error::AnalysisError;
use crate::positions::Positions;
use crate::rows::{Clock, Rows};
use crate::scalar::Rates;
use crate::walk::Walk;

/// Parts that the whole time is looked at in: what passes a stop and comes back in less is between them.
pub(crate) const N_PARTS: usize = 200;
/// Halvings of an interval of time.
const HALVINGS: usize = 60;

/// Positions, velocities and accelerations.
pub(crate) type MotionState = [Vec<f64>; 3];

/// All limits of stops along a motion.
pub(crate) struct StopWatch {
    limits: Vec<Penetration>,
    rates: Rates,
    units: Vec<f64>,
    /// Limits that bear throughout: without them motions would be free.
    pub(crate) bearing: Vec<usize>,
}

impl StopWatch {
    /// The stops of a mechanism, none of which bears throughout.
    pub(crate) fn of(positions: &Positions) -> Result<Self, AnalysisError> {
        let (model, system) = (positions.model(), positions.system());
        let limits = penetrations(model, &system.kinematics);
        let functions: Vec<_> = limits.iter().map(|limit| limit.expression).collect();
        let parameters = &positions.mechanism.parameters;
        let unit = |limit: &Penetration| match limit.motion {
            MotionKind::Rotation => 1.0,
            MotionKind::Translation => positions.size,
        };
        Ok(Self {
            rates: Rates::compile(model, system, &functions, parameters)?,
            units: limits.iter().map(unit).collect(),
            limits,
            bearing: Vec::new(),
        })
    }

    /// Lets stops that are closed at the start bear where motions are free without them, and gives the rows of all.
    pub(crate) fn hold(
        &mut self,
        positions: &Positions,
        (measures, added): (&[Measure], &[usize]),
        n_left: &dyn Fn(&mut Rows) -> usize,
    ) -> Result<Rows, AnalysisError> {
        let rows_of = |bearing: &[Penetration]| {
            positions.rows_with_stops((measures, bearing), added, Clock::Running)
        };
        let mut rows = rows_of(&[])?;
        let mut left = n_left(&mut rows);
        if left == 0 || self.limits.is_empty() {
            return Ok(rows);
        }
        let rest = vec![0.0; positions.q.len()];
        let depths = self.rates.at(positions.t(), [&positions.q, &rest, &rest]);
        for (k, [depth, ..]) in depths.into_iter().enumerate() {
            if depth.abs() > CLOSED * self.units[k] || left == 0 {
                continue;
            }
            let with = [self.bearing.clone(), vec![k]].concat();
            let own: Vec<Penetration> = with.iter().map(|&k| self.limits[k].clone()).collect();
            let mut more = rows_of(&own)?;
            let n = n_left(&mut more);
            if n < left {
                (left, rows, self.bearing) = (n, more, with);
            }
        }
        Ok(rows)
    }

    /// Names of stops, open at the start, without which one of the `n` motions that are left would not be free.
    pub(crate) fn open_ones(
        &self,
        positions: &Positions,
        (measures, added): (&[Measure], &[usize]),
        (n_left, n): (&dyn Fn(&mut Rows) -> usize, usize),
    ) -> Result<Vec<String>, AnalysisError> {
        let mut names: Vec<String> = Vec::new();
        for (k, limit) in self.limits.iter().enumerate() {
            let name = &positions.model().loads[limit.load.0].name;
            if self.bearing.contains(&k) || names.contains(name) {
                continue;
            }
            let own: Vec<Penetration> =
                self.bearing().chain(std::iter::once(limit)).cloned().collect();
            let rows = positions.rows_with_stops((measures, &own), added, Clock::Running);
            if n_left(&mut rows?) < n {
                names.push(name.clone());
            }
        }
        Ok(names)
    }

    /// The limits that bear throughout.
    pub(crate) fn bearing(&self) -> impl Iterator<Item = &Penetration> {
        self.bearing.iter().map(|&k| &self.limits[k])
    }

    /// States at all `times`.
    ///
    /// # Errors
    /// [`AnalysisError`] where the motion cannot be followed, or goes through a stop.
    pub(crate) fn follow(
        &mut self,
        positions: &Positions,
        (walk, rows): (&mut Walk<'_>, &mut Rows),
        times: &[f64],
    ) -> Result<Vec<MotionState>, AnalysisError> {
        let is_watched = self.bearing.len() < self.limits.len();
        let n_parts = if is_watched { N_PARTS.div_ceil(times.len().max(1)) } else { 1 };
        let mut found: Vec<MotionState> = Vec::with_capacity(times.len());
        let mut last: Option<(f64, MotionState)> = None;
        for &t in times {
            let from = last.as_ref().map_or(t, |(t, _)| *t);
            for part in 1..=n_parts {
                #[expect(clippy::cast_precision_loss, reason = "a few parts")]
                let share = part as f64 / n_parts as f64;
                let at = if part == n_parts { t } else { from + share * (t - from) };
                let state = walk.to(rows, at).ok_or(AnalysisError::Lost { t: at })?;
                if is_watched
                    && let Some((k, t)) =
                        self.passed((&mut *walk, &mut *rows), last.as_ref(), (at, &state))
                {
                    return Err(through_stop(positions.model(), &self.limits[k], t, times));
                }
                last = Some((at, state));
            }
            if let Some((_, state)) = &last {
                found.push(state.clone());
            }
        }
        Ok(found)
    }

    /// The limit that is passed between two instants, and when.
    fn passed(
        &mut self,
        (walk, rows): (&mut Walk<'_>, &mut Rows),
        before: Option<&(f64, MotionState)>,
        (t, state): (f64, &MotionState),
    ) -> Option<(usize, f64)> {
        let here = self.depths(t, state);
        let mut first: Option<(usize, f64)> = None;
        let Some((t0, state0)) = before else {
            return (0..here.len()).find(|&k| self.is_beyond(k, here[k][0])).map(|k| (k, t));
        };
        let there = self.depths(*t0, state0);
        let h = t - t0;
        for k in (0..here.len()).filter(|k| !self.bearing.contains(k)).collect::<Vec<_>>() {
            let ([a, rate_a, _], [b, rate_b, _]) = (there[k], here[k]);
            // In time that may run backwards.
            let (rate_a, rate_b) = (rate_a * h, rate_b * h);
            let end = if self.is_beyond(k, b) {
                Some(t)
            } else if rate_a > 0.0 && rate_b < 0.0 && a.max(b) + rate_a.max(-rate_b) > 0.0 {
                // The deepest place in between.
                let rising = |[_, rate, _]: [f64; 3]| rate * h > 0.0;
                let top = self.halved((&mut *walk, &mut *rows), (*t0, t), k, &rising)?;
                let state = walk.to(rows, top)?;
                let depth = self.depths(top, &state)[k][0];
                self.is_beyond(k, depth).then_some(top)
            } else {
                None
            };
            let Some(end) = end else { continue };
            let is_before = |[depth, ..]: [f64; 3]| depth <= 0.0;
            let at = self.halved((&mut *walk, &mut *rows), (*t0, end), k, &is_before)?;
            if first.is_none_or(|(_, known)| (at - t0).abs() < (known - t0).abs()) {
                first = Some((k, at));
            }
        }
        // Back to where the motion is followed from.
        walk.to(rows, t)?;
        first
    }

    /// The last instant in an interval of which a condition holds that does at its start.
    fn halved(
        &mut self,
        (walk, rows): (&mut Walk<'_>, &mut Rows),
        (mut from, mut to): (f64, f64),
        k: usize,
        holds: &dyn Fn([f64; 3]) -> bool,
    ) -> Option<f64> {
        for _ in 0..HALVINGS {
            let middle = 0.5 * (from + to);
            if middle == from || middle == to {
                break;
            }
            let state = walk.to(rows, middle)?;
            let here = self.depths(middle, &state)[k];
            if holds(here) { from = middle } else { to = middle }
        }
        Some(from)
    }

    fn depths(&mut self, t: f64, [q, v, a]: &MotionState) -> Vec<[f64; 3]> {
        self.rates.at(t, [q, v, a])
    }

    fn is_beyond(&self, k: usize, depth: f64) -> bool {
        depth > CLOSED * self.units[k] && !self.bearing.contains(&k)
    }
}
