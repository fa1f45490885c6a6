//! Causes that end a run early, with the numbers that matter.

use std::fmt;

use crate::stats::Stats;

/// An error that ends a run before `t_end`, or keeps it from starting.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SolveError {
    /// The step size was cut until it met its floor.
    #[error("step size fell to {:.3e} at t = {}: {cause}", .at.h, .at.t)]
    StepTooSmall {
        /// Cause of the last failure.
        cause: Cause,
        /// State of the run.
        at: Box<Standstill>,
    },
    /// A step of constant size failed; a smaller constant step may pass.
    #[error("step of constant size {:.3e} failed at t = {}: {cause}", .at.h, .at.t)]
    FixedStepFailed {
        /// Cause of the failure.
        cause: Cause,
        /// State of the run.
        at: Box<Standstill>,
    },
    /// The residual or its Jacobian has no finite value, however small the step.
    #[error("equation {row} has no finite value near t = {}", .at.t)]
    NotFinite {
        /// Row of `F`, counted from zero.
        row: usize,
        /// State of the run; `y` is the state at which the row was evaluated.
        at: Box<Standstill>,
    },
    /// The allowed number of steps is used up.
    #[error("{limit} steps were not enough: t = {} with step size {:.3e}", .at.t, .at.h)]
    TooManySteps {
        /// The number allowed.
        limit: usize,
        /// State of the run.
        at: Box<Standstill>,
    },
    /// Stability, not accuracy, limits the steps of an explicit method: a method for stiff
    /// equations needs less work.
    #[error("the equations are stiff near t = {}: step size {:.3e} is limited by stability", .at.t, .at.h)]
    Stiff {
        /// State of the run.
        at: Box<Standstill>,
    },
    /// The linear equations of the sensitivities were not solved.
    #[error("the sensitivities cannot follow the step near t = {}: {cause}", .at.t)]
    Sensitivity {
        /// Cause of the failure.
        cause: Cause,
        /// State of the run.
        at: Box<Standstill>,
    },
    /// A checkpoint does not belong to this run.
    #[error("the checkpoint cannot be used: {reason}")]
    Checkpoint {
        /// The fault found.
        reason: &'static str,
    },
    /// A vector has the wrong length.
    #[error("`{what}` has {found} entries, the system has {expected} unknowns")]
    WrongLength {
        /// Name of the vector.
        what: &'static str,
        /// Length needed.
        expected: usize,
        /// Length given.
        found: usize,
    },
    /// A start or end value is not finite.
    #[error("`{what}` is not finite: {value}")]
    InvalidStart {
        /// Name of the value.
        what: &'static str,
        /// The value given.
        value: f64,
    },
    /// An option is out of its range.
    #[error("option `{field}` must be {range}, found {value}")]
    InvalidSetting {
        /// Path of the option within [`crate::Settings`].
        field: &'static str,
        /// The value given.
        value: f64,
        /// The range it must lie in.
        range: &'static str,
    },
    /// An entry of a sparsity pattern lies outside the matrix.
    #[error("entry ({row}, {col}) lies outside a matrix of size {n}")]
    EntryOutside {
        /// Row given.
        row: usize,
        /// Column given.
        col: usize,
        /// Size of the matrix.
        n: usize,
    },
    /// A row named by [`crate::System::explicit_rows`] does not give its unknown.
    #[error("row {row} cannot give unknown {unknown}: it {reason}")]
    ExplicitRow {
        /// Row named.
        row: usize,
        /// Unknown named.
        unknown: usize,
        /// The fault of the pair.
        reason: &'static str,
    },
    /// The sparse linear solver cannot hold the factors of the system.
    #[error("no memory for the factors of a system of size {n}")]
    OutOfMemory {
        /// Number of unknowns.
        n: usize,
    },
}

impl SolveError {
    /// State of a started run; `None` for errors found before it started.
    pub fn standstill(&self) -> Option<&Standstill> {
        match self {
            Self::StepTooSmall { at, .. }
            | Self::FixedStepFailed { at, .. }
            | Self::NotFinite { at, .. }
            | Self::Stiff { at }
            | Self::Sensitivity { at, .. }
            | Self::TooManySteps { at, .. } => Some(at),
            Self::Checkpoint { .. }
            | Self::WrongLength { .. }
            | Self::InvalidStart { .. }
            | Self::InvalidSetting { .. }
            | Self::EntryOutside { .. }
            | Self::ExplicitRow { .. }
            | Self::OutOfMemory { .. } => None,
        }
    }

    /// A possible remedy, in one sentence; `None` where the message is enough.
    pub fn advice(&self) -> Option<&'static str> {
        match self {
            Self::StepTooSmall { cause, .. } => Some(cause.advice()),
            Self::FixedStepFailed { .. } => Some("try a smaller constant step, or let it adapt"),
            Self::NotFinite { .. } => {
                Some("keep the arguments of roots, logarithms and quotients in their domain")
            }
            Self::TooManySteps { .. } => {
                Some("loosen `rtol`, or look for a kink or a rapid oscillation near this time")
            }
            Self::Stiff { .. } => Some("continue with a Radau method from this state"),
            _ => None,
        }
    }

    /// The message, then where the run stands, the worst unknowns by name and a possible remedy,
    /// one fact per line.
    pub fn report(&self) -> String {
        let mut lines = vec![self.to_string()];
        if let Some(at) = self.standstill() {
            lines.push(format!("t = {}, h = {:.3e}, after {}", at.t, at.h, at.stats));
            lines.extend(at.worst.iter().map(|worst| {
                format!("`{}`: {:.3e} times its tolerance", worst.name, worst.scaled)
            }));
        }
        lines.extend(self.advice().map(|advice| format!("try: {advice}")));
        lines.join("\n")
    }

    /// The work done by a started run.
    pub fn stats(&self) -> Option<&Stats> {
        self.standstill().map(|at| &at.stats)
    }
}

/// Cause of a failed step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum Cause {
    /// The error estimate exceeds the tolerance.
    ErrorTest,
    /// Newton's iteration does not converge.
    Newton,
    /// The iteration matrix is singular: redundant equations, or a singular configuration.
    Singular,
    /// The residual or the Jacobian is not finite in this row.
    NotFinite {
        /// Row of `F`, counted from zero.
        row: usize,
    },
}

impl Cause {
    fn advice(self) -> &'static str {
        match self {
            Self::ErrorTest => "loosen `rtol` or `atol`, or look for a kink or jump at this time",
            Self::Newton => "check the start for consistency, or look for a kink at this time",
            Self::Singular => "remove redundant equations, or start away from singular poses",
            Self::NotFinite { .. } => {
                "keep the arguments of roots, logarithms and quotients in their domain"
            }
        }
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ErrorTest => write!(f, "the error test keeps failing"),
            Self::Newton => write!(f, "Newton's iteration does not converge"),
            Self::Singular => write!(f, "the iteration matrix is singular"),
            Self::NotFinite { row } => write!(f, "equation {row} has no finite value"),
        }
    }
}

/// The state of a run that cannot go on.
#[derive(Clone, PartialEq, Debug)]
pub struct Standstill {
    /// End of the last accepted step.
    pub t: f64,
    /// Size of the step tried last, signed.
    pub h: f64,
    /// Up to three unknowns with the largest scaled error or Newton correction, worst first.
    pub worst: Vec<WorstUnknown>,
    /// The last state tried; the state at `t` when no step has been tried.
    pub y: Vec<f64>,
    /// The work done.
    pub stats: Stats,
}

/// One unknown that keeps a step from being accepted.
#[derive(Clone, PartialEq, Debug)]
pub struct WorstUnknown {
    /// Index of the unknown, from zero.
    pub i: usize,
    /// Name in the [`crate::Layout`].
    pub name: String,
    /// Error or Newton correction in units of its tolerance.
    pub scaled: f64,
}
