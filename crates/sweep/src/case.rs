//! One case: its values, the start, the run, and its row.

use bksim::dae::Control;
use bksim::model::SolveOptions;
use bksim::model::diagnostic::Diagnostic;
use bksim::sim::run::{Sample, run};
use bksim::sim::start::start_at;
use bksim::{Mechanism, Rejected};

use crate::compiled::Compiled;
use crate::input::{Quantity, overrides};
use crate::output::Reducer;
use crate::row::{Ending, Fault, Row};
use crate::sampling::sample_for;
use crate::study::Study;

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

    /// Sorts the values of axes into those of parameters and those of initial values.
    fn sort(&mut self, inputs: &[f64]) {
        self.varied.clear();
        self.stated.clear();
        for (input, &value) in self.study.inputs.iter().zip(inputs) {
            match input.quantity {
                Quantity::Parameter => self.varied.push(value),
                Quantity::Initial(initial_idx) => self.stated.push((initial_idx, value)),
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
        sample_for(&study.outputs, options);
        is_known
    }

    /// Reads the model at the values of the case, and derives equations of its own.
    fn read(&mut self) -> Result<Mechanism, Rejected> {
        let request = &self.study.request;
        let overrides = overrides(&request.plan, &self.study.inputs, &self.numbers);
        let mut model = request.read(&overrides).map_err(Rejected)?;
        request.changes.apply(&mut model.solve);
        sample_for(&self.study.outputs, &mut model.solve);
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

        // The start.
        row.t = options.t_start;
        let start = match start_at(start, system, parameters, stated, options) {
            Ok(start) => start,
            Err(error) => {
                row.ending = Ending::NoStart(explain(&|m| m.diagnose_start(&error)));
                return Some(row);
            }
        };

        // The run, reduced to its outputs as it goes on.
        reducer.clear();
        let mut take = |sample: &Sample| {
            reducer.take(&study.outputs, &study.channels, sample);
            Control::Continue
        };
        match run(system, equations, &start, parameters, options, &mut take, stop) {
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
