//! Motions that are steady with drives at constant rates: equilibria in the frame that these move.
//!
//! ```text
//! q(t + s) = q + v s,   G v + ∂g/∂t = 0,   D v = 0      D: slopes of the independent quantities
//! Zᵀ r(t + s, q + v s, v)  the same for all s           no force along a free motion depends on the drives' positions
//! ```
//!
//! With r at these velocities an equilibrium is a pose that the mechanism keeps while its drives go on, as of a governor or a
//! bead on a hoop that turns; centrifugal terms are in r, gyroscopic ones in ∂r/∂v.

use bksim_mbs::coordinate::CoordinateKind;
use bksim_model::MotionKind;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::balance::Balance;
use crate::drive::DriveRate;
use crate::error::AnalysisError;
use crate::forces::ForcesAt;
use crate::loaded::Loaded;
use crate::reduced::{Reduced, pseudo_inverse};
use crate::rows::wrapped;

/// Poses in which forces are compared, and by how much drives go on there, rad or longest links.
const N_POSES: usize = 4;
const FURTHER: [f64; 3] = [0.7, 2.1, 4.4];
/// Part of the forces below which a difference is rounding.
const SAME: f64 = 1e-8;

impl Loaded {
    /// Drives whose motions are functions of time, with their rates at the start.
    pub(crate) fn moving_drives(&self) -> Vec<DriveRate> {
        let model = self.model();
        let pool = &model.pool;
        let moving = model.drives.iter().filter(|drive| pool.depends_on(drive.motion, model.time));
        let rate = |drive: &bksim_model::Drive| {
            let value =
                |symbol| if symbol == model.time { Some(self.t) } else { self.value_of(symbol) };
            let motions = model.joints[drive.joint.0].kind.motions();
            let turns = motions.get(drive.motion_idx).is_some_and(|m| *m == MotionKind::Rotation);
            DriveRate {
                name: drive.name.clone(),
                rate: pool
                    .evaluate(pool.diff(drive.motion, model.time), &value)
                    .unwrap_or(f64::NAN),
                unit: if turns { "rad/s" } else { "m/s" },
            }
        };
        moving.map(rate).collect()
    }

    /// True where drives move at constant rates and no force along the free motions depends on how far they are.
    pub(crate) fn moves_steadily(&self) -> Result<bool, AnalysisError> {
        if self.moving_drives().iter().all(|drive| drive.rate == 0.0) {
            return Ok(false);
        }
        Ok(Balance::of(self, &[], &[])?.is_steady().unwrap_or(false))
    }
}

/// Forces along the free motions, and the size of what they are the sum of.
struct Along {
    forces: DVector<f64>,
    size: f64,
}

/// Velocities with the drives from the equations without velocities, those of the independent coordinates zero.
pub(crate) fn steady_velocities(loaded: &Loaded, at: &ForcesAt) -> Option<Vec<f64>> {
    let reduced = Reduced::at(loaded, &at.jacobian, &[]).ok()?;
    let v = -(pseudo_inverse(&at.jacobian) * &at.rate);
    let own = &reduced.basis * (&reduced.slopes * &v);
    let mut v = v - own;
    let largest = v.amax();
    // What rounding leaves of zero is no rate.
    v.iter_mut().filter(|rate| rate.abs() <= 1e-12 * largest).for_each(|rate| *rate = 0.0);
    Some(v.as_slice().to_vec())
}

impl Balance<'_> {
    /// Velocities with the drives, those of the independent coordinates zero.
    pub(crate) fn steady_rates(&mut self) -> Option<Vec<f64>> {
        let q = self.start();
        let nothing = vec![0.0; q.len()];
        let at = self.moving_at(self.loaded.t, [&q, &nothing]);
        steady_velocities(self.loaded, &at)
    }

    /// True where forces along the free motions stay as they are while the drives go on, in the start and in poses near it.
    fn is_steady(&mut self) -> Option<bool> {
        let (start, t) = (self.start(), self.loaded.t);
        let v = self.steady_rates()?;
        let units = self.units();
        let fastest = v.iter().zip(&units).fold(0.0, |a: f64, (v, unit)| a.max((v / unit).abs()));
        let at = self.moving_at(t, [&start, &v]);
        let n_states = self.states().len();
        if fastest == 0.0 || Reduced::at(self.loaded, &at.jacobian, &[]).ok()?.n() == n_states {
            return Some(false);
        }
        let inertia = DMatrix::from_fn(units.len(), units.len(), |i, j| {
            at.mass[(i, j)] * units[i] * units[j]
        });
        let mut size = inertia.amax() * fastest * fastest;
        let mut changes: f64 = 0.0;
        let mut random = Pcg64::seed_from_u64(1);
        for k in 0..N_POSES {
            let aside = if k == 0 { 0.0 } else { 0.4 };
            let Some(q) = self.near(&start, &v, &mut || aside * random.random_range(-1.0..1.0))
            else {
                continue;
            };
            let first = self.forces_along(t, [&q, &v])?;
            size = size.max(first.size);
            for share in FURTHER {
                let dt = share / fastest;
                let later: Vec<f64> = q.iter().zip(&v).map(|(q, v)| q + v * dt).collect();
                let Some(then) = self.forces_along(t + dt, [&later, &v]) else {
                    return Some(false);
                };
                size = size.max(then.size);
                changes = changes.max((then.forces - &first.forces).amax());
            }
        }
        Some(changes <= SAME * size)
    }

    /// A closed pose near another one.
    fn near(&mut self, q: &[f64], v: &[f64], share: &mut dyn FnMut() -> f64) -> Option<Vec<f64>> {
        let t = self.loaded.t;
        let at = self.moving_at(t, [q, v]);
        let reduced = Reduced::at(self.loaded, &at.jacobian, &[]).ok()?;
        let kinds = self.loaded.system().coordinates();
        let is_length = |name: &String| {
            kinds.iter().any(|c| c.name == *name && c.kind == CoordinateKind::Length)
        };
        let unit = |name: &String| if is_length(name) { self.loaded.size } else { 1.0 };
        let y = DVector::from_iterator(
            reduced.n(),
            reduced.names.iter().map(|name| share() * unit(name)),
        );
        let mut q = DVector::from_column_slice(q) + &reduced.basis * y;
        for _ in 0..20 {
            let at = self.moving_at(t, [q.as_slice(), v]);
            if at.closure.is_empty() || at.closure.amax() <= 1e-12 * self.loaded.size.max(1.0) {
                return Some(q.as_slice().to_vec());
            }
            q -= pseudo_inverse(&at.jacobian) * &at.closure;
        }
        None
    }

    /// Forces along the free motions in a pose with velocities; `None` where these do not keep it closed.
    fn forces_along(&mut self, t: f64, [q, v]: [&[f64]; 2]) -> Option<Along> {
        let at = self.moving_at(t, [q, v]);
        let fastest = v.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
        let length = self.loaded.size.max(1.0);
        let stays = at.closure.iter().all(|g| wrapped(*g).abs() <= SAME * length)
            && at.rate.iter().all(|rate| rate.abs() <= SAME * fastest * length);
        if !stays {
            return None;
        }
        let reduced = Reduced::at(self.loaded, &at.jacobian, &[]).ok()?;
        let moved = (&at.velocity_by_position * &reduced.basis).abs();
        if moved.iter().any(|slope| *slope > SAME * fastest * length) {
            return None;
        }
        let forces = reduced.basis.transpose() * &at.residual;
        let size = (reduced.basis.abs().transpose() * at.residual.abs()).amax();
        Some(Along { forces, size })
    }
}
