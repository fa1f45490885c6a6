//! The iteration matrices `(λ/h) ∂F/∂y′ + ∂F/∂y`: one real, `(s − 1)/2` complex.
//!
//! Assembled from the shared Jacobian values and factored by one of two kernels, chosen once per
//! run by size and fill.

mod dense;
mod sparse;

use std::ops::{DivAssign, Mul, SubAssign};

use faer::c64;
use faer::traits::ComplexField;

use self::dense::DenseLu;
use self::sparse::SparseLu;
use crate::{LinearSolver, Pattern, SolveError};

/// Up to this size the dense kernel is the faster one, whatever the fill.
const DENSE_UP_TO: usize = 48;
/// Beyond it, a matrix with this share of entries is still treated as dense.
const DENSE_FILL: f64 = 0.3;

/// The field of an iteration matrix: `f64` or [`c64`].
pub(crate) trait Scalar:
    'static + ComplexField + Copy + SubAssign + Mul<Output = Self> + DivAssign + PartialEq
{
    const ZERO: Self;
    const ONE: Self;

    /// `shift · dydot + dy`.
    fn combine(shift: Self, dydot: f64, dy: f64) -> Self;

    /// A cheap norm, good enough to choose pivots; NaN when the value is.
    fn magnitude(self) -> f64;
}

impl Scalar for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;

    fn combine(shift: Self, dydot: f64, dy: f64) -> Self {
        shift * dydot + dy
    }

    fn magnitude(self) -> f64 {
        self.abs()
    }
}

impl Scalar for c64 {
    const ZERO: Self = c64::new(0.0, 0.0);
    const ONE: Self = c64::new(1.0, 0.0);

    fn combine(shift: Self, dydot: f64, dy: f64) -> Self {
        c64::new(shift.re * dydot + dy, shift.im * dydot)
    }

    fn magnitude(self) -> f64 {
        self.re.abs() + self.im.abs()
    }
}

/// A pivot vanishes or is not finite.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Singular;

/// `∂F/∂y` and `∂F/∂y′` at one point, values in the order of the pattern.
#[derive(Clone, Debug)]
pub(crate) struct Jacobian {
    pub(crate) df_dy: Vec<f64>,
    pub(crate) df_dydot: Vec<f64>,
}

impl Jacobian {
    pub(crate) fn new(n_entries: usize) -> Self {
        Self { df_dy: vec![0.0; n_entries], df_dydot: vec![0.0; n_entries] }
    }

    /// Entry of the first value that is not finite.
    pub(crate) fn position_not_finite(&self) -> Option<usize> {
        self.df_dy.iter().zip(&self.df_dydot).position(|(x, y)| !(x.is_finite() && y.is_finite()))
    }

    /// Whether unknown `col` appears without its derivative.
    pub(crate) fn is_algebraic(&self, pattern: &Pattern, col: usize) -> bool {
        self.df_dydot[pattern.column(col)].iter().all(|&x| x == 0.0)
    }

    /// Values of `shift · ∂F/∂y′ + ∂F/∂y` in the order of the pattern.
    fn combined<T: Scalar>(&self, shift: T) -> impl Iterator<Item = T> + '_ {
        self.df_dydot.iter().zip(&self.df_dy).map(move |(&dydot, &dy)| T::combine(shift, dydot, dy))
    }
}

/// One factored matrix.
#[expect(clippy::large_enum_variant, reason = "a run holds at most four")]
enum Factor<T: Scalar> {
    Dense(DenseLu<T>),
    Sparse(SparseLu<T>),
}

impl<T: Scalar> Factor<T> {
    fn factor(&mut self, pattern: &Pattern, jacobian: &Jacobian, shift: T) -> Result<(), Singular> {
        match self {
            Self::Dense(lu) => lu.factor(pattern, jacobian.combined(shift)),
            Self::Sparse(lu) => lu.factor(pattern, jacobian.combined(shift)),
        }
    }

    fn solve_in_place(&mut self, x: &mut [T]) {
        match self {
            Self::Dense(lu) => lu.solve_in_place(x),
            Self::Sparse(lu) => lu.solve_in_place(x),
        }
    }
}

/// The set of factored iteration matrices of one step size.
pub(crate) struct IterationMatrix {
    real: Factor<f64>,
    complex: Vec<Factor<c64>>,
}

impl IterationMatrix {
    /// Allocates for one real and `n_complex` complex matrices and analyses the pattern.
    pub(crate) fn new(
        pattern: &Pattern,
        n_complex: usize,
        solver: LinearSolver,
    ) -> Result<Self, SolveError> {
        let n = pattern.n();
        let is_dense = match solver {
            LinearSolver::Dense => true,
            LinearSolver::Sparse => false,
            LinearSolver::Auto => {
                n <= DENSE_UP_TO || pattern.n_entries() as f64 > DENSE_FILL * (n * n) as f64
            }
        };
        if is_dense {
            return Ok(Self {
                real: Factor::Dense(DenseLu::new(n)),
                complex: (0..n_complex).map(|_| Factor::Dense(DenseLu::new(n))).collect(),
            });
        }
        let symbolic = sparse::analyse(pattern)?;
        let complex = (0..n_complex)
            .map(|_| SparseLu::new(&symbolic, pattern).map(Factor::Sparse))
            .collect::<Result<_, _>>()?;
        Ok(Self { real: Factor::Sparse(SparseLu::new(&symbolic, pattern)?), complex })
    }

    /// Factors `(γ/h) ∂F/∂y′ + ∂F/∂y` and its complex companions.
    pub(crate) fn factor(
        &mut self,
        pattern: &Pattern,
        jacobian: &Jacobian,
        gamma: f64,
        lambda: &[c64],
        h: f64,
    ) -> Result<(), Singular> {
        self.real.factor(pattern, jacobian, gamma / h)?;
        for (matrix, lambda) in self.complex.iter_mut().zip(lambda) {
            matrix.factor(pattern, jacobian, lambda / h)?;
        }
        Ok(())
    }

    /// Solves with the real matrix.
    pub(crate) fn solve_real(&mut self, x: &mut [f64]) {
        self.real.solve_in_place(x);
    }

    /// Solves with complex matrix `pair`.
    pub(crate) fn solve_complex(&mut self, pair: usize, x: &mut [c64]) {
        self.complex[pair].solve_in_place(x);
    }
}

#[cfg(test)]
mod tests;
