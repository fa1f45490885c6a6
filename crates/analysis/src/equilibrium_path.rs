//! [`EquilibriumPath`]: equilibria as a curve over one parameter.
//!
//! ```text
//! z = (x, s)              coordinates in units of the mechanism, the parameter in units of its range
//! g(x, s) = 0             rows that the others follow from
//! Zᵀ r(x, λ, s) = 0       r = ∂V/∂q − Q + Gᵀ λ, G Z = 0, λ those that leave the least of r
//! ∂(Zᵀ r) = Zᵀ (∂r/∂x δx + ∂r/∂s δs)        where r = 0
//! ```
//!
//! Multipliers are no unknowns: near toggles they grow beyond all bounds, while positions do not.

use bksim_mbs::coordinate::CoordinateKind;
use bksim_sim::Svd;
use nalgebra::{DMatrix, DVector};

use crate::balance::Balance;
use crate::curve::{Curve, Equations, independent_rows};
use crate::drive::Range;

/// Equilibria as equations of positions and one parameter.
pub(crate) struct EquilibriumPath<'b, 'l> {
    pub(crate) balance: &'b mut Balance<'l>,
    /// The parameter at s = 0 and 1.
    range: Range,
    /// Unit of each coordinate: 1 rad or the longest link.
    units: Vec<f64>,
    /// True where whole turns of a coordinate mean nothing.
    pub(crate) is_turn: Vec<bool>,
    /// Constraint rows that the others follow from.
    active: Vec<usize>,
    /// Largest residual of the others where they were last asked for, in radians and longest links.
    left_out: f64,
    /// Whole turns between rows of angles and zero.
    turns: Vec<f64>,
    /// Unit of work, J: the largest that forces or their changes do at the position.
    work: f64,
}

impl<'b, 'l> EquilibriumPath<'b, 'l> {
    /// The equations about a position where the mechanism closes.
    pub(crate) fn about(
        balance: &'b mut Balance<'l>,
        range: Range,
        (q, s): (&[f64], f64),
    ) -> Curve<Self> {
        let coordinates = balance.loaded.system().coordinates();
        let size = balance.loaded.size;
        let is_length = |kind| kind == CoordinateKind::Length;
        let units = coordinates.iter().map(|c| if is_length(c.kind) { size } else { 1.0 });
        let units: Vec<f64> = units.collect();
        let is_turn = coordinates.iter().map(|c| c.kind == CoordinateKind::Angle).collect();
        balance.set(&[range.at(s)]);
        let nothing = vec![0.0; balance.forces.nc()];
        let at = balance.at(q, &nothing);
        let scaled = DMatrix::from_fn(at.jacobian.nrows(), units.len(), |row, i| {
            at.jacobian[(row, i)] * units[i]
        });
        let active = independent_rows(&scaled);
        let turns =
            at.closure.iter().map(|g| std::f64::consts::TAU * (g / std::f64::consts::TAU).round());
        let turns = turns.collect();
        let entries = (0..units.len()).flat_map(|i| (0..units.len()).map(move |k| (i, k)));
        let changes = entries.map(|(i, k)| (at.stiffness[(i, k)] * units[i] * units[k]).abs());
        let forces = at.residual.iter().zip(&units).map(|(force, unit)| (force * unit).abs());
        let work = changes.chain(forces).fold(0.0, f64::max);
        let work = if work > 0.0 { work } else { 1.0 };
        Curve {
            equations: Self { balance, range, units, is_turn, active, left_out: 0.0, turns, work },
        }
    }

    /// The unknowns of a position.
    pub(crate) fn unknowns(&self, q: &[f64], s: f64) -> DVector<f64> {
        let scaled = q.iter().zip(&self.units).map(|(q, unit)| q / unit);
        DVector::from_iterator(q.len() + 1, scaled.chain([s]))
    }

    /// The position of the unknowns.
    pub(crate) fn position(&self, z: &DVector<f64>) -> Vec<f64> {
        z.iter().zip(&self.units).map(|(x, unit)| x * unit).collect()
    }

    /// The value of the parameter.
    pub(crate) fn parameter(&self, s: f64) -> f64 {
        self.range.at(s)
    }
}

impl Equations for EquilibriumPath<'_, '_> {
    fn at(&mut self, z: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let n = z.len() - 1;
        let q = self.position(z);
        self.balance.set(&[self.parameter(z[n])]);
        let nothing = vec![0.0; self.balance.forces.nc()];
        let loads = self.balance.at(&q, &nothing);

        let is_left_out = |row: &usize| self.active.binary_search(row).is_err();
        let others = (0..loads.closure.len()).filter(is_left_out);
        let off = |row: usize| {
            (loads.closure[row] - self.turns[row]).abs()
                / self.balance.unit_of_row(self.balance.loaded.kept[row])
        };
        self.left_out = others.map(off).fold(0.0, f64::max);

        // Closed loops, each row of the size one.
        let m = self.active.len();
        let mut value = DVector::zeros(n);
        let mut jacobian = DMatrix::zeros(n, n + 1);
        let per_s = self.range.to - self.range.from;
        for (i, &row) in self.active.iter().enumerate() {
            for k in 0..n {
                jacobian[(i, k)] = loads.jacobian[(row, k)] * self.units[k];
            }
            jacobian[(i, n)] = loads.closure_by_parameter[(row, 0)] * per_s;
            value[i] = loads.closure[row] - self.turns[row];
        }
        let held = jacobian.view((0, 0), (m, n)).clone_owned();
        let free = free_directions(&held, n - m);

        // Multipliers of the active rows, then forces along the free motions.
        let applied = DVector::from_fn(n, |i, _| loads.residual[i] * self.units[i]);
        let mut lambda = nothing;
        let held_forces = -&held * &applied;
        if m > 0
            && let Some(multipliers) = (&held * held.transpose()).lu().solve(&held_forces)
        {
            self.active.iter().zip(multipliers.iter()).for_each(|(&row, l)| lambda[row] = *l);
        }
        let at = self.balance.at(&q, &lambda);
        let scaled = DMatrix::from_fn(n, n + 1, |i, k| {
            let slope = if k < n {
                at.stiffness[(i, k)] * self.units[k]
            } else {
                at.by_parameter[(i, 0)] * per_s
            };
            slope * self.units[i]
        });
        jacobian.rows_mut(m, n - m).copy_from(&(free.transpose() * scaled));
        value.rows_mut(m, n - m).copy_from(&(free.transpose() * applied));
        for i in m..n {
            // Not by their own size, which vanishes where branches cross.
            jacobian.row_mut(i).scale_mut(1.0 / self.work);
            value[i] /= self.work;
        }
        for i in 0..m {
            let size = jacobian.row(i).norm();
            if size > 0.0 {
                jacobian.row_mut(i).scale_mut(1.0 / size);
                value[i] /= size;
            }
        }
        (value, jacobian)
    }

    fn left_out(&self) -> f64 {
        self.left_out
    }
}

/// `n_free` orthonormal directions that rows leave free, in columns, oriented so that the rows and they make a
/// positive determinant.
fn free_directions(rows: &DMatrix<f64>, n_free: usize) -> DMatrix<f64> {
    let n = rows.ncols();
    let mut square = DMatrix::zeros(n, n);
    square.rows_mut(0, rows.nrows()).copy_from(rows);
    let Some(Svd { v_t, .. }) = Svd::new(&square) else { return DMatrix::zeros(n, n_free) };
    let mut free = DMatrix::from_fn(n, n_free, |i, k| v_t[(n - 1 - k, i)]);
    square.rows_mut(rows.nrows(), n_free).copy_from(&free.transpose());
    if n_free > 0 && square.determinant() < 0.0 {
        free.column_mut(0).neg_mut();
    }
    free
}
