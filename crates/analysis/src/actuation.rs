//! [`Actuation`]: the efforts of actuators that a motion needs, where there are more of them than free motions, or fewer.
//!
//! ```text
//! r + Gbᵀ λ + Gaᵀ τ = Dᵀ e          r = M a + h + ∂V/∂q − Q, b: joints, a: actuators, D: prescribed motions
//! Gb Z = 0,  D Z = 1                           free motions by the prescribed ones
//! A τ = b − e,   A = −(Ga Z)ᵀ,  b = Zᵀ r
//! τ = W u,  |e| least, then |u| least          W: limits of the efforts
//! τ + N s for any s                            A N = 0: inner forces
//! ```
//!
//! The part e that no actuator can meet is told as an effort along the prescribed motions. Efforts along lengths count times the
//! longest link.

use nalgebra::{DMatrix, DVector};

use crate::curve::independent_rows;
use crate::error::AnalysisError;
use crate::forces::ForcesAt;
use crate::reduced::{null_space, pseudo_inverse};

/// Rows and units of the equations of a motion.
pub(crate) struct Actuation {
    /// Rows of joints, couplings and quaternions among those that hold.
    pub(crate) bearing: Vec<usize>,
    /// Rows of actuators among those that hold.
    pub(crate) acting: Vec<usize>,
    /// Size of the effort of each actuator: its limit, or the unit.
    pub(crate) weights: Vec<f64>,
    /// Unit of each coordinate.
    pub(crate) unit_of_column: Vec<f64>,
    /// Unit of each prescribed motion.
    pub(crate) unit_of_motion: Vec<f64>,
}

/// Efforts in one position.
pub(crate) struct Efforts {
    /// Of all rows that hold.
    pub(crate) lambda: Vec<f64>,
    /// By prescribed motion: the effort along it that no actuator can give.
    pub(crate) missing: Vec<f64>,
    /// Efforts that move nothing, one in each column.
    pub(crate) inner: DMatrix<f64>,
}

/// Parts below this, relative to the largest, are rounding.
const ROUNDING: f64 = 1e-9;

impl Actuation {
    /// The efforts where the equations are `at` this, with λ = 0, and the prescribed motions have the `slopes` D: of the
    /// coordinates that move, before integrals of states.
    pub(crate) fn efforts(&self, at: &ForcesAt, slopes: &DMatrix<f64>) -> Option<Efforts> {
        let n_moving = slopes.ncols();
        let jacobian = at.jacobian.columns(0, n_moving);
        let bearing = jacobian.select_rows(&self.bearing);
        let acting = jacobian.select_rows(&self.acting);
        let residual = at.residual.rows(0, n_moving);
        let (z, chosen) = self.free_motions(&bearing, slopes)?;

        // In units of the mechanism and of the limits.
        let units =
            DVector::from_iterator(chosen.len(), chosen.iter().map(|&k| self.unit_of_motion[k]));
        let weights = DMatrix::from_diagonal(&DVector::from_column_slice(&self.weights));
        let a = -(&acting * &z).transpose();
        let scaled = DMatrix::from_diagonal(&units) * a * &weights;
        let needed = (z.transpose() * residual).component_mul(&units);
        let u = pseudo_inverse(&scaled) * &needed;
        let left = &needed - &scaled * &u;
        let size = needed.amax();
        let missing_of = left.map(|e| if e.abs() > ROUNDING * size { e } else { 0.0 });
        let missing_of = missing_of.component_div(&units);
        let inner = &weights * null_space(&scaled);
        let tau = &weights * u;

        // What the joints carry, with what is missing given from outside.
        let chosen_slopes = slopes.select_rows(&chosen);
        let outside = chosen_slopes.transpose() * &missing_of;
        let right = outside - residual - acting.transpose() * &tau;
        let carried = pseudo_inverse(&bearing.transpose()) * right;
        let mut lambda = vec![0.0; self.bearing.len() + self.acting.len()];
        self.bearing.iter().zip(&carried).for_each(|(&row, value)| lambda[row] = *value);
        self.acting.iter().zip(&tau).for_each(|(&row, value)| lambda[row] = *value);
        let mut missing = vec![0.0; slopes.nrows()];
        chosen.iter().zip(&missing_of).for_each(|(&k, value)| missing[k] = *value);
        lambda.iter().all(|x| x.is_finite()).then_some(Efforts { lambda, missing, inner })
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
