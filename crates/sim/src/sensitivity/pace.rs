//! [`Pace`]: sizes of the steps of linear equations along the segments of a motion.

/// The sizes that errors allow.
pub(super) struct Pace {
    /// Largest error of a step, relative to the largest value so far.
    tolerance: f64,
    /// The longest part of a segment whose errors are expected to be small enough, s.
    longest: f64,
}

/// Part of a segment below which errors are left as they are.
const SHORTEST: f64 = 1e-4;
/// The least tolerance: rounding leaves more.
const LEAST: f64 = 1e-12;

impl Pace {
    /// For the tolerance of a run, with nothing known yet.
    pub(super) fn new(rtol: f64) -> Self {
        Self { tolerance: rtol.max(LEAST), longest: f64::INFINITY }
    }

    /// The size of the next step where `left` is left, and whether it is the last: equal parts, none of them longer
    /// than it may be.
    pub(super) fn step(&self, left: f64) -> (f64, bool) {
        let n_parts = (left.abs() / self.longest).ceil().max(1.0);
        (left / n_parts, n_parts == 1.0)
    }

    /// Takes note of the error of a step of size `h` within a segment of size `whole`; false where the step is to be
    /// taken again, shorter. `longest` tells the size of a step from another one and its error in tolerances.
    pub(super) fn accepts(
        &mut self,
        (h, whole): (f64, f64),
        error: f64,
        longest: impl Fn(f64, f64) -> f64,
    ) -> bool {
        let shortest = SHORTEST * whole.abs();
        self.longest = longest(h.abs(), error / self.tolerance).max(shortest);
        error <= self.tolerance || h.abs() <= shortest
    }
}
