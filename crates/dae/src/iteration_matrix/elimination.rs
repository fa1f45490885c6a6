//! Elimination of explicit rows, which are solved for their unknowns before anything is factored.
//!
//! ```text
//! ( D  B ) (u)   (b_e)      D diagonal: row k of the first group holds one unknown of u, its own
//! ( C  R ) (x) = (b_r)
//! (R − C D⁻¹ B) x = b_r − C D⁻¹ b_e,     u = D⁻¹ (b_e − B x)
//! ```
//!
//! In a mechanism `u` are the velocities, `D = −1`, `B = λ/h` on the positions: the remainder has
//! the size of positions and multipliers (HW2 §IV.8, equations of second order). The entries that
//! each product changes are found once.

use super::{Jacobian, Scalar, Singular};
use crate::error::SolveError;
use crate::system::Pattern;

/// The pattern of the elimination; the same for all matrices of a run.
pub(super) struct Elimination {
    n: usize,
    pivots: Vec<Pivot>,
    /// Rows and unknowns of `R`, in their order.
    rows: Vec<usize>,
    unknowns: Vec<usize>,
    /// Pattern of `R − C D⁻¹ B`.
    remainder: Pattern,
    /// Entry of the full pattern and of the remainder's, for every entry of `R`.
    kept: Vec<(usize, usize)>,
    /// Entries of `B` by rows and of `C` by columns, pivot after pivot.
    b: Border,
    c: Border,
    /// Entries of the remainder that the products `C D⁻¹ B` change: by pivot, entry of `C`, entry
    /// of `B`.
    products: Vec<usize>,
}

/// One explicit row, the unknown it gives, and its entry of the pattern.
struct Pivot {
    row: usize,
    unknown: usize,
    entry: usize,
}

/// Entries in the rows (of `B`) or columns (of `C`) of the pivots: those of pivot `k` are
/// `start[k]..start[k + 1]`.
struct Border {
    start: Vec<usize>,
    /// Column (of `B`) or row (of `C`) within the remainder.
    at: Vec<usize>,
    /// Entry of the full pattern.
    entry: Vec<usize>,
}

impl Border {
    /// Sorts `(pivot, position, entry)` by pivots.
    fn new(n_pivots: usize, mut all: Vec<(usize, usize, usize)>) -> Self {
        all.sort_unstable();
        let start = (0..=n_pivots).map(|k| all.partition_point(|&(pivot, ..)| pivot < k)).collect();
        let (at, entry) = all.into_iter().map(|(_, at, entry)| (at, entry)).unzip();
        Self { start, at, entry }
    }

    fn of(&self, k: usize) -> std::ops::Range<usize> {
        self.start[k]..self.start[k + 1]
    }
}

/// The group that a row or an unknown belongs to, with its index there.
#[derive(Clone, Copy)]
enum Group {
    Pivot(usize),
    Remainder(usize),
}

/// Groups of all rows or all unknowns, and those that remain; `None` when one is named twice or
/// lies outside.
fn groups(n: usize, pivots: impl Iterator<Item = usize>) -> Option<(Vec<Group>, Vec<usize>)> {
    let mut pivot_of = vec![None; n];
    for (k, i) in pivots.enumerate() {
        if pivot_of.get_mut(i)?.replace(k).is_some() {
            return None;
        }
    }
    let mut remaining = Vec::with_capacity(n);
    let mut groups = Vec::with_capacity(n);
    for (i, pivot) in pivot_of.into_iter().enumerate() {
        groups.push(pivot.map_or(Group::Remainder(remaining.len()), Group::Pivot));
        if pivot.is_none() {
            remaining.push(i);
        }
    }
    Some((groups, remaining))
}

impl Elimination {
    /// Sorts the entries of a pattern by blocks, and finds the pattern of the remainder.
    ///
    /// # Errors
    /// [`SolveError::ExplicitRow`] when the pattern shows that a row does not give its unknown.
    pub(super) fn new(pattern: &Pattern, explicit: &[(usize, usize)]) -> Result<Self, SolveError> {
        // Groups of rows and unknowns.
        let n = pattern.n();
        let refuse = |(row, unknown), reason| SolveError::ExplicitRow { row, unknown, reason };
        let repeated = || {
            let outside = |&&(row, unknown): &&(usize, usize)| row >= n || unknown >= n;
            let named = explicit.iter().find(outside).or(explicit.last());
            let named = named.expect("only a row that is named can be refused");
            refuse(*named, "is named twice, or outside the system")
        };
        let (row_groups, rows) =
            groups(n, explicit.iter().map(|&(row, _)| row)).ok_or_else(repeated)?;
        let (unknown_groups, unknowns) =
            groups(n, explicit.iter().map(|&(_, unknown)| unknown)).ok_or_else(repeated)?;

        // Entries by the block in which they lie.
        let (mut b, mut c, mut r) = (Vec::new(), Vec::new(), Vec::new());
        for (entry, (row, col)) in pattern.entries().enumerate() {
            match (row_groups[row], unknown_groups[col]) {
                (Group::Pivot(k), Group::Pivot(l)) if k == l => (),
                (Group::Pivot(k), Group::Pivot(_)) => {
                    return Err(refuse(explicit[k], "holds the unknown of another explicit row"));
                }
                (Group::Pivot(k), Group::Remainder(col)) => b.push((k, col, entry)),
                (Group::Remainder(row), Group::Pivot(k)) => c.push((k, row, entry)),
                (Group::Remainder(row), Group::Remainder(col)) => r.push((row, col, entry)),
            }
        }
        // Each pivot is the entry of its row at its unknown.
        let pivot = |&(row, unknown): &(usize, usize)| {
            let entry = pattern.position(row, unknown);
            let entry = entry.ok_or_else(|| refuse((row, unknown), "does not hold it"))?;
            Ok(Pivot { row, unknown, entry })
        };
        let pivots = explicit.iter().map(pivot).collect::<Result<Vec<_>, SolveError>>()?;
        let (b, c) = (Border::new(pivots.len(), b), Border::new(pivots.len(), c));

        // The pattern of the remainder: its own entries and those that the products add.
        let filled = |k: usize| {
            let columns = &b.at[b.of(k)];
            c.at[c.of(k)].iter().flat_map(move |&row| columns.iter().map(move |&col| (row, col)))
        };
        let fill = || (0..pivots.len()).flat_map(filled);
        let own = r.iter().map(|&(row, col, _)| (row, col));
        let remainder = Pattern::new(rows.len(), own.chain(fill()))?;
        let position =
            |row, col| remainder.position(row, col).expect("the pattern was made of these entries");
        let kept = r.iter().map(|&(row, col, entry)| (entry, position(row, col))).collect();
        let products = fill().map(|(row, col)| position(row, col)).collect();
        Ok(Self { n, pivots, rows, unknowns, remainder, kept, b, c, products })
    }

    pub(super) fn remainder(&self) -> &Pattern {
        &self.remainder
    }
}

/// The numbers of one matrix, and buffers of its solution.
pub(super) struct Borders<T> {
    /// `D⁻¹`, `D⁻¹ B` and `C`.
    inverse: Vec<T>,
    b: Vec<T>,
    c: Vec<T>,
    /// All values of the matrix, and of its remainder.
    full: Vec<T>,
    remainder: Vec<T>,
    /// Right side, then solution: of the pivots, of the remainder.
    u: Vec<T>,
    x: Vec<T>,
}

impl<T: Scalar> Borders<T> {
    pub(super) fn new(plan: &Elimination, n_entries: usize) -> Self {
        let zeros = |n: usize| vec![T::ZERO; n];
        Self {
            inverse: zeros(plan.pivots.len()),
            b: zeros(plan.b.at.len()),
            c: zeros(plan.c.at.len()),
            full: zeros(n_entries),
            remainder: zeros(plan.remainder.n_entries()),
            u: zeros(plan.pivots.len()),
            x: zeros(plan.rows.len()),
        }
    }

    /// Eliminates; returns the values of the remainder.
    pub(super) fn eliminate(
        &mut self,
        plan: &Elimination,
        jacobian: &Jacobian,
        shift: T,
    ) -> Result<&[T], Singular> {
        for (value, combined) in self.full.iter_mut().zip(jacobian.combined(shift)) {
            *value = combined;
        }
        for (k, pivot) in plan.pivots.iter().enumerate() {
            let inverse = self.full[pivot.entry].reciprocal();
            if !(inverse.magnitude() > 0.0 && inverse.magnitude().is_finite()) {
                return Err(Singular);
            }
            self.inverse[k] = inverse;
            for i in plan.b.of(k) {
                self.b[i] = self.full[plan.b.entry[i]] * inverse;
            }
        }
        for (c, &entry) in self.c.iter_mut().zip(&plan.c.entry) {
            *c = self.full[entry];
        }

        // R − C (D⁻¹ B).
        self.remainder.fill(T::ZERO);
        for &(entry, target) in &plan.kept {
            self.remainder[target] = self.full[entry];
        }
        let mut targets = plan.products.iter();
        for k in 0..plan.pivots.len() {
            let b = &self.b[plan.b.of(k)];
            for &c in &self.c[plan.c.of(k)] {
                for (&b, &target) in b.iter().zip(targets.by_ref()) {
                    self.remainder[target] -= c * b;
                }
            }
        }
        Ok(&self.remainder)
    }

    /// Splits the right side `b` and eliminates in it; returns that of the remainder, to be
    /// replaced by its solution.
    pub(super) fn reduce(&mut self, plan: &Elimination, b: &[f64]) -> &mut [T] {
        for (x, &row) in self.x.iter_mut().zip(&plan.rows) {
            *x = T::load(b, row, plan.n);
        }
        for (k, pivot) in plan.pivots.iter().enumerate() {
            let u = T::load(b, pivot.row, plan.n) * self.inverse[k];
            self.u[k] = u;
            let entries = plan.c.of(k);
            for (&c, &at) in self.c[entries.clone()].iter().zip(&plan.c.at[entries]) {
                self.x[at] -= c * u;
            }
        }
        &mut self.x
    }

    /// Completes the solution of the remainder and writes all of it.
    pub(super) fn complete(&mut self, plan: &Elimination, out: &mut [f64]) {
        for (k, pivot) in plan.pivots.iter().enumerate() {
            let mut u = self.u[k];
            let entries = plan.b.of(k);
            for (&b, &at) in self.b[entries.clone()].iter().zip(&plan.b.at[entries]) {
                u -= b * self.x[at];
            }
            u.store(out, pivot.unknown, plan.n);
        }
        for (x, &unknown) in self.x.iter().zip(&plan.unknowns) {
            x.store(out, unknown, plan.n);
        }
    }
}
