//! [`Follower`]: changes along a motion that any method finds, step by step and from phase to phase.
//!
//! The motion comes first, over each step as a polynomial ([`Segment`]); the changes follow the linear equations along
//! it, by collocation ([`LinearCollocation`]), in parts of the step where it is too long for them. Steps, events and
//! samples are so those of a run without sensitivities, to the last bit.

use bksim_dae::{Control, LinearCoefficients, LinearCollocation, LinearStep, Stages};

use super::channels::Channels;
use super::following::{Following, Variation};
use super::pace::Pace;
use super::reduction::Reduction;
use super::tangent::{TangentPoint, Tangents};
use super::written::Instants;
use super::{Sensitive, SensitivityEquations, SensitivityPlan};
use crate::function::Buffers;
use crate::hybrid::Passage;
use crate::modes::indicators::IndicatorEvaluator;
use crate::modes::{ContactMode, Modes};
use crate::redundancy::UniquenessChange;
use crate::run::{
    NoSensitivity, Observer, Problem, Sample, Segment, Slowness, StateSensitivity, Undefined,
};
use crate::state::{AccelerationRef, StateRef};

/// The equations of one phase.
pub(super) struct PhaseEquations<'a> {
    /// The parameters of the model, then the modes.
    pub(super) parameters: Vec<f64>,
    inactive: Vec<usize>,
    pub(super) modes: Modes,
    pub(super) variation: Variation<'a>,
    pub(super) tangents: Tangents<'a>,
    pub(super) indicators: Buffers,
    /// Of the indicators themselves.
    pub(super) values: IndicatorEvaluator<'a>,
    channels: Buffers,
}

/// An observer that hands every sample on with its sensitivities.
pub(super) struct Follower<'a, 'o> {
    pub(super) problem: Problem<'a>,
    pub(super) equations: &'a SensitivityEquations,
    pub(super) following: &'a Following,
    channels: &'a Channels,
    start: &'a [StateSensitivity],
    pub(super) phase: PhaseEquations<'a>,
    collocation: LinearCollocation,
    coefficients: Vec<LinearCoefficients>,
    /// The equations of independent coordinates, and the method for as many.
    reduction: Reduction,
    reduced: Option<(usize, LinearCollocation)>,
    pace: Pace,
    /// Time up to which the motion has been followed, s.
    pub(super) t: f64,
    /// Changes of q and v there, nq × n_sensitive by rows.
    pub(super) dq: Vec<f64>,
    pub(super) dv: Vec<f64>,
    /// By quantity, what the rows of friction that sticks lack to their position.
    pub(super) offsets: Vec<Vec<f64>>,
    /// Segments since the changes have been taken onto the constraints.
    n_drifting: usize,
    /// Of the last segment.
    steps: Vec<LinearStep>,
    /// Largest change of a velocity so far, by quantity.
    scale: Vec<f64>,
    /// Changes of a velocity by less than this, as a part of the velocity, are rounding; by quantity.
    least: Vec<f64>,
    pub(super) fault: Option<NoSensitivity>,
    state: Vec<f64>,
    /// The nodes of a step, with q and v at each.
    nodes: (Vec<f64>, Vec<f64>),
    observer: &'o mut dyn Observer,
}

/// Segments after which changes are taken onto the constraints.
const DRIFTING: usize = 8;

/// Part of the motion by which a relative change of a parameter may be off: rounding is less, and changes by what has no
/// influence are rounding alone.
const ROUNDING: f64 = 1e-12;

/// Changes of q and v, nq × n_sensitive by rows.
type Changes = (Vec<f64>, Vec<f64>);

/// By quantity, [`ROUNDING`] in tolerances over the parameter's value; zero where that has no size.
fn least(plan: &SensitivityPlan, (parameters, rtol): (&[f64], f64)) -> Vec<f64> {
    let of_quantity = |by: Option<&Sensitive>| match by {
        Some(&Sensitive::Parameter(k)) if parameters[k] != 0.0 => {
            ROUNDING / (rtol.max(ROUNDING) * parameters[k].abs())
        }
        _ => 0.0,
    };
    (0..plan.start.len()).map(|k| of_quantity(plan.equations.sensitive.get(k))).collect()
}

/// The stages for a mechanism of nq coordinates.
pub(super) fn stages(nq: usize) -> Stages {
    /// Coordinates for which seven stages cost less than shorter steps of five.
    const MOST_OF_SEVEN: usize = 6;
    if nq <= MOST_OF_SEVEN { Stages::Seven } else { Stages::Five }
}

impl<'a, 'o> Follower<'a, 'o> {
    /// From the start of a run.
    pub(super) fn new(
        problem: Problem<'a>,
        plan: &'a SensitivityPlan,
        following: &'a Following,
        observer: &'o mut dyn Observer,
    ) -> Self {
        let Problem { compiled, start, parameters, options, .. } = problem;
        let (equations, m, nq) = (&plan.equations, plan.start.len(), compiled.nq());
        let parameters = start.parameters_with_modes(parameters);
        let inactive = start.inactive_rows().to_vec();
        let phase = PhaseEquations::new(problem, (equations, following), parameters, inactive);
        let stages = stages(nq);
        let by_rows = |of: fn(&StateSensitivity) -> &[f64]| -> Vec<f64> {
            (0..nq).flat_map(|i| plan.start.iter().map(move |by| of(by)[i])).collect()
        };
        let mut follower = Self {
            problem,
            equations,
            following,
            channels: &equations.channels,
            start: &plan.start,
            phase,
            collocation: LinearCollocation::new(stages, nq, m),
            coefficients: vec![LinearCoefficients::zeros(nq, m); stages.count()],
            reduction: Reduction::default(),
            reduced: None,
            pace: Pace::new(options.rtol),
            t: start.t,
            dq: by_rows(|by| &by.q),
            dv: by_rows(|by| &by.v),
            offsets: vec![vec![0.0; compiled.nc()]; m],
            n_drifting: 0,
            steps: Vec::new(),
            scale: vec![0.0; m],
            least: least(plan, (problem.parameters, options.rtol)),
            fault: None,
            state: vec![0.0; 2 * nq],
            nodes: (vec![0.0; stages.count()], vec![0.0; stages.count() * 2 * nq]),
            observer,
        };
        let state = StateRef { t: start.t, q: &start.q, v: &start.v };
        let acceleration = AccelerationRef { a: &start.a, lambda: &start.lambda };
        follower.take_offsets(TangentPoint { state, acceleration });
        follower
    }

    /// Changes of q and v by quantity `k`.
    pub(super) fn column(&self, k: usize) -> (Vec<f64>, Vec<f64>) {
        let m = self.start.len();
        let of = |all: &[f64]| all.iter().skip(k).step_by(m).copied().collect();
        (of(&self.dq), of(&self.dv))
    }

    /// Takes changes of q and v by quantity `k`.
    pub(super) fn set_column(&mut self, k: usize, dq: &[f64], dv: &[f64]) {
        let m = self.start.len();
        self.dq.iter_mut().skip(k).step_by(m).zip(dq).for_each(|(x, value)| *x = *value);
        self.dv.iter_mut().skip(k).step_by(m).zip(dv).for_each(|(x, value)| *x = *value);
    }

    /// Number of quantities.
    pub(super) fn n_sensitive(&self) -> usize {
        self.start.len()
    }

    /// Goes on in other modes, or with other rows.
    pub(super) fn enter(&mut self, parameters: Vec<f64>, inactive: Vec<usize>) {
        let both = (self.equations, self.following);
        self.phase = PhaseEquations::new(self.problem, both, parameters, inactive);
    }

    /// Takes the offsets of the phase from the changes at a state.
    pub(super) fn take_offsets(&mut self, at: TangentPoint<'_>) {
        for k in 0..self.n_sensitive() {
            let (dq, _) = self.column(k);
            self.offsets[k].fill(0.0);
            let change = self.equations.change(k);
            // Where it sticks is all that is asked for.
            let _ = self.phase.tangents.take_offset(at, change, &dq, &mut self.offsets[k]);
        }
    }

    /// Takes all changes onto the linearised constraints at a state.
    pub(super) fn onto_constraints(&mut self, at: TangentPoint<'_>) -> bool {
        if self.phase.tangents.is_free() {
            return true;
        }
        if self.phase.tangents.prepare(at.state).is_err() {
            return false;
        }
        (0..self.n_sensitive()).all(|k| {
            let (mut dq, mut dv) = self.column(k);
            let with = (self.equations.change(k), self.offsets[k].as_slice());
            let moved = self.phase.tangents.onto_constraints(at, with, (&mut dq, &mut dv));
            self.set_column(k, &dq, &dv);
            moved.is_ok()
        })
    }

    /// Follows the motion over a segment.
    fn follow(&mut self, segment: &Segment) -> Result<(), Undefined> {
        let n = self.problem.parameters.len();
        let is_same =
            self.phase.parameters[n..] == segment.modes && self.phase.inactive == segment.dependent;
        if !is_same {
            let parameters = [self.problem.parameters, &segment.modes].concat();
            self.enter(parameters, segment.dependent.clone());
        }
        self.steps.clear();
        let whole = segment.t1 - segment.t0;
        let mut from = segment.t0;
        while from != segment.t1 {
            let (h, is_last) = self.pace.step(segment.t1 - from);
            let (step, end) = self.step(segment, from, h).ok_or(Undefined::Singular)?;
            let error = self.error(&step);
            let Self { pace, collocation, .. } = self;
            let longest = |h: f64, error: f64| collocation.longest_step(h, error);
            if pace.accepts((h, whole), error, longest) {
                self.n_drifting += usize::from(end.is_none());
                match end {
                    Some(end) => (self.dq, self.dv) = end,
                    None => step.at(step.t1(), &mut self.dq, &mut self.dv),
                }
                self.note_scale();
                self.steps.push(step);
                from = if is_last { segment.t1 } else { from + h };
            }
        }
        self.t = segment.t1;

        // Onto the linearised constraints now and then: steps of all coordinates leave them by their errors.
        if !self.phase.tangents.is_free() && self.n_drifting >= DRIFTING {
            self.n_drifting = 0;
            let mut state = std::mem::take(&mut self.state);
            segment.at(segment.t1, &mut state);
            let (q, v) = state.split_at(state.len() / 2);
            let zeros = (vec![0.0; q.len()], vec![0.0; self.problem.compiled.nc()]);
            let acceleration = AccelerationRef { a: &zeros.0, lambda: &zeros.1 };
            let state_there = StateRef { t: segment.t1, q, v };
            let is_regular =
                self.onto_constraints(TangentPoint { state: state_there, acceleration });
            self.state = state;
            if !is_regular {
                return Err(Undefined::Singular);
            }
        }
        Ok(())
    }

    /// A step of the changes along a part of a segment; and those at its end, where dependent coordinates follow from the
    /// others there.
    fn step(
        &mut self,
        segment: &Segment,
        t0: f64,
        h: f64,
    ) -> Option<(LinearStep, Option<Changes>)> {
        let Self { collocation, coefficients, phase, nodes, .. } = self;
        let (t, states) = nodes;
        let width = states.len() / t.len().max(1);
        for ((t, state), c) in
            t.iter_mut().zip(states.chunks_exact_mut(width)).zip(collocation.nodes())
        {
            *t = t0 + c * h;
            segment.at(*t, state);
        }
        if !phase.variation.coefficients_at(Instants { t, states }, coefficients) {
            return None;
        }
        if let Some((step, end)) = self.reduced_step(t0, h) {
            return Some((step, Some(end)));
        }
        let Self { collocation, coefficients, dq, dv, .. } = self;
        Some((collocation.step((t0, h), (dq, dv), coefficients)?, None))
    }

    /// Step of the independent coordinates alone, where the coefficients at the nodes are known.
    fn reduced_step(&mut self, t0: f64, h: f64) -> Option<(LinearStep, Changes)> {
        let Self { collocation, coefficients, reduction, reduced, phase, following, .. } = self;
        if phase.tangents.has_sticking() {
            return None;
        }
        let variation = &phase.variation;
        let values = &variation.of_instants.constraints;
        let partition =
            reduction.take(&following.constraints, values, variation.active(), coefficients)?;

        // The changes of independent coordinates.
        let (m, ni) = (self.start.len(), partition.independent.len());
        let stages = stages(self.problem.compiled.nq());
        if reduced.as_ref().is_none_or(|(n, _)| *n != ni) {
            *reduced = Some((ni, LinearCollocation::new(stages, ni, m)));
        }
        let (_, method) = reduced.as_mut()?;
        let [mut q_i, mut v_i] = [&self.dq, &self.dv].map(|all| partition.independent_rows(all, m));
        let step = method.step((t0, h), (&q_i, &v_i), reduction.coefficients())?;

        // All of them at the nodes.
        let partition = reduction.partition()?;
        let (mut q, mut v) = (vec![0.0; self.dq.len()], vec![0.0; self.dv.len()]);
        let mut w = vec![0.0; coefficients.len() * q.len()];
        let nodes = collocation.nodes().iter().zip(&*coefficients).zip(reduction.dependents());
        for (((c, of_node), dependents), w) in nodes.zip(w.chunks_exact_mut(q.len().max(1))) {
            step.at(t0 + c * h, &mut q_i, &mut v_i);
            partition.complete(dependents, (&q_i, &v_i), (&mut q, &mut v), m);
            of_node.apply((&q, &v), w);
        }
        Some((collocation.through((t0, h), (&self.dq, &self.dv), &w), (q, v)))
    }

    /// Largest error of a step, relative to the largest change of a velocity by the same quantity.
    fn error(&self, step: &LinearStep) -> f64 {
        let m = self.start.len();
        let (mut u, mut rate) = (vec![0.0; self.dq.len()], vec![0.0; self.dv.len()]);
        step.at(step.t1(), &mut u, &mut rate);
        let speed = self.speed();
        let larger = |(scale, least): (&f64, &f64)| scale.max(least * speed);
        let mut scale: Vec<f64> = self.scale.iter().zip(&self.least).map(larger).collect();
        for (k, value) in self.dv.iter().chain(&rate).enumerate() {
            scale[k % m] = scale[k % m].max(value.abs());
        }
        let errors = step.errors().enumerate();
        let relative =
            errors.map(|(k, error)| if error == 0.0 { 0.0 } else { error / scale[k % m] });
        relative.fold(0.0, f64::max)
    }

    /// Largest velocity at the nodes of the last step.
    fn speed(&self) -> f64 {
        let nq = self.problem.compiled.nq();
        let velocities = self.nodes.1.chunks_exact(2 * nq.max(1)).flat_map(|state| &state[nq..]);
        velocities.fold(0.0, |largest: f64, v| largest.max(v.abs()))
    }

    fn note_scale(&mut self) {
        let m = self.start.len();
        for (k, value) in self.dv.iter().enumerate() {
            self.scale[k % m] = self.scale[k % m].max(value.abs());
        }
    }

    /// The changes of q and v at an instant of the last segment, nq × n_sensitive by rows.
    fn changes_at(&self, t: f64) -> (Vec<f64>, Vec<f64>) {
        let (mut dq, mut dv) = (self.dq.clone(), self.dv.clone());
        let covers = |step: &&LinearStep| (t - step.t0()) * (step.t1() - t) >= 0.0;
        if t != self.t
            && let Some(step) = self.steps.iter().find(covers)
        {
            step.at(t, &mut dq, &mut dv);
        }
        (dq, dv)
    }

    /// The sensitivities of a sample.
    fn complete(&mut self, sample: &Sample) -> Option<Vec<StateSensitivity>> {
        let Sample { t, q, v, a, lambda, .. } = sample;
        let state = StateRef { t: *t, q, v };
        let at = TangentPoint { state, acceleration: AccelerationRef { a, lambda } };
        let (all_dq, all_dv) = self.changes_at(*t);
        let m = self.start.len();
        let is_pressed = self.problem.compiled.pressing.is_some();
        let Self { phase, equations, offsets, .. } = self;
        phase.tangents.prepare(state).ok()?;
        if is_pressed && !phase.variation.take(state) {
            return None;
        }
        let column = |all: &[f64], k: usize| -> Vec<f64> {
            all.iter().skip(k).step_by(m).copied().collect()
        };
        let by = |k: usize| {
            let change = equations.change(k);
            let (dq, dv) = (column(&all_dq, k), column(&all_dv, k));
            let mut by = phase.tangents.complete(at, (change, &offsets[k]), (&dq, &dv)).ok()?;
            if is_pressed {
                let mut dz = vec![0.0; a.len() + lambda.len()];
                phase.variation.change_into(k, (&by.q, &by.v), &mut dz);
                by.lambda = dz.split_off(a.len());
                by.a = dz;
            }
            // Friction that slides is a load to all of them, and a multiplier to who reads it.
            by.channels = self.channels.evaluate(&mut phase.channels, at, change, &by);
            phase.fill_slip_friction(self.problem, (self.following, equations), (at, k), &mut by);
            by.channels.iter().chain(&by.lambda).all(|value| value.is_finite()).then_some(by)
        };
        (0..m).map(by).collect()
    }
}

impl<'a> PhaseEquations<'a> {
    fn new(
        Problem { compiled, .. }: Problem<'a>,
        (equations, following): (&'a SensitivityEquations, &'a Following),
        parameters: Vec<f64>,
        inactive: Vec<usize>,
    ) -> Self {
        let numbers = &parameters[compiled.n_parameters..];
        let modes = compiled.indicators.modes_from_numbers(numbers).unwrap_or_default();
        Self {
            modes,
            variation: Variation::new(following, compiled, &parameters, &inactive),
            tangents: Tangents::new(equations, compiled, &parameters, &inactive),
            indicators: following.indicators.buffers(&parameters[..]),
            values: compiled.indicators.at(&parameters),
            channels: equations.channels.buffers(&parameters[..]),
            parameters,
            inactive,
        }
    }

    /// Fills in the changes of multipliers of friction that slips, λ = −ς F.
    fn fill_slip_friction(
        &mut self,
        Problem { compiled, .. }: Problem<'_>,
        (following, equations): (&Following, &SensitivityEquations),
        (at, k): (TangentPoint<'_>, usize),
        by: &mut StateSensitivity,
    ) {
        let is_slip = |mode: &ContactMode| matches!(mode, ContactMode::Slip(_));
        if !self.modes.contacts.iter().any(is_slip) {
            return;
        }
        let change = equations.change(k);
        let outputs = following.indicators.evaluate(
            &mut self.indicators,
            &[&at.arguments(change, (&by.q, &by.v), (&by.a, &by.lambda))],
        );
        let of_contacts = outputs[compiled.indicators.switches.len()..].chunks_exact(4);
        let contacts = compiled.indicators.contacts.iter().zip(&self.modes.contacts);
        for ((contact, mode), four) in contacts.zip(of_contacts) {
            if let ContactMode::Slip(sign) = mode {
                by.lambda[contact.row] = -sign * four[2];
            }
        }
    }
}

impl Observer for Follower<'_, '_> {
    fn sample(&mut self, sample: &Sample, _: &[StateSensitivity]) -> Control {
        if self.fault.is_some() {
            return Control::Stop;
        }
        let Some(by) = self.complete(sample) else {
            self.fault = Some(NoSensitivity { t: sample.t, why: Undefined::Singular });
            return Control::Stop;
        };
        self.observer.sample(sample, &by)
    }

    fn wants_segments(&self) -> bool {
        true
    }

    fn segment(&mut self, segment: &Segment) {
        if self.fault.is_none()
            && let Err(why) = self.follow(segment)
        {
            self.fault = Some(NoSensitivity { t: segment.t0, why });
        }
        if self.observer.wants_segments() {
            self.observer.segment(segment);
        }
    }

    fn passage(&mut self, passage: &Passage) {
        if self.fault.is_none()
            && let Err(why) = self.jump(passage)
        {
            self.fault = Some(NoSensitivity { t: passage.t(), why });
        }
        self.observer.passage(passage);
    }

    fn uniqueness(&mut self, change: &UniquenessChange) {
        self.observer.uniqueness(change);
    }

    fn slow(&mut self, slowness: &Slowness) {
        self.observer.slow(slowness);
    }

    fn stops_hopeless_runs(&self) -> bool {
        self.observer.stops_hopeless_runs()
    }
}
