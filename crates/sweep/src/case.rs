//! One case: its values, the start, the run, and what is kept of it.

use bksim::dae::Control;
use bksim::mbs::diagnostic::Diagnostic;
use bksim::mbs::model::SolveOptions;
use bksim::mbs::run::{Sample, run};
use bksim::mbs::start::start_at;

use crate::codes;
use crate::output::Reducer;
use crate::study::{Of, Study};

/// A case and what came of it.
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
    /// Its values are refused, as `bksim check` would.
    Refused(Fault),
    /// There is no consistent start.
    NoStart(Fault),
    /// The run stopped early.
    StoppedEarly(Fault),
}

/// Why a case failed, as `bksim solve` says it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Fault {
    /// Code, such as `S001`.
    pub code: &'static str,
    /// What is wrong.
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

/// Runs cases one after the other with buffers of its own.
pub(crate) struct Worker<'a> {
    study: &'a Study,
    numbers: Vec<f64>,
    /// Initial values that axes set.
    stated: Vec<(usize, f64)>,
    reducer: Reducer,
}

impl<'a> Worker<'a> {
    pub(crate) fn new(study: &'a Study) -> Self {
        let numbers = vec![0.0; study.inputs.len()];
        Self { study, numbers, stated: Vec::new(), reducer: Reducer::new(study.outputs.len()) }
    }

    /// Runs a case; `None` when it was stopped.
    pub(crate) fn case(&mut self, case: u64, stop: &dyn Fn() -> bool) -> Option<Row> {
        let study = self.study;
        study.request.plan.case(case, &mut self.numbers);
        let inputs = study.inputs.iter().zip(&self.numbers);
        let inputs: Vec<f64> = inputs.map(|(input, &number)| input.to_si(number)).collect();
        let mut row =
            Row { case, inputs, outputs: Vec::new(), ending: Ending::Done, t: 0.0, n_steps: 0 };

        let (parameters, options) = match self.values() {
            Ok(values) => values,
            Err(fault) => {
                row.ending = Ending::Refused(fault);
                return Some(row);
            }
        };
        row.t = options.t_start;
        self.stated.clear();
        let inputs = study.inputs.iter().zip(&row.inputs);
        self.stated.extend(inputs.filter_map(|(input, &value)| match input.of {
            Of::Initial(initial_idx) => Some((initial_idx, value)),
            Of::Parameter => None,
        }));
        let start =
            match start_at(&study.start, &study.compiled, &parameters, &self.stated, &options) {
                Ok(start) => start,
                Err(error) => {
                    let fault = study.explain(&parameters, &options, |m| m.diagnose_start(&error));
                    row.ending = Ending::NoStart(fault.into());
                    return Some(row);
                }
            };

        let Self { reducer, .. } = self;
        reducer.clear();
        let mut take = |sample: &Sample| {
            reducer.take(&study.outputs, &study.channels, sample);
            Control::Continue
        };
        let (compiled, equations) = (&study.compiled, &study.equations);
        match run(compiled, equations, &start, &parameters, &options, &mut take, stop) {
            Ok(summary) if !summary.reached_end => return None,
            Ok(summary) => {
                reducer.finish(&study.outputs, &mut row.outputs);
                (row.t, row.n_steps) = (summary.t, summary.stats.n_step as u64);
            }
            Err(failure) => {
                let summary = &failure.summary;
                (row.t, row.n_steps) = (summary.t, summary.stats.n_step as u64);
                let explain = |m: &bksim::Mechanism| m.diagnose(equations, &failure);
                let fault = study.explain(&parameters, &options, explain);
                row.ending = Ending::StoppedEarly(fault.into());
            }
        }
        Some(row)
    }

    /// The parameter values of the case and its settings, as the reader of models gives them.
    fn values(&self) -> Result<(Vec<f64>, SolveOptions), Fault> {
        let request = &self.study.request;
        let overrides = request.overrides(&self.study.inputs, &self.numbers);
        match request.read(&overrides) {
            Ok(mut model) => {
                let changed = request.changes.apply(&mut model.solve);
                changed
                    .map_err(|bad| Fault { code: codes::BAD_OPTION.0, reason: bad.to_string() })?;
                self.study.sample_for_outputs(&mut model.solve);
                Ok((model.parameters.iter().map(|p| p.value).collect(), model.solve))
            }
            Err(faults) => {
                let error = faults.into_iter().find(Diagnostic::is_error);
                Err(error.map_or_else(Fault::unknown, Fault::from))
            }
        }
    }
}

impl From<Diagnostic> for Fault {
    fn from(fault: Diagnostic) -> Self {
        Self { code: fault.code.0, reason: fault.message }
    }
}

impl Fault {
    /// A reader that gives no model has found an error; this stands for one that was not told.
    fn unknown() -> Self {
        Self { code: "", reason: "the model is refused".to_owned() }
    }
}
