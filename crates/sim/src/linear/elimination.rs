//! Sparse symmetric elimination in a fixed order, for the multiplier system.
//!
//! ```text
//! [ M  Gᵀ ]
//! [ G  0  ] = L D Lᵀ        M positive definite, G of full row rank
//! ```
//!
//! The order is chosen once, by least degree (W. F. Tinney and J. W. Walker, Proc. IEEE 55, 1967),
//! with one rule: a multiplier is eliminated after all coordinates of its row. Every leading block
//! then holds rows of G of full rank over the coordinates before them and is regular, so that no
//! pivot has to be searched for while the motion goes on. The updates are recorded as a list of
//! positions and repeated for every state: work and memory grow with the fill, not with the size.

mod pivots;
mod written;

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};
use std::sync::Arc;

pub(crate) use self::pivots::{n_padded, padded};
use crate::linear::shape::Shape;

/// A pivot below this part of what it was at its best, or of its own diagonal entry of M, is
/// rounding: other means must decide.
const SMALLEST_PIVOT: f64 = 1e-14;

/// Whose pivot vanishes, has the wrong sign or is not finite.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Singular {
    /// M is not positive definite.
    Coordinate,
    /// Rows of G depend on one another.
    Multiplier,
}

/// Entries one after the other in `values`, which one column updates by entries of its own that are one after the other,
/// too: where a matrix is full, a whole column.
#[derive(Clone, Copy, Debug)]
struct Run {
    /// Counted from the end of the column that updates them.
    target: usize,
    length: usize,
}

/// Factors of `[M Gᵀ; G 0]`, without the rows of G that are left out. Clones share all that does not change.
#[derive(Clone, Debug)]
pub(crate) struct Elimination {
    order: Arc<Order>,
    /// The diagonal, the entries below it, and one number for the rows that are left out.
    values: Vec<f64>,
    /// Largest magnitude of each pivot so far, with room for the padding.
    best: Vec<f64>,
    /// Smallest pivot of a multiplier, as a part of its best.
    rank_margin: f64,
    /// Right side, then solution, in the order of elimination.
    x: Vec<f64>,
}

/// Who is eliminated when, and what that changes.
#[derive(Debug)]
struct Order {
    /// Coordinates come first, then multipliers: nodes below this are coordinates.
    nq: usize,
    /// The node eliminated at each position.
    nodes: Vec<usize>,
    /// Where the entries below the diagonal of each column start in `rows`.
    starts: Vec<usize>,
    /// Positions of these entries, ascending in each column.
    rows: Vec<usize>,
    /// The entries below the diagonal that updates change, in the order of the updates.
    runs: Vec<Run>,
    n_updates: usize,
    /// Index in `values` of each value of M, then of G.
    slots: Vec<usize>,
    /// Of each pivot, padded: those of multipliers are negative.
    signs: Vec<f64>,
}

impl Elimination {
    /// Plans the elimination; `active` are the rows of G that take part.
    pub(crate) fn new(shape: &Shape, active: &[usize]) -> Self {
        // Who is connected with whom by an entry.
        let mut node_of_row = vec![None; shape.nc];
        active.iter().enumerate().for_each(|(k, &row)| node_of_row[row] = Some(shape.nq + k));
        let n = shape.nq + active.len();
        let mut graph = vec![BTreeSet::new(); n];
        let mut connect = |i: usize, j: usize| {
            if i != j {
                graph[i].insert(j);
                graph[j].insert(i);
            }
        };
        shape.mass.iter().for_each(|&(i, j)| connect(i, j));
        let couplings = shape.jacobian.iter();
        couplings.for_each(|&(row, i)| {
            if let Some(node) = node_of_row[row] {
                connect(node, i);
            }
        });
        let (nodes, columns) = least_degree_order(shape.nq, graph);

        // Columns by position.
        let mut position = vec![0; n];
        nodes.iter().enumerate().for_each(|(k, &node)| position[node] = k);
        let (mut starts, mut rows) = (vec![0], Vec::new());
        for column in &columns {
            let mut below: Vec<usize> = column.iter().map(|&node| position[node]).collect();
            below.sort_unstable();
            rows.extend(below);
            starts.push(rows.len());
        }

        // Indices of the values and of the updates.
        let index = |i: usize, j: usize| {
            let (row, col) = (i.max(j), i.min(j));
            if row == col {
                return row;
            }
            let column = &rows[starts[col]..starts[col + 1]];
            n + starts[col] + column.partition_point(|&r| r < row)
        };
        let waste = n + rows.len();
        let of_mass = shape.mass.iter().map(|&(i, j)| index(position[i], position[j]));
        let of_jacobian = shape.jacobian.iter().map(|&(row, i)| {
            node_of_row[row].map_or(waste, |node| index(position[node], position[i]))
        });
        let slots = of_mass.chain(of_jacobian).collect();
        let (mut runs, mut n_updates): (Vec<Run>, usize) = (Vec::new(), 0);
        for k in 0..n {
            let column = &rows[starts[k]..starts[k + 1]];
            let end = n + starts[k + 1];
            for (a, &j) in column.iter().enumerate() {
                n_updates += column.len() - a;
                let first = runs.len();
                for target in column[a + 1..].iter().map(|&i| index(i, j) - end) {
                    match runs[first..].last_mut() {
                        Some(run) if run.target + run.length == target => run.length += 1,
                        _ => runs.push(Run { target, length: 1 }),
                    }
                }
            }
        }
        let sign = |&node: &usize| if node < shape.nq { 1.0 } else { -1.0 };
        let signs: Vec<f64> = nodes.iter().map(sign).collect();
        let order = Order {
            nq: shape.nq,
            signs: padded(&signs).collect(),
            nodes,
            starts,
            rows,
            runs,
            n_updates,
            slots,
        };
        Self {
            order: Arc::new(order),
            values: vec![0.0; waste + 1],
            best: vec![0.0; n_padded(n)],
            x: vec![0.0; n],
            rank_margin: 1.0,
        }
    }

    /// Factors the matrix with these values of M and G, in the order of the shape.
    ///
    /// # Errors
    /// [`Singular`] says whose pivot vanishes, has the wrong sign or is not finite.
    pub(crate) fn factor(&mut self, mass: &[f64], jacobian: &[f64]) -> Result<(), Singular> {
        let Self { order, values, best, rank_margin, .. } = self;
        let Order { nq, nodes, starts, rows, runs, slots, .. } = &**order;
        let n = nodes.len();
        values.fill(0.0);
        for (&slot, &value) in slots.iter().zip(mass.iter().chain(jacobian)) {
            values[slot] = value;
        }
        *rank_margin = 1.0;
        let (diagonal, lower) = values.split_at(n);
        debug_assert_eq!(lower.len(), rows.len() + 1);
        // A coordinate's pivot is compared with its own entry of M.
        for k in 0..n {
            if nodes[k] < *nq {
                best[k] = diagonal[k].abs();
            }
        }
        let mut next = 0;
        for k in 0..n {
            let pivot = checked_pivot(values[k], nodes[k] >= *nq, &mut best[k], rank_margin)?;
            let (from, to) = (n + starts[k], n + starts[k + 1]);
            let (known, later) = values.split_at_mut(to);
            for j in from..to {
                let factor = known[j] / pivot;
                known[rows[j - n]] -= factor * known[j];
                let mut i = j + 1;
                while i < to {
                    let Run { target, length } = runs[next];
                    let changed = later[target..target + length].iter_mut();
                    changed.zip(&known[i..i + length]).for_each(|(x, by)| *x -= factor * by);
                    i += length;
                    next += 1;
                }
            }
            values[from..to].iter_mut().for_each(|l| *l /= pivot);
        }
        Ok(())
    }

    /// Number of multiplications and subtractions of the elimination.
    pub(crate) fn n_updates(&self) -> usize {
        self.order.n_updates
    }

    /// Takes factors that were computed elsewhere and whose pivots were accepted: the diagonal, then the
    /// entries below it, in this order of elimination.
    pub(crate) fn take(&mut self, factors: impl Iterator<Item = f64>) {
        self.values.iter_mut().zip(factors).for_each(|(own, factor)| *own = factor);
    }

    /// Distance of G from a loss of rank: the smallest pivot of a multiplier as a part of its best so
    /// far, about the square of the smallest singular value of G; 0 in a singular pose.
    pub(crate) fn rank_margin(&self) -> f64 {
        self.rank_margin
    }

    /// Largest magnitude of each pivot so far.
    pub(crate) fn best_pivots(&self) -> &[f64] {
        &self.best[..self.x.len()]
    }

    /// Best pivots ([`Elimination::best_pivots`]) to be overwritten.
    pub(crate) fn best_pivots_mut(&mut self) -> &mut [f64] {
        &mut self.best[..self.x.len()]
    }

    /// Solves with the factors, in place; `x` holds coordinates, then the active multipliers.
    pub(crate) fn solve_in_place(&mut self, x: &mut [f64]) {
        let Self { order, values, x: sorted, .. } = self;
        let Order { nodes, starts, rows, .. } = &**order;
        let n = nodes.len();
        let (diagonal, lower) = values.split_at(n);
        for (sorted, &node) in sorted.iter_mut().zip(nodes) {
            *sorted = x[node];
        }
        for k in 0..n {
            let value = sorted[k];
            for p in starts[k]..starts[k + 1] {
                sorted[rows[p]] -= lower[p] * value;
            }
        }
        for k in (0..n).rev() {
            // As `record_step` has it, of which the quotient is known before.
            let mut value = sorted[k] * (1.0 / diagonal[k]);
            for p in starts[k]..starts[k + 1] {
                value -= lower[p] * sorted[rows[p]];
            }
            sorted[k] = value;
        }
        for (&sorted, &node) in sorted.iter().zip(nodes) {
            x[node] = sorted;
        }
    }
}

/// A pivot, unless it is as good as zero against its best one.
fn checked_pivot(
    pivot: f64,
    is_multiplier: bool,
    best: &mut f64,
    rank_margin: &mut f64,
) -> Result<f64, Singular> {
    let magnitude = if is_multiplier { -pivot } else { pivot };
    if is_multiplier {
        *best = best.max(magnitude);
        // A row without entries has never had a pivot.
        let part = if *best > 0.0 { magnitude / *best } else { 0.0 };
        *rank_margin = rank_margin.min(part.max(0.0));
    }
    // NaN fails the comparison.
    if magnitude > SMALLEST_PIVOT * *best {
        Ok(pivot)
    } else if is_multiplier {
        Err(Singular::Multiplier)
    } else {
        Err(Singular::Coordinate)
    }
}

/// The order of elimination, and for each of its nodes those left that it is then connected with.
fn least_degree_order(
    nq: usize,
    mut graph: Vec<BTreeSet<usize>>,
) -> (Vec<usize>, Vec<BTreeSet<usize>>) {
    let n = graph.len();
    // Coordinates that a multiplier still waits for.
    let mut waits: Vec<usize> =
        (0..n).map(|node| if node < nq { 0 } else { graph[node].len() }).collect();
    let rows_of: Vec<Vec<usize>> = graph[..nq]
        .iter()
        .map(|near| near.iter().copied().filter(|&other| other >= nq).collect())
        .collect();
    // How many nodes a pivot waits for, one after the other.
    let mut heights = vec![0; n];
    let mut heap: BinaryHeap<Reverse<(usize, usize, usize)>> = (0..n)
        .filter(|&node| waits[node] == 0)
        .map(|node| Reverse((graph[node].len(), heights[node], node)))
        .collect();
    // The node of least degree next, among those that wait for none; of these, one whose pivot is known soon.
    let mut is_done = vec![false; n];
    let (mut order, mut columns) = (Vec::with_capacity(n), Vec::with_capacity(n));
    while let Some(Reverse((degree, height, node))) = heap.pop() {
        // What has changed since was pushed again.
        if is_done[node] || degree != graph[node].len() || height != heights[node] {
            continue;
        }
        // Its neighbours become neighbours of each other.
        is_done[node] = true;
        let near = std::mem::take(&mut graph[node]);
        for &a in &near {
            graph[a].remove(&node);
            graph[a].extend(near.iter().copied().filter(|&b| b != a));
            heights[a] = heights[a].max(height + 1);
        }
        // Multipliers whose last coordinate this was wait no more.
        let freed = rows_of.get(node).into_iter().flatten().copied().filter(|&row| {
            waits[row] -= 1;
            waits[row] == 0
        });
        let freed: Vec<usize> = freed.collect();
        for &a in near.iter().chain(&freed) {
            if waits[a] == 0 && !is_done[a] {
                heap.push(Reverse((graph[a].len(), heights[a], a)));
            }
        }
        order.push(node);
        columns.push(near);
    }
    (order, columns)
}

#[cfg(test)]
mod tests {
    use bksim_expr::{Composition, Value};

    use super::*;

    /// Two bodies on a chain of four rows over six coordinates, M full in the first two.
    fn shape() -> Shape {
        Shape {
            nq: 4,
            nc: 3,
            mass: vec![(0, 0), (1, 0), (1, 1), (2, 2), (3, 3)],
            jacobian: vec![(0, 0), (0, 2), (1, 1), (1, 2), (2, 2), (2, 3)],
            of_rates: Vec::new(),
        }
    }

    const MASS: [f64; 5] = [3.0, 1.0, 2.0, 5.0, 4.0];
    const JACOBIAN: [f64; 6] = [1.0, -2.0, 0.5, 1.5, 1.0, 3.0];

    fn times(x: &[f64], active: &[usize]) -> Vec<f64> {
        let shape = shape();
        let mut out = vec![0.0; shape.nq + active.len()];
        for (&(i, j), m) in shape.mass.iter().zip(MASS) {
            out[i] += m * x[j];
            if i != j {
                out[j] += m * x[i];
            }
        }
        for (&(row, i), g) in shape.jacobian.iter().zip(JACOBIAN) {
            if let Some(k) = active.iter().position(|&r| r == row) {
                out[shape.nq + k] += g * x[i];
                out[i] += g * x[shape.nq + k];
            }
        }
        out
    }

    #[test]
    fn solutions_satisfy_the_system_with_and_without_rows_left_out() {
        for active in [vec![0, 1, 2], vec![0, 2], vec![]] {
            let mut elimination = Elimination::new(&shape(), &active);
            elimination.factor(&MASS, &JACOBIAN).expect("the system is regular");
            let rhs: Vec<f64> = (0..4 + active.len()).map(|i| 1.0 + i as f64).collect();
            let mut x = rhs.clone();
            elimination.solve_in_place(&mut x);
            for (found, wanted) in times(&x, &active).iter().zip(&rhs) {
                assert!(
                    (found - wanted).abs() < 1e-12,
                    "{found} against {wanted}, rows {active:?}"
                );
            }
        }
    }

    /// The numbers of the matrix as inputs of a tape, then the right side.
    #[test]
    fn what_is_written_down_solves_the_system_with_the_factors_of_the_loops() {
        let active = [0, 1, 2];
        let mut elimination = Elimination::new(&shape(), &active);
        elimination.factor(&MASS, &JACOBIAN).expect("the system is regular");
        let rhs: Vec<f64> = (0..7).map(|i| 1.0 + f64::from(i)).collect();
        let point = [&MASS[..], &JACOBIAN, &rhs].concat();

        let mut recorder = Composition::new(point.len(), 0);
        let inputs: Vec<Value> = (0..point.len()).map(|i| recorder.input(i)).collect();
        let (matrix, right_side) = inputs.split_at(MASS.len() + JACOBIAN.len());
        let matrix = matrix.split_at(MASS.len());
        let (solution, factors) = elimination.record(&mut recorder, matrix, right_side);
        let tape = recorder.finish(&[solution, factors].concat());
        let mut found = vec![0.0; tape.n_outputs()];
        tape.evaluate(&mut tape.workspace(&[]), &point, &mut found);
        let (solution, factors) = found.split_at(rhs.len());
        for (found, wanted) in times(solution, &active).iter().zip(&rhs) {
            assert!((found - wanted).abs() < 1e-12, "{found} against {wanted}");
        }
        assert_eq!(factors.len() + 1, elimination.values.len());
        for (found, wanted) in factors.iter().zip(&elimination.values) {
            assert!((found - wanted).abs() < 1e-14, "{found} against {wanted}");
        }
    }

    /// Rows of a chain depend on their neighbours: eliminated from both ends, half as many wait for each other.
    #[test]
    fn of_equal_nodes_one_that_waits_for_few_is_next() {
        const N: usize = 8;
        let mass: Vec<(usize, usize)> =
            (0..N).flat_map(|i| [(i, i)].into_iter().chain((i > 0).then(|| (i, i - 1)))).collect();
        let plan = Elimination::new(
            &Shape { nq: N, nc: 0, mass, jacobian: Vec::new(), of_rates: Vec::new() },
            &[],
        );
        let Order { starts, rows, .. } = &*plan.order;
        let mut heights = [0; N];
        for k in 0..N {
            for &row in &rows[starts[k]..starts[k + 1]] {
                heights[row] = heights[row].max(heights[k] + 1);
            }
        }
        assert_eq!(heights.iter().max(), Some(&(N / 2)));
    }

    #[test]
    fn dependent_rows_and_missing_inertia_are_singular() {
        let mut elimination = Elimination::new(&shape(), &[0, 1, 2]);
        elimination.factor(&MASS, &JACOBIAN).expect("the system is regular");
        assert_eq!(elimination.rank_margin(), 1.0);
        let mut weak = JACOBIAN;
        weak[4..].fill(1e-3);
        elimination.factor(&MASS, &weak).expect("weak, but regular");
        assert!(elimination.rank_margin() < 1e-5, "{}", elimination.rank_margin());
        weak[4..].fill(0.0);
        assert_eq!(elimination.factor(&MASS, &weak), Err(Singular::Multiplier));
        let mut massless = MASS;
        massless[3] = 0.0;
        assert_eq!(elimination.factor(&massless, &JACOBIAN), Err(Singular::Coordinate));
    }

    #[test]
    fn a_full_matrix_is_updated_by_whole_columns() {
        const N: usize = 30;
        let mass = (0..N).flat_map(|i| (0..=i).map(move |j| (i, j))).collect();
        let plan = Elimination::new(
            &Shape { nq: N, nc: 0, mass, jacobian: Vec::new(), of_rates: Vec::new() },
            &[],
        );
        // Of the column k below the diagonal all but the last entry change a column of their own.
        let n_columns: usize = (0..N).map(|k| (N - 1 - k).saturating_sub(1)).sum();
        assert_eq!(plan.order.runs.len(), n_columns);
        let n_entries: usize = plan.order.runs.iter().map(|run| run.length).sum();
        assert_eq!(plan.order.n_updates, n_entries + N * (N - 1) / 2);
    }

    #[test]
    fn the_fill_of_a_chain_grows_with_its_length() {
        let chain = |n: usize| {
            let mut shape = Shape { nq: 3 * n, nc: 2 * n, ..Shape::default() };
            shape.mass = (0..3 * n).map(|i| (i, i)).collect();
            for k in 0..n {
                for axis in 0..2 {
                    let row = 2 * k + axis;
                    let ends = [3 * k + axis, 3 * k + 2].into_iter();
                    let before = (k > 0).then(|| [3 * k - 3 + axis, 3 * k - 1]);
                    let all = ends.chain(before.into_iter().flatten());
                    shape.jacobian.extend(all.map(|i| (row, i)));
                }
            }
            let active: Vec<usize> = (0..2 * n).collect();
            Elimination::new(&shape, &active).n_updates()
        };
        let (short, long) = (chain(100), chain(200));
        assert!(long < 2 * short + short / 10, "{short} updates, then {long}");
    }
}
