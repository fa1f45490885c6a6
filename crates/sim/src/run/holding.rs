//! [`Holding`]: whether the stages of explicit steps are taken onto the constraints.
//!
//! Away from the constraints, accelerations have no limit in a singular pose, and steps that come near one may be
//! rejected for it over and over. They are tried again with their stages on the constraints
//! ([`MultiplierSystem::nearby_into`](crate::multiplier::MultiplierSystem::nearby_into)), which costs more, and
//! adds rounding of its own: where the error of a step does not fall for it, all is left as it is until the pose
//! is passed.

use bksim_dae::{Attempt, Loader, Saver, SolveError};

/// Rank margin of an attempt that is near a pose: mechanisms that pass none hardly come so near to one, and nearer, steps
/// have become too short to pass over where rounding is large.
const NEAR: f64 = 0.02;

/// The error of a step that is smaller and held has fallen by a higher power of its size than this, or it would have
/// fallen all the same: by the eighth.
const OF_HELP: f64 = 11.0;

/// State between two attempts at a step.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Holding {
    /// True while stages are held on the constraints.
    pub(super) is_on: bool,
    /// True where that has turned out to be no help near this pose.
    is_useless: bool,
    /// The least rank margin of the attempt.
    least_margin: f64,
}

impl Default for Holding {
    fn default() -> Self {
        Self { is_on: false, is_useless: false, least_margin: 1.0 }
    }
}

impl Holding {
    /// Takes note of the rank margin of a stage.
    pub(super) fn observe(&mut self, margin: f64) {
        self.least_margin = self.least_margin.min(margin);
    }

    /// Takes note of an attempt.
    pub(super) fn note(&mut self, attempt: Attempt) {
        let is_near = self.least_margin < NEAR;
        let (power, is_rejected) = match attempt {
            Attempt::Begun => {
                self.least_margin = 1.0;
                return;
            }
            Attempt::Accepted { power } => (power, false),
            Attempt::Rejected { power } => (power, true),
        };
        self.is_useless |= self.is_on && power.is_some_and(|power| power < OF_HELP);
        self.is_useless &= is_near || is_rejected;
        self.is_on = (self.is_on || is_rejected) && is_near && !self.is_useless;
    }

    pub(super) fn save(self, saver: &mut Saver) {
        saver.flag(self.is_on);
        saver.flag(self.is_useless);
    }

    pub(super) fn load(&mut self, loader: &mut Loader<'_>) -> Result<(), SolveError> {
        (self.is_on, self.is_useless) = (loader.flag()?, loader.flag()?);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The attempts at steps of these least margins, and whether stages are held after each.
    fn after(attempts: &[(f64, Attempt)]) -> Vec<bool> {
        let mut holding = Holding::default();
        let mut one = |&(margin, attempt): &(f64, Attempt)| {
            holding.note(Attempt::Begun);
            holding.observe(margin);
            holding.note(attempt);
            holding.is_on
        };
        attempts.iter().map(&mut one).collect()
    }

    const ACCEPTED: Attempt = Attempt::Accepted { power: None };
    const REJECTED: Attempt = Attempt::Rejected { power: None };

    #[test]
    fn stages_are_held_from_the_first_rejection_near_a_pose_until_it_is_passed() {
        let attempts = [
            (0.1, REJECTED),
            (0.1, ACCEPTED),
            (1e-3, REJECTED),
            (1e-3, Attempt::Accepted { power: Some(30.0) }),
            (0.1, ACCEPTED),
            (1e-3, ACCEPTED),
        ];
        assert_eq!(after(&attempts), [false, false, true, true, false, false]);
    }

    #[test]
    fn stages_are_left_alone_where_holding_them_does_not_help() {
        for power in [0.5, 8.0] {
            let attempts = [
                (1e-3, REJECTED),
                (1e-3, Attempt::Rejected { power: Some(power) }),
                (1e-3, REJECTED),
                (1e-3, ACCEPTED),
                (0.9, ACCEPTED),
                (1e-3, REJECTED),
            ];
            assert_eq!(after(&attempts), [true, false, false, false, false, true]);
        }
    }
}
