//! [`Schedule`]: when samples are due.

use bksim_model::{Outputs, SolveOptions};

/// The output times of a run.
#[derive(Clone, Debug)]
pub(super) struct Schedule {
    t_start: f64,
    t_end: f64,
    every: f64,
    /// Times, if given, in the order of the run.
    outputs: Outputs,
    /// Number of output times handed out, the start included.
    pub(super) next_idx: usize,
}

impl Schedule {
    pub(super) fn new(t_start: f64, options: &SolveOptions, outputs: &Outputs) -> Self {
        Self {
            t_start,
            t_end: options.t_end,
            every: options.interval(),
            outputs: ordered(outputs, t_start, options.t_end),
            next_idx: 1,
        }
    }

    /// Makes `t` the next output time, in place of all others before the end.
    pub(super) fn ask(&mut self, t: f64) {
        match &mut self.outputs {
            Outputs::Times(times) => {
                times.clear();
                times.push(t);
            }
            outputs => *outputs = Outputs::Times(vec![t]),
        }
        self.next_idx = 1;
    }

    /// The next output time after that of the last sample, `t_last`, if it is not after `t` in the
    /// direction of the run.
    pub(super) fn due(&self, t: f64, t_last: f64) -> Option<f64> {
        let forward = self.forward();
        let due = match &self.outputs {
            Outputs::Even => {
                #[expect(clippy::cast_precision_loss, reason = "2^53 outputs are not reached")]
                let grid = self.t_start + forward * self.every * self.next_idx as f64;
                // The end is an output of its own; a time that rounds onto it counts as the end.
                let near_end = (self.t_end - grid) * forward < 1e-9 * self.every;
                if near_end { self.t_end } else { grid }
            }
            Outputs::Steps if t == t_last => return None,
            Outputs::Steps => t,
            // After the times that are given comes the end.
            Outputs::Times(times) => times.get(self.next_idx - 1).copied().unwrap_or(self.t_end),
        };
        let passed = t_last == self.t_end && self.next_idx > 1;
        (!passed && (t - due) * forward >= 0.0).then_some(due)
    }

    /// True where more than `n` output times may follow within one step.
    pub(super) fn has_more_than(&self, n: usize) -> bool {
        // All of them, with the end.
        #[expect(clippy::cast_precision_loss, reason = "2^53 outputs are not reached")]
        let n_all = match &self.outputs {
            Outputs::Even => (self.t_end - self.t_start).abs() / self.every + 1.0,
            Outputs::Steps => return false,
            Outputs::Times(times) => times.len() as f64 + 1.0,
        };
        #[expect(clippy::cast_precision_loss, reason = "2^53 outputs are not reached")]
        let n_done = (self.next_idx - 1) as f64;
        n_all - n_done > n as f64
    }

    /// True if `t` comes after `earlier` in the direction of the run.
    pub(super) fn is_after(&self, t: f64, earlier: f64) -> bool {
        (t - earlier) * self.forward() > 0.0
    }

    /// True where the run ends at `t`.
    pub(super) fn is_end(&self, t: f64) -> bool {
        t == self.t_end
    }

    fn forward(&self) -> f64 {
        (self.t_end - self.t_start).signum()
    }
}

/// Given times in the order of a run, without those that are not inside it.
fn ordered(outputs: &Outputs, t_start: f64, t_end: f64) -> Outputs {
    let Outputs::Times(times) = outputs else { return outputs.clone() };
    let forward = (t_end - t_start).signum();
    let is_inside = |t: &f64| (t - t_start) * forward > 0.0 && (t_end - t) * forward > 0.0;
    let mut times: Vec<f64> = times.iter().copied().filter(is_inside).collect();
    times.sort_by(|a, b| (forward * a).total_cmp(&(forward * b)));
    times.dedup();
    Outputs::Times(times)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A second of outputs, of which so many have been handed out with the start.
    fn schedule(outputs: Outputs, next_idx: usize) -> Schedule {
        Schedule { t_start: 0.0, t_end: 1.0, every: 0.1, outputs, next_idx }
    }

    #[test]
    fn output_times_that_may_follow_are_counted_with_the_end() {
        let even = schedule(Outputs::Even, 1);
        assert!(even.has_more_than(9) && !even.has_more_than(11));
        let half_done = schedule(Outputs::Even, 6);
        assert!(half_done.has_more_than(4) && !half_done.has_more_than(6));
        let times = schedule(Outputs::Times(vec![0.2, 0.3, 0.7]), 1);
        assert!(times.has_more_than(3) && !times.has_more_than(4));
        // However many steps follow, each has one.
        assert!(!schedule(Outputs::Steps, 1).has_more_than(1));
    }
}
