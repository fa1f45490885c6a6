//! One case: its values, the start, the run, and its row.

use bksim::dae::Control;
use bksim::model::SolveOptions;
use bksim::sim::run::Sample;
use bksim::{Mechanism, Rejected, Simulation};

use crate::input::{Quantity, overrides};
use crate::output::Reducer;
use crate::row::{Ending, Row};
use crate::sampling::samples_for;
use crate::study::Study;

/// Runs cases one after the other with buffers of its own.
pub(crate) struct Worker<'a> {
    study: &'a Study,
    /// The equations that all cases share, with the values of this one.
    shared: Simulation,
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
            shared: study.simulation.clone(),
            numbers: vec![0.0; study.inputs.len()],
            varied: Vec::new(),
            parameters: study.simulation.parameters().to_vec(),
            options: study.options.clone(),
            stated: Vec::new(),
            recorded: Vec::new(),
            reducer: Reducer::new(&study.outputs, study.simulation.parameters()),
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
        // Where the values make another model, it has equations of its own.
        let own = if self.replay() { Ok(None) } else { self.derive().map(Some) };
        match own {
            Ok(own) => {
                let simulation = self.simulation(own);
                return self.run(row, &simulation, stop);
            }
            Err(rejected) => row.ending = Ending::Refused(rejected.into()),
        }
        Some(row)
    }

    /// The simulation of this case: the shared equations with its values, or its `own`.
    fn simulation(&mut self, own: Option<Simulation>) -> Simulation {
        let mut simulation = if let Some(own) = own {
            own
        } else {
            self.shared.set_parameters(&self.parameters);
            self.shared.set_options(&self.options);
            self.shared.clone()
        };
        simulation.set_initial(&self.stated);
        simulation.set_samples(samples_for(&self.study.outputs, simulation.options()));
        simulation
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
        is_known
    }

    /// Reads the model at the values of the case, and derives equations of its own.
    fn derive(&self) -> Result<Simulation, Rejected> {
        let request = &self.study.request;
        let overrides = overrides(&request.plan, &self.study.inputs, &self.numbers);
        let mut model = request.read(&overrides).map_err(Rejected)?;
        request.changes.apply(&mut model.solve);
        model.compliances = request.compliances(&model)?;
        Mechanism::derive(model, Vec::new())?.simulation()
    }

    /// Finds the start and runs.
    fn run(
        &mut self,
        mut row: Row,
        simulation: &Simulation,
        stop: &dyn Fn() -> bool,
    ) -> Option<Row> {
        let Self { study, reducer, .. } = self;

        // The start.
        row.t = simulation.options().t_start;
        let start = match simulation.start() {
            Ok(start) => start,
            Err(rejected) => {
                row.ending = Ending::NoStart(rejected.into());
                return Some(row);
            }
        };

        // The run, reduced to its outputs as it goes on.
        reducer.begin(&study.outputs, simulation.parameters());
        let mut take = |sample: &Sample| {
            reducer.take(&study.outputs, &study.channels, sample);
            Control::Continue
        };
        match simulation.run(&start, &mut take, stop) {
            Ok(summary) if !summary.reached_end => return None,
            Ok(summary) => {
                reducer.finish(&study.outputs, &mut row.outputs);
                (row.t, row.n_steps) = (summary.t, summary.stats.n_step as u64);
            }
            Err(failure) => {
                let summary = &failure.summary;
                (row.t, row.n_steps) = (summary.t, summary.stats.n_step as u64);
                row.ending = Ending::StoppedEarly(simulation.diagnose(&failure).into());
            }
        }
        Some(row)
    }
}
