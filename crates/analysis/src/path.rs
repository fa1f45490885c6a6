//! [`Path`]: positions along one free motion, with or without a parameter of what is prescribed.

use nalgebra::{DMatrix, DVector};

use crate::curve::{Curve, Equations, independent_rows};
use crate::rows::Rows;

/// Prescribed values and time as functions of the parameter s: t = t₀ + ṫ s, u = u₀ + u′ s.
#[derive(Clone, Debug, Default)]
pub(crate) struct Law {
    pub(crate) t: f64,
    pub(crate) t_slope: f64,
    pub(crate) u: Vec<f64>,
    pub(crate) u_slope: Vec<f64>,
}

/// Rows of positions as equations of coordinates in units of the mechanism, then of the parameter, if
/// there is one.
pub(crate) struct Path<'r> {
    pub(crate) rows: &'r mut Rows,
    pub(crate) law: Law,
    has_parameter: bool,
    /// Rows that the others follow from.
    active: Vec<usize>,
}

impl<'r> Path<'r> {
    /// The curve through `x`, where the parameter, if there is one, is zero.
    ///
    /// # Errors
    /// The number of free motions, where that is another than one.
    pub(crate) fn through(
        rows: &'r mut Rows,
        (law, has_parameter): (Law, bool),
        x: &[f64],
    ) -> Result<Curve<Self>, usize> {
        let active = (0..rows.n_rows()).collect();
        let mut path = Self { rows, law, has_parameter, active };
        let z = path.unknowns(x);
        let n = z.len();
        let all = path.active.clone();
        let mut best = independent_rows(&path.at(&z).1);
        // In a singular pose the rows tell more a little aside.
        for k in 0..n {
            if best.len() + 1 >= n {
                break;
            }
            let mut aside = z.clone();
            aside[k] += 1e-3;
            path.active.clone_from(&all);
            let found = independent_rows(&path.at(&aside).1);
            if found.len() > best.len() && found.len() < n {
                best = found;
            }
        }
        path.active = best;
        let n_free = n - path.active.len();
        if n_free == 1 { Ok(Curve { equations: path }) } else { Err(n_free) }
    }

    /// Unknowns at coordinates in units of the mechanism, with the parameter zero.
    pub(crate) fn unknowns(&self, x: &[f64]) -> DVector<f64> {
        let mut z = DVector::zeros(x.len() + usize::from(self.has_parameter));
        z.rows_mut(0, x.len()).copy_from_slice(x);
        z
    }

    /// Time at a value of the parameter.
    pub(crate) fn time(&self, s: f64) -> f64 {
        self.law.t + self.law.t_slope * s
    }
}

impl Equations for Path<'_> {
    fn at(&mut self, z: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let n = self.rows.n();
        let s = if self.has_parameter { z[n] } else { 0.0 };
        let law = self.law.u.iter().zip(&self.law.u_slope);
        let u: Vec<f64> = law.map(|(u, slope)| u + slope * s).collect();
        let at = self.rows.at(self.time(s), &z.as_slice()[..n], &u);
        let value = DVector::from_fn(self.active.len(), |i, _| at.value[self.active[i]]);
        let first = self.rows.first_prescribed();
        let jacobian = DMatrix::from_fn(self.active.len(), z.len(), |i, column| {
            let row = self.active[i];
            if column < n {
                return at.jacobian[(row, column)];
            }
            let of_time = at.rate[row] * self.law.t_slope;
            match row.checked_sub(first).and_then(|k| Some((k, self.law.u_slope.get(k)?))) {
                Some((k, slope)) => of_time - slope / self.rows.unit_of_prescribed(k),
                None => of_time,
            }
        });
        (value, jacobian)
    }
}
