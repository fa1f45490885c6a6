//! The `[solve]` table: how a motion is integrated and sampled.

pub use bksim_expr::Jit;

use crate::diagnostic::Span;

/// The largest number of samples, and of fixed steps, of a run: hours of work, and terabytes.
pub const MOST_OUTPUTS: f64 = 1e10;

/// The `[solve]` table; every field has a default, so that a model without one solves.
#[derive(Clone, Debug)]
pub struct SolveOptions {
    /// Start, s. Default 0.
    pub t_start: f64,
    /// End, s. Default 10.
    pub t_end: f64,
    /// Output interval, s, where outputs are even. Default: a five-hundredth of the span.
    pub every: Option<f64>,
    /// Times of the samples. Default: evenly.
    pub outputs: Outputs,
    /// Relative tolerance. Default 1e-6.
    pub rtol: f64,
    /// Absolute tolerance in the units of each coordinate. Default 1e-8.
    pub atol: f64,
    /// Fixed step, s; `None` for adaptive steps.
    pub step: Option<f64>,
    /// In fixed-step mode, Newton's iteration ends below this error. Default 1e-10.
    pub newton_tolerance: f64,
    /// The integrator.
    pub method: Method,
    /// Which equations Radau integrates.
    pub formulation: Formulation,
    /// Use of machine code; no result depends on it. Default: when it pays.
    pub jit: Jit,
    /// Position of each stated key, for messages that arise later.
    pub spans: Vec<(String, Span)>,
}

impl SolveOptions {
    /// The interval of even outputs, s.
    pub fn interval(&self) -> f64 {
        self.every.unwrap_or((self.t_end - self.t_start).abs() / 500.0)
    }

    /// The option that makes more than [`MOST_OUTPUTS`] samples or steps, with its value and their number.
    pub fn too_many(&self) -> Option<(&'static str, f64, f64)> {
        let span = (self.t_end - self.t_start).abs();
        let every = (self.outputs == Outputs::Even).then(|| ("every", self.interval()));
        let step = self.step.map(|step| ("step", step));
        let counted = |(key, interval)| (key, interval, span / interval);
        [every, step].into_iter().flatten().map(counted).find(|&(.., n)| n > MOST_OUTPUTS)
    }
}

/// Times of the samples between the start and the end.
#[derive(Clone, PartialEq, Debug, Default)]
pub enum Outputs {
    /// At even intervals.
    #[default]
    Even,
    /// At the end of every accepted step, and where something switches.
    Steps,
    /// At these times, s, in any order; those outside of the run are passed over.
    Times(Vec<f64>),
}

/// The integrator of the equations of motion.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Method {
    /// Explicit steps as long as the motion is not stiff, then Radau IIA. Radau IIA with a fixed
    /// step.
    #[default]
    Auto,
    /// Radau IIA on the chosen formulation.
    Radau,
    /// Dormand–Prince 8(5,3) on the accelerations of the multiplier system, with projection.
    Explicit,
}

/// Which form of the equations of motion is integrated by Radau.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Formulation {
    /// Stabilised index 2 (Gear, Gupta and Leimkuhler 1985): position and velocity constraints.
    Ggl,
    /// Index 2: velocity constraints only; positions are projected after every step.
    #[default]
    Index2,
    /// Index 3: position constraints only.
    Index3,
    /// Index 1: acceleration constraints only; positions and velocities are projected after every
    /// step.
    Index1,
}
