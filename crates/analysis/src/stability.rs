//! Stability of a pose in balance, each part against its own size.
//!
//! ```text
//! K_n = Nᵀ K N        N: orthonormal free motions, in units of the mechanism
//! κ_k = y_kᵀ K_n y_k  against  Σ |u_i| |K_ij| |u_j|,  u = N y_k        what rounding leaves of κ_k
//! ```
//!
//! That is a test of the potential: with a symmetric K_n, damping that takes no energy in, and any gyroscopic terms, a pose is
//! stable if all κ are positive (Dirichlet, Kelvin–Tait–Chetaev). Forces that follow the motion make K_n unsymmetric, and
//! damping can be below zero: then, and where gyroscopic terms may hold a maximum, the roots of small motions decide.
//!
//! A soft part next to stiff ones has a small eigenvalue, which is none the less exact: what counts is the size of the
//! terms that it is the sum of, not the stiffness elsewhere.

use nalgebra::{Complex, DMatrix, DVector};

use crate::balance::Balance;
use crate::equilibrium::Stability;
use crate::forces::ForcesAt;
use crate::pencil::Pencil;
use crate::reduced::Reduced;

/// Part of the terms of a stiffness, or of the roots of small motions, below which one counts as zero.
const NO_STIFFNESS: f64 = 1e-9;
/// Parts of the terms of a matrix, and of what joints bear, below which they have no potential by rounding alone.
const NO_SKEW: [f64; 2] = [1e-8, 1e-10];
/// Part of what joints bear that is left of forces in balance by rounding.
const FORCES: f64 = 1e-12;
/// Part of the largest eigenvalue that a method for all of them leaves in each.
const EIGENVALUES: f64 = 1e-13;

/// A matrix along orthonormal free motions, with the sizes of the terms that it is the sum of.
struct Along {
    matrix: DMatrix<f64>,
    sizes: DMatrix<f64>,
    free: DMatrix<f64>,
}

impl Along {
    fn of(matrix: &DMatrix<f64>, units: &DVector<f64>, free: &DMatrix<f64>) -> Self {
        let n = units.len();
        let matrix = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)] * units[i] * units[j]);
        Self { sizes: matrix.abs(), matrix: free.transpose() * matrix * free, free: free.clone() }
    }

    /// Eigenvalues of the symmetric part, each with what of it may be rounding where joints bear work of the size `loads`.
    fn symmetric(&self, loads: f64) -> Vec<(f64, f64)> {
        let eigen = ((&self.matrix + self.matrix.transpose()) * 0.5).symmetric_eigen();
        let largest = eigen.eigenvalues.amax();
        let of = |(k, &value): (usize, &f64)| {
            let own = (&self.free * eigen.eigenvectors.column(k)).abs();
            let terms = own.dot(&(&self.sizes * &own));
            (value, (NO_STIFFNESS * terms).max(FORCES * loads).max(EIGENVALUES * largest))
        };
        eigen.eigenvalues.iter().enumerate().map(of).collect()
    }

    /// True if the matrix is symmetric up to rounding.
    fn is_symmetric(&self, loads: f64) -> bool {
        let sizes = self.free.abs();
        let sizes = sizes.transpose() * &self.sizes * &sizes;
        let skew = (&self.matrix - self.matrix.transpose()).abs();
        skew.iter()
            .zip(&sizes)
            .all(|(skew, size)| *skew <= (NO_SKEW[0] * size).max(NO_SKEW[1] * loads))
    }
}

impl Balance<'_> {
    /// Stability along the `motions` of `reduced`, where joints bear work of the size `loads`.
    pub(crate) fn stability(
        &self,
        at: &ForcesAt,
        (reduced, motions): (&Reduced, &[usize]),
        loads: f64,
    ) -> Stability {
        if !self.states().is_empty() {
            let roots = Pencil::of(at, reduced).finite_eigenvalues().0;
            return stability_of_small_motions(&roots);
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
        let stiffness = Along::of(&at.stiffness, &units, &free);
        let damping = Along::of(&at.damping, &units, &free);
        let values = stiffness.symmetric(loads);
        let by_potential = if values.iter().any(|(value, nothing)| *value < -nothing) {
            Stability::Unstable
        } else if values.iter().any(|(value, nothing)| *value <= *nothing) {
            Stability::Neutral
        } else {
            Stability::Stable
        };
        let takes_in = damping.symmetric(0.0).iter().any(|(value, nothing)| *value < -nothing);
        let is_conservative = stiffness.is_symmetric(loads) && !takes_in;
        let turns = !damping.is_symmetric(0.0);
        if is_conservative && !(turns && by_potential == Stability::Unstable) {
            return by_potential;
        }
        // What has no inertia follows at once, by its stiffness alone.
        let (roots, n_light) = Pencil::of(at, reduced).finite_eigenvalues();
        if roots.is_empty() || (n_light > 0 && by_potential == Stability::Unstable) {
            return by_potential;
        }
        stability_of_small_motions(&roots)
    }
}

/// Stability by the roots of the equations of small motions.
fn stability_of_small_motions(roots: &[Complex<f64>]) -> Stability {
    let size = roots.iter().fold(0.0, |size: f64, s| size.max(s.norm()));
    let nothing = NO_STIFFNESS * size;
    let grows = |s: &&Complex<f64>| s.re > nothing;
    if roots.iter().filter(grows).any(|s| s.im.abs() <= nothing) {
        Stability::Unstable
    } else if roots.iter().any(|s| grows(&s)) {
        Stability::Flutter
    } else if roots.iter().all(|s| s.re < -nothing) {
        Stability::Stable
    } else if roots.iter().any(|s| s.norm() <= nothing) {
        Stability::Neutral
    } else {
        Stability::Marginal
    }
}
