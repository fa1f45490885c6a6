//! Laps: a point of a train of wheels may come round many times on one way before the whole motion comes back.
//!
//! ```text
//! (p(s) − p₀) · p₀′ = 0,  p(s) = p₀,  p′(s) ∥ p₀′        a pass of a place in its direction
//! ```
//!
//! The way is analytic: where all places of the first lap are passed again in a later one, it is one curve.

use crate::coupler_curve::{CouplerCurve, Sample, Tracer, dot, length};
use crate::curve::Curve;
use crate::path::Path;

/// Places of the first lap that a later one has to pass.
const N_PLACES: usize = 16;
/// Distance from a place at which it is passed, in lengths of the longest link.
const MEETS: f64 = 1e-8;

impl Tracer {
    /// A way up to where it repeats itself, and as it is where it does not.
    pub(crate) fn once(
        &mut self,
        curve: &mut Curve<Path<'_>>,
        mut way: CouplerCurve,
    ) -> CouplerCurve {
        let last = way.samples.len().saturating_sub(1);
        // The end of a motion that comes back is no pass of its own.
        let inner = if way.is_closed { last } else { way.samples.len() };
        let Some(home) = way.samples.first().cloned() else { return way };
        let passes = self.passes(curve, &way.samples[..inner], &home);
        let Some((lap, end)) = passes.first().cloned() else { return way };
        for place in way.samples[1..=lap].iter().step_by(1 + lap / N_PLACES) {
            if self.moves(place) && self.passes(curve, &way.samples[lap..], place).is_empty() {
                return way;
            }
        }
        way.n_laps = way.is_closed.then_some(passes.len() + 1);
        way.samples.truncate(lap + 1);
        way.samples.push(end);
        way.is_closed = true;
        way
    }

    /// Where a place is passed in its direction after the first of some samples: the sample before, and that there.
    fn passes(
        &mut self,
        curve: &mut Curve<Path<'_>>,
        samples: &[Sample],
        place: &Sample,
    ) -> Vec<(usize, Sample)> {
        let mut found = Vec::new();
        if !self.moves(place) {
            return found;
        }
        for k in 1..samples.len().saturating_sub(1) {
            let [a, b] = [&samples[k], &samples[k + 1]];
            let chord = length(&less(&b.p, &a.p));
            if length(&less(&a.p, &place.p)) > 4.0 * chord {
                continue;
            }
            let [before, after] = [a, b].map(|at| dot(&less(&at.p, &place.p), &place.slope));
            if before < 0.0 && after >= 0.0 {
                let share = before / (before - after);
                let there = self.passing(curve, a, share * a.reach(b), place);
                found.extend(there.map(|there| (k, there)));
            }
        }
        found
    }

    /// The sample near the arc length `s` from another one in which a place is passed.
    fn passing(
        &mut self,
        curve: &mut Curve<Path<'_>>,
        from: &Sample,
        mut s: f64,
        place: &Sample,
    ) -> Option<Sample> {
        const MOST: usize = 8;
        for _ in 0..MOST {
            let at = self.beyond(curve, from, s)?;
            let off = less(&at.p, &place.p);
            // The slope by s, along the direction of the sample.
            let share = at.pose.tangent.dot(&from.pose.tangent);
            let step = -dot(&off, &place.slope) / dot(&at.slope, &place.slope) * share;
            let is_parallel = dot(&at.slope, &place.slope)
                >= (1.0 - MEETS) * length(&at.slope) * length(&place.slope);
            if step.abs() < 1e-12 {
                return (length(&off) < MEETS * self.size && is_parallel).then_some(at);
            }
            s += step;
        }
        None
    }
}

fn less(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}
