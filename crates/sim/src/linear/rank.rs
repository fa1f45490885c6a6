//! Which rows of a sparse matrix depend on rows before them.
//!
//! ```text
//! rows freed of their parts along the independent rows before:   G Gᵀ = L D Lᵀ,   D_k = |rest of row k|²
//! ```
//!
//! Gram and Schmidt's process by the factors of their products, which stay sparse where the rows
//! freed of each other do not. One row of L at a time: T. A. Davis, *Algorithm 849: A concise sparse
//! Cholesky factorization package*, ACM Trans. Math. Softw. 31 (2005).

use crate::linear::dense::{self, DEPENDENT, Dependence, RANK_TOLERANCE};
use crate::linear::rows::{LARGEST_DENSE, SparseRows};

/// Squared part of a row below which its rest is found again: the products hold it to half the
/// digits only.
const DOUBTFUL: f64 = 1e-4;

/// Parts of a row that count as nothing.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Smallness {
    /// A row depends on others when less than this part of it is left.
    pub(crate) rest: f64,
    /// A row has no part in a dependency when it enters with less than this.
    pub(crate) part: f64,
}

/// Rows of `jacobian` that depend on rows before them, and all rows that take part in a dependency.
///
/// Rows are scaled to unit length first, so that units do not decide. Small matrices are dense: that
/// process tells weak rows from dependent ones more finely.
pub(crate) fn dependent_rows(jacobian: &SparseRows) -> Dependence {
    if jacobian.n_columns > LARGEST_DENSE {
        sparse_dependent_rows(jacobian, ROUNDING)
    } else {
        dense_dependent_rows(jacobian)
    }
}

/// Dependent rows by dense elimination, for which rows of zeros, as of the many open contacts of a pile, are left out.
fn dense_dependent_rows(jacobian: &SparseRows) -> Dependence {
    let is_row = |&row: &usize| jacobian.row(row).iter().any(|&(_, g)| g != 0.0);
    let rows: Vec<usize> = (0..jacobian.n_rows()).filter(is_row).collect();
    if rows.len() == jacobian.n_rows() {
        return dense::dependent_rows(&jacobian.dense());
    }
    let found = dense::dependent_rows(&jacobian.select(&rows).dense());
    // They follow from any others, and take no part.
    let with_empty = |some: &[usize]| {
        let mut marked = vec![true; jacobian.n_rows()];
        for &row in &rows {
            marked[row] = false;
        }
        for &k in some {
            marked[rows[k]] = true;
        }
        (0..marked.len()).filter(|&row| marked[row]).collect()
    };
    let (dependent, involved) = (with_empty(&found.dependent), with_empty(&found.involved));
    Dependence { rank: found.rank, dependent, involved }
}

/// Remainders of dependent rows in a pose that is closed to rounding.
const ROUNDING: Smallness = Smallness { rest: DEPENDENT, part: 1e-6 };

/// Dependent rows ([`dependent_rows`]) by sparse elimination, with its own notion of nothing.
pub(crate) fn sparse_dependent_rows(jacobian: &SparseRows, smallness: Smallness) -> Dependence {
    let norms = jacobian.norms();
    let longest = norms.iter().copied().fold(0.0, f64::max);
    let mut basis = Basis::new(jacobian.n_columns);
    let mut dependent = Vec::new();
    let mut involved = vec![false; jacobian.n_rows()];
    for (row_idx, &norm) in norms.iter().enumerate() {
        // A row of rounding errors constrains nothing in this pose.
        let is_row = norm > RANK_TOLERANCE * longest;
        let row = jacobian.row(row_idx).iter().map(|&(column, g)| (column, g / norm));
        let row: Vec<(usize, f64)> = row.filter(|_| is_row).collect();
        // Rows of open contacts are rows of zeros: they follow from any others, and take no part.
        if row.is_empty() {
            dependent.push(row_idx);
            involved[row_idx] = true;
            continue;
        }
        if let Err(combination) = basis.add(row_idx, &row, smallness.rest) {
            dependent.push(row_idx);
            involved[row_idx] = true;
            for (&partner, part) in basis.independent.iter().zip(combination) {
                involved[partner] |= part.abs() > smallness.part;
            }
        }
    }
    let involved = (0..jacobian.n_rows()).filter(|&row| involved[row]).collect();
    Dependence { rank: basis.independent.len(), dependent, involved }
}

/// Up to `n` rows, ascending: those that are `kept`, which are independent, then each the one of which the most is left
/// without those chosen before it, so that they are far from depending on each other. Rows of zeros are never chosen.
pub(crate) fn best_rows(rows: &SparseRows, kept: &[usize], n: usize) -> Vec<usize> {
    let mut rests: Vec<Vec<(usize, f64)>> =
        (0..rows.n_rows()).map(|row| rows.row(row).to_vec()).collect();
    let square = |row: &[(usize, f64)]| row.iter().map(|(_, g)| g * g).sum::<f64>();
    let mut chosen = Vec::with_capacity(n);
    let mut dense = vec![0.0; rows.n_columns];
    while chosen.len() < n {
        let largest = (0..rests.len())
            .max_by(|&a, &b| square(&rests[a]).total_cmp(&square(&rests[b])).then(b.cmp(&a)));
        let next = kept.get(chosen.len()).copied().or(largest);
        let Some(best) = next.filter(|&best| square(&rests[best]) > 0.0) else { break };
        let norm = square(&rests[best]).sqrt();
        let direction: Vec<_> = rests[best].iter().map(|&(i, g)| (i, g / norm)).collect();
        chosen.push(best);
        rests[best].clear();
        // The others without their parts along it; rows that do not meet it stay as they are.
        for &(i, g) in &direction {
            dense[i] = g;
        }
        for rest in &mut rests {
            let along: f64 = rest.iter().map(|&(i, g)| g * dense[i]).sum();
            if along != 0.0 {
                for (i, g) in rest.iter_mut() {
                    *g -= along * dense[*i];
                }
                let missing = direction.iter().filter(|(i, _)| rest.iter().all(|(j, _)| j != i));
                let missing: Vec<_> = missing.map(|&(i, g)| (i, -along * g)).collect();
                rest.extend(missing);
            }
        }
        for &(i, _) in &direction {
            dense[i] = 0.0;
        }
    }
    chosen.sort_unstable();
    chosen
}

/// A basis of the combinations of rows that vanish, each by its rows and their factors: one for each row
/// that depends on rows before it. Rows that combine to nothing but rounding count as dependent.
///
/// Rows are scaled to unit length first, so that units do not decide.
pub(crate) fn vanishing_combinations(rows: &SparseRows) -> Vec<Vec<(usize, f64)>> {
    let norms = rows.norms();
    let mut basis = Basis::new(rows.n_columns);
    let mut found = Vec::new();
    for (row_idx, &norm) in norms.iter().enumerate() {
        let row: Vec<_> = rows.row(row_idx).iter().map(|&(column, g)| (column, g / norm)).collect();
        if let Err(combination) = basis.add(row_idx, &row, ROUNDING.rest) {
            let others = basis.independent.iter().zip(combination).filter(|(_, part)| *part != 0.0);
            let others = others.map(|(&other, part)| (other, -part / norms[other]));
            found.push(others.chain([(row_idx, 1.0 / norm)]).collect());
        }
    }
    found
}

/// Independent rows, and L D Lᵀ of their products.
struct Basis {
    /// Numbers of the rows.
    independent: Vec<usize>,
    rows: SparseRows,
    /// By column of the rows: which of them have an entry there, and the entry.
    of_column: Vec<Vec<(usize, f64)>>,
    /// Columns of L below the diagonal.
    lower: Vec<Vec<(usize, f64)>>,
    diagonal: Vec<f64>,
    /// The first entry below the diagonal in each column: the elimination tree.
    parent: Vec<Option<usize>>,
    /// One number for each row, zero between uses.
    y: Vec<f64>,
    is_reached: Vec<bool>,
}

impl Basis {
    fn new(n_columns: usize) -> Self {
        Self {
            independent: Vec::new(),
            rows: SparseRows::new(n_columns),
            of_column: vec![Vec::new(); n_columns],
            lower: Vec::new(),
            diagonal: Vec::new(),
            parent: Vec::new(),
            y: Vec::new(),
            is_reached: Vec::new(),
        }
    }

    /// Adds a row, or says by which combination of the independent ones it follows from them.
    fn add(&mut self, row_idx: usize, row: &[(usize, f64)], smallest: f64) -> Result<(), Vec<f64>> {
        let (below, mut rest) = self.next_row(row);
        if rest < DOUBTFUL {
            let (combination, exact) = self.rest(row, &below);
            if exact <= smallest {
                return Err(combination);
            }
            rest = exact * exact;
        }
        let number = self.independent.len();
        for (i, l) in below {
            self.lower[i].push((number, l));
            self.parent[i].get_or_insert(number);
        }
        for &(column, g) in row {
            self.of_column[column].push((number, g));
        }
        self.independent.push(row_idx);
        self.rows.push(row.iter().copied());
        self.diagonal.push(rest);
        self.lower.push(Vec::new());
        self.parent.push(None);
        self.y.push(0.0);
        self.is_reached.push(false);
        Ok(())
    }

    /// The row of L that belongs to a new row, and what is left of the row, squared.
    fn next_row(&mut self, row: &[(usize, f64)]) -> (Vec<(usize, f64)>, f64) {
        // Products with the independent rows, and everything that they change on the way up the tree.
        let mut reached: Vec<usize> = Vec::new();
        for &(column, g) in row {
            for &(other, h) in &self.of_column[column] {
                self.y[other] += g * h;
                let mut at = Some(other);
                while let Some(i) = at.filter(|&i| !self.is_reached[i]) {
                    self.is_reached[i] = true;
                    reached.push(i);
                    at = self.parent[i];
                }
            }
        }
        // Users have larger numbers than what they use.
        reached.sort_unstable();
        let mut rest: f64 = row.iter().map(|(_, g)| g * g).sum();
        let mut below = Vec::with_capacity(reached.len());
        for i in reached {
            let y = std::mem::take(&mut self.y[i]);
            self.is_reached[i] = false;
            self.lower[i].iter().for_each(|&(k, l)| self.y[k] -= l * y);
            let l = y / self.diagonal[i];
            rest -= l * y;
            below.push((i, l));
        }
        (below, rest)
    }

    /// The combination of the independent rows that comes nearest to a row, and the length of what is left
    /// of it; both refined.
    fn rest(&self, row: &[(usize, f64)], below: &[(usize, f64)]) -> (Vec<f64>, f64) {
        const REFINEMENTS: usize = 2;
        let n = self.independent.len();
        let mut combination = vec![0.0; n];
        for &(i, l) in below {
            combination[i] = l;
        }
        self.back_substitute(&mut combination);
        let mut left = self.left(row, &combination);
        for _ in 0..REFINEMENTS {
            // L y = products with what is left, D Lᵀ x = y.
            let mut x = self.rows.times(&left);
            for i in 0..n {
                let y = x[i];
                self.lower[i].iter().for_each(|&(k, l)| x[k] -= l * y);
            }
            x.iter_mut().zip(&self.diagonal).for_each(|(x, d)| *x /= d);
            self.back_substitute(&mut x);
            combination.iter_mut().zip(&x).for_each(|(c, x)| *c += x);
            left = self.left(row, &combination);
        }
        (combination, left.iter().map(|x| x * x).sum::<f64>().sqrt())
    }

    /// Solves with Lᵀ, in place.
    fn back_substitute(&self, x: &mut [f64]) {
        for i in (0..x.len()).rev() {
            x[i] -= self.lower[i].iter().map(|&(k, l)| l * x[k]).sum::<f64>();
        }
    }

    /// A row without a combination of the independent ones.
    fn left(&self, row: &[(usize, f64)], combination: &[f64]) -> Vec<f64> {
        let mut left = vec![0.0; self.rows.n_columns];
        for &(column, g) in row {
            left[column] += g;
        }
        for (i, &part) in combination.iter().enumerate().filter(|(_, part)| **part != 0.0) {
            self.rows.row(i).iter().for_each(|&(column, g)| left[column] -= part * g);
        }
        left
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::linear::rows::tests::jacobian_of_example;

    /// The least that is left of a row without those before it, squared, of independent rows scaled to unit
    /// length.
    pub(crate) fn weakest_rest(rows: &SparseRows) -> f64 {
        let norms = rows.norms();
        let mut basis = Basis::new(rows.n_columns);
        for (row_idx, norm) in norms.into_iter().enumerate() {
            let row: Vec<_> = rows.row(row_idx).iter().map(|&(i, g)| (i, g / norm)).collect();
            basis.add(row_idx, &row, ROUNDING.rest).expect("independent");
        }
        basis.diagonal.into_iter().fold(f64::INFINITY, f64::min)
    }

    fn check(jacobian: &SparseRows, what: &str) -> Dependence {
        let found = sparse_dependent_rows(jacobian, ROUNDING);
        assert_eq!(found, dense::dependent_rows(&jacobian.dense()), "{what}");
        found
    }

    #[test]
    fn sparse_and_dense_processes_find_the_same_rows() {
        for name in ["five-link", "four-bar", "quick-return", "slider-crank"] {
            let found = check(&jacobian_of_example(name), name);
            assert!(found.dependent.is_empty(), "{name}");
        }
        let found = check(&jacobian_of_example("parallelogram"), "parallelogram");
        assert_eq!(found.dependent.len(), 1);
        assert!(found.involved.len() > 1, "{found:?}");
    }

    #[test]
    fn rows_of_any_size_and_nearness_are_distinguished() {
        let first = [(0, 0, 1e6), (0, 1, 1e6), (1, 1, 1e-3), (1, 2, 2e-3)];
        // Row 0 and 1 once more, nearly; an empty row; one of its own.
        let near = |apart: f64| {
            let more = [(2, 0, 3.0), (2, 1, 5.0), (2, 2, 4.0 + apart), (4, 3, 1.0)];
            SparseRows::from_entries(5, 4, first.into_iter().chain(more))
        };
        assert_eq!(check(&near(0.0), "equal").dependent, [2, 3]);
        assert_eq!(check(&near(1e-9), "nearly equal").dependent, [2, 3]);
        assert_eq!(check(&near(1e-4), "apart").dependent, [3]);
    }

    #[test]
    fn the_factors_of_a_chain_grow_with_its_length() {
        // Rows that meet their neighbours, as the pins of a chain do.
        let fill = |n: usize| {
            let row = |k: usize| [(k, k, 1.0), (k, k + 1, -1.0), (k, n + 1 + k, 0.5)];
            let rows = SparseRows::from_entries(n, 2 * n + 1, (0..n).flat_map(row));
            let mut basis = Basis::new(rows.n_columns);
            for k in 0..n {
                basis.add(k, rows.row(k), ROUNDING.rest).expect("independent");
            }
            basis.lower.iter().map(Vec::len).sum::<usize>()
        };
        assert_eq!((fill(50), fill(100)), (49, 99));
    }
}
