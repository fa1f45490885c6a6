//! Velocities after an impact: Newton's law of restitution on the mechanism as a whole.
//!
//! ```text
//! M (v⁺ − v⁻) + Gᵀ Λ + Jᵀ P = 0         G v⁺ + ∂g/∂t = 0
//! ξ = J v⁺ + ε J v⁻ ≤ 0,   P ≥ 0,   Pᵀ ξ = 0
//! ```
//!
//! J v is the rate of penetration, positive on approach. A stop that takes an impulse P > 0 parts
//! with ε times the speed of approach; one that parts faster by itself takes none. So the stops that
//! take an impulse are found by trying sets of them, and each set is a linear system:
//!
//! ```text
//! [ M  Gᵀ  Jᵀ ] [ v⁺ ]   [  M v⁻   ]
//! [ G  0   0  ] [ Λ  ] = [ −∂g/∂t  ]        J: the rows of these stops alone
//! [ J  0   0  ] [ P  ]   [ −ε J v⁻ ]
//! ```
//!
//! Source: Glocker and Pfeiffer (1996), §8.2, with J. J. Moreau's form of Newton's law.

use nalgebra::{DMatrix, DVector, Dyn, LU};

use super::complementarity::{pushes, stays_apart};
use super::mode_sets::ModeSets;
use crate::linear::augmented::Augmented;
use crate::linear::elimination::{Elimination, Singular};
use crate::linear::matrix::Matrix;
use crate::linear::rank::dependent_rows;
use crate::linear::rows::SparseRows;
use crate::linear::shape::Shape;

/// Friction that takes part in an impact.
pub(crate) struct Rubbing<'a> {
    /// One row for each track: that of its slip with the opposite sign.
    pub(crate) rows: &'a SparseRows,
    /// μ of each.
    pub(crate) mu: &'a [f64],
    /// The stops that press each, by their numbers among those of the impact.
    pub(crate) pressed_by: &'a [Vec<usize>],
    /// True if tracks come in pairs: the two directions of a tangent plane, one after the other.
    pub(crate) is_spatial: bool,
}

/// Outcome of an impact.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Impact {
    /// v⁺.
    pub(crate) v: DVector<f64>,
    /// P of every stop, N s or N m s.
    pub(crate) impulses: DVector<f64>,
}

/// The equations of an impact.
pub(crate) struct ImpactEquations<'a> {
    pub(crate) mass: &'a Matrix,
    /// G: the independent rows that hold throughout.
    pub(crate) g: &'a SparseRows,
    /// ∂g/∂t after the impact.
    pub(crate) g_rate: &'a [f64],
    /// J: one row for each stop that may take part.
    pub(crate) stops: &'a SparseRows,
    /// ε of each.
    pub(crate) restitution: &'a [f64],
}

/// Relative size of rounding in a sign.
const ROUNDING: f64 = 1e-9;
/// A pivot below this part of its row is none: such stops cannot both take an impulse.
const SMALLEST_PIVOT: f64 = 1e-11;
/// Stops beyond which their sets are not tried one after the other.
const FEWEST_OF_MANY: usize = 6;

impl ImpactEquations<'_> {
    /// The velocities after an impact at the velocities `v`; `None` when no set of stops is
    /// consistent.
    ///
    /// Sets are tried in a fixed order, all stops first.
    pub(crate) fn solve(&self, v: &DVector<f64>) -> Option<Impact> {
        let n = self.restitution.len();
        let rates = Matrix::of(self.stops.clone());
        let approach = rates.times(v);
        // Speeds that the stops demand of themselves if they take part: ξ = 0.
        let parting =
            DVector::from_iterator(n, approach.iter().zip(self.restitution).map(|(u, e)| -e * u));

        let momentum = self.mass.times(v);
        // Of many stops all, then those of a complementarity problem.
        let most = if n > FEWEST_OF_MANY { 1 } else { usize::MAX };
        let found = ModeSets::new(vec![2; n]).take(most).find_map(|left_out| {
            let active: Vec<usize> = (0..n).filter(|&k| left_out[k] == 0).collect();
            let rows = self.stops.select(&active);
            let (after, impulse) =
                self.with_momentum(&rows, &parting.select_rows(&active), &momentum)?;

            // ξ ≤ 0 of every stop, P ≥ 0 of those that take part.
            let reached = rates.times(&after);
            let excess = &reached - &parting;
            let speed = approach.amax().max(reached.amax());
            let largest = if impulse.is_empty() { 0.0 } else { impulse.amax() };
            let is_parting = excess.iter().all(|&xi| stays_apart(xi, ROUNDING * speed));
            let is_pushing = impulse.iter().all(|&p| pushes(p, ROUNDING * largest));
            if !is_parting || !is_pushing {
                return None;
            }
            let mut impulses = DVector::zeros(n);
            for (k, p) in active.iter().zip(impulse.iter()) {
                impulses[*k] = p.max(0.0);
            }
            Some(Impact { v: after, impulses })
        });
        found.or_else(|| {
            let rows = &self.stops.select(&[]);
            let none = Rubbing { rows, mu: &[], pressed_by: &[], is_spatial: false };
            (n > FEWEST_OF_MANY).then(|| self.solve_rubbing(v, &none)).flatten()
        })
    }

    /// v⁺ and P when all of `rows` end at the speeds `parting`, from a momentum M v⁻; `None` when rows are dependent.
    pub(super) fn with_momentum(
        &self,
        rows: &SparseRows,
        parting: &DVector<f64>,
        momentum: &DVector<f64>,
    ) -> Option<(DVector<f64>, DVector<f64>)> {
        self.factored(rows)?.solve(self.g_rate, parting, momentum)
    }

    /// The factors of the equations when all of `rows` take part; `None` when rows are dependent.
    pub(super) fn factored(&self, rows: &SparseRows) -> Option<Factored> {
        match self.mass {
            Matrix::Dense(mass) => self.factored_dense(mass, rows),
            Matrix::Sparse(mass) => self.factored_sparse(mass, rows),
        }
    }

    /// By dense factors with pivots.
    fn factored_dense(&self, mass: &DMatrix<f64>, rows: &SparseRows) -> Option<Factored> {
        let (nq, ng) = (mass.nrows(), self.g.n_rows());
        let n = nq + ng + rows.n_rows();
        let mut matrix = DMatrix::zeros(n, n);
        matrix.view_mut((0, 0), (nq, nq)).copy_from(mass);
        for (first, block) in [(nq, self.g), (nq + ng, rows)] {
            let (block, count) = (block.dense(), block.n_rows());
            matrix.view_mut((first, 0), (count, nq)).copy_from(&block);
            matrix.view_mut((0, first), (nq, count)).copy_from(&block.transpose());
        }
        // Rows of unit size, so that a small pivot means dependence and not small units.
        let size_of = |i: usize| matrix.row(i).amax();
        let sizes: Vec<f64> =
            (0..n).map(size_of).map(|size| if size > 0.0 { size } else { 1.0 }).collect();
        sizes.iter().enumerate().for_each(|(i, &size)| matrix.row_mut(i).unscale_mut(size));
        let lu = matrix.lu();
        let pivots = lu.u().diagonal().map(f64::abs);
        if n > 0 && pivots.min() <= SMALLEST_PIVOT * pivots.max() {
            return None;
        }
        Some(Factored::Dense(lu, sizes))
    }

    /// By sparse elimination, which needs to know first that the rows are independent.
    fn factored_sparse(&self, mass: &SparseRows, rows: &SparseRows) -> Option<Factored> {
        let nq = mass.n_columns;
        let mut active = self.g.clone();
        (0..rows.n_rows()).for_each(|k| active.push(rows.row(k).iter().copied()));
        if !dependent_rows(&active).dependent.is_empty() {
            return None;
        }

        // The multiplier system of these rows.
        let lower = mass.entries().filter(|&(i, j, _)| j <= i);
        let (entries, mass): (Vec<_>, Vec<f64>) = lower.map(|(i, j, m)| ((i, j), m)).unzip();
        let (couplings, jacobian): (Vec<_>, Vec<f64>) =
            active.entries().map(|(k, i, g)| ((k, i), g)).unzip();
        let shape = Shape {
            nq,
            nc: active.n_rows(),
            mass: entries,
            jacobian: couplings,
            of_rates: Vec::new(),
        };
        let all: Vec<usize> = (0..shape.nc).collect();
        let mut elimination = Elimination::new(&shape, &all);
        match elimination.factor(&mass, &jacobian) {
            Ok(()) => Some(Factored::Sparse(elimination)),
            Err(Singular::Multiplier) => None,
            Err(Singular::Coordinate) => {
                let mut augmented = Box::new(Augmented::new(&shape, &all));
                augmented.factor(&mass, &jacobian).ok()?;
                Some(Factored::Augmented(augmented, jacobian))
            }
        }
    }
}

/// Factors of the equations of an impact.
pub(super) enum Factored {
    /// With the sizes by which rows were divided.
    Dense(LU<f64, Dyn, Dyn>, Vec<f64>),
    Sparse(Elimination),
    /// With the entries of the rows.
    Augmented(Box<Augmented>, Vec<f64>),
}

impl Factored {
    /// v⁺ and P for a momentum M v⁻ when rows end at these speeds.
    pub(super) fn solve(
        &mut self,
        g_rate: &[f64],
        parting: &DVector<f64>,
        momentum: &DVector<f64>,
    ) -> Option<(DVector<f64>, DVector<f64>)> {
        let resisting = g_rate.iter().map(|rate| -rate);
        let mut x: Vec<f64> =
            momentum.iter().copied().chain(resisting).chain(parting.iter().copied()).collect();
        match self {
            Self::Dense(lu, sizes) => {
                x.iter_mut().zip(sizes.iter()).for_each(|(x, size)| *x /= size);
                x = lu.solve(&DVector::from_vec(x))?.as_slice().to_vec();
            }
            Self::Sparse(elimination) => elimination.solve_in_place(&mut x),
            Self::Augmented(augmented, jacobian) => augmented.solve_in_place(jacobian, &mut x),
        }
        let nq = momentum.len();
        let part = |from: usize, n: usize| DVector::from_column_slice(&x[from..from + n]);
        x.iter()
            .all(|value| value.is_finite())
            .then(|| (part(0, nq), part(nq + g_rate.len(), parting.len())))
    }
}

/// The independent rows besides those of stops; which these are must not depend on the stops.
pub(super) fn independent_without(jacobian: &SparseRows, stops: &[usize]) -> Vec<usize> {
    let dependent = dependent_rows(&jacobian.without(stops)).dependent;
    let mut is_dependent = vec![false; jacobian.n_rows()];
    for row in dependent {
        is_dependent[row] = true;
    }
    (0..jacobian.n_rows()).filter(|&row| !is_dependent[row]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The entries of a matrix that are not zero.
    fn sparse(matrix: &DMatrix<f64>) -> SparseRows {
        let all = (0..matrix.nrows()).flat_map(|i| (0..matrix.ncols()).map(move |j| (i, j)));
        let entries = all.map(|(i, j)| (i, j, matrix[(i, j)])).filter(|entry| entry.2 != 0.0);
        SparseRows::from_entries(matrix.nrows(), matrix.ncols(), entries)
    }

    /// The outcome by dense factors, which sparse elimination confirms.
    fn outcome(
        mass: &DMatrix<f64>,
        (g, g_rate): (&DMatrix<f64>, &[f64]),
        (stops, restitution): (&DMatrix<f64>, &[f64]),
        v: &[f64],
    ) -> Option<Impact> {
        let (g, stops) = (sparse(g), sparse(stops));
        let v = DVector::from_column_slice(v);
        let forms = [Matrix::Dense(mass.clone()), Matrix::Sparse(sparse(mass))];
        let [dense, sparse] = forms.map(|mass| {
            let (g, stops) = (&g, &stops);
            ImpactEquations { mass: &mass, g, g_rate, stops, restitution }.solve(&v)
        });
        assert_eq!(dense.is_some(), sparse.is_some(), "{dense:?} and {sparse:?}");
        if let (Some(dense), Some(sparse)) = (&dense, &sparse) {
            let apart =
                (&dense.v - &sparse.v).amax().max((&dense.impulses - &sparse.impulses).amax());
            assert!(apart < 1e-13, "dense {dense:?}, sparse {sparse:?}");
        }
        dense
    }

    fn free(mass: &DMatrix<f64>, j: &DMatrix<f64>, e: &[f64], v: &[f64]) -> Option<Impact> {
        outcome(mass, (&DMatrix::zeros(0, v.len()), &[]), (j, e), v)
    }

    #[test]
    fn two_carts_exchange_momentum_and_part_by_the_restitution() {
        // Penetration x₁ − x₂; momentum 2·3 = 6 kg m/s, speed of approach 3 m/s.
        let mass = DMatrix::from_diagonal(&DVector::from_vec(vec![2.0, 1.0]));
        let j = DMatrix::from_row_slice(1, 2, &[1.0, -1.0]);
        for e in [0.0, 0.4, 1.0] {
            let found = free(&mass, &j, &[e], &[3.0, 0.0]).expect("an impact");
            let parting = found.v[1] - found.v[0];
            let momentum = 2.0 * found.v[0] + found.v[1];
            assert!((parting - 3.0 * e).abs() < 1e-13, "e = {e}: parting with {parting}");
            assert!((momentum - 6.0).abs() < 1e-13, "e = {e}: momentum {momentum}");
            // P = (1 + e) μ u, μ = 2/3 kg.
            let expected = (1.0 + e) * 2.0;
            assert!((found.impulses[0] - expected).abs() < 1e-13, "P = {}", found.impulses[0]);
        }
    }

    #[test]
    fn a_rod_that_falls_flat_on_two_supports_is_held_by_both() {
        // Height of the middle and angle; supports at ±1 m, a rod of 1 kg and 1/3 kg m².
        let mass = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 1.0 / 3.0]));
        let j = DMatrix::from_row_slice(2, 2, &[-1.0, 1.0, -1.0, -1.0]);
        let flat = free(&mass, &j, &[0.0, 0.0], &[-1.0, 0.0]).expect("an impact");
        assert!(flat.v.amax() < 1e-14, "{}", flat.v);
        assert!((flat.impulses[0] - 0.5).abs() < 1e-14 && (flat.impulses[1] - 0.5).abs() < 1e-14);

        // One end hits while the other is in touch but at rest. With 1/3 kg m² the other is pressed
        // down and takes an impulse too; with weights at the ends, 4 kg m², it is thrown up.
        let tilting = free(&mass, &j, &[0.0, 0.0], &[-0.5, -0.5]).expect("an impact");
        assert!(tilting.v.amax() < 1e-14 && tilting.impulses.min() > 0.1, "{}", tilting.v);
        let mass = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 4.0]));
        let tilting = free(&mass, &j, &[0.0, 0.0], &[-0.5, -0.5]).expect("an impact");
        assert_eq!(tilting.impulses[0], 0.0, "{}", tilting.impulses);
        assert!(tilting.impulses[1] > 0.0, "{}", tilting.impulses);
        let rates = &j * &tilting.v;
        assert!(rates[0] < -1e-3 && rates[1].abs() < 1e-14, "{rates}");
    }

    #[test]
    fn an_impact_passes_through_the_joints() {
        // A lever of two carts tied together, x₁ = x₂: both stop as one body of 3 kg.
        let mass = DMatrix::from_diagonal(&DVector::from_vec(vec![2.0, 1.0]));
        let g = DMatrix::from_row_slice(1, 2, &[1.0, -1.0]);
        let j = DMatrix::from_row_slice(1, 2, &[1.0, 0.0]);
        let found = outcome(&mass, (&g, &[0.0]), (&j, &[0.5]), &[2.0, 2.0]).expect("an impact");
        assert!((found.v - DVector::from_element(2, -1.0)).amax() < 1e-14);
        assert!((found.impulses[0] - 9.0).abs() < 1e-13);
    }

    #[test]
    fn a_stop_against_a_driven_joint_has_no_answer() {
        let mass = DMatrix::from_element(1, 1, 1.0);
        let one = DMatrix::from_element(1, 1, 1.0);
        let found = outcome(&mass, (&one, &[-2.0]), (&one, &[0.0]), &[2.0]);
        assert_eq!(found, None);
    }

    #[test]
    fn more_stops_than_bits_are_hit_at_once() {
        // Forty carts of 1 kg, each against its own wall.
        const N: usize = 40;
        let one = DMatrix::identity(N, N);
        let found = free(&one, &one, &[0.5; N], &[2.0; N]).expect("an impact");
        assert!((found.v - DVector::from_element(N, -1.0)).amax() < 1e-14);
        assert!((found.impulses - DVector::from_element(N, 3.0)).amax() < 1e-14);
    }
}
