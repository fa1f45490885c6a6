//! Noise of the right side: its rounding, which may be far more than that of its arguments.
//!
//! ```text
//! f_k = f(t, y + k d),  k = 0 … 6,  d a few roundings of y
//! σ² = 1/20 mean (Δ³ f)²        what a smooth f has there cancels in the differences
//! ```
//!
//! J. J. Moré and S. M. Wild, *Estimating computational noise*, SIAM J. Sci. Comput. 33 (2011), (2.3) for differences
//! of order three. The error estimate of a step, |h| Σ e_i k_i, then holds |h| ‖e‖ σ of noise, however small the step
//! is: a tolerance below that cannot be met, and is raised to it.

use super::derivative;
use crate::scale::Scale;
use crate::stats::Stats;
use crate::system::Ode;

/// States that are compared, and the order of the differences.
const N_STATES: usize = 7;
const ORDER: usize = 3;
/// `(3!)² / 6!`: the part of the variance of a difference of order three.
const PART: f64 = 1.0 / 20.0;
/// Distance of two states, relative to each unknown: some tens of roundings.
const DISTANCE: f64 = 1.0 / (1u64 << 47) as f64;
/// Errors within so many times the noise of one step are noise.
const ALLOWANCE: f64 = 3.0;
/// Accepted steps after which it is measured anew where it matters.
const LASTING: usize = 50;

/// The noise that was measured last, with room for measuring it.
#[derive(Clone, Debug, Default)]
pub(super) struct RightSideNoise {
    /// In tolerances per unit of time.
    pub(super) rate: f64,
    /// Accepted steps since then.
    pub(super) age: usize,
    values: Vec<f64>,
    argument: Vec<f64>,
}

impl RightSideNoise {
    /// The error that a step of this size may have, in tolerances: one, or what noise leaves.
    pub(super) fn floor(&self, h: f64) -> f64 {
        (ALLOWANCE * self.rate * h.abs()).max(1.0)
    }

    /// A step has been accepted.
    pub(super) fn pass(&mut self) {
        self.age += 1;
        if self.age >= LASTING {
            self.rate = 0.0;
        }
    }

    /// Measures the noise at a state, in the units of `scale`; `gain` is the norm of the weights of the error estimate.
    pub(super) fn measure<S: Ode>(
        &mut self,
        system: &mut S,
        (t, y): (f64, &[f64]),
        (scale, gain): (&Scale, f64),
        stats: &mut Stats,
    ) {
        let n = y.len();
        let Self { rate, age, values, argument } = self;
        (*rate, *age) = (0.0, 0);
        values.resize(n * N_STATES, 0.0);
        argument.resize(n, 0.0);
        for (k, out) in values.chunks_exact_mut(n.max(1)).enumerate() {
            for (i, (argument, y)) in argument.iter_mut().zip(y).enumerate() {
                // Signs of no pattern, so that no direction is preferred.
                let sign = if (i.wrapping_mul(0x9E37_79B9) >> 7) & 1 == 0 { 1.0 } else { -1.0 };
                *argument = y * (1.0 + sign * k as f64 * DISTANCE);
            }
            if derivative(system, t, argument, out, stats).is_err() {
                return;
            }
        }

        // Differences in place, then their mean squares in the first column.
        for _ in 0..ORDER {
            for k in 0..N_STATES - 1 {
                let (low, high) = values.split_at_mut((k + 1) * n);
                let column = low[k * n..].iter_mut();
                column.zip(&high[..n]).for_each(|(low, high)| *low = high - *low);
            }
        }
        let count = N_STATES - ORDER;
        for i in 0..n {
            let sum: f64 = (0..count).map(|k| values[k * n + i].powi(2)).sum();
            argument[i] = (PART * sum / count as f64).sqrt();
        }
        let found = gain * scale.rms(argument);
        *rate = if found.is_finite() { found } else { 0.0 };
    }
}

#[cfg(test)]
mod tests {
    use crate::explicit::ExplicitSolver;
    use crate::run::Start;
    use crate::settings::{Settings, Tolerance};
    use crate::system::{Index, Layout, NotFinite, Ode};

    /// A swing x″ = −x with something added to x″.
    struct Swing {
        layout: Layout,
        added: fn(f64, &[f64]) -> f64,
    }

    impl Ode for Swing {
        fn layout(&self) -> &Layout {
            &self.layout
        }

        fn derivative(&mut self, t: f64, y: &[f64], ydot: &mut [f64]) -> Result<(), NotFinite> {
            ydot.copy_from_slice(&[y[1], (self.added)(t, y) - y[0]]);
            Ok(())
        }
    }

    /// Steps and x at `t_end` from x = 1, x′ = 0.
    fn swung(added: fn(f64, &[f64]) -> f64, t_end: f64, rtol: f64) -> (usize, f64, usize) {
        let layout = Layout::from_groups(&[(2, Index::One)]);
        let settings = Settings {
            rtol,
            atol: Tolerance::Scalar(rtol),
            max_steps: 100_000,
            ..Settings::default()
        };
        let start = Start { t: 0.0, y: vec![1.0, 0.0], ydot: vec![0.0; 2] };
        let mut solver = ExplicitSolver::new(Swing { layout, added }, start, t_end, settings)
            .expect("a start with values");
        while solver.advance().expect("steps are not too many") {}
        (solver.stats().n_step, solver.y()[0], solver.noise().count)
    }

    /// Noise of 1e-8, a function of the last bits.
    fn rough(_: f64, y: &[f64]) -> f64 {
        let bits =
            (y[0].to_bits() ^ y[1].to_bits().rotate_left(17)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        1e-8 * ((bits >> 11) as f64 / (1u64 << 53) as f64 - 0.5)
    }

    #[test]
    fn noise_above_the_tolerance_is_taken_as_it_is() {
        let (n_step, x, n_noise) = swung(rough, 20.0, 1e-13);
        assert!(n_step < 3000, "{n_step} steps");
        assert!((x - 20.0_f64.cos()).abs() < 1e-8, "off by {:e}", x - 20.0_f64.cos());
        assert!(n_noise > 20, "{n_noise}");
    }

    #[test]
    fn a_jump_is_no_noise() {
        let jump = |t: f64, _: &[f64]| if t < 1.234_567 { 0.0 } else { 0.3 };
        let (_, x, _) = swung(jump, 3.0, 1e-12);
        let exact = 3.0_f64.cos() + 0.3 * (1.0 - (3.0_f64 - 1.234_567).cos());
        assert!((x - exact).abs() < 1e-10, "off by {:e}", x - exact);
    }

    #[test]
    fn smooth_equations_keep_their_tolerance() {
        let (n_step, x, n_noise) = swung(|_, _| 0.0, 20.0, 1e-12);
        assert!(n_step < 200 && n_noise < 3, "{n_step}, {n_noise}");
        assert!((x - 20.0_f64.cos()).abs() < 1e-10);
    }
}
