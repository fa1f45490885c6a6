//! The order of pivots of a small sparse matrix, and the elimination in that order as a list of
//! products.
//!
//! Pivots are chosen after Markowitz among the entries that are not small in their column: I. S. Duff,
//! A. M. Erisman, J. K. Reid, *Direct Methods for Sparse Matrices*, 2nd ed., Oxford 2017, §5.2 and §7.2.

use super::Singular;
use crate::system::Pattern;

/// Row and column of one pivot.
pub(super) type Pivot = (usize, usize);

/// An entry this much smaller than the largest of its column is no pivot.
const THRESHOLD: f64 = 0.1;

/// The pivots of a matrix whose `values` follow the pattern, in their order; the first ones are given.
///
/// # Errors
/// [`Singular`] when no pivot is left.
pub(super) fn choose(
    pattern: &Pattern,
    first: &[Pivot],
    values: impl Iterator<Item = f64>,
) -> Result<Vec<Pivot>, Singular> {
    let n = pattern.n();
    let mut rest = Remainder::new(pattern, values);
    let mut order = Vec::with_capacity(n);
    for k in 0..n {
        let pivot = match first.get(k) {
            Some(&given) => given,
            None => rest.best().ok_or(Singular)?,
        };
        rest.eliminate(pivot);
        order.push(pivot);
    }
    Ok(order)
}

/// The part of a matrix that is not eliminated yet.
struct Remainder {
    n: usize,
    /// By rows.
    values: Vec<f64>,
    /// Columns of the entries of each row; none of a row that is eliminated.
    columns: Vec<Vec<usize>>,
    /// Entries of each column.
    counts: Vec<usize>,
    largest: Vec<f64>,
}

impl Remainder {
    fn new(pattern: &Pattern, values: impl Iterator<Item = f64>) -> Self {
        let n = pattern.n();
        let mut rest = Self {
            n,
            values: vec![0.0; n * n],
            columns: vec![Vec::new(); n],
            counts: vec![0; n],
            largest: vec![0.0; n],
        };
        for ((row, col), value) in pattern.entries().zip(values) {
            rest.values[row * n + col] = value;
            rest.columns[row].push(col);
            rest.counts[col] += 1;
        }
        rest
    }

    /// The entry with least fill among those that are not small; the larger of equals.
    fn best(&mut self) -> Option<Pivot> {
        self.largest.fill(0.0);
        for (row, columns) in self.columns.iter().enumerate() {
            for &col in columns {
                let size = self.values[row * self.n + col].abs();
                self.largest[col] = self.largest[col].max(size);
            }
        }
        let mut best: Option<(usize, f64, Pivot)> = None;
        for (row, columns) in self.columns.iter().enumerate() {
            for &col in columns {
                let part = self.values[row * self.n + col].abs() / self.largest[col];
                let fill = (columns.len() - 1) * (self.counts[col] - 1);
                let is_better = |&(least, most, _): &(usize, f64, Pivot)| {
                    fill < least || (fill == least && part > most)
                };
                // Comparisons with NaN, of a column of zeros, are false.
                if part >= THRESHOLD && best.as_ref().is_none_or(is_better) {
                    best = Some((fill, part, (row, col)));
                }
            }
        }
        best.map(|(.., pivot)| pivot)
    }

    fn eliminate(&mut self, (row, col): Pivot) {
        let n = self.n;
        let of_pivot = std::mem::take(&mut self.columns[row]);
        for &j in &of_pivot {
            self.counts[j] -= 1;
        }
        for i in 0..n {
            let Some(at) = self.columns[i].iter().position(|&j| j == col) else { continue };
            self.columns[i].swap_remove(at);
            let factor = self.values[i * n + col] / self.values[row * n + col];
            for &j in of_pivot.iter().filter(|&&j| j != col) {
                if !self.columns[i].contains(&j) {
                    self.columns[i].push(j);
                    self.counts[j] += 1;
                }
                self.values[i * n + j] -= factor * self.values[row * n + j];
            }
        }
    }
}

/// An elimination as straight-line code over numbered places: those of the pattern's entries in their
/// order, then those of the fill.
#[derive(Default)]
pub(super) struct Program {
    pub(super) order: Vec<Pivot>,
    pub(super) n_places: usize,
    pub(super) steps: Vec<Step>,
    /// Of `L`, by columns: the place of each entry, and the step whose pivot has its row.
    pub(super) l: Vec<Entry>,
    /// Of `U`, by rows: the place of each entry, and the step whose pivot has its column.
    pub(super) u: Vec<Entry>,
    /// Places that the products of each step change, by entries of `L`, then of `U`.
    pub(super) targets: Vec<usize>,
}

/// Ranges of one pivot, each from the end of that of the step before.
#[derive(Clone, Copy)]
pub(super) struct Step {
    pub(super) pivot: usize,
    pub(super) l_end: usize,
    pub(super) u_end: usize,
}

#[derive(Clone, Copy)]
pub(super) struct Entry {
    pub(super) place: usize,
    pub(super) step: usize,
}

impl Program {
    /// The elimination of a pattern in an order of pivots, which must be entries when their turn comes.
    pub(super) fn new(pattern: &Pattern, order: Vec<Pivot>) -> Option<Self> {
        const NONE: usize = usize::MAX;
        let n = pattern.n();
        let (mut step_of_row, mut step_of_column) = (vec![NONE; n], vec![NONE; n]);
        for (k, &(row, col)) in order.iter().enumerate() {
            *step_of_row.get_mut(row)? = k;
            *step_of_column.get_mut(col)? = k;
        }
        if order.len() != n || step_of_row.contains(&NONE) || step_of_column.contains(&NONE) {
            return None;
        }
        // Places of the entries, rows and columns numbered by their steps.
        let mut places = vec![NONE; n * n];
        for (place, (row, col)) in pattern.entries().enumerate() {
            places[step_of_row[row] * n + step_of_column[col]] = place;
        }
        let mut program = Self { n_places: pattern.n_entries(), ..Self::default() };
        for k in 0..n {
            let pivot = places[k * n + k];
            if pivot == NONE {
                return None;
            }
            let below = (k + 1..n).filter(|&i| places[i * n + k] != NONE);
            let right = (k + 1..n).filter(|&j| places[k * n + j] != NONE);
            let (below, right): (Vec<_>, Vec<_>) = (below.collect(), right.collect());
            let entries = |steps: &[usize], at: &dyn Fn(usize) -> usize| -> Vec<Entry> {
                steps.iter().map(|&step| Entry { place: places[at(step)], step }).collect()
            };
            program.l.extend(entries(&below, &|i| i * n + k));
            program.u.extend(entries(&right, &|j| k * n + j));
            for &i in &below {
                for &j in &right {
                    let target = &mut places[i * n + j];
                    if *target == NONE {
                        *target = program.n_places;
                        program.n_places += 1;
                    }
                    program.targets.push(*target);
                }
            }
            let (l_end, u_end) = (program.l.len(), program.u.len());
            program.steps.push(Step { pivot, l_end, u_end });
        }
        program.order = order;
        Some(program)
    }
}
