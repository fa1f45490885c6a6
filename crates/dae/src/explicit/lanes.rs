//! States in lanes: `f` at several of them at once, or one after the other where the system knows no better.

#![expect(clippy::inline_always, reason = "kernels are compiled with the registers of `run`")]

use pulp::{Simd, WithSimd};

use super::derivative;
use crate::lanes::run;
use crate::stats::Stats;
use crate::system::{LANES, Lanes, NotFinite, Ode};

/// As many states as there are lanes, and `f` there, unknown by unknown.
pub(super) struct LaneWork {
    pub(super) y: Vec<Lanes>,
    pub(super) f: Vec<Lanes>,
    /// One state and `f` there.
    one: [Vec<f64>; 2],
    /// The lane in which `f` had no value.
    failed: usize,
}

impl LaneWork {
    pub(super) fn new(n: usize) -> Self {
        let zero = || vec![[0.0; LANES]; n];
        Self { y: zero(), f: zero(), one: [vec![0.0; n], vec![0.0; n]], failed: 0 }
    }

    /// Evaluates `f` at all states.
    ///
    /// # Errors
    /// [`NotFinite`] of the first lane without a value.
    pub(super) fn evaluate<S: Ode>(
        &mut self,
        system: &mut S,
        times: Lanes,
        stats: &mut Stats,
    ) -> Result<(), NotFinite> {
        if system.derivative_lanes(times, &self.y, &mut self.f) {
            stats.n_residual += LANES;
            if run(AreFinite(&self.f)) {
                return Ok(());
            }
        }
        let Self { y, f, one: [state, slope], failed } = self;
        for (lane, t) in times.into_iter().enumerate() {
            state.iter_mut().zip(&*y).for_each(|(own, y)| *own = y[lane]);
            *failed = lane;
            derivative(system, t, state, slope, stats)?;
            f.iter_mut().zip(&*slope).for_each(|(f, slope)| f[lane] = *slope);
        }
        Ok(())
    }

    /// `before + 2 h f` in the place of `y`, and `y` in that of `before`.
    pub(super) fn midpoint(&mut self, h: &Lanes, before: &mut Vec<Lanes>) {
        let h = h.map(|h| 2.0 * h);
        run(Midpoint { h, before, f: &self.f });
        std::mem::swap(before, &mut self.y);
    }

    /// State and derivative of a lane.
    pub(super) fn lane_into(&self, lane: usize, y: &mut [f64], f: &mut [f64]) {
        y.iter_mut().zip(&self.y).for_each(|(y, own)| *y = own[lane]);
        f.iter_mut().zip(&self.f).for_each(|(f, own)| *f = own[lane]);
    }

    /// The state at which `f` had no value.
    pub(super) fn argument_into(&self, argument: &mut [f64]) {
        argument.iter_mut().zip(&self.y).for_each(|(y, own)| *y = own[self.failed]);
    }
}

struct AreFinite<'a>(&'a [Lanes]);

impl WithSimd for AreFinite<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        // What is finite leaves nothing; all else leaves NaN.
        let mut left = [0.0; LANES];
        for x in self.0 {
            for lane in 0..LANES {
                left[lane] += 0.0 * x[lane];
            }
        }
        left == [0.0; LANES]
    }
}

struct Midpoint<'a> {
    h: Lanes,
    before: &'a mut [Lanes],
    f: &'a [Lanes],
}

impl WithSimd for Midpoint<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { h, before, f } = self;
        for (before, f) in before.iter_mut().zip(f) {
            for lane in 0..LANES {
                before[lane] += h[lane] * f[lane];
            }
        }
    }
}
