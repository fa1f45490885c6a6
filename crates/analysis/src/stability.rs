//! Stability of a pose in balance, each part against its own size.
//!
//! ```text
//! K_n = Nᵀ K N        N: orthonormal free motions, in units of the mechanism
//! κ_k = y_kᵀ K_n y_k  against  Σ |u_i| |K_ij| |u_j|,  u = N y_k        what rounding leaves of κ_k
//! ```
//!
//! A soft part next to stiff ones has a small eigenvalue, which is none the less exact: what counts is the size of the
//! terms that it is the sum of, not the stiffness elsewhere.

use nalgebra::DMatrix;

use crate::balance::Balance;
use crate::equilibrium::Stability;
use crate::forces::ForcesAt;
use crate::pencil::Pencil;
use crate::reduced::Reduced;

/// Part of the terms of a stiffness, or of the roots of small motions, below which one counts as zero.
const NO_STIFFNESS: f64 = 1e-9;
/// Part of what joints bear that is left of forces in balance by rounding.
const FORCES: f64 = 1e-12;
/// Part of the largest eigenvalue that a method for all of them leaves in each.
const EIGENVALUES: f64 = 1e-13;

impl Balance<'_> {
    /// Stability along the `motions` of `reduced`, where joints bear work of the size `loads`; with states by small motions.
    pub(crate) fn stability(
        &self,
        at: &ForcesAt,
        (reduced, motions): (&Reduced, &[usize]),
        loads: f64,
    ) -> Stability {
        if !self.states().is_empty() {
            return stability_of_small_motions(&Pencil::of(at, reduced));
        }
        let units = self.units();
        let mut free = reduced.basis.select_columns(motions);
        if free.is_empty() {
            return Stability::Stable;
        }
        for (mut row, unit) in free.row_iter_mut().zip(&units) {
            row /= *unit;
        }
        let free = free.qr().q();
        let n = units.len();
        let stiffness = DMatrix::from_fn(n, n, |i, j| at.stiffness[(i, j)] * units[i] * units[j]);
        let sizes = stiffness.abs();
        let projected = free.transpose() * &stiffness * &free;
        let eigen = ((&projected + projected.transpose()) * 0.5).symmetric_eigen();
        let largest = eigen.eigenvalues.amax();
        let mut found = Stability::Stable;
        for (k, &value) in eigen.eigenvalues.iter().enumerate() {
            let own = (&free * eigen.eigenvectors.column(k)).abs();
            let terms = own.dot(&(&sizes * &own));
            let nothing = (NO_STIFFNESS * terms).max(FORCES * loads).max(EIGENVALUES * largest);
            if value < -nothing {
                return Stability::Unstable;
            }
            if value <= nothing {
                found = Stability::Neutral;
            }
        }
        found
    }
}

/// Stability by the roots of the equations of small motions.
fn stability_of_small_motions(pencil: &Pencil) -> Stability {
    let (roots, _) = pencil.finite_eigenvalues();
    let size = roots.iter().fold(0.0, |size: f64, s| size.max(s.norm()));
    let last = roots.iter().fold(f64::NEG_INFINITY, |last, s| last.max(s.re));
    if last < -NO_STIFFNESS * size {
        Stability::Stable
    } else if last > NO_STIFFNESS * size {
        Stability::Unstable
    } else {
        Stability::Neutral
    }
}
