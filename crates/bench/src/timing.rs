//! CPU time, repeated runs, and ratios of paired runs.
//!
//! A loaded machine makes some runs slower and none faster, so the minimum of several runs is the
//! cleanest number, and the median shows how noisy they were. Two programs are compared in rounds,
//! one after the other, and the ratio is taken within each round:
//!
//! ```text
//! ratio = median over the rounds of  min(ours) / min(theirs)
//! ```

use std::time::Duration;

use rustix::time::{ClockId, clock_gettime};

/// Amount of measuring.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    /// Rounds in which ours and theirs alternate; full 3, quick 1.
    pub(crate) rounds: usize,
    /// Runs of one thing in one round, at least; full 3, quick 1.
    pub(crate) min_runs: usize,
    /// Runs of one thing in one round, at most; full 50, quick 1.
    pub(crate) max_runs: usize,
    /// Seconds of CPU time after which no further run starts; full 0.5, quick 0.
    pub(crate) enough_s: f64,
    /// Seconds of CPU time that one run may be expected to take; larger sizes are left out. Full
    /// 60, quick 5.
    pub(crate) longest_s: f64,
    /// True if sizes are reduced to check that everything works.
    pub(crate) is_quick: bool,
}

impl Effort {
    /// For numbers worth reporting.
    pub(crate) const FULL: Self = Self {
        rounds: 3,
        min_runs: 3,
        max_runs: 50,
        enough_s: 0.5,
        longest_s: 60.0,
        is_quick: false,
    };
    /// To check that everything works.
    pub(crate) const QUICK: Self =
        Self { rounds: 1, min_runs: 1, max_runs: 1, enough_s: 0.0, longest_s: 5.0, is_quick: true };
}

/// CPU time of this process, s.
pub(crate) fn cpu_time() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    Duration::try_from(now).expect("CPU time is not negative").as_secs_f64()
}

/// Times of repeated runs, s.
#[derive(Clone, Debug, Default)]
pub(crate) struct Samples(Vec<f64>);

impl Samples {
    /// The fastest run; NaN if there was none.
    pub(crate) fn minimum(&self) -> f64 {
        self.0.iter().copied().fold(f64::NAN, f64::min)
    }

    /// Adds the runs of another round.
    pub(crate) fn extend(&mut self, other: &Self) {
        self.0.extend_from_slice(&other.0);
    }
}

/// The middle of some numbers; NaN if there are none.
pub(crate) fn median(numbers: &[f64]) -> f64 {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    match n {
        0 => f64::NAN,
        _ if n % 2 == 1 => sorted[n / 2],
        _ => f64::midpoint(sorted[n / 2 - 1], sorted[n / 2]),
    }
}

/// Times `work` on a fresh state from `prepare` for every run; `prepare` is not timed.
pub(crate) fn repeat<S, T>(
    effort: Effort,
    mut prepare: impl FnMut() -> S,
    mut work: impl FnMut(&mut S) -> T,
) -> Samples {
    let mut samples = Vec::new();
    let mut spent = 0.0;
    while samples.len() < effort.min_runs
        || (samples.len() < effort.max_runs && spent < effort.enough_s)
    {
        let mut state = prepare();
        let start = cpu_time();
        let result = std::hint::black_box(work(&mut state));
        let took = cpu_time() - start;
        drop(result);
        samples.push(took);
        spent += took;
    }
    Samples(samples)
}

/// Ours against theirs, over several rounds.
#[derive(Clone, Debug, Default)]
pub(crate) struct Paired {
    /// All our runs.
    pub(crate) ours: Samples,
    /// All their runs.
    pub(crate) theirs: Samples,
    ratios: Vec<f64>,
}

impl Paired {
    /// Adds one round.
    pub(crate) fn push(&mut self, ours: &Samples, theirs: &Samples) {
        self.ours.extend(ours);
        self.theirs.extend(theirs);
        self.ratios.push(ours.minimum() / theirs.minimum());
    }

    /// The median ratio of the rounds.
    pub(crate) fn ratio(&self) -> f64 {
        median(&self.ratios)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_are_in_the_middle() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), 2.5);
        assert!(median(&[]).is_nan());
    }

    #[test]
    fn ratios_are_taken_within_rounds() {
        let mut paired = Paired::default();
        // The machine slows down from round to round; the ratio stays.
        for load in [1.0, 2.0, 5.0] {
            let samples = |t: f64| Samples(vec![2.0 * t * load, t * load]);
            paired.push(&samples(1.0), &samples(4.0));
        }
        assert_eq!(paired.ratio(), 0.25);
        assert_eq!((paired.ours.minimum(), paired.theirs.minimum()), (1.0, 4.0));
    }

    #[test]
    fn runs_are_repeated_until_enough() {
        let effort = Effort { min_runs: 3, max_runs: 4, enough_s: f64::MAX, ..Effort::QUICK };
        let (mut prepared, mut worked) = (0, 0);
        let samples = repeat(effort, || prepared += 1, |()| worked += 1);
        assert_eq!((prepared, worked, samples.0.len()), (4, 4, 4));
        assert!(samples.minimum() >= 0.0);
    }
}
