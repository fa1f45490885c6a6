//! [`Actuation`]: the efforts of actuators that a motion needs, where there are more of them than free motions, or fewer.
//!
//! ```text
//! r + Gbᵀ λ + Gaᵀ τ + Gcᵀ c = Dᵀ e  r = M a + h + ∂V/∂q − Q, b: joints, a: actuators, c: contacts, D: prescribed motions
//! Gb Z = 0,  D Z = 1                           free motions by the prescribed ones
//! A τ + C c = b − e,   A = −(Ga Z)ᵀ,  C = −(Gc Z)ᵀ,  b = Zᵀ r
//! τ = W u,  |e| least, then |u| least          W: limits of the efforts;  c within its bounds
//! τ + N s for any s                            A N = 0: inner forces
//! ```
//!
//! Contacts are stops that bear, c ≥ 0, and friction at rest, |c| ≤ F₀. Efforts along lengths count times the longest link.

use bksim_sim::Svd;
use nalgebra::{DMatrix, DVector};

use crate::bounded_least::bounded_least;
use crate::curve::independent_rows;
use crate::error::AnalysisError;
use crate::reduced::{null_space, pseudo_inverse};
use crate::rows::RANK_TOLERANCE;

/// Rows and units of the equations of a motion.
pub(crate) struct Actuation {
    /// Rows of joints, couplings and quaternions.
    pub(crate) bearing: Vec<usize>,
    /// Rows of actuators.
    pub(crate) acting: Vec<usize>,
    /// Size of the effort of each actuator: its limit, or the unit.
    pub(crate) weights: Vec<f64>,
    /// Unit of each coordinate.
    pub(crate) unit_of_column: Vec<f64>,
    /// Unit of each prescribed motion, then of each stop that bears throughout.
    pub(crate) unit_of_motion: Vec<f64>,
}

/// The equations of a motion at one instant, ready for any loads.
pub(crate) struct EffortEquations {
    /// Z, by columns.
    pub(crate) free: DMatrix<f64>,
    /// Prescribed motions that the columns of Z are by.
    chosen: Vec<usize>,
    /// Units of these.
    units: DVector<f64>,
    weights: DVector<f64>,
    /// A W in units of the motions, and its inverse.
    acting: DMatrix<f64>,
    acting_inverse: DMatrix<f64>,
    /// C in units of the motions.
    touching: DMatrix<f64>,
    /// D of the motions that are chosen.
    slopes: DMatrix<f64>,
    n_motions: usize,
    /// Gaᵀ, Gcᵀ, and the inverse of Gbᵀ.
    actuators: DMatrix<f64>,
    contacts: DMatrix<f64>,
    bearing_inverse: DMatrix<f64>,
    /// Rows of λ in the order of joints, actuators and contacts.
    rows: [Vec<usize>; 3],
}

/// Efforts in one position.
#[derive(Clone, Debug)]
pub(crate) struct Efforts {
    /// Of all rows.
    pub(crate) lambda: Vec<f64>,
    /// τ, by actuator.
    pub(crate) tau: DVector<f64>,
    /// c, by contact.
    pub(crate) contacts: DVector<f64>,
    /// By prescribed motion, then stop that bears throughout: the effort along it that nothing can give.
    pub(crate) missing: Vec<f64>,
}

/// Parts below this, relative to the largest, are rounding.
const ROUNDING: f64 = 1e-9;
/// Weight of a motion that is not met next to the size of the efforts.
const MET: f64 = 1e4;

impl Actuation {
    /// The equations where G = `jacobian` of the coordinates that move, the prescribed motions and the stops that bear throughout
    /// have the `slopes` D, and the rows `touching` of contacts have a force.
    pub(crate) fn at(
        &self,
        jacobian: &DMatrix<f64>,
        slopes: &DMatrix<f64>,
        touching: &[usize],
    ) -> Option<EffortEquations> {
        let bearing = jacobian.select_rows(&self.bearing);
        let acting = jacobian.select_rows(&self.acting);
        let contacts = jacobian.select_rows(touching);
        let (z, chosen) = self.free_motions(&bearing, slopes)?;

        // In units of the mechanism and of the limits.
        let units =
            DVector::from_iterator(chosen.len(), chosen.iter().map(|&k| self.unit_of_motion[k]));
        let weights = DVector::from_column_slice(&self.weights);
        let along = |rows: &DMatrix<f64>| DMatrix::from_diagonal(&units) * -(rows * &z).transpose();
        let scaled = along(&acting) * DMatrix::from_diagonal(&weights);
        Some(EffortEquations {
            acting_inverse: pseudo_inverse(&scaled),
            acting: scaled,
            touching: along(&contacts),
            slopes: slopes.select_rows(&chosen),
            n_motions: slopes.nrows(),
            actuators: acting.transpose(),
            contacts: contacts.transpose(),
            bearing_inverse: pseudo_inverse(&bearing.transpose()),
            rows: [self.bearing.clone(), self.acting.clone(), touching.to_vec()],
            free: z,
            chosen,
            units,
            weights,
        })
    }

    /// Z, and the prescribed motions that it is by: as many as are free.
    fn free_motions(
        &self,
        bearing: &DMatrix<f64>,
        slopes: &DMatrix<f64>,
    ) -> Option<(DMatrix<f64>, Vec<usize>)> {
        let units = DVector::from_column_slice(&self.unit_of_column[..slopes.ncols()]);
        let units = DMatrix::from_diagonal(&units);
        let free = &units * null_space(&(bearing * &units));
        if free.ncols() == 0 {
            return Some((free, Vec::new()));
        }
        let along = slopes * &free;
        let scaled = DMatrix::from_fn(along.nrows(), along.ncols(), |k, i| {
            along[(k, i)] / self.unit_of_motion[k]
        });
        let chosen = independent_rows(&scaled);
        if chosen.len() != free.ncols() {
            return None;
        }
        let inverse = along.select_rows(&chosen).try_inverse()?;
        Some((free * inverse, chosen))
    }
}

impl EffortEquations {
    /// The efforts under loads with this `residual` r, its terms of this `size` by free motion, with contacts within `bounds`.
    pub(crate) fn efforts(
        &self,
        residual: &DVector<f64>,
        size: f64,
        bounds: &[[f64; 2]],
    ) -> Option<Efforts> {
        let needed = self.needed(residual);
        let c = self.touching_efforts(&needed, bounds);
        let u = &self.acting_inverse * (&needed - &self.touching * &c);
        self.completed(residual, size, &u, c)
    }

    /// The efforts next to `u` with these efforts of contacts.
    pub(crate) fn efforts_near(
        &self,
        residual: &DVector<f64>,
        size: f64,
        (tau, c): (&DVector<f64>, &DVector<f64>),
    ) -> Option<Efforts> {
        let needed = self.needed(residual);
        let u = tau.component_div(&self.weights);
        let left = &needed - &self.touching * c - &self.acting * &u;
        let u = u + &self.acting_inverse * left;
        self.completed(residual, size, &u, c.clone())
    }

    /// Combinations of efforts, then of contacts, that move nothing, one in each column.
    pub(crate) fn inner(&self) -> DMatrix<f64> {
        let (n, n_contacts) = (self.weights.len(), self.touching.ncols());
        let mut all = DMatrix::zeros(self.chosen.len(), n + n_contacts);
        all.columns_mut(0, n).copy_from(&self.acting);
        all.columns_mut(n, n_contacts).copy_from(&self.touching);
        let mut inner = null_space(&all);
        for (k, weight) in self.weights.iter().enumerate() {
            inner.row_mut(k).scale_mut(*weight);
        }
        inner
    }

    /// Number of inner forces of the actuators alone.
    pub(crate) fn n_inner(&self) -> usize {
        null_space(&self.acting).ncols()
    }

    /// Of each contact whether its force is open together with efforts.
    pub(crate) fn open_contacts(&self) -> Vec<bool> {
        let (inner, n) = (self.inner(), self.weights.len());
        let takes_part = |row: usize| {
            (0..inner.ncols()).any(|k| {
                let column = inner.column(k);
                column.rows(0, n).amax() > ROUNDING * column.amax()
                    && column[n + row].abs() > ROUNDING * column.amax()
            })
        };
        (0..self.touching.ncols()).map(takes_part).collect()
    }

    /// Zᵀ r in units of the motions.
    fn needed(&self, residual: &DVector<f64>) -> DVector<f64> {
        (self.free.transpose() * residual).component_mul(&self.units)
    }

    /// Largest of terms of a residual along the free motions, in units of the motions.
    pub(crate) fn size_along(&self, terms: &DVector<f64>) -> f64 {
        (self.free.abs().transpose() * terms).component_mul(&self.units).amax()
    }

    /// The efforts of contacts with which the motion is met as well as can be, then those of actuators are the smallest.
    fn touching_efforts(&self, needed: &DVector<f64>, bounds: &[[f64; 2]]) -> DVector<f64> {
        let n = bounds.len();
        if n == 0 {
            return DVector::zeros(0);
        }
        // What contacts do to the efforts, and to what no actuator can meet.
        let effort = &self.acting_inverse * &self.touching;
        let unmet = &self.touching - &self.acting * &effort;
        let (own, left) = (
            &self.acting_inverse * needed,
            needed - &self.acting * (&self.acting_inverse * needed),
        );
        let stacked = |first: &DMatrix<f64>, second: DMatrix<f64>| {
            let mut all = DMatrix::zeros(first.nrows() + second.nrows(), first.ncols());
            all.rows_mut(0, first.nrows()).copy_from(first);
            all.rows_mut(first.nrows(), second.nrows()).copy_from(&second);
            all
        };
        let right = stacked(
            &DMatrix::from_columns(std::slice::from_ref(&own)),
            DMatrix::from_columns(&[&left * MET]),
        );
        let (mut c, is_free) =
            bounded_least(&stacked(&effort, &unmet * MET), &right.column(0).into_owned(), bounds);

        // Those within their bounds exactly: first the motion, then the efforts.
        let free: Vec<usize> = (0..n).filter(|&k| is_free[k]).collect();
        let fixed = DVector::from_fn(n, |k, _| if is_free[k] { 0.0 } else { c[k] });
        let (effort_of_free, unmet_of_free) =
            (effort.select_columns(&free), unmet.select_columns(&free));
        let tolerance = RANK_TOLERANCE * self.touching.norm();
        let (inverse, rest) = parts(&unmet_of_free, tolerance);
        let first = inverse * (left - &unmet * &fixed);
        let open = &effort_of_free * &rest;
        let second = pseudo_inverse(&open) * (own - &effort * &fixed - &effort_of_free * &first);
        let exact = first + rest * second;
        let keeps = free.iter().zip(exact.iter()).all(|(&k, x)| {
            let slack = ROUNDING * (x.abs() + c[k].abs());
            *x >= bounds[k][0] - slack && *x <= bounds[k][1] + slack
        });
        if keeps {
            free.iter().zip(exact.iter()).for_each(|(&k, x)| c[k] = *x);
        }
        c
    }

    /// Forces that joints carry, with what is missing given from outside.
    fn completed(
        &self,
        residual: &DVector<f64>,
        size: f64,
        u: &DVector<f64>,
        c: DVector<f64>,
    ) -> Option<Efforts> {
        let needed = self.needed(residual);
        let left = &needed - &self.acting * u - &self.touching * &c;
        let missing_of = left.map(|e| if e.abs() > ROUNDING * size { e } else { 0.0 });
        let missing_of = missing_of.component_div(&self.units);
        let tau = u.component_mul(&self.weights);

        let outside = self.slopes.transpose() * &missing_of;
        let right = outside - residual - &self.actuators * &tau - &self.contacts * &c;
        let carried = &self.bearing_inverse * right;
        let [bearing, acting, touching] = &self.rows;
        let last = self.rows.iter().flatten().max().map_or(0, |row| row + 1);
        let mut lambda = vec![0.0; last];
        bearing.iter().zip(&carried).for_each(|(&row, value)| lambda[row] = *value);
        acting.iter().zip(&tau).for_each(|(&row, value)| lambda[row] = *value);
        touching.iter().zip(&c).for_each(|(&row, value)| lambda[row] = *value);
        let mut missing = vec![0.0; self.n_motions];
        self.chosen.iter().zip(&missing_of).for_each(|(&k, value)| missing[k] = *value);
        let is_finite = lambda.iter().all(|x| x.is_finite());
        is_finite.then_some(Efforts { lambda, tau, contacts: c, missing })
    }
}

/// A⁺, and the directions that A takes to zero, by singular values above a tolerance.
fn parts(matrix: &DMatrix<f64>, tolerance: f64) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = matrix.ncols();
    if n == 0 {
        return (DMatrix::zeros(0, matrix.nrows()), DMatrix::zeros(0, 0));
    }
    let mut square = DMatrix::zeros(n.max(matrix.nrows()), n);
    square.rows_mut(0, matrix.nrows()).copy_from(matrix);
    let Some(svd) = Svd::new(&square) else {
        return (DMatrix::zeros(n, matrix.nrows()), DMatrix::identity(n, n));
    };
    let inverse = svd.pseudo_inverse(tolerance).columns(0, matrix.nrows()).into_owned();
    let free: Vec<usize> = (0..n).filter(|&k| svd.singular_values[k] <= tolerance).collect();
    (inverse, DMatrix::from_fn(n, free.len(), |i, k| svd.v_t[(free[k], i)]))
}

/// An effort of an actuator that may not be exceeded, by the name of its joint or drive.
#[derive(Clone, PartialEq, Debug)]
pub struct EffortLimit {
    /// `A`, or the name of a drive.
    pub name: String,
    /// N or N m, for both signs.
    pub limit: f64,
}

impl EffortLimit {
    /// Reads a limit such as `12 N m` of the actuator `name`, whose effort turns or pushes.
    ///
    /// # Errors
    /// [`AnalysisError::BadRange`] for what is no effort above zero.
    pub fn parse(name: &str, text: &str) -> Result<Self, AnalysisError> {
        let read = |unit| crate::drive::quantity(text, unit).ok();
        let limit = read("N*m").or_else(|| read("N")).filter(|limit| *limit > 0.0);
        let bad = || AnalysisError::BadRange { text: text.to_owned(), unit: "N*m".to_owned() };
        Ok(Self { name: name.to_owned(), limit: limit.ok_or_else(bad)? })
    }
}
