//! [`Pace`]: how many steps the rest of a run would take, and [`Slowness`]: that these are too many.
//!
//! ```text
//! steps left = WINDOW · (t_end − t) / (t − t_window)
//! ```
//!
//! over windows of so many attempts at a step. A run that seems to need more than a million is said
//! to be slow at once, not when it ends; where explicit steps are the slow ones and the method may be
//! chosen, Radau IIA is tried first, and stays where its steps are far longer. However many steps a run
//! has taken, it goes on as long as it comes forward: only one with next to everything still before it
//! is stopped.

use super::race::{COST, Race, TRIAL as TRIAL_OF_RACE};
use bksim_dae::{Loader, Saver, SolveError, Standstill};

/// Attempts at a step after which the pace is looked at.
const WINDOW: usize = 5_000;

/// Steps that a run is expected to need at most.
const MANY: f64 = 1e6;

/// A run that would need so many is stopped at once.
const HOPELESS: f64 = 1e12;

/// A run that has made so many attempts at a step and has so many times as many before it is stopped, too.
const FAR: [(usize, f64); 2] = [(300_000, 30_000.0), (3_000_000, 1000.0)];

/// Steps of constant size, which can be counted ahead, are not begun where there are more.
const MOST_FIXED: f64 = 3e7;

/// A mechanism of which nothing moves so far in a step, m or rad, hardly moves.
pub(super) const TINY: f64 = 1e-3;

/// Attempts at a step after which Radau IIA must have gained on explicit steps,
const TRIAL: usize = 500;

/// by this factor: its steps cost more.
const GAIN: f64 = 5.0;

/// Where the present window began.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Pace {
    t: f64,
    n_step: usize,
    trial: Option<Trial>,
    /// True if Radau IIA has been on trial because the run was slow.
    is_tried: bool,
    race: Race,
    /// Whether Radau IIA is on trial, or has just lost, in a race: windows go on over those.
    is_racing: bool,
}

/// Radau IIA on trial.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Trial {
    /// The least way of a step, s, for which it stays.
    way: f64,
    /// Attempts at a step in which it must have come so far.
    n: usize,
    /// Where it began, s, and the attempts until then.
    begin: (f64, usize),
}

/// A run that takes far more steps than expected.
#[derive(Clone, PartialEq, Debug)]
pub struct Slowness {
    /// When it was noticed, s.
    pub t: f64,
    /// The size of its steps there, s.
    pub step_size: f64,
    /// Attempts at a step until then.
    pub n_step: usize,
    /// Steps that the rest of the run would take at this pace.
    pub steps_left: f64,
    /// Coordinates whose errors keep the steps small, the worst first.
    pub worst: Vec<usize>,
    /// True if the run was stopped at once.
    pub is_hopeless: bool,
    /// Coordinates there, nq.
    pub q: Vec<f64>,
    /// Velocities there, nq.
    pub v: Vec<f64>,
}

/// The meaning of a pace for the run.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Verdict {
    /// It ends in reasonable time, or nothing is known yet.
    Fine,
    /// The rest would take so many steps.
    Slow(f64),
    /// Cost so high that there is no point in going on.
    Hopeless(f64),
}

impl Pace {
    /// A window that begins at `t`, after `n_step` attempts.
    pub(super) fn begin(t: f64, n_step: usize) -> Self {
        Self {
            t,
            n_step,
            trial: None,
            is_tried: false,
            race: Race::begin(t, n_step),
            is_racing: false,
        }
    }

    /// Starts in another phase.
    pub(super) fn restart(&mut self, t: f64, n_step: usize) {
        if !self.is_racing {
            self.begin_window(t, n_step);
        }
        self.is_racing &= self.trial.is_some();
        self.race.restart(t, n_step);
    }

    fn begin_window(&mut self, t: f64, n_step: usize) {
        *self = Self { t, n_step, ..*self };
    }

    /// True if Radau IIA has not yet been on trial because the run was slow.
    pub(super) fn may_try(&self) -> bool {
        !self.is_tried
    }

    /// Whether Radau IIA is, or has been, only tried.
    pub(super) fn is_on_trial(&self) -> bool {
        self.is_tried || self.trial.is_some()
    }

    /// Radau IIA is on trial from here on, where explicit steps would be so many up to the end.
    pub(super) fn try_radau(&mut self, (t, t_end): (f64, f64), n_step: usize, steps_left: f64) {
        let way = GAIN * (t_end - t).abs() / steps_left;
        self.trial = Some(Trial { way, n: TRIAL, begin: (t, n_step) });
        self.is_tried = true;
    }

    /// True where Radau IIA should be tried against explicit steps that seem to be limited by stability, of which the
    /// last one ends at `t`; the trial has begun then.
    pub(super) fn begins_race(
        &mut self,
        (t, t_end): (f64, f64),
        n_step: usize,
        h_rho: f64,
    ) -> bool {
        let rival = self.race.observe((t, t_end), n_step, h_rho);
        if let Some(way) = rival {
            let (way, begin) = (COST * way, (t, n_step));
            self.trial = Some(Trial { way, n: TRIAL_OF_RACE, begin });
            self.is_racing = true;
        }
        rival.is_some()
    }

    /// The mean way of Radau's steps, of which one ends at `t`, where they should be looked at.
    pub(super) fn looks_at_radau(&mut self, t: f64, n_step: usize) -> Option<f64> {
        self.race.observe_implicit(t, n_step).filter(|_| self.trial.is_none())
    }

    /// Explicit steps go on in Radau's place.
    pub(super) fn go_back(&mut self) {
        self.race.go_back();
    }

    /// The trial is over.
    pub(super) fn end_trial(&mut self) {
        self.trial = None;
    }

    /// True if the trial is over without a gain.
    pub(super) fn has_lost(&mut self, t: f64, n_step: usize) -> bool {
        let attempts = |trial: &Trial| n_step - trial.begin.1.min(n_step);
        let is_over = |trial: &Trial| attempts(trial) >= trial.n;
        let Some(trial) = self.trial.filter(is_over) else { return false };
        self.trial = None;
        #[expect(clippy::cast_precision_loss, reason = "a few hundred")]
        let way = (t - trial.begin.0).abs() / attempts(&trial) as f64;
        let has_lost = way < trial.way;
        self.is_racing &= has_lost;
        has_lost
    }

    /// Takes note of the attempts so far; judges at the end of each window. Steps of constant size are
    /// as small as they were asked to be, which is not slow.
    pub(super) fn observe(
        &mut self,
        t: f64,
        n_step: usize,
        (t_end, is_fixed): (f64, bool),
    ) -> Verdict {
        let n = n_step - self.n_step.min(n_step);
        if n < WINDOW {
            return Verdict::Fine;
        }
        let way = (t - self.t).abs();
        self.begin_window(t, n_step);
        #[expect(clippy::cast_precision_loss, reason = "far below 2⁵²")]
        let [n, so_far] = [n as f64, n_step as f64];
        let left = n * (t_end - t).abs() / way;
        let is_hopeless = if is_fixed {
            left > MOST_FIXED
        } else {
            left > HOPELESS
                || FAR.iter().any(|&(made, times)| n_step >= made && left > times * so_far)
        };
        if is_hopeless {
            Verdict::Hopeless(left)
        } else if left > MANY && !is_fixed {
            Verdict::Slow(left)
        } else {
            Verdict::Fine
        }
    }

    pub(super) fn save(&self, saver: &mut Saver) {
        saver.real(self.t);
        saver.count(self.n_step);
        saver.flag(self.is_tried);
        saver.flag(self.is_racing);
        self.race.save(saver);
        saver.flag(self.trial.is_some());
        if let Some(Trial { way, n, begin }) = self.trial {
            saver.slice(&[way, begin.0]);
            saver.count(n);
            saver.count(begin.1);
        }
    }

    pub(super) fn load(loader: &mut Loader<'_>) -> Result<Self, SolveError> {
        let (t, n_step) = (loader.real()?, loader.index(usize::MAX)?);
        let (is_tried, is_racing) = (loader.flag()?, loader.flag()?);
        let race = Race::load(loader)?;
        let trial = loader.flag()?.then(|| Trial::load(loader)).transpose()?;
        Ok(Self { t, n_step, trial, is_tried, race, is_racing })
    }
}

impl Trial {
    fn load(loader: &mut Loader<'_>) -> Result<Self, SolveError> {
        let mut numbers = [0.0; 2];
        loader.fill(&mut numbers)?;
        let [way, t] = numbers;
        let (n, n_step) = (loader.index(usize::MAX)?, loader.index(usize::MAX)?);
        Ok(Self { way, n, begin: (t, n_step) })
    }
}

impl Slowness {
    /// At the end of a step; `n_step` attempts have been made in all.
    pub(super) fn new(
        at: &Standstill,
        nq: usize,
        n_step: usize,
        (steps_left, is_hopeless): (f64, bool),
    ) -> Self {
        let mut worst: Vec<usize> = Vec::new();
        for unknown in at.worst.iter().filter(|unknown| unknown.i < 2 * nq) {
            if !worst.contains(&(unknown.i % nq)) {
                worst.push(unknown.i % nq);
            }
        }
        let (q, v) = at.y[..2 * nq].split_at(nq);
        let (q, v) = (q.to_vec(), v.to_vec());
        let step_size = at.h.abs();
        Self { t: at.t, step_size, n_step, steps_left, worst, is_hopeless, q, v }
    }

    pub(super) fn save(&self, saver: &mut Saver) {
        saver.slice(&[self.t, self.step_size, self.steps_left]);
        saver.count(self.n_step);
        saver.indices(&self.worst);
        saver.flag(self.is_hopeless);
        saver.slice(&self.q);
        saver.slice(&self.v);
    }

    pub(super) fn load(loader: &mut Loader<'_>, nq: usize) -> Result<Self, SolveError> {
        let mut numbers = [0.0; 3];
        loader.fill(&mut numbers)?;
        let [t, step_size, steps_left] = numbers;
        let n_step = loader.index(usize::MAX)?;
        let worst = loader.indices(nq)?;
        let is_hopeless = loader.flag()?;
        let (mut q, mut v) = (vec![0.0; nq], vec![0.0; nq]);
        loader.fill(&mut q)?;
        loader.fill(&mut v)?;
        Ok(Self { t, step_size, n_step, steps_left, worst, is_hopeless, q, v })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ADAPTIVE: bool = false;

    #[test]
    fn only_a_whole_window_is_judged_and_by_its_own_pace() {
        let mut pace = Pace::begin(0.0, 0);
        let end = (1.0, ADAPTIVE);
        assert_eq!(pace.observe(1e-9, WINDOW - 1, end), Verdict::Fine);
        let Verdict::Slow(left) = pace.observe(1e-3, WINDOW, end) else { panic!("not slow") };
        assert!((left - 0.4995e7).abs() < 1e3, "{left}");
        // The next window is quick, however slow the first was.
        assert_eq!(pace.observe(0.5, 2 * WINDOW, end), Verdict::Fine);
        assert!(matches!(pace.observe(0.5 + 1e-10, 3 * WINDOW, end), Verdict::Hopeless(_)));
    }

    #[test]
    fn a_run_back_in_time_has_a_pace_too() {
        let mut pace = Pace::begin(1.0, 0);
        assert!(matches!(pace.observe(0.999, WINDOW, (-1.0, ADAPTIVE)), Verdict::Slow(_)));
    }

    #[test]
    fn a_long_run_goes_on_as_long_as_it_comes_forward() {
        let n_step = 300_000_000;
        let later = |way: f64, n_step: usize| {
            let mut pace = Pace::begin(0.0, n_step - WINDOW);
            pace.observe(way, n_step, (1e6, ADAPTIVE))
        };
        // A hundredth of the run after three hundred million steps, and all but the end of it.
        assert!(matches!(
            later(1e6 * WINDOW as f64 / (100 * n_step) as f64, n_step),
            Verdict::Slow(_)
        ));
        assert_eq!(later(1e4, n_step), Verdict::Fine);
        // After so many, far more are left.
        for (made, times) in FAR {
            let hardly = 1e6 * WINDOW as f64 / (1.1 * times * made as f64);
            assert!(matches!(later(hardly, made), Verdict::Hopeless(_)));
            assert!(matches!(later(hardly, FAR[0].0 - 1), Verdict::Slow(_)));
        }
    }

    #[test]
    fn constant_steps_are_stopped_at_once_or_never() {
        let after = |way: f64| Pace::begin(0.0, 0).observe(way, WINDOW, (1.0, true));
        assert_eq!(after(WINDOW as f64 / 2e7), Verdict::Fine);
        assert!(matches!(after(WINDOW as f64 / 4e7), Verdict::Hopeless(_)));
    }
}
