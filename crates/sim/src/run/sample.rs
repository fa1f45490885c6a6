//! [`Sample`]: everything about one instant, and its derivatives by some quantity.

use bksim_dae::Stats;

pub use crate::evaluator::Energy;

/// Everything about one instant.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Sample {
    /// s.
    pub t: f64,
    /// Coordinates, nq.
    pub q: Vec<f64>,
    /// Velocities, nq.
    pub v: Vec<f64>,
    /// Accelerations, nq.
    pub a: Vec<f64>,
    /// Multipliers, nc.
    pub lambda: Vec<f64>,
    /// Reactions on the successors, by joint: force N, moment N m, world axes.
    pub reactions: Vec<[f64; 6]>,
    /// Values of the model's [inputs](crate::input), SI.
    pub inputs: Vec<f64>,
    /// Values of the named signals, SI.
    pub signals: Vec<f64>,
    /// Energies and power.
    pub energy: Energy,
    /// Work of loads and drives since the start, J.
    pub work: f64,
    /// Largest |g| of the integrator's state and of the sample, m or rad.
    pub position_residual: [f64; 2],
    /// Largest |G v + ∂g/∂t| of the integrator's state and of the sample, m/s or rad/s.
    pub velocity_residual: [f64; 2],
    /// Step size at this instant, s; zero at the start.
    pub step_size: f64,
    /// Counters so far.
    pub stats: Stats,
}

impl Sample {
    /// True if every number of it is finite.
    pub fn is_finite(&self) -> bool {
        let Self { q, v, a, lambda, reactions, inputs, signals, energy, work, .. } = self;
        let Energy { kinetic, potential, power } = *energy;
        let parts = [q, v, a, lambda, inputs, signals, reactions.as_flattened()];
        let alone = [kinetic, potential, power, *work];
        parts.into_iter().flatten().chain(&alone).all(|value| value.is_finite())
    }
}

/// Derivatives of one instant by one quantity, in the units of each over the unit of the quantity.
#[derive(Clone, PartialEq, Debug)]
pub struct StateSensitivity {
    /// Of the coordinates, nq.
    pub q: Vec<f64>,
    /// Of the velocities, nq.
    pub v: Vec<f64>,
    /// Of the accelerations, nq.
    pub a: Vec<f64>,
    /// Of the multipliers, nc; of the smallest ones when they are not unique.
    pub lambda: Vec<f64>,
    /// Of the energies, reactions, signals and points that [`crate::sensitivity::channels`] lists; none of a start,
    /// before its sample.
    pub channels: Vec<f64>,
}
