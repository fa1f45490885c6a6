//! [`Reduced`]: the motions that constraints leave free, by independent coordinates.
//!
//! ```text
//! δq = Z y,   G Z = 0,   D Z = 1     y: deviations of the independent quantities, whose slopes are D
//! M_r = Zᵀ M Z,   C_r = Zᵀ C Z,   K_r = Zᵀ K Z
//! ```

use bksim_mbs::coordinate::{CoordinateKind, Owner};
use bksim_sim::Svd;
use nalgebra::{DMatrix, DVector};

use crate::error::AnalysisError;
use crate::loaded::Loaded;
use crate::rows::RANK_TOLERANCE;

/// Free motions at a position.
#[derive(Clone, Debug)]
pub(crate) struct Reduced {
    /// Z, nq × n_free, SI.
    pub(crate) basis: DMatrix<f64>,
    /// D, n_free × nq, SI.
    pub(crate) slopes: DMatrix<f64>,
    /// Names of the independent quantities.
    pub(crate) names: Vec<String>,
    /// Units of these.
    pub(crate) units: Vec<&'static str>,
}

/// Vectors that span what `jacobian` leaves free, orthonormal, in columns.
pub(crate) fn null_space(jacobian: &DMatrix<f64>) -> DMatrix<f64> {
    let n = jacobian.ncols();
    let mut square = DMatrix::zeros(n.max(jacobian.nrows()), n);
    square.rows_mut(0, jacobian.nrows()).copy_from(jacobian);
    let Some(svd) = Svd::new(&square) else { return DMatrix::zeros(n, 0) };
    let free: Vec<usize> = (0..n)
        .filter(|&k| svd.singular_values[k] <= RANK_TOLERANCE * svd.largest().max(1e-300))
        .collect();
    DMatrix::from_fn(n, free.len(), |i, k| svd.v_t[(free[k], i)])
}

/// A⁺ by singular values.
pub(crate) fn pseudo_inverse(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let zero = || DMatrix::zeros(matrix.ncols(), matrix.nrows());
    let tolerance = RANK_TOLERANCE * matrix.norm();
    Svd::new(matrix).map_or_else(zero, |svd| svd.pseudo_inverse(tolerance))
}

impl Reduced {
    /// The free motions where G = `jacobian`, by the measures `named` with their slopes, else by
    /// coordinates: those of joints with the ground first.
    pub(crate) fn at(
        loaded: &Loaded,
        jacobian: &DMatrix<f64>,
        named: &[(String, &'static str, Vec<f64>)],
    ) -> Result<Self, AnalysisError> {
        // In units of the mechanism, so that metres and radians weigh alike.
        let coordinates = loaded.system().coordinates();
        let unit = |i: usize| match coordinates[i].kind {
            CoordinateKind::Angle | CoordinateKind::Quaternion | CoordinateKind::Integral => 1.0,
            CoordinateKind::Length => loaded.size,
        };
        let n = coordinates.len();
        let scaled = DMatrix::from_fn(jacobian.nrows(), n, |row, i| jacobian[(row, i)] * unit(i));
        let mut free = null_space(&scaled);
        for i in 0..n {
            free.row_mut(i).scale_mut(unit(i));
        }
        let n_free = free.ncols();
        let chosen: Vec<(String, &'static str, DVector<f64>)> = if named.is_empty() {
            let own = |i: usize| {
                let unit = coordinates[i].kind.unit();
                let slope = DVector::from_fn(n, |k, _| f64::from(u8::from(k == i)));
                (coordinates[i].name.clone(), unit, slope)
            };
            independent(&free, &order(loaded), &unit).into_iter().map(own).collect()
        } else {
            let given = |(name, unit, slopes): &(String, &'static str, Vec<f64>)| {
                (name.clone(), *unit, DVector::from_column_slice(slopes))
            };
            named.iter().map(given).collect()
        };
        if chosen.len() != n_free {
            return Err(AnalysisError::NQuantities { n_free, n_named: chosen.len() });
        }
        let slopes = DMatrix::from_fn(n_free, n, |k, i| chosen[k].2[i]);
        let name = || chosen.first().map_or_else(String::new, |(name, ..)| name.clone());
        let inverse = (&slopes * &free)
            .try_inverse()
            .filter(|inverse| inverse.iter().all(|x| x.is_finite() && x.abs() < 1e9));
        let inverse = inverse.ok_or_else(|| AnalysisError::Singular { name: name() })?;
        Ok(Self {
            basis: free * inverse,
            slopes,
            names: chosen.iter().map(|(name, ..)| name.clone()).collect(),
            units: chosen.iter().map(|(_, unit, _)| *unit).collect(),
        })
    }

    /// Number of free motions.
    pub(crate) fn n(&self) -> usize {
        self.basis.ncols()
    }

    /// Zᵀ A Z.
    pub(crate) fn project(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        self.basis.transpose() * matrix * &self.basis
    }
}

/// Coordinates, those of joints with the ground first.
fn order(loaded: &Loaded) -> Vec<usize> {
    let model = loaded.model();
    let coordinates = loaded.system().coordinates();
    let joins_ground = |joint: bksim_model::JointId| {
        let joint = &model.joints[joint.0];
        joint.predecessor.body == bksim_model::GROUND || joint.successor.body == bksim_model::GROUND
    };
    let is_on_ground = |i: &usize| match coordinates[*i].owner {
        Owner::Joint(joint, _) => joins_ground(joint),
        Owner::Quaternion(body, _) => loaded.system().tree.joint_of(body).is_some_and(joins_ground),
        Owner::Body(..) | Owner::State(_) => false,
    };
    let all = 0..coordinates.len();
    let (mut first, rest): (Vec<usize>, Vec<usize>) = all.partition(is_on_ground);
    first.extend(rest);
    first
}

/// Coordinates that the free motions can be told by, the first ones in `order` that do well.
fn independent(free: &DMatrix<f64>, order: &[usize], unit: &dyn Fn(usize) -> f64) -> Vec<usize> {
    for weakest in [0.05, 1e-3, 1e-8] {
        let mut chosen: Vec<usize> = Vec::new();
        let mut rest: DMatrix<f64> = free.clone();
        for i in 0..rest.nrows() {
            rest.row_mut(i).scale_mut(1.0 / unit(i));
        }
        for &i in order {
            let row = rest.row(i).transpose();
            let length = row.norm();
            if chosen.len() < free.ncols() && length > weakest {
                let direction = row / length;
                for k in 0..rest.nrows() {
                    let along = rest.row(k).transpose().dot(&direction);
                    let less = rest.row(k) - direction.transpose() * along;
                    rest.row_mut(k).copy_from(&less);
                }
                chosen.push(i);
            }
        }
        if chosen.len() == free.ncols() {
            chosen.sort_unstable();
            return chosen;
        }
    }
    Vec::new()
}
