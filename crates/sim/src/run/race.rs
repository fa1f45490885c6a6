//! [`Race`]: whether Radau IIA would take the motion further for the same work.
//!
//! Stiffness shows in explicit steps as `h ρ` near the end of the range in which they are stable. Hairer's
//! count of such steps (HW2 §IV.2) need not complete there, as the control of steps swings to and fro across
//! that end, and does not begin where the fast motion is an oscillation. So where `h ρ` is large in the mean,
//! Radau IIA takes some steps, and stays if these lead further for the same work. Each trial that is lost
//! doubles the wait for the next, so that all of them together cost little.
//!
//! Radau's steps are looked at from time to time: where `h ρ` of them is so small that explicit ones of
//! nearly the same size are stable, these are cheaper.

use bksim_dae::{Loader, Saver, SolveError};

/// Steps over which means are taken.
const SMOOTH: f64 = 50.0;

/// Where `h ρ` is smaller in the mean, accuracy limits explicit steps, which are stable up to six. Means of
/// fifty steps of most mechanisms that are not stiff are below 0.5; a few reach 2, and lose
/// some trials.
pub(super) const LARGE: f64 = 0.75;

/// Where errors do nothing but decay, smaller `h ρ` is large: steps at tight tolerances are limited by the error that a
/// fast decay makes afresh in each of them, far within the range where they are stable. Steps of the governor in
/// its bodies' coordinates have 0.38 at 10⁻¹⁰, where Radau IIA takes seventy times fewer.
pub(super) const DECAYING: f64 = 0.25;

/// Relative tolerance from which on that is looked for; at looser ones steps are few.
pub(super) const TIGHT: f64 = 1e-8;

/// The cosine between an error and its decay from which on it does nothing else.
pub(super) const PURE: f64 = 0.9;

/// Explicit steps before the first trial.
const FIRST_WAIT: usize = 300;

/// A trial of Radau's ends after so many attempts at a step.
pub(super) const TRIAL: usize = 30;

/// Explicit steps that cost as much as one of Radau's.
pub(super) const COST: f64 = 5.0;

/// Attempts at a step of Radau's after which its steps are looked at first.
const FIRST_LOOK: usize = 200;

/// Where `h ρ` of Radau's steps is smaller, explicit ones of nearly the same size are stable.
pub(super) const STABLE: f64 = 5.0;

/// The pace of steps, and when Radau IIA is tried next.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Race {
    /// Where the last step ended, and the attempts until then.
    t: f64,
    n_step: usize,
    /// Mean way of an attempt, s.
    way: f64,
    /// Mean `h ρ` of a step.
    h_rho: f64,
    /// Attempts since steps of this method began, or were looked at.
    n: usize,
    /// Attempts after which a trial may be.
    wait: usize,
    /// Attempts after which Radau's steps are looked at.
    look: usize,
}

impl Race {
    /// Before the first step.
    pub(super) fn begin(t: f64, n_step: usize) -> Self {
        Self { t, n_step, way: 0.0, h_rho: 0.0, n: 0, wait: FIRST_WAIT, look: FIRST_LOOK }
    }

    /// Starts in another phase.
    pub(super) fn restart(&mut self, t: f64, n_step: usize) {
        *self = Self { wait: self.wait, look: self.look, ..Self::begin(t, n_step) };
    }

    /// Takes note of an explicit step that ends at `t`, with `h ρ` near its end. Returns the mean way of an
    /// attempt where Radau IIA should be tried.
    pub(super) fn observe(
        &mut self,
        (t, t_end): (f64, f64),
        n_step: usize,
        h_rho: f64,
    ) -> Option<f64> {
        self.note_way(t, n_step);
        self.h_rho += (h_rho - self.h_rho) / SMOOTH;

        // Not at once, not for nothing, and not for the last few steps.
        #[expect(clippy::cast_precision_loss, reason = "far below 2⁵²")]
        let is_long = (t_end - t).abs() > self.way * self.wait as f64;
        let is_due = self.n >= self.wait && self.h_rho > LARGE && is_long;
        is_due.then(|| {
            self.wait *= 2;
            self.way
        })
    }

    /// Takes note of a step of Radau's that ends at `t`. Returns the mean way of such steps where they should
    /// be looked at.
    pub(super) fn observe_implicit(&mut self, t: f64, n_step: usize) -> Option<f64> {
        self.note_way(t, n_step);
        (self.n >= self.look).then(|| {
            self.n = 0;
            self.way
        })
    }

    /// Explicit steps go on; should they turn out slower again, the next look is later.
    pub(super) fn go_back(&mut self) {
        self.look *= 2;
    }

    fn note_way(&mut self, t: f64, n_step: usize) {
        let n = n_step.saturating_sub(self.n_step).max(1);
        #[expect(clippy::cast_precision_loss, reason = "the work of a few attempts")]
        let way = (t - self.t).abs() / n as f64;
        self.way += (way - self.way) / SMOOTH;
        (self.t, self.n_step, self.n) = (t, n_step, self.n + n);
    }

    pub(super) fn save(&self, saver: &mut Saver) {
        let Self { t, n_step, way, h_rho, n, wait, look } = *self;
        saver.real(t);
        saver.real(way);
        saver.real(h_rho);
        saver.count(n_step);
        saver.count(n);
        saver.count(wait);
        saver.count(look);
    }

    pub(super) fn load(loader: &mut Loader<'_>) -> Result<Self, SolveError> {
        let (t, way, h_rho) = (loader.real()?, loader.real()?, loader.real()?);
        let mut count = || loader.index(usize::MAX);
        Ok(Self { t, n_step: count()?, way, h_rho, n: count()?, wait: count()?, look: count()? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `h ρ` of steps at the end of the stable range.
    const LIMITED: f64 = 5.0;

    /// Attempts before a trial, of steps with this `h ρ`, in a run of ten thousand.
    fn attempts(race: &mut Race, h_rho: f64) -> Option<usize> {
        let t = |n: usize| 1e-4 * n as f64;
        race.restart(0.0, 0);
        (1..10_000).find(|&n| race.observe((t(n), 1.0), n, h_rho).is_some())
    }

    #[test]
    fn steps_limited_by_stability_lead_to_a_trial_and_others_never() {
        let mut race = Race::begin(0.0, 0);
        assert_eq!(attempts(&mut race, 0.5), None);
        assert_eq!(attempts(&mut race, 5.0), Some(FIRST_WAIT));
    }

    #[test]
    fn trials_that_are_lost_grow_rare() {
        let mut race = Race::begin(0.0, 0);
        let waits: Vec<_> = (0..4).map(|_| attempts(&mut race, 5.0)).collect();
        assert_eq!(waits, [300, 600, 1200, 2400].map(Some));
    }

    #[test]
    fn the_last_few_steps_are_no_race() {
        let mut race = Race::begin(0.0, 0);
        let ends = (1..1000).map(|n| 1e-3 * f64::from(n));
        let trials =
            ends.enumerate().filter(|&(n, t)| race.observe((t, 1.0), n + 1, LIMITED).is_some());
        assert_eq!(trials.count(), 1);
        let mut race = Race::begin(0.0, 0);
        let mut ends = (1..500).map(|n| 2e-3 * f64::from(n)).enumerate();
        assert!(ends.all(|(n, t)| race.observe((t, 1.0), n + 1, LIMITED).is_none()));
    }
}
