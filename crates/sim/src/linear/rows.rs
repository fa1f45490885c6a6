//! [`SparseRows`]: sparse matrices of numbers, and the smallest solution of sparse equations.
//!
//! ```text
//! x = Gᵀ (G Gᵀ + δ²)⁻¹ r, and again for what it leaves of r
//! ```
//!
//! The smallest x with G x = r, whatever the rank of G: a slack for every row makes the rows
//! independent, and repeating takes the slack away again (iterated Tikhonov regularisation; P. C.
//! Hansen, *Rank-Deficient and Discrete Ill-Posed Problems*, 1998, §5.1.5).

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use crate::linear::dense::least_squares;
use crate::linear::elimination::Elimination;
use crate::linear::lq;
use crate::linear::shape::Shape;

/// Columns up to which dense decompositions serve: they tell weak directions from none more
/// finely, and are quick enough.
pub(crate) const LARGEST_DENSE: usize = 200;

/// The shortest x that comes nearest to G x = r; NaN where an entry is not finite.
pub(crate) fn shortest_solution(rows: &SparseRows, r: &[f64]) -> Vec<f64> {
    // Rows of zeros, those of open contacts, say nothing of x; where bodies may touch there are many.
    let is_zero = |row: &usize| rows.row(*row).iter().all(|&(_, g)| g == 0.0);
    let (zeros, others): (Vec<usize>, Vec<usize>) = (0..rows.n_rows()).partition(is_zero);
    if !zeros.is_empty() {
        let r: Vec<f64> = others.iter().map(|&row| r[row]).collect();
        return shortest_solution(&rows.select(&others), &r);
    }
    if rows.n_columns.max(rows.n_rows()) > LARGEST_DENSE {
        return rows.shortest_solution(r);
    }
    let mut flat = vec![0.0; rows.n_rows() * rows.n_columns];
    rows.entries().for_each(|(row, column, g)| flat[row * rows.n_columns + column] += g);
    lq::shortest_solution(flat, rows.n_columns, r).unwrap_or_else(|| {
        least_squares(&rows.dense(), &DVector::from_column_slice(r)).0.as_slice().to_vec()
    })
}

/// Sparse rows of numbers.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct SparseRows {
    pub(crate) n_columns: usize,
    /// Where each row starts, and where the last one ends.
    starts: Vec<usize>,
    entries: Vec<(usize, f64)>,
}

impl SparseRows {
    /// No rows of this length.
    pub(crate) fn new(n_columns: usize) -> Self {
        Self { n_columns, starts: vec![0], entries: Vec::new() }
    }

    /// Sparse rows from their entries, in any order.
    pub(crate) fn from_entries(
        n_rows: usize,
        n_columns: usize,
        entries: impl IntoIterator<Item = (usize, usize, f64)>,
    ) -> Self {
        let mut rows = Self::new(n_columns);
        let mut entries: Vec<_> = entries.into_iter().collect();
        entries.sort_unstable_by_key(|&(row, column, _)| (row, column));
        rows.push_rows(n_rows, entries);
        rows
    }

    /// Adds so many rows from their entries, row by row with columns ascending.
    pub(crate) fn push_rows(
        &mut self,
        n_rows: usize,
        entries: impl IntoIterator<Item = (usize, usize, f64)>,
    ) {
        let first = self.n_rows();
        for (row, column, value) in entries {
            while self.starts.len() <= first + row {
                self.starts.push(self.entries.len());
            }
            self.entries.push((column, value));
        }
        self.starts.resize(first + n_rows + 1, self.entries.len());
    }

    /// Adds a row.
    pub(crate) fn push(&mut self, entries: impl IntoIterator<Item = (usize, f64)>) {
        self.entries.extend(entries);
        self.starts.push(self.entries.len());
    }

    pub(crate) fn n_rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// Replaces the values of all entries, row by row.
    pub(crate) fn set_values(&mut self, values: &[f64]) {
        assert_eq!(values.len(), self.entries.len(), "a value for every entry");
        self.entries.iter_mut().zip(values).for_each(|((_, entry), &value)| *entry = value);
    }

    /// Makes all entries of these columns zero.
    pub(crate) fn clear_columns(&mut self, columns: &[usize]) {
        let own = self.entries.iter_mut().filter(|(column, _)| columns.contains(column));
        own.for_each(|(_, entry)| *entry = 0.0);
    }

    /// Places of a row among all entries.
    pub(crate) fn places(&self, row: usize) -> Range<usize> {
        self.starts[row]..self.starts[row + 1]
    }

    /// Columns and values of a row.
    pub(crate) fn row(&self, row: usize) -> &[(usize, f64)] {
        &self.entries[self.places(row)]
    }

    /// All `(row, column, value)`, row by row.
    pub(crate) fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        let with_row = |row| self.row(row).iter().map(move |&(column, value)| (row, column, value));
        (0..self.n_rows()).flat_map(with_row)
    }

    /// Matrix with some rows emptied.
    pub(crate) fn without(&self, rows: &[usize]) -> Self {
        let mut is_emptied = vec![false; self.n_rows()];
        for &row in rows {
            is_emptied[row] = true;
        }
        let mut left = Self::new(self.n_columns);
        for (row, &is_emptied) in is_emptied.iter().enumerate() {
            left.push(self.row(row).iter().copied().filter(|_| !is_emptied));
        }
        left
    }

    /// Some of the rows.
    pub(crate) fn select(&self, rows: &[usize]) -> Self {
        let mut selected = Self::new(self.n_columns);
        for &row in rows {
            selected.push(self.row(row).iter().copied());
        }
        selected
    }

    /// G x.
    pub(crate) fn times(&self, x: &[f64]) -> Vec<f64> {
        let product = |row| self.row(row).iter().map(|&(column, value)| value * x[column]).sum();
        (0..self.n_rows()).map(product).collect()
    }

    /// Gᵀ.
    pub(crate) fn transposed(&self) -> Self {
        let entries = self.entries().map(|(row, column, g)| (column, row, g));
        Self::from_entries(self.n_columns, self.n_rows(), entries)
    }

    pub(crate) fn dense(&self) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(self.n_rows(), self.n_columns);
        self.entries().for_each(|(row, column, value)| matrix[(row, column)] += value);
        matrix
    }

    /// Length of each row.
    pub(crate) fn norms(&self) -> Vec<f64> {
        let norm = |row| self.row(row).iter().map(|(_, value)| value * value).sum::<f64>().sqrt();
        (0..self.n_rows()).map(norm).collect()
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.entries.iter().all(|(_, value)| value.is_finite())
    }

    /// The shortest x that comes nearest to G x = r, by sparse elimination.
    ///
    /// NaN where an entry is not finite.
    pub(crate) fn shortest_solution(&self, r: &[f64]) -> Vec<f64> {
        const CONSISTENT: f64 = 1e-9;
        if self.n_rows() == 0 || self.n_columns == 0 {
            return vec![0.0; self.n_columns];
        }
        let Some(mut inverse) = Inverse::of(self.clone()) else {
            return vec![f64::NAN; self.n_columns];
        };
        let x = inverse.apply(r);
        let left = difference(r, &self.times(&x));
        if length(&left) <= CONSISTENT * length(r) {
            return x;
        }
        // The rows contradict each other: first the nearest right side that they can have. The
        // smallest z with Gᵀ z = Gᵀ r is that.
        let transposed = self.transposed();
        let right_side = transposed.times(r);
        let Some(mut inverse_of_transposed) = Inverse::of(transposed) else { return x };
        inverse.apply(&inverse_of_transposed.apply(&right_side))
    }
}

/// The pseudoinverse of some rows, by the factors of G Gᵀ + δ².
#[derive(Clone, Debug)]
pub(crate) struct Inverse {
    rows: SparseRows,
    elimination: Elimination,
}

impl Inverse {
    /// `None` when an entry is not finite.
    pub(crate) fn of(rows: SparseRows) -> Option<Self> {
        // Directions of G weaker than this come slowly, those weaker than its square not at all.
        const SLACK: f64 = 1e-6;
        let (n, m) = (rows.n_columns, rows.n_rows());
        let longest = rows.norms().into_iter().fold(0.0, f64::max);
        let slack = SLACK * if longest > 0.0 { longest } else { 1.0 };
        // Each row ends with its own slack, which is a coordinate like the others.
        let with_slack = |row: usize| {
            rows.row(row).iter().copied().chain([(n + row, slack)]).map(move |e| (row, e))
        };
        let (positions, values): (Vec<_>, Vec<f64>) = (0..m)
            .flat_map(with_slack)
            .map(|(row, (column, value))| ((row, column), value))
            .unzip();
        let mass = (0..n + m).map(|i| (i, i)).collect();
        let shape = Shape { nq: n + m, nc: m, mass, jacobian: positions, of_rates: Vec::new() };
        let mut elimination = Elimination::new(&shape, &(0..m).collect::<Vec<_>>());
        let is_regular = elimination.factor(&vec![1.0; n + m], &values).is_ok();
        (is_regular && rows.is_finite()).then_some(Self { rows, elimination })
    }

    /// The smallest x with G x = r, for an r that G can make.
    pub(crate) fn apply(&mut self, r: &[f64]) -> Vec<f64> {
        const MAX_ROUNDS: usize = 8;
        const GAINING: f64 = 0.5;
        let mut x = vec![0.0; self.rows.n_columns];
        let mut left = r.to_vec();
        for _ in 0..MAX_ROUNDS {
            let unknowns = self.solve(&left);
            let trial: Vec<f64> = x.iter().zip(&unknowns).map(|(x, step)| x + step).collect();
            let rest = difference(r, &self.rows.times(&trial));
            let is_gaining = length(&rest) < GAINING * length(&left);
            if length(&rest) < length(&left) {
                (x, left) = (trial, rest);
            }
            if !is_gaining {
                break;
            }
        }
        x
    }

    /// The combination y of rows, of length 1, that comes nearest to vanishing, by inverse
    /// iteration; and |Gᵀ y|, the smallest singular value, unless it is far below δ.
    pub(crate) fn weakest_combination(&mut self) -> (Vec<f64>, f64) {
        const ROUNDS: usize = 4;
        // No direction of a mechanism is at right angles to these steps of the golden section.
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let (n, m) = (self.rows.n_columns, self.rows.n_rows());
        let mut y: Vec<f64> = (1..=m).map(|k| 0.5 + (GOLDEN * k as f64).fract()).collect();
        for _ in 0..ROUNDS {
            y = self.solve(&unit(&y)).split_off(n + m);
        }
        let y = unit(&y);
        let vanishing = length(&self.rows.transposed().times(&y));
        (y, vanishing)
    }

    /// Solves the equations with slack: x, the slacks, and minus (G Gᵀ + δ²)⁻¹ r.
    fn solve(&mut self, r: &[f64]) -> Vec<f64> {
        let mut unknowns = vec![0.0; self.rows.n_columns + r.len()];
        unknowns.extend_from_slice(r);
        self.elimination.solve_in_place(&mut unknowns);
        unknowns
    }
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// x by its length.
fn unit(x: &[f64]) -> Vec<f64> {
    let scale = 1.0 / length(x);
    x.iter().map(|x| scale * x).collect()
}

/// √(x · x).
pub(crate) fn length(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::compiled::compile;
    use crate::linear::svd::Svd;
    use crate::start::start;
    use bksim_mbs::assemble::assemble;
    use bksim_model::file::{Source, read};

    /// G of an example model at its start.
    pub(crate) fn jacobian_of_example(name: &str) -> SparseRows {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples");
        let text = std::fs::read_to_string(format!("{folder}/{name}/model.toml"));
        let model = read(&Source::new(&text.expect("an example"), name)).model.expect("a model");
        let system = assemble(&model);
        let compiled = compile(&model, &system).expect("compiles");
        let parameters: Vec<f64> = model.parameters.iter().map(|p| p.value).collect();
        let begin = start(&model, &system, &compiled, &parameters).expect("a start");
        compiled.evaluator(&parameters).constraints(begin.t, &begin.q).jacobian_rows()
    }

    fn check(rows: &SparseRows, r: &[f64], what: &str) {
        const CLOSE: f64 = 1e-8;
        let found = rows.shortest_solution(r);
        let expected = least_squares(&rows.dense(), &DVector::from_column_slice(r)).0;
        let error = length(&difference(&found, expected.as_slice()));
        assert!(
            error <= CLOSE * expected.norm().max(1.0),
            "{what}: {found:?} against {expected}, error {error:e}"
        );
    }

    #[test]
    fn sparse_and_dense_solutions_agree_at_any_rank() {
        let independent = [(0, 0, 2.0), (0, 1, 1.0), (1, 1, -1.0), (1, 3, 0.5)];
        let rows = SparseRows::from_entries(2, 4, independent);
        check(&rows, &[1.0, -2.0], "independent rows");
        // The third row is the sum of the others.
        let repeated = [(2, 0, 2.0), (2, 3, 0.5)];
        let rows = SparseRows::from_entries(3, 4, independent.into_iter().chain(repeated));
        check(&rows, &[1.0, -2.0, -1.0], "rows that repeat");
        check(&rows, &[1.0, -2.0, 3.0], "rows that contradict");
        check(&rows.transposed(), &[1.0, 0.0, 2.0, 5.0], "more rows than columns");
        check(&SparseRows::from_entries(2, 2, []), &[1.0, 1.0], "nothing");
    }

    #[test]
    fn sparse_and_dense_solutions_agree_on_the_constraints_of_the_examples() {
        for name in ["five-link", "four-bar", "parallelogram", "quick-return", "slider-crank"] {
            let rows = jacobian_of_example(name);
            let r: Vec<f64> = (0..rows.n_rows()).map(|k| (1.0 + k as f64).sin()).collect();
            check(&rows, &r, name);
            check(&rows, &rows.times(&vec![1.0; rows.n_columns]), name);
        }
    }

    #[test]
    fn the_weakest_combination_is_the_smallest_singular_vector() {
        for name in ["five-link", "four-bar", "parallelogram"] {
            let rows = jacobian_of_example(name);
            let (y, least) = Inverse::of(rows.clone()).expect("finite").weakest_combination();
            let expected = Svd::values(&rows.dense()).expect("finite").min();
            assert!((length(&y) - 1.0).abs() < 1e-12);
            // Below the slack all that is known is that it is there.
            let close = 0.02 * expected + 1e-5 * rows.dense().amax();
            assert!((least - expected).abs() <= close, "{name}: {least:e} against {expected:e}");
        }
    }
}
