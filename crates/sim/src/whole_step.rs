//! [`WholeStep`]: a step of Dormand and Prince as one function, for small mechanisms.
//!
//! The straight-line code of the accelerations is written down eleven times, with the sums between the stages,
//! and translated as a whole: nothing is gathered, copied or looked at from stage to stage. In this it gives the
//! bits of the stages one by one.

use std::sync::{Arc, OnceLock};

use bksim_dae::{N_STEP_VECTORS, Recorder, STEP_END, StepSpan, record_step};
use bksim_expr::{Composition, Jit, LaneRunner, LaneValues, LaneWorkspace, Tape, Value};

use crate::function::{Buffers, Function, Uses};
use crate::linear::elimination::{n_padded, padded};
use crate::linear::shape::Shape;
use crate::linear::written::WrittenSystem;

/// Stages of a step whose accelerations are part of it.
const N_STAGES: usize = 11;
/// Operations up to which a step is made one function: beyond, code is longer than the cache of a processor, and what
/// surrounds an evaluation is little next to it.
const LARGEST: usize = 20_000;
/// Steps by which making the function for one state has about paid, for each operation of a stage: it is made of so many stages.
const STEPS_PER_OPERATION: usize = N_STAGES;

/// The function, made when it pays; shared by all runs of a mechanism.
#[derive(Debug)]
pub(crate) struct WholeStep {
    parts: Arc<StepParts>,
    jit: Jit,
    steps: Uses,
    /// `None` where there is no such function.
    made: OnceLock<Option<Made>>,
    /// A further projection of the end, and the derivative there.
    closing: OnceLock<Function>,
}

/// The functions that a step is made of, all of the same parameters.
#[derive(Debug)]
pub(crate) struct StepParts {
    pub(crate) shape: Shape,
    /// v̇, λ and factors of (t, q, v).
    pub(crate) line: Tape,
    /// The power of (t, q, v, λ), where there is some.
    pub(crate) power: Option<Tape>,
    /// G, g and ∂g/∂t of (t, q).
    pub(crate) constraints: Tape,
}

/// The function of one state, and of several at once, each translated when it is first called.
#[derive(Debug)]
struct Made {
    one: LaneRunner<1>,
    four: LaneRunner<4>,
    eight: LaneRunner<8>,
}

/// Parameters of a [`WholeStep`], and room for its arguments.
#[derive(Debug)]
pub(crate) struct StepBuffers {
    workspace: LaneWorkspace<1>,
    arguments: Vec<[f64; 1]>,
}

/// Steps in lanes, each with parameters of its own.
#[derive(Debug)]
pub(crate) enum LaneSteps {
    Four(Lanes<4>),
    Eight(Lanes<8>),
}

#[derive(Debug)]
pub(crate) struct Lanes<const N: usize> {
    workspace: LaneWorkspace<N>,
    arguments: LaneValues<N>,
    results: LaneValues<N>,
    parameters: [Vec<f64>; N],
}

/// A step that is about to be tried.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PendingStep<'a> {
    /// With modes.
    pub(crate) parameters: &'a [f64],
    pub(crate) span: StepSpan,
    /// (q, v, W) where it begins.
    pub(crate) y: &'a [f64],
    pub(crate) ydot: &'a [f64],
}

/// The results of a step by their meaning.
pub(crate) struct StepResults<'a> {
    /// The vectors and the end.
    pub(crate) numbers: &'a [f64],
    pub(crate) end: ProjectedEnd<'a>,
    /// Factors of stage 11, see `Elimination::take`.
    pub(crate) factors: &'a [f64],
    /// The pivots of stages 1 to 11, stage by stage, each [`padded`].
    pub(crate) pivots: &'a [f64],
    /// Pivots at the projected end, padded as well.
    pub(crate) end_pivots: &'a [f64],
}

/// The end of a step on the constraints.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProjectedEnd<'a> {
    /// The largest |g| at the end of the step, before a step of Newton's method and after it, m or rad; the step is
    /// taken where the second is less. Nothing where there are no constraints.
    pub(crate) gaps: &'a [f64],
    /// The end (q, v, W) and its derivative.
    pub(crate) state: [&'a [f64]; 2],
}

impl<'a> ProjectedEnd<'a> {
    /// The first of some results, `n` for each vector, and those after them.
    pub(crate) fn of(results: &'a [f64], n: usize, nc: usize) -> (Self, &'a [f64]) {
        let (gaps, rest) = results.split_at(Self::n_gaps(nc));
        let (state, rest) = rest.split_at(2 * n);
        (Self { gaps, state: state.split_at(n).into() }, rest)
    }

    /// Numbers of the gaps, where there are so many constraints.
    pub(crate) fn n_gaps(nc: usize) -> usize {
        if nc > 0 { 2 } else { 0 }
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.state.iter().all(|numbers| are_finite(numbers))
    }
}

/// True where all numbers are finite. Such leave nothing when they are multiplied by zero, all others NaN: without a branch
/// at each, several are looked at together.
pub(crate) fn are_finite(numbers: &[f64]) -> bool {
    let (blocks, rest) = numbers.as_chunks::<4>();
    let mut left = [0.0; 4];
    for block in blocks {
        for lane in 0..4 {
            left[lane] += 0.0 * block[lane];
        }
    }
    rest.iter().chain(&left).fold(0.0, |sum, x| sum + 0.0 * x) == 0.0
}

impl WholeStep {
    /// Step that is not made yet.
    pub(crate) fn new(parts: Arc<StepParts>, jit: Jit) -> Self {
        Self { parts, jit, steps: Uses::new(jit), made: OnceLock::new(), closing: OnceLock::new() }
    }

    fn made(&self) -> Option<&Made> {
        let make = |tape: Tape| Made {
            one: LaneRunner::new(tape.clone(), Jit::On),
            four: LaneRunner::new(tape.clone(), Jit::On),
            eight: LaneRunner::new(tape, Jit::On),
        };
        self.made.get_or_init(|| step_tape(&self.parts).map(make)).as_ref()
    }

    /// The function of one state if it is due now.
    fn one(&self) -> Option<&LaneRunner<1>> {
        if !self.steps.are_enough(STEPS_PER_OPERATION * self.parts.line.len()) {
            return None;
        }
        self.made().map(|made| &made.one).filter(|one| one.has_code())
    }

    /// Writes the results of a whole step to `results`; false where it must be taken stage by stage.
    pub(crate) fn take(
        &self,
        buffers: &mut Option<StepBuffers>,
        parameters: &[f64],
        StepSpan { t, h, t1 }: StepSpan,
        (y, ydot): (&[f64], &[f64]),
        results: &mut Vec<f64>,
    ) -> bool {
        let Some(runner) = self.one() else { return false };
        let StepBuffers { workspace, arguments } = buffers.get_or_insert_with(|| StepBuffers {
            workspace: runner.workspace(parameters),
            arguments: vec![[0.0]; runner.tape().n_inputs()],
        });
        let (span, states) = arguments.as_flattened_mut().split_at_mut(3);
        span.copy_from_slice(&[t, h, t1]);
        let (own_y, own_ydot) = states.split_at_mut(y.len());
        own_y.copy_from_slice(y);
        own_ydot.copy_from_slice(ydot);
        results.resize(runner.tape().n_outputs(), 0.0);
        runner.evaluate(workspace, arguments, results.as_chunks_mut().0);
        true
    }

    /// The results of a whole step by their meaning.
    pub(crate) fn results<'r>(&self, results: &'r [f64]) -> StepResults<'r> {
        let Shape { nq, nc, .. } = self.parts.shape;
        let n = 2 * nq + 1;
        let (end, rest) = ProjectedEnd::of(&results[N_STEP_VECTORS * n..], n, nc);
        let numbers = &results[..results.len() - rest.len()];
        let n_pivots = n_padded(nq + nc);
        let (rest, end_pivots) = rest.split_at(rest.len() - n_pivots);
        let (factors, pivots) = rest.split_at(rest.len() - N_STAGES * n_pivots);
        StepResults { numbers, end, factors, pivots, end_pivots }
    }

    /// The end of a step at `t1` projected once more, from the state (q, v, W) with the factors of stage 11, and the
    /// pivots there.
    pub(crate) fn close<'b>(
        &self,
        buffers: &'b mut Buffers,
        t1: f64,
        (state, factors): (&[f64], &[f64]),
    ) -> (ProjectedEnd<'b>, &'b [f64]) {
        let make = || Function::with_code(closing_tape(&self.parts, factors.len()), self.jit);
        let results = self.closing.get_or_init(make).evaluate(buffers, &[&[t1], state, factors]);
        ProjectedEnd::of(results, state.len(), self.parts.shape.nc)
    }
}

impl StepParts {
    /// Records rates, accelerations and power at a state, with the factors they come from.
    pub(crate) fn record_derivative(
        &self,
        recorder: &mut Composition,
        t: Value,
        y: &[Value],
    ) -> (Vec<Value>, Vec<Value>) {
        let Shape { nq, nc, .. } = self.shape;
        let state = &y[..2 * nq];
        let solved = recorder.call(&self.line, &[&[t], state].concat());
        let (solution, factors) = solved.split_at(nq + nc);
        let work = match &self.power {
            Some(power) => recorder.call(power, &[&[t], state, &solution[nq..]].concat())[0],
            None => recorder.constant(0.0),
        };
        ([&state[nq..], &solution[..nq], &[work]].concat(), factors.to_vec())
    }
}

/// A step as a function of (t, h, t1, y, f(t, y)) with y = (q, v, W); `None` for a mechanism that is too large.
fn step_tape(parts: &StepParts) -> Option<Tape> {
    let StepParts { shape, line, .. } = parts;
    let Shape { nq, nc, .. } = *shape;
    if N_STAGES * line.len() > LARGEST {
        return None;
    }
    let n = 2 * nq + 1;
    let mut recorder = StepRecorder(Composition::new(3 + 2 * n, line.n_parameters()));
    let inputs: Vec<Value> = (0..3 + 2 * n).map(|i| recorder.0.input(i)).collect();
    let [t, h, t1] = [inputs[0], inputs[1], inputs[2]];
    let (y, f0) = inputs[3..].split_at(n);

    // The stages and their sums.
    let (mut factors, mut pivots) = (Vec::new(), Vec::new());
    let stage = |StepRecorder(recorder): &mut StepRecorder, t: Value, y: &[Value]| {
        let (slope, own_factors) = parts.record_derivative(recorder, t, y);
        pivots.extend(padded(&own_factors[..nq + nc]));
        factors = own_factors;
        slope
    };
    let mut results = record_step(&mut recorder, [t, h], (y, f0), stage);
    let StepRecorder(mut recorder) = recorder;

    // The end, projected, and its derivative.
    let y1 = results[STEP_END * n..][..n].to_vec();
    let (end, end_pivots) = record_end(parts, &mut recorder, t1, (&y1, &factors));
    results.extend([end, factors, pivots, end_pivots].concat());
    Some(recorder.finish(&results))
}

/// A [`ProjectedEnd`] and its pivots as a function of (t1, y, factors), `n_factors` of these.
fn closing_tape(parts: &StepParts, n_factors: usize) -> Tape {
    let n = 2 * parts.shape.nq + 1;
    let mut recorder = Composition::new(1 + n + n_factors, parts.line.n_parameters());
    let inputs: Vec<Value> = (0..=n + n_factors).map(|i| recorder.input(i)).collect();
    let (end, pivots) = record_end(parts, &mut recorder, inputs[0], inputs[1..].split_at(n));
    recorder.finish(&[end, pivots].concat())
}

/// Records a [`ProjectedEnd`] at `t1`, from a state near it and factors, and the pivots there, [`padded`].
fn record_end(
    parts: &StepParts,
    recorder: &mut Composition,
    t1: Value,
    (y, factors): (&[Value], &[Value]),
) -> (Vec<Value>, Vec<Value>) {
    let Shape { nq, nc, .. } = parts.shape;
    let (gaps, end) = record_projection(parts, recorder, t1, y, factors);
    let (slope, factors) = parts.record_derivative(recorder, t1, &end);
    let pivots = padded(&factors[..nq + nc]).collect();
    ([gaps, end, slope].concat(), pivots)
}

/// Records one step of Newton's method for the positions, kept where it closes the gap further, then the projection of
/// the velocities: the largest |g| before and after, and the projected state. See `MultiplierSystem::project`.
pub(crate) fn record_projection(
    StepParts { shape, constraints, .. }: &StepParts,
    recorder: &mut Composition,
    t: Value,
    y: &[Value],
    factors: &[Value],
) -> (Vec<Value>, Vec<Value>) {
    if shape.nc == 0 {
        return (Vec::new(), y.to_vec());
    }
    let system = WrittenSystem::new(shape, constraints);
    let (q, v) = y[..2 * shape.nq].split_at(shape.nq);
    let before = system.position(recorder, t, q);
    let (kept, gap) = system.newton_step(recorder, t, factors, &before);
    let rate = system.rate(recorder, &kept, v);
    let v = system.velocities(recorder, factors, &rate, v);
    (vec![before.gap, gap], [&kept.q[..], &v, &y[2 * shape.nq..]].concat())
}

/// Writes the arithmetic of a step into a composition.
pub(crate) struct StepRecorder(pub(crate) Composition);

impl Recorder for StepRecorder {
    type Value = Value;

    fn constant(&mut self, value: f64) -> Value {
        self.0.constant(value)
    }

    fn add(&mut self, a: Value, b: Value) -> Value {
        self.0.add(a, b)
    }

    fn multiply(&mut self, a: Value, b: Value) -> Value {
        self.0.multiply(a, b)
    }
}

impl LaneSteps {
    /// Room for whole steps, all with these parameters so far; `None` where there are none.
    pub(crate) fn new(step: &WholeStep, parameters: &[f64]) -> Option<Self> {
        if step.jit == Jit::Off {
            return None;
        }
        let Made { four, eight, .. } = step.made()?;
        if eight.has_code() {
            return Some(Self::Eight(Lanes::new(eight, parameters)));
        }
        four.has_code().then(|| Self::Four(Lanes::new(four, parameters)))
    }

    /// Takes down a step in one of the lanes.
    pub(crate) fn set(&mut self, step: &WholeStep, lane: usize, pending: PendingStep<'_>) {
        let Some(Made { four, eight, .. }) = step.made() else { return };
        match self {
            Self::Four(lanes) => lanes.set(four, lane, pending),
            Self::Eight(lanes) => lanes.set(eight, lane, pending),
        }
    }

    /// Takes the steps of all lanes.
    pub(crate) fn take(&mut self, step: &WholeStep) {
        let Some(Made { four, eight, .. }) = step.made() else { return };
        match self {
            Self::Four(lanes) => lanes.take(four),
            Self::Eight(lanes) => lanes.take(eight),
        }
    }

    /// Writes the results of a lane.
    pub(crate) fn results_into(&self, lane: usize, own: &mut Vec<f64>) {
        match self {
            Self::Four(lanes) => lanes.results_into(lane, own),
            Self::Eight(lanes) => lanes.results_into(lane, own),
        }
    }
}

impl<const N: usize> Lanes<N> {
    fn new(runner: &LaneRunner<N>, parameters: &[f64]) -> Self {
        Self {
            workspace: runner.workspace(parameters),
            arguments: LaneValues::zeros(runner.tape().n_inputs()),
            results: LaneValues::zeros(runner.tape().n_outputs()),
            parameters: std::array::from_fn(|_| parameters.to_vec()),
        }
    }

    fn set(&mut self, runner: &LaneRunner<N>, lane: usize, step: PendingStep<'_>) {
        let PendingStep { parameters, span: StepSpan { t, h, t1 }, y, ydot } = step;
        if self.parameters[lane] != parameters {
            runner.set_parameters(&mut self.workspace, lane, parameters);
            self.parameters[lane].copy_from_slice(parameters);
        }
        let numbers = [t, h, t1].into_iter().chain(y.iter().chain(ydot).copied());
        self.arguments.iter_mut().zip(numbers).for_each(|(all, one)| all[lane] = one);
    }

    fn results_into(&self, lane: usize, own: &mut Vec<f64>) {
        own.resize(self.results.len(), 0.0);
        own.iter_mut().zip(&*self.results).for_each(|(own, all)| *own = all[lane]);
    }

    fn take(&mut self, runner: &LaneRunner<N>) {
        runner.evaluate(&mut self.workspace, &self.arguments, &mut self.results);
    }
}
