//! How large an error is: weights of the unknowns, and the estimate of the local error.

use crate::iteration_matrix::IterationMatrix;
use crate::newton::{NewtonWork, Point};
use crate::tableau::Tableau;
use crate::{Index, Stats, StepControl, System, Tolerance};

/// Weights that turn errors into units of their tolerance.
///
/// ```text
/// weight_i = |h|^{index_i − 1} / (atol_i + rtol |y_i|)
/// ```
///
/// The power of `h` discounts unknowns of index 2 and 3 (header of `RADAU5`).
#[derive(Clone, Debug)]
pub(crate) struct Scale {
    weight: Vec<f64>,
    /// Which unknowns the error test looks at, and their number.
    is_tested: Vec<bool>,
    n_tested: usize,
}

/// The denominator of [`Scale`].
#[derive(Clone, Debug)]
pub(crate) enum Unit {
    /// Error control: `atol + rtol |y|`.
    Tolerance { rtol: f64, atol: Tolerance },
    /// Fixed steps have no error tolerance: `1 + |y|`.
    Magnitude,
}

impl Unit {
    pub(crate) fn new(settings: &crate::Settings) -> Self {
        match settings.step {
            StepControl::Adaptive => {
                Self::Tolerance { rtol: settings.rtol, atol: settings.atol.clone() }
            }
            StepControl::Fixed { .. } => Self::Magnitude,
        }
    }

    fn of(&self, i: usize, y: f64) -> f64 {
        match self {
            Self::Tolerance { rtol, atol } => atol.of(i) + rtol * y.abs(),
            Self::Magnitude => 1.0 + y.abs(),
        }
    }
}

impl Scale {
    pub(crate) fn new(n: usize) -> Self {
        Self { weight: vec![1.0; n], is_tested: vec![true; n], n_tested: n }
    }

    /// Number of unknowns.
    pub(crate) fn len(&self) -> usize {
        self.weight.len()
    }

    /// Says which unknowns the error test looks at; if it were none, it looks at all.
    pub(crate) fn test_only(&mut self, is_tested: impl Fn(usize) -> bool) {
        let n = self.weight.len();
        self.n_tested = (0..n).filter(|&i| is_tested(i)).count();
        let any = self.n_tested > 0;
        self.is_tested.iter_mut().enumerate().for_each(|(i, t)| *t = !any || is_tested(i));
        if !any {
            self.n_tested = n;
        }
    }

    /// Root mean square of the weighted entries of `x` that the error test looks at: one or more vectors of
    /// length `n`.
    pub(crate) fn rms_tested(&self, x: &[f64]) -> f64 {
        let n = self.weight.len();
        if n == 0 {
            return 0.0;
        }
        let square = |(i, x): (usize, &f64)| {
            if self.is_tested[i] { (x * self.weight[i]).powi(2) } else { 0.0 }
        };
        let sum: f64 =
            x.chunks_exact(n).map(|x| x.iter().enumerate().map(square).sum::<f64>()).sum();
        (sum / (self.n_tested * (x.len() / n)) as f64).sqrt()
    }

    /// Takes the weights at state `y` and step size `h`.
    pub(crate) fn update(&mut self, unit: &Unit, index: &[Index], y: &[f64], h: f64) {
        for (i, weight) in self.weight.iter_mut().enumerate() {
            *weight = h.abs().powi(index[i].power()) / unit.of(i, y[i]);
        }
    }

    /// Root mean square of the weighted entries of `x`: one or more vectors of length `n`.
    pub(crate) fn rms(&self, x: &[f64]) -> f64 {
        let n = self.weight.len();
        if n == 0 {
            return 0.0;
        }
        let sum: f64 = x
            .chunks_exact(n)
            .map(|x| x.iter().zip(&self.weight).map(|(x, w)| (x * w) * (x * w)).sum::<f64>())
            .sum();
        (sum / x.len() as f64).sqrt()
    }

    /// Weighted magnitude of entry `i`, the largest over the vectors in `x`.
    pub(crate) fn magnitude(&self, x: &[f64], i: usize) -> f64 {
        let n = self.weight.len();
        // `f64::max` drops NaN, which must come out on top here.
        x.iter()
            .skip(i)
            .step_by(n)
            .map(|x| (x * self.weight[i]).abs())
            .fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a })
    }
}

/// Estimates the local error of a solved step into `error`; returns its weighted norm.
///
/// The embedded formula of order `s` gives, in place of HW2 §IV.8 (8.19), a value `w` that stands
/// for `y′(t0)` when the step is exact, and one Newton step turns its defect into an error:
///
/// ```text
/// w = −(γ/h) Σ_i e_i z_i
/// ((γ/h) ∂F/∂y′ + ∂F/∂y) err = −F(t0, y0, w)
/// ```
///
/// For `F = M y′ − f` this is exactly (8.19); `y′(t0)` itself, unknown for multipliers, is not
/// needed. The matrix filters the stiff components.
pub(crate) fn error_estimate<S: System>(
    system: &mut S,
    at: Point<'_>,
    tableau: &Tableau,
    matrix: &mut IterationMatrix,
    work: &mut NewtonWork,
    filter: Filter,
    stats: &mut Stats,
) -> f64 {
    // The embedded value that stands for y′(t0).
    let n = at.y.len();
    let NewtonWork { z, y_stage, ydot_stage, defect, error, scale, .. } = work;
    ydot_stage.fill(0.0);
    for (z, e) in z.chunks_exact(n.max(1)).zip(&tableau.e) {
        for (w, z) in ydot_stage.iter_mut().zip(z) {
            *w -= tableau.gamma / at.h * e * z;
        }
    }
    y_stage.copy_from_slice(at.y);

    // First filter.
    let defect = &mut defect[..n];
    stats.n_residual += 1;
    if system.residual(at.t, y_stage, ydot_stage, defect).is_err() {
        return f64::NAN;
    }
    for (error, defect) in error.iter_mut().zip(&*defect) {
        *error = -defect;
    }
    matrix.solve_real(error);
    stats.n_solve += 1;
    let norm = scale.rms_tested(error);
    if filter == Filter::Once || norm < 1.0 {
        return norm;
    }

    // Second filter; it looks at a point that may lie outside the domain, where the first stands.
    for (y, (y0, error)) in y_stage.iter_mut().zip(at.y.iter().zip(&*error)) {
        *y = y0 + error;
    }
    stats.n_residual += 1;
    if system.residual(at.t, y_stage, ydot_stage, defect).is_err() {
        return norm;
    }
    for (error, defect) in error.iter_mut().zip(&*defect) {
        *error = -defect;
    }
    matrix.solve_real(error);
    stats.n_solve += 1;
    scale.rms_tested(error)
}

/// How often the estimate passes through the iteration matrix.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Filter {
    /// Once.
    Once,
    /// Where stiff transients may make it too large, at the start and after a rejection, an
    /// estimate above one passes again through `F(t0, y0 + err, w)`, HW2 §IV.8 (8.20).
    Twice,
}
