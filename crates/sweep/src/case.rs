//! Cases: their values, starts, runs, and rows.

use std::collections::VecDeque;
use std::ops::Range;

use bksim::dae::Control;
use bksim::model::SolveOptions;
use bksim::record::Channels;
use bksim::sim::hybrid::Passage;
use bksim::sim::run::{Observer, Replay, Sample, Segment, StateSensitivity};
use bksim::sim::start::Start;
use bksim::{Mechanism, Rejected, Simulation};

use crate::input::{Quantity, overrides};
use crate::output::{Outputs, Reducer};
use crate::row::{Ending, Row};
use crate::sampling::samples_for;
use crate::study::Study;

/// Runs cases with buffers of its own, some together.
pub(crate) struct Worker<'a> {
    study: &'a Study,
    /// Points in the place of the cases of the plan: a value for each axis, in its unit.
    points: Option<&'a [Vec<f64>]>,
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
    /// One for each case that runs.
    reducers: Vec<Reducer>,
}

/// A case that is ready to run.
struct Ready {
    /// Place among the rows.
    place: usize,
    simulation: Simulation,
    start: Start,
}

/// Observer of the run of a case, which takes its outputs.
struct CaseObserver<'a> {
    reducer: &'a mut Reducer,
    outputs: &'a Outputs,
    channels: &'a Channels,
    simulation: &'a Simulation,
    motion: Motion<'a>,
}

/// The motion of a case between samples, as far as its extremes need it.
#[derive(Default)]
struct Motion<'a> {
    segments: VecDeque<Segment>,
    /// Once it was needed.
    replay: Option<Replay<'a>>,
}

impl<'a> Motion<'a> {
    fn replay(&mut self, simulation: &'a Simulation) -> &mut Replay<'a> {
        self.replay
            .get_or_insert_with(|| Replay::new(simulation.compiled(), simulation.parameters()))
    }

    fn at(&mut self, simulation: &'a Simulation, t: f64) -> Option<Sample> {
        let idx = self.segments.iter().position(|segment| segment.contains(t))?;
        self.replay(simulation);
        let Self { segments, replay } = self;
        replay.as_mut()?.at(&segments[idx], t).ok().cloned()
    }

    /// Leaves out what ends before an instant.
    fn forget_before(&mut self, t: f64) {
        let is_past = |segment: &Segment| (t - segment.t1) * (segment.t1 - segment.t0) > 0.0;
        while self.segments.front().is_some_and(is_past) {
            self.segments.pop_front();
        }
    }
}

impl CaseObserver<'_> {
    fn take(&mut self, sample: &Sample, is_event: bool) {
        let Self { reducer, outputs, channels, simulation, motion } = self;
        let mut at = |t: f64| motion.at(simulation, t);
        reducer.take(outputs, channels, (sample, is_event), &mut at);
        let options = simulation.options();
        match reducer.since(options.t_end >= options.t_start) {
            Some(since) => motion.forget_before(since),
            None => motion.segments.clear(),
        }
    }
}

impl Observer for CaseObserver<'_> {
    fn sample(&mut self, sample: &Sample, _: &[StateSensitivity]) -> Control {
        self.take(sample, false);
        Control::Continue
    }

    fn wants_segments(&self) -> bool {
        self.outputs.has_extremes()
    }

    fn segment(&mut self, segment: &Segment) {
        self.motion.segments.push_back(segment.clone());
    }

    fn passage(&mut self, passage: &Passage) {
        if !self.outputs.has_extremes() {
            return;
        }
        let around = self.motion.replay(self.simulation).around(passage);
        for sample in around.into_iter().flatten().filter(Sample::is_finite) {
            self.take(&sample, true);
        }
    }
}

impl<'a> Worker<'a> {
    pub(crate) fn new(study: &'a Study) -> Self {
        Self::at(study, None)
    }

    /// Runs these points in the place of the cases of the plan, if there are any.
    pub(crate) fn at(study: &'a Study, points: Option<&'a [Vec<f64>]>) -> Self {
        Self {
            study,
            points,
            shared: study.simulation.clone(),
            numbers: vec![0.0; study.inputs.len()],
            varied: Vec::new(),
            parameters: study.simulation.parameters().to_vec(),
            options: study.options.clone(),
            stated: Vec::new(),
            recorded: Vec::new(),
            reducers: Vec::new(),
        }
    }

    /// Runs up to [`ensemble_size`](bksim::sim::run::ensemble_size) cases; `None` in the place of those that were stopped.
    pub(crate) fn cases(&mut self, cases: Range<u64>, stop: &dyn Fn() -> bool) -> Vec<Option<Row>> {
        let mut rows = Vec::new();
        let mut ready = Vec::new();
        for (place, case) in cases.enumerate() {
            let mut row = self.row(case);
            match self.prepare() {
                Ok(simulation) => {
                    row.t = simulation.options().t_start;
                    match simulation.start() {
                        Ok(start) => ready.push(Ready { place, simulation, start }),
                        Err(rejected) => row.ending = Ending::NoStart(rejected.into()),
                    }
                }
                Err(rejected) => row.ending = Ending::Refused(rejected.into()),
            }
            rows.push(Some(row));
        }
        self.run(&ready, &mut rows, stop);
        rows
    }

    /// The row of a case, without results, with its values taken.
    fn row(&mut self, case: u64) -> Row {
        let study = self.study;
        match usize::try_from(case).ok().zip(self.points) {
            Some((case, points)) => self.numbers.clone_from(&points[case]),
            None => study.request.plan.case(case, &mut self.numbers),
        }
        let inputs = study.inputs.iter().zip(&self.numbers);
        let inputs: Vec<f64> = inputs.map(|(input, &number)| input.to_si(number)).collect();
        self.sort(&inputs);
        Row { case, inputs, outputs: Vec::new(), ending: Ending::Done, t: 0.0, n_steps: 0 }
    }

    /// The simulation of the first case with the shared equations; `None` where its values make another model.
    pub(crate) fn replayed(&mut self) -> Option<Simulation> {
        self.row(0);
        self.replay().then(|| self.simulation(None))
    }

    /// The simulation of the case whose values were taken.
    fn prepare(&mut self) -> Result<Simulation, Rejected> {
        // Where the values make another model, it has equations of its own.
        let own = if self.replay() { None } else { Some(self.derive()?) };
        Ok(self.simulation(own))
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

    /// Runs cases from their starts, reduced to their outputs as they go on.
    fn run(&mut self, ready: &[Ready], rows: &mut [Option<Row>], stop: &dyn Fn() -> bool) {
        let Self { study, reducers, .. } = self;
        let Study { outputs, channels, simulation, .. } = *study;
        reducers.resize_with(ready.len(), || Reducer::new(outputs, simulation.parameters()));
        for (reducer, Ready { simulation, .. }) in reducers.iter_mut().zip(ready) {
            reducer.begin(outputs, simulation.parameters());
        }
        let mut observers: Vec<_> = (reducers.iter_mut().zip(ready))
            .map(|(reducer, Ready { simulation, .. })| CaseObserver {
                reducer,
                outputs,
                channels,
                simulation,
                motion: Motion::default(),
            })
            .collect();
        let members: Vec<(&Simulation, &Start)> =
            ready.iter().map(|Ready { simulation, start, .. }| (simulation, start)).collect();
        let outcomes = Simulation::run_together(&members, &mut observers, stop);

        // Their rows.
        for ((Ready { place, simulation, .. }, observer), outcome) in
            ready.iter().zip(observers).zip(outcomes)
        {
            let CaseObserver { reducer, mut motion, .. } = observer;
            let Some(row) = &mut rows[*place] else { continue };
            match outcome {
                Ok(summary) if !summary.reached_end => rows[*place] = None,
                Ok(summary) => {
                    let mut at = |t: f64| motion.at(simulation, t);
                    reducer.finish((outputs, channels), &mut at, &mut row.outputs);
                    (row.t, row.n_steps) = (summary.t, summary.stats.n_step as u64);
                }
                Err(failure) => {
                    let summary = &failure.summary;
                    (row.t, row.n_steps) = (summary.t, summary.stats.n_step as u64);
                    row.ending = Ending::StoppedEarly(simulation.diagnose(&failure).into());
                }
            }
        }
    }
}
