//! [`Pace`]: sizes of the steps of linear equations along the segments of a motion.

/// The sizes that errors allow.
pub(super) struct Pace {
    /// Largest error of a step, relative to the largest value so far.
    tolerance: f64,
    /// The longest part of a segment whose errors are expected to be small enough, s.
    longest: f64,
    /// Size and error of a step that was found too long, with which shorter ones from there are compared.
    rejected: Option<[f64; 2]>,
}

/// Part of a segment below which errors are left as they are.
const SHORTEST: f64 = 1e-4;
/// The least tolerance: rounding leaves more.
const LEAST: f64 = 1e-12;

impl Pace {
    /// For the tolerance of a run, with nothing known yet.
    pub(super) fn new(rtol: f64) -> Self {
        Self { tolerance: rtol.max(LEAST), longest: f64::INFINITY, rejected: None }
    }

    /// The size of the next step where `left` is left, and whether it is the last: equal parts, none of them longer
    /// than it may be.
    pub(super) fn step(&self, left: f64) -> (f64, bool) {
        let n_parts = (left.abs() / self.longest).ceil().max(1.0);
        (left / n_parts, n_parts == 1.0)
    }

    /// Takes note of the error of a step of size `h` within a segment of size `whole`; false where the step is to be
    /// taken again, shorter. `longest` tells the size of a step from another one and its error in tolerances.
    ///
    /// Where the error of a step of less than half the size is no smaller than half, it is rounding, as of changes that
    /// begin with a high power of time: a step that is shorter yet would only be worse.
    pub(super) fn accepts(
        &mut self,
        (h, whole): (f64, f64),
        error: f64,
        longest: impl Fn(f64, f64) -> f64,
    ) -> bool {
        /// The quotient of a segment and its parts is rounded.
        const ROUNDED: f64 = 1.0 + 1e-9;
        let (size, shortest) = (h.abs(), SHORTEST * whole.abs());
        let compared = self.rejected.filter(|[longer, _]| size < 0.5 * longer);
        let is_rounding = compared.is_some_and(|[_, before]| error > 0.5 * before);
        let is_kept = error <= self.tolerance || is_rounding || size <= ROUNDED * shortest;
        let next = if is_rounding { size } else { longest(size, error / self.tolerance) };
        self.longest = next.max(shortest);
        self.rejected = match self.rejected {
            // Steps after it are compared with the same one.
            longer if is_rounding => longer,
            _ if is_kept => None,
            Some(longer) if compared.is_none() => Some(longer),
            _ => Some([size, error]),
        };
        is_kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Longest step of a method of order eight.
    fn longest(h: f64, error: f64) -> f64 {
        h * (0.9 * error.powf(-1.0 / 8.0)).clamp(0.2, 5.0)
    }

    /// Steps that it takes over a segment, and attempts, with errors of this size.
    fn over(whole: f64, error: impl Fn(f64) -> f64) -> [usize; 2] {
        let mut pace = Pace::new(1e-10);
        let (mut from, mut counts) = (0.0, [0, 0]);
        while from != whole {
            let (h, is_last) = pace.step(whole - from);
            counts[1] += 1;
            assert!(counts[1] < 100_000, "it never ends");
            if pace.accepts((h, whole), error(h), longest) {
                counts[0] += 1;
                from = if is_last { whole } else { from + h };
            }
        }
        counts
    }

    #[test]
    fn errors_that_fall_make_steps_shorter() {
        let [n_steps, n_attempts] = over(1.0, |h| 1e-3 * h.powi(8));
        assert!((5..20).contains(&n_steps), "{n_steps}");
        assert!(n_attempts < n_steps + 5, "{n_attempts} attempts");
    }

    #[test]
    fn errors_of_rounding_do_not() {
        let [n_steps, _] = over(1.0, |_| 1e-9);
        assert!(n_steps < 10, "{n_steps}");
        let [n_steps, _] = over(1.0, |h| 1e-3 * h.powi(8) + 1e-9);
        assert!(n_steps < 40, "{n_steps}");
    }

    /// Errors that grow as steps become shorter, but never at once, come to the shortest steps, whatever the size.
    #[test]
    fn the_shortest_steps_are_taken() {
        for k in 0..50 {
            let whole = 0.013 * f64::from(k + 1);
            let [n_steps, _] = over(whole, |h| if h < 1.01e-4 * whole { 1e-9 } else { h / whole });
            assert!(n_steps < 20_000, "{n_steps}");
        }
    }
}
