//! The row of a case: its values, its outputs and how it ended.

use bksim::Rejected;
use bksim::model::diagnostic::Diagnostic;

/// A case and its results.
#[derive(Clone, PartialEq, Debug)]
pub struct Row {
    /// Number of the case.
    pub case: u64,
    /// The varied quantities, SI, by axis.
    pub inputs: Vec<f64>,
    /// The outputs; empty unless the run reached its end.
    pub outputs: Vec<f64>,
    /// How it ended.
    pub ending: Ending,
    /// Last instant, s; the start of a case that did not start.
    pub t: f64,
    /// Steps of the integrator.
    pub n_steps: u64,
}

/// How a case ended.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Ending {
    /// At the end of its run.
    Done,
    /// Values that are refused, as `bksim check` would.
    Refused(Fault),
    /// There is no consistent start.
    NoStart(Fault),
    /// The run stopped early.
    StoppedEarly(Fault),
}

/// Why a case failed, in the words of `bksim solve`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Fault {
    /// Code, such as `S001`.
    pub code: &'static str,
    /// The fault in words.
    pub reason: String,
}

impl Ending {
    /// One word: `done`, `refused`, `no start` or `stopped`.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Refused(_) => "refused",
            Self::NoStart(_) => "no start",
            Self::StoppedEarly(_) => "stopped",
        }
    }

    /// Why a case failed.
    pub fn fault(&self) -> Option<&Fault> {
        match self {
            Self::Done => None,
            Self::Refused(fault) | Self::NoStart(fault) | Self::StoppedEarly(fault) => Some(fault),
        }
    }
}

impl From<Diagnostic> for Fault {
    fn from(fault: Diagnostic) -> Self {
        Self { code: fault.code.0, reason: fault.message }
    }
}

impl From<Rejected> for Fault {
    fn from(Rejected(faults): Rejected) -> Self {
        let error = faults.into_iter().find(Diagnostic::is_error);
        // Whoever refuses a model has found an error.
        error.map_or(Self { code: "", reason: "the model is refused".to_owned() }, Self::from)
    }
}
