//! One case: its values, the start, the run, and what is kept of it.

use bksim::dae::Control;
use bksim::model::SolveOptions;
use bksim::model::diagnostic::Diagnostic;
use bksim::sim::run::{Problem, Sample, run};
use bksim::sim::start::start_at;
use bksim::{Mechanism, Rejected};

use crate::output::Reducer;
use crate::study::{Compiled, Of, Study};

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
    /// By axis: in its unit, and of parameters in SI.
    numbers: Vec<f64>,
    varied: Vec<f64>,
    parameters: Vec<f64>,
    options: SolveOptions,
    /// Initial values that axes set.
    stated: Vec<(usize, f64)>,
    recorded: Vec<f64>,
    reducer: Reducer,
}

impl<'a> Worker<'a> {
    pub(crate) fn new(study: &'a Study) -> Self {
        Self {
            study,
            numbers: vec![0.0; study.inputs.len()],
            varied: Vec::new(),
            parameters: vec![0.0; study.n_parameters],
            options: study.options.clone(),
            stated: Vec::new(),
            recorded: Vec::new(),
            reducer: Reducer::new(study.outputs.len()),
        }
    }

    /// Runs a case; `None` when it was stopped.
    pub(crate) fn case(&mut self, case: u64, stop: &dyn Fn() -> bool) -> Option<Row> {
        let study = self.study;
        study.request.plan.case(case, &mut self.numbers);
        let inputs = study.inputs.iter().zip(&self.numbers);
        let inputs: Vec<f64> = inputs.map(|(input, &number)| input.to_si(number)).collect();
        self.sort(&inputs);
        let mut row =
            Row { case, inputs, outputs: Vec::new(), ending: Ending::Done, t: 0.0, n_steps: 0 };
        if self.replay() {
            return self.run(row, &study.shared, None, stop);
        }
        // The values are refused, or the model is another one with them.
        match self.read() {
            Ok(mechanism) => {
                let compiled = Compiled::of(&mechanism);
                match compiled {
                    Ok(compiled) => {
                        let row = self.run(row, &compiled, Some(&mechanism), stop);
                        // The next case begins with the settings that are shared.
                        self.options.clone_from(&study.options);
                        return row;
                    }
                    Err(rejected) => row.ending = Ending::Refused(rejected.into()),
                }
            }
            Err(rejected) => row.ending = Ending::Refused(rejected.into()),
        }
        Some(row)
    }

    /// Puts values of axes where they belong.
    fn sort(&mut self, inputs: &[f64]) {
        self.varied.clear();
        self.stated.clear();
        for (input, &value) in self.study.inputs.iter().zip(inputs) {
            match input.of {
                Of::Parameter => self.varied.push(value),
                Of::Initial(initial_idx) => self.stated.push((initial_idx, value)),
            }
        }
    }

    /// Finds parameters and settings as the reader of models would; false when only it can.
    fn replay(&mut self) -> bool {
        let Self { study, varied, parameters, options, recorded, .. } = self;
        let recording = &study.recording;
        if !recording.has_settings() {
            return recording.replay(varied, recorded, parameters, options);
        }
        options.clone_from(&study.solve);
        let is_known = recording.replay(varied, recorded, parameters, options);
        study.request.changes.apply(options);
        study.sample_for_outputs(options);
        is_known
    }

    /// Reads the model at the values of the case, and derives equations of its own.
    fn read(&mut self) -> Result<Mechanism, Rejected> {
        let request = &self.study.request;
        let overrides = request.overrides(&self.study.inputs, &self.numbers);
        let mut model = request.read(&overrides).map_err(Rejected)?;
        request.changes.apply(&mut model.solve);
        self.study.sample_for_outputs(&mut model.solve);
        self.options.clone_from(&model.solve);
        self.parameters.clear();
        self.parameters.extend(model.parameters.iter().map(|p| p.value));
        Mechanism::derive(model, Vec::new())
    }

    /// Finds the start and runs; faults are explained with `own`, or what is shared.
    fn run(
        &mut self,
        mut row: Row,
        compiled: &Compiled,
        own: Option<&Mechanism>,
        stop: &dyn Fn() -> bool,
    ) -> Option<Row> {
        let Self { study, parameters, options, stated, reducer, .. } = self;
        let Compiled { system, equations, start } = compiled;
        let explain = |explain: &dyn Fn(&Mechanism) -> Diagnostic| {
            let fault = match own {
                Some(own) => explain(own),
                None => study.explain(parameters, options, explain),
            };
            Fault::from(fault)
        };
        row.t = options.t_start;
        let start = match start_at(start, system, parameters, stated, options) {
            Ok(start) => start,
            Err(error) => {
                row.ending = Ending::NoStart(explain(&|m| m.diagnose_start(&error)));
                return Some(row);
            }
        };
        reducer.clear();
        let mut take = |sample: &Sample| {
            reducer.take(&study.outputs, &study.channels, sample);
            Control::Continue
        };
        let problem = Problem { compiled: system, equations, start: &start, parameters, options };
        match run(problem, &mut take, stop) {
            Ok(summary) if !summary.reached_end => return None,
            Ok(summary) => {
                reducer.finish(&study.outputs, &mut row.outputs);
                (row.t, row.n_steps) = (summary.t, summary.stats.n_step as u64);
            }
            Err(failure) => {
                let summary = &failure.summary;
                (row.t, row.n_steps) = (summary.t, summary.stats.n_step as u64);
                let fault = explain(&|m| m.diagnose(equations, &failure));
                row.ending = Ending::StoppedEarly(fault);
            }
        }
        Some(row)
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
