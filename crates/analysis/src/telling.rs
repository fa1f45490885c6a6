//! Quantities in which equilibria differ: coordinates, unless two equilibria have the same ones; then positions of joints.
//!
//! In coordinates of bodies a pendulum is at the same `x` upright and hanging, and only the angle of its pin differs.

use nalgebra::DMatrix;

use crate::balance::Balance;
use crate::error::AnalysisError;
use crate::quantity::PoseQuantity;

/// Coordinates that differ by less are equal, rad or parts of the longest link.
const SAME: f64 = 1e-6;
/// Most poses whose coordinates are looked at.
const MOST: usize = 8;
/// Part of a rate of one that is left of a measure that follows from others.
const FOLLOWS: f64 = 1e-3;

impl Balance<'_> {
    /// Describes free motions by positions of joints, unless measures are named or the `poses` differ in their coordinates.
    pub(crate) fn tell_apart(&mut self, poses: &[&Vec<f64>]) -> Result<(), AnalysisError> {
        if poses.len() < 2 || !self.by.0.is_empty() || !self.states().is_empty() {
            return Ok(());
        }
        // The coordinates that are independent depend on the pose.
        let mut reference = None;
        for q in poses.iter().take(MOST) {
            let nothing = vec![0.0; self.forces.nc()];
            let jacobian = self.at(q, &nothing).jacobian;
            let Ok(reduced) = self.reduced(q, &jacobian) else { continue };
            if self.n_motions.is_some_and(|n| n != reduced.n()) {
                continue;
            }
            let coordinates = self.loaded.system().coordinates();
            let is_own = |i: &usize| reduced.names.contains(&coordinates[*i].name);
            let own: Vec<usize> = (0..coordinates.len()).filter(is_own).collect();
            let are_same = |a: &[f64], b: &[f64]| {
                let off = self.apart(a, b);
                own.iter().all(|&i| off[i].abs() < SAME)
            };
            let is_like_another =
                |k: usize| poses[..k].iter().any(|other| are_same(poses[k], other));
            if (1..poses.len()).any(is_like_another) {
                reference = Some((*q, reduced));
                break;
            }
        }
        let Some((first, reduced)) = reference else { return Ok(()) };
        let chosen = self.independent_joints(first, &reduced.basis);
        if chosen.len() == reduced.n() {
            let quantities: Vec<PoseQuantity> =
                chosen.into_iter().map(|k| self.loaded.quantities[k].clone()).collect();
            self.by = (quantities.clone(), self.loaded.scalars(&quantities)?);
        }
        Ok(())
    }

    /// Numbers of the positions of joints whose rates do not follow from those of others, along free motions.
    fn independent_joints(&mut self, q: &[f64], basis: &DMatrix<f64>) -> Vec<usize> {
        let loaded = self.loaded;
        let n_of_joints: usize =
            loaded.model().joints.iter().map(|joint| joint.kind.motions().len()).sum();
        let n_of_joints = n_of_joints.min(loaded.quantities.len());
        let gradients = self.pose_gradients(q);
        let slopes = DMatrix::from_fn(n_of_joints, q.len(), |k, i| gradients[k][i]);
        let mut rest = slopes * basis;
        for (k, mut row) in rest.row_iter_mut().enumerate() {
            if !loaded.quantities[k].is_angle() {
                row /= loaded.size;
            }
        }
        let largest = rest.amax();
        let mut chosen = Vec::new();
        for k in 0..n_of_joints {
            let row = rest.row(k).transpose();
            let length = row.norm();
            if length <= FOLLOWS * largest || !length.is_finite() {
                continue;
            }
            let direction = row / length;
            let along = &rest * &direction;
            rest -= along * direction.transpose();
            chosen.push(k);
        }
        chosen
    }
}
