//! The problem `0 = F(t, y, y′)`: the trait that a caller implements, and the shape of a system.

use std::ops::Range;
use std::sync::Arc;

use crate::error::SolveError;

/// An implicit system of differential-algebraic equations `0 = F(t, y, y′)` with `n` equations and
/// `n` unknowns.
///
/// `y′` may enter nonlinearly. Unknowns whose derivative does not appear (multipliers) are allowed;
/// their index is declared in [`Layout`].
pub trait System {
    /// The number of unknowns and the index of each.
    fn layout(&self) -> &Layout;

    /// The union of the sparsity patterns of `∂F/∂y` and `∂F/∂y′`.
    fn pattern(&self) -> &Pattern;

    /// Equations that give one unknown by the others, as `(row, unknown)`: in mechanisms
    /// `q′ − v = 0`, which gives the velocities. Their unknowns are eliminated before the iteration
    /// matrices are factored, which then have the size of what remains. None by default.
    ///
    /// Of a row named here, `∂F/∂y + s ∂F/∂y′` must be far from zero at its own unknown for every
    /// `s` (a constant ∂F/∂y without `y′` is best) and absent from the pattern at the unknowns of
    /// the other rows named. The same list must be returned throughout a run.
    fn explicit_rows(&self) -> &[(usize, usize)] {
        &[]
    }

    /// Writes `F(t, y, ydot)` to `out`; all slices have length `n`.
    ///
    /// # Errors
    /// [`NotFinite`] names the first row that has no finite value; the solver then retries with a
    /// smaller step. The solver checks `out` itself as well, so an implementation may leave the
    /// check to it.
    fn residual(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        out: &mut [f64],
    ) -> Result<(), NotFinite>;

    /// Writes `∂F/∂y` to `df_dy` and `∂F/∂y′` to `df_dydot`.
    ///
    /// Entry `k` of both arrays belongs to entry `k` of [`System::pattern`]; entries that are zero
    /// in one of the two matrices must be written as zero.
    ///
    /// # Errors
    /// [`NotFinite`] names the row of the first entry that has no finite value.
    fn jacobian(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        df_dy: &mut [f64],
        df_dydot: &mut [f64],
    ) -> Result<(), NotFinite>;
}

/// A borrowed system is one too, so that a run need not consume it.
impl<S: System + ?Sized> System for &mut S {
    fn layout(&self) -> &Layout {
        (**self).layout()
    }

    fn pattern(&self) -> &Pattern {
        (**self).pattern()
    }

    fn explicit_rows(&self) -> &[(usize, usize)] {
        (**self).explicit_rows()
    }

    fn residual(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        out: &mut [f64],
    ) -> Result<(), NotFinite> {
        (**self).residual(t, y, ydot, out)
    }

    fn jacobian(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        df_dy: &mut [f64],
        df_dydot: &mut [f64],
    ) -> Result<(), NotFinite> {
        (**self).jacobian(t, y, ydot, df_dy, df_dydot)
    }
}

/// An attempt at an explicit step, as it goes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Attempt {
    /// Attempt whose stages are about to be evaluated.
    Begun,
    /// It is a step of the run.
    Accepted {
        /// Where it repeats a larger one, the power of their size that their errors are in proportion to.
        power: Option<f64>,
    },
    /// Attempt whose error is too large.
    Rejected {
        /// Power of the step size in the error, as above.
        power: Option<f64>,
    },
}

/// An explicit system of ordinary differential equations `y′ = f(t, y)`, not stiff, for
/// [`crate::ExplicitSolver`].
///
/// A mechanism becomes one when its accelerations are solved from the multiplier system; its
/// constraints are then kept by [`Ode::project`].
pub trait Ode {
    /// The number of unknowns and their names; the indices are not read.
    fn layout(&self) -> &Layout;

    /// Writes `f(t, y)` to `ydot`.
    ///
    /// # Errors
    /// [`NotFinite`] names the first row that has no finite value; the solver then retries with a
    /// smaller step. The solver checks `ydot` itself as well.
    fn derivative(&mut self, t: f64, y: &[f64], ydot: &mut [f64]) -> Result<(), NotFinite>;

    /// Writes the vectors of [`record_step`](crate::record_step) to `results`, where there is straight-line code for
    /// a whole step from `(t, y)` and all numbers are finite; false where the step must be taken stage by stage, as it
    /// must by default. What is written must equal what stages give. `results` takes as many numbers as the system
    /// likes, those of the vectors first.
    fn whole_step(
        &mut self,
        _span: StepSpan,
        _y: &[f64],
        _ydot: &[f64],
        _results: &mut Vec<f64>,
    ) -> bool {
        false
    }

    /// Writes the projected end, at `t1`, of the step that [`Ode::whole_step`] has taken last and its derivative, where
    /// they follow from its `results` and are finite; false, with nothing written, where [`Ode::project`] and
    /// [`Ode::derivative`] must find them.
    fn whole_end(
        &mut self,
        _t1: f64,
        _results: &[f64],
        _y1: &mut [f64],
        _ydot1: &mut [f64],
    ) -> bool {
        false
    }

    /// Takes note of how the attempts at steps go. What [`Ode::derivative`] continues the equations by, away from
    /// their solutions, may change between two of them, but not within one. By default nothing is done.
    fn note(&mut self, _attempt: Attempt) {}

    /// Moves the end of an accepted step back to the invariants of the equations, by a change of
    /// the size of the error tolerance. The next derivative is evaluated there anyway, so that
    /// this costs no other evaluation. By default nothing is done.
    ///
    /// # Errors
    /// [`NotFinite`] when there is no such state nearby; the step is then tried again, smaller.
    fn project(&mut self, _t: f64, _y: &mut [f64]) -> Result<(), NotFinite> {
        Ok(())
    }
}

/// Where a step lies.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct StepSpan {
    /// Start of the step.
    pub t: f64,
    /// Size of the step, signed.
    pub h: f64,
    /// End of the step, `t + h` but for rounding.
    pub t1: f64,
}

/// A borrowed system is one too, so that a run need not consume it.
impl<S: Ode + ?Sized> Ode for &mut S {
    fn layout(&self) -> &Layout {
        (**self).layout()
    }

    fn derivative(&mut self, t: f64, y: &[f64], ydot: &mut [f64]) -> Result<(), NotFinite> {
        (**self).derivative(t, y, ydot)
    }

    fn whole_step(
        &mut self,
        span: StepSpan,
        y: &[f64],
        ydot: &[f64],
        results: &mut Vec<f64>,
    ) -> bool {
        (**self).whole_step(span, y, ydot, results)
    }

    fn whole_end(&mut self, t1: f64, results: &[f64], y1: &mut [f64], ydot1: &mut [f64]) -> bool {
        (**self).whole_end(t1, results, y1, ydot1)
    }

    fn note(&mut self, attempt: Attempt) {
        (**self).note(attempt);
    }

    fn project(&mut self, t: f64, y: &mut [f64]) -> Result<(), NotFinite> {
        (**self).project(t, y)
    }
}

/// A row of the residual or of its Jacobian has no finite value at the point asked for.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("equation {row} has no finite value")]
pub struct NotFinite {
    /// Row of `F`, counted from zero.
    pub row: usize,
}

/// How often the equations must be differentiated until they determine the derivative of an
/// unknown (differentiation index of HW2 §VII.1), which decides how its error is weighed.
///
/// An error of an index-2 unknown is multiplied by `h`, of an index-3 unknown by `h²`, before it is
/// compared with the tolerance, as in `RADAU5`: such unknowns carry errors `1/h` and `1/h²` larger
/// that do not act on the others.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub enum Index {
    /// Differential unknowns (index 0) and algebraic ones that their equation determines (index 1).
    #[default]
    One,
    /// Velocities of a mechanism in index-3 form; multipliers in index-2 form.
    Two,
    /// Multipliers of a mechanism in index-3 form.
    Three,
}

impl Index {
    /// The power of `h` that weighs errors of such an unknown.
    pub(crate) fn power(self) -> i32 {
        match self {
            Self::One => 0,
            Self::Two => 1,
            Self::Three => 2,
        }
    }
}

/// The unknowns of a system: how many, the index of each, and optionally their names.
/// Copies share them.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Layout {
    index: Arc<[Index]>,
    names: Arc<[String]>,
}

impl Layout {
    /// One entry per unknown.
    pub fn new(index: Vec<Index>) -> Self {
        Self { index: index.into(), names: Arc::default() }
    }

    /// Consecutive groups of unknowns of equal index, as `[(nq, Index::One), (nv, Index::Two), …]`.
    pub fn from_groups(groups: &[(usize, Index)]) -> Self {
        Self::new(
            groups.iter().flat_map(|&(count, index)| std::iter::repeat_n(index, count)).collect(),
        )
    }

    /// Names the unknowns; messages use them where present. Missing names fall back to `y[i]`.
    #[must_use]
    pub fn with_names(mut self, names: Vec<String>) -> Self {
        self.names = names.into();
        self
    }

    /// Number of unknowns.
    pub fn n(&self) -> usize {
        self.index.len()
    }

    /// Index of each unknown.
    pub fn index(&self) -> &[Index] {
        &self.index
    }

    /// The name of unknown `i`, or `y[i]`.
    pub fn name(&self, i: usize) -> String {
        self.names.get(i).cloned().unwrap_or_else(|| format!("y[{i}]"))
    }
}

/// A square sparsity pattern in compressed column form: rows ascend within a column.
///
/// ```
/// let pattern = bksim_dae::Pattern::new(2, [(1, 0), (0, 1), (0, 0)])?;
/// assert_eq!(pattern.entries().collect::<Vec<_>>(), [(0, 0), (1, 0), (0, 1)]);
/// assert_eq!(pattern.position(0, 1), Some(2));
/// # Ok::<(), bksim_dae::SolveError>(())
/// ```
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Pattern {
    n: usize,
    col_ptr: Vec<usize>,
    row_idx: Vec<usize>,
}

impl Pattern {
    /// The pattern of an `n × n` matrix with the given `(row, column)` entries, in any order;
    /// repeated entries count once.
    ///
    /// # Errors
    /// [`SolveError::EntryOutside`] when a row or column is not below `n`.
    pub fn new(
        n: usize,
        entries: impl IntoIterator<Item = (usize, usize)>,
    ) -> Result<Self, SolveError> {
        let mut by_column: Vec<(usize, usize)> =
            entries.into_iter().map(|(row, col)| (col, row)).collect();
        if let Some(&(col, row)) = by_column.iter().find(|&&(col, row)| col >= n || row >= n) {
            return Err(SolveError::EntryOutside { row, col, n });
        }
        by_column.sort_unstable();
        by_column.dedup();

        let mut col_ptr = vec![0; n + 1];
        for &(col, _) in &by_column {
            col_ptr[col + 1] += 1;
        }
        for col in 0..n {
            col_ptr[col + 1] += col_ptr[col];
        }
        Ok(Self { n, col_ptr, row_idx: by_column.into_iter().map(|(_, row)| row).collect() })
    }

    /// The pattern of a full `n × n` matrix; values are then stored by columns.
    pub fn dense(n: usize) -> Self {
        Self {
            n,
            col_ptr: (0..=n).map(|col| col * n).collect(),
            row_idx: (0..n * n).map(|k| k % n).collect(),
        }
    }

    /// Number of rows and of columns.
    pub fn n(&self) -> usize {
        self.n
    }

    /// Number of entries.
    pub fn n_entries(&self) -> usize {
        self.row_idx.len()
    }

    /// All entries as `(row, column)`, in the order in which values are stored.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (0..self.n)
            .flat_map(move |col| self.row_idx[self.column(col)].iter().map(move |&r| (r, col)))
    }

    /// Where the value of `(row, col)` is stored, if it is part of the pattern.
    pub fn position(&self, row: usize, col: usize) -> Option<usize> {
        let range = (col < self.n).then(|| self.column(col))?;
        self.row_idx[range.clone()].binary_search(&row).ok().map(|k| range.start + k)
    }

    /// Positions of the entries of one column.
    pub(crate) fn column(&self, col: usize) -> Range<usize> {
        self.col_ptr[col]..self.col_ptr[col + 1]
    }

    /// Start of each column, `n + 1` numbers.
    pub(crate) fn col_ptr(&self) -> &[usize] {
        &self.col_ptr
    }

    /// Row of each entry.
    pub(crate) fn row_idx(&self) -> &[usize] {
        &self.row_idx
    }
}
