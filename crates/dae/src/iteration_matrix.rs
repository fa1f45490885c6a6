//! The iteration matrices `(λ/h) ∂F/∂y′ + ∂F/∂y`: one real, `(s − 1)/2` complex.
//!
//! Assembled from the shared Jacobian values. Small systems are factored all together, each in a lane of
//! its own; of larger ones the explicit rows are eliminated, and what remains is factored by one of two
//! kernels. Size and fill choose once per run.

mod dense;
mod elimination;
mod packed;
mod pivots;
mod sparse;
mod static_lu;

use std::ops::{Mul, Sub, SubAssign};

use faer::c64;
use faer::traits::ComplexField;

use self::dense::DenseLu;
use self::elimination::{Borders, Elimination};
use self::packed::Column;
use self::sparse::{SparseLu, Symbolic};
use self::static_lu::StaticLu;
use crate::checkpoint::{Loader, Saver};
use crate::error::{Cause, SolveError};
use crate::settings::LinearSolver;
use crate::system::{Index, Pattern, System};

/// Up to this size, eliminated rows not counted, all matrices are factored together. Not those of index 3:
/// its error estimates fail where rounding of the solution is larger than with pivots chosen each time.
const STATIC_UP_TO: usize = 24;
/// Up to this one if no more than this share of entries is there.
const SPARSE_STATIC_UP_TO: usize = 64;
const STATIC_FILL: f64 = 0.5;
/// Up to this size the dense kernel is the faster one, whatever the fill.
const DENSE_UP_TO: usize = 48;
/// Beyond it, a matrix with this share of entries is still treated as dense.
const DENSE_FILL: f64 = 0.3;

/// The field of an iteration matrix: `f64` or [`c64`].
///
/// Vectors are arrays of `f64`: a complex one is its real parts, then its imaginary parts.
pub(crate) trait Scalar:
    Column + ComplexField + Sub<Output = Self> + SubAssign + Mul<Output = Self> + PartialEq
{
    const ZERO: Self;
    const ONE: Self;

    /// `shift · dydot + dy`.
    fn combine(shift: Self, dydot: f64, dy: f64) -> Self;

    /// A cheap norm, good enough to choose pivots; NaN when the value is.
    fn magnitude(self) -> f64;

    /// `1 / self`.
    fn reciprocal(self) -> Self;

    /// Entry `i` of a vector of length `n`.
    fn load(x: &[f64], i: usize, n: usize) -> Self;

    /// Overwrites entry `i` of a vector of length `n`.
    fn store(self, x: &mut [f64], i: usize, n: usize);
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

    fn reciprocal(self) -> Self {
        1.0 / self
    }

    fn load(x: &[f64], i: usize, _n: usize) -> Self {
        x[i]
    }

    fn store(self, x: &mut [f64], i: usize, _n: usize) {
        x[i] = self;
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

    fn reciprocal(self) -> Self {
        self.inv()
    }

    fn load(x: &[f64], i: usize, n: usize) -> Self {
        c64::new(x[i], x[n + i])
    }

    fn store(self, x: &mut [f64], i: usize, n: usize) {
        (x[i], x[n + i]) = (self.re, self.im);
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

    /// Evaluates both at one point.
    pub(crate) fn evaluate<S: System>(
        &mut self,
        system: &mut S,
        t: f64,
        y: &[f64],
        ydot: &[f64],
    ) -> Result<(), Cause> {
        let Self { df_dy, df_dydot } = self;
        system
            .jacobian(t, y, ydot, df_dy, df_dydot)
            .map_err(|not_finite| Cause::NotFinite { row: not_finite.row })?;
        let is_bad = |(x, y): (&f64, &f64)| !(x.is_finite() && y.is_finite());
        match df_dy.iter().zip(&*df_dydot).position(is_bad) {
            None => Ok(()),
            Some(k) => Err(Cause::NotFinite { row: system.pattern().row_idx()[k] }),
        }
    }

    /// `out += ∂F/∂y · y + ∂F/∂y′ · ydot`.
    pub(crate) fn add_products(&self, pattern: &Pattern, y: &[f64], ydot: &[f64], out: &mut [f64]) {
        for (col, (y, ydot)) in y.iter().zip(ydot).enumerate() {
            for k in pattern.column(col) {
                out[pattern.row_idx()[k]] += self.df_dy[k] * y + self.df_dydot[k] * ydot;
            }
        }
    }

    /// True if unknown `col` appears without its derivative.
    pub(crate) fn is_algebraic(&self, pattern: &Pattern, col: usize) -> bool {
        self.df_dydot[pattern.column(col)].iter().all(|&x| x == 0.0)
    }

    /// Values of `shift · ∂F/∂y′ + ∂F/∂y` in the order of the pattern.
    fn combined<T: Scalar>(&self, shift: T) -> impl Iterator<Item = T> + '_ {
        self.df_dydot.iter().zip(&self.df_dy).map(move |(&dydot, &dy)| T::combine(shift, dydot, dy))
    }
}

/// One factored matrix: the blocks around the eliminated rows, and the kernel of the remainder.
struct Factor<T: Scalar> {
    borders: Borders<T>,
    kernel: Kernel<T>,
}

/// One of two kernels.
#[expect(clippy::large_enum_variant, reason = "a run holds at most four")]
enum Kernel<T: Scalar> {
    Dense(DenseLu<T>),
    Sparse(SparseLu<T>),
}

impl<T: Scalar> Factor<T> {
    /// Dense, unless there is a symbolic analysis.
    fn new(
        plan: &Elimination,
        n_entries: usize,
        symbolic: Option<&Symbolic>,
    ) -> Result<Self, SolveError> {
        let kernel = match symbolic {
            None => Kernel::Dense(DenseLu::new(plan.remainder())),
            Some(symbolic) => Kernel::Sparse(SparseLu::new(symbolic, plan.remainder())?),
        };
        Ok(Self { borders: Borders::new(plan, n_entries), kernel })
    }

    fn factor(
        &mut self,
        plan: &Elimination,
        jacobian: &Jacobian,
        shift: T,
    ) -> Result<(), Singular> {
        let values = self.borders.eliminate(plan, jacobian, shift)?;
        match &mut self.kernel {
            Kernel::Dense(lu) => lu.factor(values),
            Kernel::Sparse(lu) => lu.factor(plan.remainder(), values),
        }
    }

    fn solve_in_place(&mut self, plan: &Elimination, x: &mut [f64]) {
        let remainder = self.borders.reduce(plan, x);
        match &mut self.kernel {
            Kernel::Dense(lu) => lu.solve_in_place(remainder),
            Kernel::Sparse(lu) => lu.solve_in_place(remainder),
        }
        self.borders.complete(plan, x);
    }
}

/// The set of factored iteration matrices of one step size.
pub(crate) struct IterationMatrix(Method);

/// All matrices together, or one after the other.
enum Method {
    Together(Box<StaticLu>),
    Apart(Box<SeparateFactors>),
}

struct SeparateFactors {
    plan: Elimination,
    real: Factor<f64>,
    complex: Vec<Factor<c64>>,
}

impl IterationMatrix {
    /// Allocates for one real and `n_complex` complex matrices and analyses the pattern.
    pub(crate) fn new<S: System>(
        system: &S,
        n_complex: usize,
        solver: LinearSolver,
    ) -> Result<Self, SolveError> {
        let (pattern, explicit_rows) = (system.pattern(), system.explicit_rows());
        let is_index_3 = system.layout().index().contains(&Index::Three);
        let plan = Elimination::new(pattern, explicit_rows)?;
        let (n_entries, remainder) = (pattern.n_entries(), plan.remainder());
        let n = remainder.n();
        let fill = remainder.n_entries() as f64 / (n * n).max(1) as f64;
        let is_static = match solver {
            LinearSolver::Static => true,
            LinearSolver::Dense | LinearSolver::Sparse => false,
            LinearSolver::Auto if is_index_3 => false,
            LinearSolver::Auto => {
                n <= STATIC_UP_TO || (n <= SPARSE_STATIC_UP_TO && fill < STATIC_FILL)
            }
        };
        if is_static {
            let lu = StaticLu::new(pattern, explicit_rows);
            return Ok(Self(Method::Together(Box::new(lu))));
        }
        let is_dense = match solver {
            LinearSolver::Dense => true,
            LinearSolver::Sparse => false,
            _ => n <= DENSE_UP_TO || fill > DENSE_FILL,
        };
        let symbolic = if is_dense { None } else { Some(sparse::analyse(remainder)?) };
        let complex = (0..n_complex).map(|_| Factor::new(&plan, n_entries, symbolic.as_ref()));
        let complex = complex.collect::<Result<_, _>>()?;
        let real = Factor::new(&plan, n_entries, symbolic.as_ref())?;
        Ok(Self(Method::Apart(Box::new(SeparateFactors { plan, real, complex }))))
    }

    /// Factors `(γ/h) ∂F/∂y′ + ∂F/∂y` and the complex `(λ_k/h) ∂F/∂y′ + ∂F/∂y`.
    pub(crate) fn factor(
        &mut self,
        jacobian: &Jacobian,
        gamma: f64,
        lambda: &[c64],
        h: f64,
    ) -> Result<(), Singular> {
        match &mut self.0 {
            Method::Together(lu) => lu.factor(jacobian, gamma, lambda, h),
            Method::Apart(factors) => {
                let SeparateFactors { plan, real, complex } = factors.as_mut();
                real.factor(plan, jacobian, gamma / h)?;
                for (matrix, lambda) in complex.iter_mut().zip(lambda) {
                    matrix.factor(plan, jacobian, lambda / h)?;
                }
                Ok(())
            }
        }
    }

    /// Solves with the real matrix.
    pub(crate) fn solve_real(&mut self, x: &mut [f64]) {
        match &mut self.0 {
            Method::Together(lu) => lu.solve(x),
            Method::Apart(factors) => factors.real.solve_in_place(&factors.plan, x),
        }
    }

    /// Solves with all matrices of systems of `n` unknowns: `x` holds the right side of the real one,
    /// then for every complex one the real parts and the imaginary parts.
    pub(crate) fn solve_all(&mut self, n: usize, x: &mut [f64]) {
        match &mut self.0 {
            Method::Together(lu) => lu.solve(x),
            Method::Apart(factors) => {
                let SeparateFactors { plan, real, complex } = factors.as_mut();
                let (first, pairs) = x.split_at_mut(n);
                real.solve_in_place(plan, first);
                for (matrix, pair) in complex.iter_mut().zip(pairs.chunks_exact_mut(2 * n)) {
                    matrix.solve_in_place(plan, pair);
                }
            }
        }
    }

    /// Saves what the next factors depend on besides the Jacobian.
    pub(crate) fn save(&self, saver: &mut Saver) {
        if let Method::Together(lu) = &self.0 {
            lu.save(saver);
        }
    }

    pub(crate) fn load(&mut self, loader: &mut Loader<'_>) -> Result<(), SolveError> {
        match &mut self.0 {
            Method::Together(lu) => lu.load(loader),
            Method::Apart(_) => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests;
