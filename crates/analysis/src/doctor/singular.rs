//! Singular poses along a drive: where it turns back, and where the mechanism can go on in two ways.
//!
//! ```text
//! dead point     τ · ∇u = 0                 u the drive, τ the direction of the free motion
//! branch point   det [G; τᵀ] changes sign   G loses rank: two curves of poses cross
//! ```
//!
//! Source: E. L. Allgower and K. Georg, *Introduction to Numerical Continuation Methods* (2003), chapter 8.

use bksim_model::Model;
use nalgebra::DMatrix;

use crate::curve::{Curve, Equations, Point};
use crate::drive::position;
use crate::error::AnalysisError;
use crate::extreme::Extremes;
use crate::path::{Law, Path};
use crate::positions::Positions;
use crate::rows::{Clock, wrapped};
use crate::trace::Trace;
use crate::way_rates::ASIDE;

/// A pose in which a drive does not determine the motion.
#[derive(Clone, PartialEq, Debug)]
pub struct SingularPose {
    /// Value of the drive, rad or m.
    pub drive: f64,
    /// The kind of pose.
    pub kind: Singularity,
    /// Positions of joints and bodies there.
    pub pose: Vec<(String, f64)>,
}

/// Kinds of singular poses.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Singularity {
    /// The drive turns back there: it cannot move the mechanism through.
    DeadPoint,
    /// The mechanism can go on in two ways, whatever drives it.
    BranchPoint,
}

/// The singular poses of a mechanism with one free motion along the whole of it, with `name` as its drive; drives of the
/// model are released.
///
/// # Errors
/// [`AnalysisError`] when the start does not close, more than one motion is free, or there is no such measure.
pub fn singular_poses(model: Model, name: &str) -> Result<Vec<SingularPose>, AnalysisError> {
    let measure = position(&model, name)?;
    let positions = Positions::of(model)?;
    let drive = positions.quantity_of(name, measure);
    let is_angle = drive.is_angle();
    let mut watched = Extremes::of(&positions, &[drive])?;
    let last = watched.names().len() - 1;
    let released: Vec<usize> = (0..positions.model().drives.len()).collect();
    let mut rows = positions.rows(&[], &released, Clock::Held)?;
    let x = rows.scaled(&positions.q);
    let law = Law { t: positions.t(), ..Law::default() };
    let mut curve = Path::through(&mut rows, (law, false), &x).map_err(|no_path| {
        let one = |n_free| AnalysisError::NotOneMotion { n_free };
        positions.no_path(no_path, ASIDE, one)
    })?;
    let Some(trace) = Trace::through(&mut curve, &x) else {
        return Err(AnalysisError::Singular { name: name.to_owned() });
    };

    let mut found: Vec<SingularPose> = Vec::new();
    let mut tell = |kind, mut pose: Vec<(String, f64)>| {
        let drive = pose.pop().map_or(f64::NAN, |(_, value)| value);
        let is_known = |known: &SingularPose| {
            known.kind == kind
                && known.pose.iter().zip(&pose).all(|((_, a), (_, b))| wrapped(a - b).abs() < 1e-7)
        };
        if !found.iter().any(is_known) {
            let drive = if is_angle { wrapped(drive) } else { drive };
            found.push(SingularPose { drive, kind, pose });
        }
    };
    for (pair, &step) in trace.points.windows(2).zip(&trace.steps) {
        let ends = [orientation(&mut curve, &pair[0]), orientation(&mut curve, &pair[1])];
        if ends[0] * ends[1] < 0.0 {
            let point = crossing(&mut curve, &pair[0], step, ends);
            tell(Singularity::BranchPoint, watched.pose(&curve, &point));
        }
        for extreme in watched.between(&mut curve, (&pair[0], &pair[1]), [step, step]) {
            let is_drive = extreme.pose[last].1 == extreme.value && extreme.name == name;
            if is_drive {
                tell(Singularity::DeadPoint, extreme.pose);
            }
        }
    }
    Ok(found)
}

/// The point within a step at which the orientation changes its sign. There the corrector is singular, too, so points
/// come as near as it goes, and the last stretch is taken for straight.
pub(crate) fn crossing(
    curve: &mut Curve<Path<'_>>,
    from: &Point,
    step: f64,
    ends: [f64; 2],
) -> Point {
    let at = |z: nalgebra::DVector<f64>| Point { z, tangent: from.tangent.clone() };
    let ([mut a, mut b], [mut at_a, mut at_b]) = ([0.0, step], ends);
    for _ in 0..40 {
        let middle = 0.5 * (a + b);
        let mut z = &from.z + &from.tangent * middle;
        let Some(_) = curve.correct(&mut z, &from.tangent) else { break };
        let Some(point) = curve.point(z, &from.tangent) else { break };
        let value = orientation(curve, &point);
        if (value > 0.0) == (at_a > 0.0) {
            (a, at_a) = (middle, value);
        } else {
            (b, at_b) = (middle, value);
        }
    }
    let c = (a * at_b - b * at_a) / (at_b - at_a);
    let mut corrected = |c: f64| {
        let mut z = &from.z + &from.tangent * c;
        let reached = curve.correct(&mut z, &from.tangent).is_some();
        reached.then_some(z)
    };
    match (corrected(a), corrected(b)) {
        (Some(z_a), Some(z_b)) if b > a => at(&z_a + (z_b - &z_a) * ((c - a) / (b - a))),
        _ => at(&from.z + &from.tangent * c),
    }
}

/// det [G; τᵀ], over its largest size.
pub(crate) fn orientation(curve: &mut Curve<Path<'_>>, point: &Point) -> f64 {
    let (_, jacobian) = curve.equations.at(&point.z);
    let (m, n) = jacobian.shape();
    let mut square = DMatrix::zeros(m + 1, n);
    for (i, row) in jacobian.row_iter().enumerate() {
        let size = row.norm();
        square.row_mut(i).copy_from(&(row / if size > 0.0 { size } else { 1.0 }));
    }
    square.row_mut(m).copy_from(&point.tangent.transpose());
    if square.is_square() { square.determinant() } else { 0.0 }
}
