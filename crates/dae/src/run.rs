//! The start of a run, its end, and what an observer decides in between.

use crate::stats::Stats;

/// Time and state at the start of a run.
///
/// `y` must satisfy all constraints, those obtained by differentiation included. `ydot` starts the
/// iterations and the choice of the first step; components without meaning (derivatives of
/// multipliers) may be zero.
#[derive(Clone, PartialEq, Debug)]
pub struct Start {
    /// Time.
    pub t: f64,
    /// State, length `n`.
    pub y: Vec<f64>,
    /// Derivative, length `n`.
    pub ydot: Vec<f64>,
}

/// An observer's answer to a step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Control {
    /// Go on.
    Continue,
    /// End the run at the end of this step.
    Stop,
}

/// Why a run without errors ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum End {
    /// `t_end` is reached exactly.
    Reached,
    /// The observer asked to stop.
    Stopped,
}

/// The end of a run without errors.
#[derive(Clone, PartialEq, Debug)]
pub struct Outcome {
    /// Why it ended.
    pub end: End,
    /// Time reached.
    pub t: f64,
    /// State at `t`.
    pub y: Vec<f64>,
    /// Derivative at `t`.
    pub ydot: Vec<f64>,
    /// Work done.
    pub stats: Stats,
}
