//! [`Path`]: positions along one free motion, with or without a parameter of what is prescribed.

use nalgebra::{DMatrix, DVector};

use crate::around::{Around, Way, around};
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
    /// Largest residual of the others where all were last asked for.
    left_out: f64,
    /// The way that is followed from a pose where several cross.
    way: Option<Way>,
}

/// Part of a direction below which the parameter does not change.
const NO_CHANGE: f64 = 1e-6;

/// Poses around a start that are no curve.
#[derive(Clone, Debug)]
pub(crate) enum NoPath {
    /// This number of motions is free there.
    Free(usize),
    /// It yields in these directions, in units of the mechanism, but goes nowhere.
    Nowhere(Vec<DVector<f64>>),
    /// Curves cross, and none is chosen.
    Crossing(Vec<Way>),
    /// Curves cross, and none has this number.
    NoWay(usize, Vec<Way>),
    /// Curves cross, and the parameter does not change along that of this number.
    Still(usize),
}

impl<'r> Path<'r> {
    /// The curve through `x`, where the parameter, if there is one, is zero.
    ///
    /// # Errors
    /// [`NoPath`] where there is not one curve alone.
    pub(crate) fn through(
        rows: &'r mut Rows,
        law: (Law, bool),
        x: &[f64],
    ) -> Result<Curve<Self>, NoPath> {
        Self::along(rows, law, x, None)
    }

    /// The curve through `x`; of several that cross there that of the number `branch`, from one.
    ///
    /// # Errors
    /// [`NoPath`] where there is no such curve.
    pub(crate) fn along(
        rows: &'r mut Rows,
        law: (Law, bool),
        x: &[f64],
        branch: Option<usize>,
    ) -> Result<Curve<Self>, NoPath> {
        let mut path = Self::of_all(rows, law);
        let z = path.unknowns(x);
        let n = z.len();
        match around(&mut path, &z) {
            Around::Nowhere(directions) => return Err(NoPath::Nowhere(directions)),
            Around::Regular(1) => path.active = independent_rows(&path.at(&z).1),
            Around::Regular(n_free) => return Err(NoPath::Free(n_free)),
            Around::Crossing(ways) => {
                let alone = (ways.len() == 1).then_some(1);
                let Some(number) = branch.or(alone) else { return Err(NoPath::Crossing(ways)) };
                let way = number.checked_sub(1).and_then(|k| ways.get(k)).cloned();
                let Some(way) = way else { return Err(NoPath::NoWay(number, ways)) };
                if path.has_parameter && way.tangent[n - 1].abs() < NO_CHANGE {
                    return Err(NoPath::Still(number));
                }
                // The rows show more a little ahead.
                path.active = independent_rows(&path.at(&way.ahead).1);
                path.way = Some(way);
            }
        }
        let n_free = n - path.active.len();
        if n_free == 1 { Ok(Curve { equations: path }) } else { Err(NoPath::Free(n_free)) }
    }

    /// The equations with all rows, none of which is taken to follow from others.
    pub(crate) fn of_all(rows: &'r mut Rows, (law, has_parameter): (Law, bool)) -> Self {
        let active = (0..rows.n_rows()).collect();
        Self { rows, law, has_parameter, active, left_out: 0.0, way: None }
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
        let others = (0..at.value.len()).filter(|row| self.active.binary_search(row).is_err());
        self.left_out = others.fold(0.0, |most: f64, row| most.max(at.value[row].abs()));
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

    fn left_out(&self) -> f64 {
        self.left_out
    }

    fn first_direction(&self) -> Option<DVector<f64>> {
        self.way.as_ref().map(|way| way.tangent.clone())
    }
}
