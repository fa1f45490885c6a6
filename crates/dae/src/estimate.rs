//! The estimate of the local error of a solved step.

use crate::iteration_matrix::IterationMatrix;
use crate::newton::{NewtonWork, Point};
use crate::stats::Stats;
use crate::system::System;
use crate::tableau::Tableau;

/// Estimates the local error of a solved step into `error`; returns its weighted norm.
///
/// The embedded formula of order `s` gives, instead of HW2 §IV.8 (8.19), a value `w` that equals
/// `y′(t0)` when the step is exact, and one Newton step turns its defect into an error:
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
    // w, the embedded value for y′(t0).
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

    // Second filter; its point may lie outside the domain, and then the first estimate holds.
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

/// Number of times that the estimate passes through the iteration matrix.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Filter {
    /// Once.
    Once,
    /// Where stiff transients may make it too large, at the start and after a rejection, an
    /// estimate above one passes again through `F(t0, y0 + err, w)`, HW2 §IV.8 (8.20).
    Twice,
}
