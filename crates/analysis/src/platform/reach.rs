//! [`Reach`]: coordinates of a mechanism whose platform has been displaced.
//!
//! The platform is brought from its place in the start to the other one with the lengths of its legs released, in small steps
//! with Newton's iteration onto all joints after each. Where a leg comes into a singular pose on the way, another way is taken.

use bksim_expr::Expr;
use bksim_mbs::constraint::Source;
use bksim_model::{Axis, BodyId, Measure};
use bksim_sim::Svd;
use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::legs::Legs;
use super::study::Displacement;
use crate::error::AnalysisError;
use crate::positions::Positions;
use crate::rows::{Clock, RANK_TOLERANCE, Rows};
use crate::scalar::Scalars;

pub(crate) struct Reach {
    /// Joints, and what is held outside of legs.
    rows: Rows,
    held: Vec<f64>,
    /// Centre of mass and direction cosines of base and platform.
    poses: Scalars,
    /// Pose of the platform against the base in the start.
    start: (UnitQuaternion<f64>, Vector3<f64>),
    /// Place of the base.
    base: (UnitQuaternion<f64>, Vector3<f64>),
    size: f64,
    t: f64,
    /// True if lengths can be released; points on circles have none.
    has_ways: bool,
}

/// Numbers of one body's pose.
const N_POSE: usize = 12;

impl Reach {
    pub(super) fn of(
        positions: &Positions,
        legs: &Legs,
        held: &[Measure],
        u: &[f64],
    ) -> Result<Self, AnalysisError> {
        let model = positions.model();
        let in_leg = |joint: usize| legs.holds(&model.joints[joint]);
        // Lengths are released: drives of legs, and links that are legs.
        let is_link = |joint: usize| legs.six.iter().any(|leg| leg.joints == [joint]);
        let constraints = &positions.system().constraints;
        let rows = (0..constraints.len()).filter(|&row| match constraints[row].source {
            Source::Drive(drive) => !in_leg(model.drives[drive.0].joint.0),
            Source::Joint(joint) => !is_link(joint.0),
            _ => true,
        });
        let rows: Vec<usize> = rows.collect();
        let is_kept = |measure: &Measure| match *measure {
            Measure::JointPosition(joint, _) => !in_leg(joint.0),
            _ => true,
        };
        let kept = held.iter().zip(u).filter(|(measure, _)| is_kept(measure));
        let (kept, values): (Vec<Measure>, Vec<f64>) = kept.map(|(m, u)| (*m, *u)).unzip();
        let parameters = positions.mechanism.parameters.as_slice();
        let numbers = (parameters, positions.size, Clock::Held);
        let rows = Rows::compile(model, positions.system(), &kept, &rows, numbers)?;
        let axes = [Axis::X, Axis::Y, Axis::Z];
        let kinematics = &positions.system().kinematics;
        let pose = |&body: &usize| -> Vec<Expr> {
            let body = BodyId(body);
            let at = kinematics.position(model, body, None);
            let cosine =
                |a: Axis, b: Axis| kinematics.measure(model, Measure::DirectionCosine(body, a, b));
            let cosines = axes.iter().flat_map(|&a| axes.iter().map(move |&b| (a, b)));
            at.into_iter().chain(cosines.map(|(a, b)| cosine(a, b))).collect()
        };
        let functions: Vec<Expr> = legs.bodies.iter().flat_map(pose).collect();
        let mut poses = Scalars::compile(model, positions.system(), &functions, parameters)?;
        let values_at_start = poses.values(positions.t(), &positions.q);
        let [base, start] = [0, 1].map(|k| pose_of(&values_at_start[N_POSE * k..]));
        let has_ways = legs.six.iter().all(|leg| !leg.is_circle);
        let (size, t) = (positions.size, positions.t());
        Ok(Self { rows, held: values, poses, start, base, size, t, has_ways })
    }

    /// True where the coordinates show the platform there.
    pub(crate) fn is_at(&mut self, q: &[f64], there: &Displacement) -> bool {
        const SAME: f64 = 1e-7;
        let values = self.poses.values(self.t, q);
        let [base, own] = [0, 1].map(|k| pose_of(&values[N_POSE * k..]));
        // The base may have moved, too.
        let back = self.base.0 * base.0.inverse();
        let at = back * (own.1 - base.1) + self.base.1;
        let off = at - (there.rotation * self.start.1 + there.shift);
        let turned = (back * own.0).angle_to(&(there.rotation * self.start.0));
        off.norm() < SAME * self.size && turned < SAME
    }

    /// Coordinates, in units of the mechanism, near to those of the displaced platform; none where no way leads there.
    pub(crate) fn coordinates(&mut self, start: &[f64], there: &Displacement) -> Option<Vec<f64>> {
        const N_WAYS: u64 = 6;
        if !self.has_ways {
            return None;
        }
        (0..N_WAYS).find_map(|way| self.along(start, there, way))
    }

    /// The end of one way: a screw with a detour that grows with its number.
    fn along(&mut self, start: &[f64], there: &Displacement, way: u64) -> Option<Vec<f64>> {
        const SHORTEST: f64 = 1e-4;
        const LONGEST: f64 = 0.05;
        let mut random = Pcg64::seed_from_u64(way);
        let mut vector = || Vector3::from_fn(|_, _| random.random_range(-0.6..0.6));
        let (aside, about) =
            if way == 0 { Default::default() } else { (vector() * self.size, vector()) };
        let to = there.rotation * self.start.1 + there.shift;
        let (angle, (from, at)) = (there.rotation.scaled_axis(), self.start);
        let target = |s: f64| {
            let detour = (std::f64::consts::PI * s).sin();
            let rotation = UnitQuaternion::from_scaled_axis(angle * s)
                * UnitQuaternion::from_scaled_axis(about * detour)
                * from;
            (rotation, at + (to - at) * s + aside * detour)
        };
        let targets = |s: f64| numbers(target(s));
        let (mut x, mut s, mut step) = (start.to_vec(), 0.0_f64, LONGEST);
        while s < 1.0 {
            let next = f64::min(1.0, s + step);
            if let Some(there) = self.closed(x.clone(), &targets(next)) {
                (x, s) = (there, next);
                step = f64::min(LONGEST, 2.0 * step);
            } else {
                step *= 0.5;
                if step < SHORTEST {
                    return None;
                }
            }
        }
        Some(x)
    }

    /// Newton's iteration onto the joints and a pose of the platform; none where it would be far.
    fn closed(&mut self, mut x: Vec<f64>, pose: &[f64; N_POSE]) -> Option<Vec<f64>> {
        const MOST: usize = 8;
        const FARTHEST: f64 = 0.5;
        const NEAR: f64 = 1e-10;
        for _ in 0..MOST {
            let at = self.rows.at(self.t, &x, &self.held);
            let q = self.rows.unscaled(&x);
            let values = self.poses.values(self.t, &q);
            let slopes = self.poses.gradients(self.t, &q);
            let (m, n) = at.jacobian.shape();
            let unit = |k: usize| if k < 3 { self.size } else { 1.0 };
            let miss = |k: usize| (values[N_POSE + k] - pose[k]) / unit(k);
            let value =
                DVector::from_fn(m + N_POSE, |i, _| if i < m { at.value[i] } else { miss(i - m) });
            if value.amax() < NEAR {
                return Some(x);
            }
            let units = &self.rows.unit_of_column;
            let jacobian = DMatrix::from_fn(m + N_POSE, n, |i, j| match i.checked_sub(m) {
                None => at.jacobian[(i, j)],
                Some(k) => slopes[N_POSE + k][j] * units[j] / unit(k),
            });
            let step = Svd::new(&jacobian)?.solve(&value, RANK_TOLERANCE * jacobian.norm());
            let size = step.amax();
            if size.is_nan() || size > FARTHEST {
                return None;
            }
            x.iter_mut().zip(step.iter()).for_each(|(x, step)| *x -= step);
        }
        None
    }
}

/// Orientation and centre of mass from their numbers.
fn pose_of(values: &[f64]) -> (UnitQuaternion<f64>, Vector3<f64>) {
    let rotation = Matrix3::from_row_slice(&values[3..N_POSE]);
    let rotation = Rotation3::from_matrix_unchecked(rotation);
    (UnitQuaternion::from_rotation_matrix(&rotation), Vector3::from_column_slice(&values[..3]))
}

/// Numbers of an orientation and a centre of mass.
fn numbers((rotation, at): (UnitQuaternion<f64>, Vector3<f64>)) -> [f64; N_POSE] {
    let matrix = rotation.to_rotation_matrix().into_inner().transpose();
    let all: Vec<f64> = at.iter().chain(matrix.iter()).copied().collect();
    std::array::from_fn(|k| all[k])
}
