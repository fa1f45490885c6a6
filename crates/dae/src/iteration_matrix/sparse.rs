//! Sparse LU by `faer`: ordering and symbolic analysis once, numeric factorisation per step size.

use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::lu::{
    LuRef, LuSymbolicParams, NumericLu, SymbolicLu, factorize_symbolic_lu,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Spec};

use super::{Scalar, Singular};
use crate::error::SolveError;
use crate::system::Pattern;

fn symbolic_matrix(pattern: &Pattern) -> SymbolicSparseColMatRef<'_, usize> {
    let n = pattern.n();
    SymbolicSparseColMatRef::new_checked(n, n, pattern.col_ptr(), None, pattern.row_idx())
}

/// Ordering and symbolic analysis.
pub(super) type Symbolic = Arc<SymbolicLu<usize>>;

/// The ordering, shared by the real and the complex factors.
///
/// The supernodal kernel never paid for the patterns of mechanisms, so the simplicial one is
/// forced.
pub(super) fn analyse(pattern: &Pattern) -> Result<Symbolic, SolveError> {
    let params = LuSymbolicParams {
        supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SIMPLICIAL,
        ..LuSymbolicParams::default()
    };
    factorize_symbolic_lu(symbolic_matrix(pattern), params)
        .map(Arc::new)
        .map_err(|_| SolveError::OutOfMemory { n: pattern.n() })
}

/// One sparse matrix and its factors.
pub(super) struct SparseLu<T> {
    symbolic: Symbolic,
    numeric: NumericLu<usize, T>,
    probe: Vec<T>,
    stack: MemBuffer,
}

impl<T: Scalar> SparseLu<T> {
    pub(super) fn new(symbolic: &Symbolic, pattern: &Pattern) -> Result<Self, SolveError> {
        let request = symbolic
            .factorize_numeric_lu_scratch::<T>(Par::Seq, Spec::default())
            .or(symbolic.solve_in_place_scratch::<T>(1, Par::Seq));
        let stack =
            MemBuffer::try_new(request).map_err(|_| SolveError::OutOfMemory { n: pattern.n() })?;
        Ok(Self {
            symbolic: Arc::clone(symbolic),
            numeric: NumericLu::new(),
            probe: vec![T::ZERO; pattern.n()],
            stack,
        })
    }

    /// Factors the matrix whose `values` follow the entries of `pattern`.
    pub(super) fn factor(&mut self, pattern: &Pattern, values: &[T]) -> Result<(), Singular> {
        let matrix = SparseColMatRef::new(symbolic_matrix(pattern), values);
        let stack = MemStack::new(&mut self.stack);
        self.symbolic
            .factorize_numeric_lu(&mut self.numeric, matrix, Par::Seq, stack, Spec::default())
            .map_err(|_| Singular)?;

        // faer divides by a vanishing pivot without an error: a solution shows it.
        let mut probe = std::mem::take(&mut self.probe);
        probe.fill(T::ONE);
        self.solve_in_place(&mut probe);
        let is_regular = probe.iter().all(|x| x.magnitude().is_finite());
        self.probe = probe;
        if is_regular { Ok(()) } else { Err(Singular) }
    }

    /// Only valid after a successful [`SparseLu::factor`].
    pub(super) fn solve_in_place(&mut self, x: &mut [T]) {
        let n = x.len();
        LuRef::new_unchecked(&self.symbolic, &self.numeric).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(x, n, 1),
            Par::Seq,
            MemStack::new(&mut self.stack),
        );
    }
}
