//! Detection of steps that are limited by stability (HW2 §IV.2, stiffness detection).
//!
//! ```text
//! h ρ ≈ |h| ‖f(Y) − f(y1)‖ / ‖Y − y1‖
//! ```
//!
//! for the argument `Y` of the last stage, close to `y1` at the same time. The method is stable on
//! the negative axis up to [`STABLE_RANGE`].

/// The largest `|h| ρ` of a decaying motion for which steps are stable: code of `DOP853`.
pub const STABLE_RANGE: f64 = 6.1;

/// Two states at the end of a step.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(super) struct Pair {
    /// `h ρ` by their difference.
    pub(super) h_rho: f64,
    /// The cosine between their difference and minus that of their derivatives: one where it decays along the run,
    /// nearly zero where it swings.
    pub(super) decay: f64,
}

/// Number of steps beyond the stable range that are stiffness,
const STIFF_AFTER: usize = 15;
/// so many in sequence within it forget them.
const FORGET_AFTER: usize = 6;

/// Accepted steps beyond the limit, and those within it since.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(super) struct StiffnessTest {
    pub(super) n_beyond: usize,
    pub(super) n_within: usize,
    /// Of the last step.
    pub(super) last: Pair,
}

impl StiffnessTest {
    /// Takes note of `h ρ` of an accepted step.
    pub(super) fn observe(&mut self, pair: Pair) {
        self.last = pair;
        if pair.h_rho > STABLE_RANGE {
            self.n_beyond += 1;
            self.n_within = 0;
        } else if self.n_beyond > 0 {
            self.n_within += 1;
            if self.n_within == FORGET_AFTER {
                (self.n_beyond, self.n_within) = (0, 0);
            }
        }
    }

    pub(super) fn is_stiff(&self) -> bool {
        self.n_beyond >= STIFF_AFTER
    }
}
