//! The spectral radius of the motion as y′ = f(t, y), by power iteration.
//!
//! ```text
//! w ← (f(t, y + δ w) − f(t, y)) / δ,   ρ ≈ the geometric mean of its growth
//! ```
//!
//! Two steps of it turn an undamped oscillation round once more, so that the mean over an even number is
//! right there, too.

use bksim_dae::Ode;

use super::motion::ExplicitMotion;
use super::progress::Run;

/// Iterations, and those of them that only turn `w` to the fastest part of the motion.
const ITERATIONS: usize = 12;
const WARM_UP: usize = 4;

/// Size of a perturbation, as a part of that of the state.
const DELTA: f64 = 1e-7;

impl Run<'_> {
    /// The spectral radius where the run stands, 1/s; `None` where the accelerations have no value.
    pub(super) fn spectral_radius(&self) -> Option<f64> {
        let (mechanism, reached) = (&self.mechanism, &self.reached);
        let multipliers = self.multipliers.clone();
        let (compiled, parameters) = (mechanism.compiled(), mechanism.parameters());
        let mut motion = ExplicitMotion::new(compiled, parameters, multipliers);
        let mut rate = |y: &[f64]| {
            let mut ydot = vec![0.0; y.len()];
            motion.derivative(reached.t, y, &mut ydot).is_ok().then_some(ydot)
        };
        // The work, the last of the unknowns, acts on nothing.
        let y = [reached.q.as_slice(), &reached.v, &[0.0]].concat();
        let norm = |x: &[f64]| x[..x.len() - 1].iter().map(|x| x * x).sum::<f64>().sqrt();
        let delta = DELTA * norm(&y).max(1.0);
        let at_rest = rate(&y)?;

        #[expect(clippy::cast_precision_loss, reason = "a start with something of every direction")]
        let mut w: Vec<f64> = (0..y.len()).map(|i| (1.0 + i as f64).sin()).collect();
        let mut growth = 0.0;
        for k in 0..ITERATIONS {
            let scale = delta / norm(&w);
            let moved: Vec<f64> = y.iter().zip(&w).map(|(y, w)| y + scale * w).collect();
            let moved = rate(&moved)?;
            w = moved.iter().zip(&at_rest).map(|(a, b)| (a - b) / delta).collect();
            let size = norm(&w);
            if size == 0.0 {
                return Some(0.0);
            }
            if k >= WARM_UP {
                growth += size.ln();
            }
        }
        #[expect(clippy::cast_precision_loss, reason = "a few iterations")]
        let n = (ITERATIONS - WARM_UP) as f64;
        Some((growth / n).exp()).filter(|radius| radius.is_finite())
    }
}
