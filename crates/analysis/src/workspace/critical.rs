//! Critical poses, in which a point cannot move in one direction of the plane: the equations of the head of `workspace.rs`.

use bksim_sim::Svd;
use nalgebra::{DMatrix, DVector};

use crate::curve::{Equations, Point};
use crate::path::Path;
use crate::rows::{Rows, wrapped};
use crate::scalar::Scalars;

/// Equations some of whose unknowns are the coordinates.
pub(super) trait InMechanism {
    /// Coordinates in units of the mechanism.
    fn x(&self, point: &Point) -> Vec<f64>;
    /// Coordinates.
    fn q(&self, point: &Point) -> Vec<f64>;
}

impl InMechanism for Path<'_> {
    fn x(&self, point: &Point) -> Vec<f64> {
        point.z.as_slice()[..self.rows.n()].to_vec()
    }

    fn q(&self, point: &Point) -> Vec<f64> {
        self.rows.unscaled(&point.z.as_slice()[..self.rows.n()])
    }
}

/// The equations of critical poses: x, λ, w.
pub(super) struct Critical<'r> {
    pub(super) rows: &'r mut Rows,
    /// x and y of the point first.
    pub(super) point: Scalars,
    pub(super) active: Vec<usize>,
    pub(super) u: Vec<f64>,
    pub(super) t: f64,
    pub(super) size: f64,
}

impl InMechanism for Critical<'_> {
    fn x(&self, point: &Point) -> Vec<f64> {
        point.z.as_slice()[..self.rows.n()].to_vec()
    }

    fn q(&self, point: &Point) -> Vec<f64> {
        self.rows.unscaled(&point.z.as_slice()[..self.rows.n()])
    }
}

impl Critical<'_> {
    /// Φ, and the slopes of Φ and of the point, in units of the mechanism.
    fn slopes(&mut self, x: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let at = self.rows.at(self.t, x, &self.u);
        let q = self.rows.unscaled(x);
        let of_point = self.point.gradients(self.t, &q);
        let m = self.active.len();
        let slopes = DMatrix::from_fn(m + 2, x.len(), |i, k| match self.active.get(i) {
            Some(&row) => at.jacobian[(row, k)],
            None => of_point[i - m][k] * self.rows.unit_of_column[k] / self.size,
        });
        (DVector::from_fn(m, |i, _| at.value[self.active[i]]), slopes)
    }

    /// A critical pose near `x`, by Gauss and Newton's iteration.
    pub(super) fn stationary(&mut self, x: &[f64]) -> Option<DVector<f64>> {
        const MOST: usize = 60;
        let (n, m) = (x.len(), self.active.len());
        // The combination of slopes that is least.
        let (_, slopes) = self.slopes(x);
        let mut square = DMatrix::zeros(n.max(m + 2), m + 2);
        square.rows_mut(0, n).copy_from(&slopes.transpose());
        let v_t = Svd::new(&square)?.v_t;
        let least = v_t.row(v_t.nrows() - 1);
        let mut z = DVector::from_fn(n + m + 2, |i, _| if i < n { x[i] } else { least[i - n] });
        for _ in 0..MOST {
            let (value, jacobian) = self.at(&z);
            if value.amax() < 1e-12 {
                return Some(z);
            }
            let step = Svd::new(&jacobian)?.solve(&value, 1e-10);
            let size = step.norm();
            if !size.is_finite() {
                return None;
            }
            z -= step * if size > 0.4 { 0.4 / size } else { 1.0 };
        }
        None
    }
}

impl Equations for Critical<'_> {
    fn at(&mut self, z: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        const ASIDE: f64 = 1e-6;
        let (n, m) = (self.rows.n(), self.active.len());
        let x = z.as_slice()[..n].to_vec();
        let weights = z.rows(n, m + 2).into_owned();
        let (phi, slopes) = self.slopes(&x);
        let mut value = DVector::zeros(m + n + 1);
        value.rows_mut(0, m).copy_from(&phi);
        value.rows_mut(m, n).copy_from(&(slopes.transpose() * &weights));
        value[m + n] = 0.5 * (weights.norm_squared() - 1.0);
        let mut jacobian = DMatrix::zeros(m + n + 1, z.len());
        jacobian.view_mut((0, 0), (m, n)).copy_from(&slopes.rows(0, m));
        jacobian.view_mut((m, n), (n, m + 2)).copy_from(&slopes.transpose());
        jacobian.view_mut((m + n, n), (1, m + 2)).copy_from(&weights.transpose());
        // Second derivatives by central differences: Newton's iteration needs no more digits of them.
        for k in 0..n {
            let mut forces_at = |off: f64| {
                let mut x = x.clone();
                x[k] += off;
                self.slopes(&x).1.transpose() * &weights
            };
            let change = (forces_at(ASIDE) - forces_at(-ASIDE)) / (2.0 * ASIDE);
            jacobian.view_mut((m, k), (n, 1)).copy_from(&change);
        }
        (value, jacobian)
    }
}

/// True where a critical pose lies on a curve of such poses, with λ and w of either sign.
pub(super) fn holds(way: &[Point], z: &DVector<f64>, (is_turn, n): (&[bool], usize)) -> bool {
    let off = |from: &Point, sign: f64| {
        let off = DVector::from_fn(z.len(), |i, _| {
            let off = if i < n { z[i] - from.z[i] } else { sign * z[i] - from.z[i] };
            if is_turn[i] { wrapped(off) } else { off }
        });
        let along = off.dot(&from.tangent);
        (along.abs() < 0.05, (off - &from.tangent * along).norm())
    };
    let is_near = |(is_next, aside): (bool, f64)| is_next && aside < 2e-3;
    way.iter().any(|from| is_near(off(from, 1.0)) || is_near(off(from, -1.0)))
}
