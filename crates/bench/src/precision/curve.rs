//! Work against precision: digits and times of one solver at each tolerance, and the time to reach
//! given digits.

use serde_json::{Value, json};

/// Parts of a state, in the order of [`Point::digits`].
pub(crate) const PARTS: [&str; 3] = ["position", "velocity", "multiplier"];

/// One run of one solver.
#[derive(Clone, Debug)]
pub(crate) struct Point {
    /// rtol = atol.
    pub(crate) tolerance: f64,
    /// Correct digits of q, v and λ at the end; NaN if the run did not reach it.
    pub(crate) digits: [f64; 3],
    /// CPU time of the fastest run, s.
    pub(crate) seconds: f64,
    /// Counters in Hairer's sense.
    pub(crate) counters: Counters,
}

/// Work of one run.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[expect(clippy::struct_field_names, reason = "the names of counters begin with n")]
pub(crate) struct Counters {
    pub(crate) n_step: usize,
    pub(crate) n_reject: usize,
    pub(crate) n_residual: usize,
    pub(crate) n_jacobian: usize,
    pub(crate) n_factor: usize,
}

/// All runs of one solver on one problem, from loose to tight tolerance.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    /// The solver.
    pub(crate) name: &'static str,
    pub(crate) points: Vec<Point>,
}

impl Curve {
    /// CPU time to reach `digits` of one part, s: between two neighbouring runs by interpolation of
    /// the logarithm of time over digits. NaN if no run reaches them; the time of the loosest run
    /// if it has more.
    pub(crate) fn seconds_for(&self, part: usize, digits: f64) -> f64 {
        let reached = |point: &&Point| point.digits[part].is_finite();
        let points: Vec<&Point> = self.points.iter().filter(reached).collect();
        match points.first() {
            Some(loosest) if loosest.digits[part] >= digits => return loosest.seconds,
            _ => (),
        }
        let crossing = points.windows(2).find(|pair| pair[1].digits[part] >= digits);
        crossing.map_or(f64::NAN, |pair| {
            let [from, to] = [pair[0], pair[1]];
            let share = (digits - from.digits[part]) / (to.digits[part] - from.digits[part]);
            (from.seconds.ln() + share * (to.seconds / from.seconds).ln()).exp()
        })
    }

    /// Takes the smaller times of another round of the same runs.
    pub(crate) fn merge(&mut self, other: &Self) {
        for (point, again) in self.points.iter_mut().zip(&other.points) {
            point.seconds = point.seconds.min(again.seconds);
        }
    }

    /// All numbers as JSON.
    pub(crate) fn to_json(&self) -> Value {
        let one = |point: &Point| {
            let Counters { n_step, n_reject, n_residual, n_jacobian, n_factor } = point.counters;
            json!({
                "tolerance": point.tolerance, "digits": point.digits, "seconds": point.seconds,
                "n_step": n_step, "n_reject": n_reject, "n_residual": n_residual,
                "n_jacobian": n_jacobian, "n_factor": n_factor,
            })
        };
        self.points.iter().map(one).collect()
    }
}

/// Correct digits: −log10 max |x − r| / max(1, |r|), at most 17; NaN if an entry is not finite.
pub(crate) fn digits(x: &[f64], reference: &[f64]) -> f64 {
    if x.len() != reference.len() || x.iter().any(|x| !x.is_finite()) {
        return f64::NAN;
    }
    let error = |(x, r): (&f64, &f64)| (x - r).abs() / r.abs().max(1.0);
    let worst = x.iter().zip(reference).map(error).fold(0.0, f64::max);
    -worst.max(1e-17).log10()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(points: &[(f64, f64)]) -> Curve {
        let point = |&(digits, seconds): &(f64, f64)| Point {
            tolerance: 1.0,
            digits: [digits; 3],
            seconds,
            counters: Counters::default(),
        };
        Curve { name: "test", points: points.iter().map(point).collect() }
    }

    #[test]
    fn times_are_interpolated_between_neighbours() {
        let curve = curve(&[(2.0, 1.0), (4.0, 4.0), (f64::NAN, 5.0), (6.0, 100.0)]);
        assert_eq!(curve.seconds_for(0, 1.0), 1.0);
        assert!((curve.seconds_for(0, 3.0) - 2.0).abs() < 1e-12);
        assert!((curve.seconds_for(1, 5.0) - 20.0).abs() < 1e-12);
        assert!(curve.seconds_for(2, 6.5).is_nan());
    }

    #[test]
    fn digits_are_relative_above_one_and_absolute_below() {
        assert!((digits(&[200.0 + 2e-4, 0.1], &[200.0, 0.1]) - 6.0).abs() < 1e-6);
        assert!((digits(&[0.1 + 1e-3], &[0.1]) - 3.0).abs() < 1e-6);
        assert!(digits(&[f64::NAN], &[1.0]).is_nan());
        assert_eq!(digits(&[1.0], &[1.0]), 17.0);
    }
}
