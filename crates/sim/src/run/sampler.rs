//! [`Sampler`]: from dense output to samples, by projection, accelerations, reactions, energies.

use bksim_dae::{Control, Loader, Saver, SolveError};
use bksim_mbs::constraint::Source;

use super::completion::{complete, complete_state, measure_contacts};
use super::dense::DenseOutput;
use super::mechanism::PhaseMechanism;
use super::observer::{Observer, Segment};
use super::problem::Problem;
use super::sample::Sample;
use super::schedule::Schedule;
use super::stepper::Stepper;
use super::summary::Summary;
use super::work::{StepWork, WorkOver, WorkTolerance};
use crate::compiled::CompiledSystem;
use crate::function::Buffers;
use crate::multiplier::{MultiplierSystem, largest};
use crate::sampled::Tick;
use crate::start::Start;
use bksim_model::LoadId;

/// Samples that are kept of a step in which a run was stopped: few, as a person who stops a run waits for them.
const MAX_PENDING: usize = 100;

/// Turns the dense output of steps into samples.
pub(crate) struct Sampler {
    schedule: Schedule,
    /// Factors of its own: those of the integrator must not depend on output times.
    pub(crate) multipliers: MultiplierSystem,
    is_powered: bool,
    /// The equations had no finite value at the last output time; that sample was not handed out.
    pub(crate) is_undefined: bool,
    pub(crate) sample: Sample,
    /// Samples of the last step that were not handed out: the observer had asked to stop.
    pending: Vec<Sample>,
    /// There were too many of those: the run goes on from before the step.
    pub(crate) is_cut: bool,
    y: Vec<f64>,
    segment: Segment,
    pub(super) potential_start: f64,
    /// Second angles of three in sequence.
    second_angles: Vec<usize>,
    /// Friction whose size has been below zero, and when, s.
    driving: Option<(f64, LoadId)>,
    /// Constraint rows of ropes that stay taut.
    taut_ropes: Vec<usize>,
    /// Place of a rope that it would have left, by its number, and when, s.
    left: Option<(f64, usize)>,
    /// Place that a rope goes nearly once around at the start, by its number, and the turn, rad.
    wound: Option<(usize, f64)>,
    turns: Option<Buffers>,
    /// Up to where the present step has been passed, if it has been begun.
    passed: Option<f64>,
    /// Work at its start, J, and what its quadrature keeps to.
    work_start: f64,
    work_tolerance: WorkTolerance,
    work_over: WorkOver,
    /// Work in and out of drives, if there are some: time of the last sample, s, its power, W, and the sum until then, J.
    driven: Option<[f64; 3]>,
    /// From here on samples are those of the next phase, s.
    held_back: f64,
    /// Of the step that has been passed last, s.
    pub(super) step_size: f64,
}

impl Sampler {
    pub(crate) fn new(problem: Problem<'_>, mechanism: &PhaseMechanism<'_>) -> Self {
        let Problem { compiled, start, options, outputs, .. } = problem;
        // The most unknowns of any method: (q, v, λ, μ) of the stabilised form.
        let n_unknowns = 2 * (compiled.nq() + compiled.nc());
        Self {
            schedule: Schedule::new(start.t, options, outputs),
            multipliers: mechanism.multipliers(),
            is_powered: compiled.power.is_some(),
            is_undefined: false,
            sample: Sample::default(),
            pending: Vec::new(),
            is_cut: false,
            y: vec![0.0; n_unknowns.max(2 * compiled.nq() + 1)],
            segment: Segment::default(),
            potential_start: 0.0,
            second_angles: compiled.second_angles.clone(),
            driving: None,
            taut_ropes: compiled.taut_ropes.clone(),
            left: None,
            wound: None,
            turns: None,
            passed: None,
            work_start: 0.0,
            work_tolerance: WorkTolerance { rtol: options.rtol, atol: options.atol, turnover: 0.0 },
            driven: compiled
                .sources
                .iter()
                .any(|source| matches!(source, Source::Drive(_)))
                .then_some([start.t, 0.0, 0.0]),
            work_over: WorkOver::Known,
            held_back: f64::INFINITY,
            step_size: 0.0,
        }
    }

    /// Hands out the start, unless a number of it is not finite: the run then fails at its first step.
    pub(crate) fn begin(
        &mut self,
        start: &Start,
        mechanism: &mut PhaseMechanism<'_>,
        summary: &mut Summary,
        observer: &mut dyn Observer,
    ) -> Control {
        let sample = &mut self.sample;
        sample.t = start.t;
        sample.q.clone_from(&start.q);
        sample.v.clone_from(&start.v);
        sample.a.clone_from(&start.a);
        sample.lambda.clone_from(&start.lambda);
        sample.position_residual = [start.position_residual; 2];
        sample.velocity_residual = [start.velocity_residual; 2];
        complete(&mut mechanism.evaluator, sample);
        self.share(mechanism);
        self.note_drives(mechanism);
        self.potential_start = self.sample.energy.potential;
        summary.energy.initial = self.sample.energy.kinetic + self.sample.energy.potential;
        self.is_undefined = !self.sample.is_finite();
        if self.is_undefined { Control::Continue } else { self.hand_out(summary, observer) }
    }

    /// Goes on in other modes.
    pub(super) fn enter(&mut self, mechanism: &PhaseMechanism<'_>) {
        self.multipliers = mechanism.multipliers();
        self.count_half_turns(mechanism);
    }

    /// Goes on with the half turns of ropes that the mechanism has counted.
    pub(super) fn count_half_turns(&mut self, mechanism: &PhaseMechanism<'_>) {
        let turns = mechanism.compiled().rope_turns.as_ref().zip(self.turns.as_mut());
        if let Some((turns, buffers)) = turns {
            *buffers = turns.buffers(mechanism.parameters());
        }
    }

    /// True where a step may have more samples than are kept of one in which a run is stopped.
    pub(super) fn may_be_cut(&self) -> bool {
        self.schedule.has_more_than(MAX_PENDING)
    }

    /// True if every sample up to `t_end` has been handed out.
    pub(super) fn is_complete(&self, summary: &Summary, t_end: f64) -> bool {
        summary.t == t_end && self.pending.is_empty()
    }

    /// Hands out the samples that a run had kept back when it was stopped.
    pub(super) fn hand_out_pending(
        &mut self,
        summary: &mut Summary,
        observer: &mut dyn Observer,
    ) -> Control {
        let mut control = Control::Continue;
        let mut pending = std::mem::take(&mut self.pending).into_iter();
        for sample in pending.by_ref() {
            self.sample = sample;
            control = self.hand_out(summary, observer);
            if control == Control::Stop {
                break;
            }
        }
        self.pending = pending.collect();
        control
    }

    /// Samples the output times of a step, or of what is left of it, and follows the work over it.
    pub(crate) fn pass(
        &mut self,
        dense: &DenseOutput<'_>,
        mechanism: &mut PhaseMechanism<'_>,
        summary: &mut Summary,
        observer: &mut dyn Observer,
    ) -> Control {
        let control = self.pass_until(dense.t1, dense, mechanism, summary, observer);
        let passed = self.passed.take();
        if !self.is_undefined && !self.is_cut {
            let from = passed.expect("the step has been passed up to its last output time");
            self.work_until(dense, [from, dense.t1], mechanism, summary);
        }
        control
    }

    /// Passes ([`Sampler::pass`]) only up to `t` within the step.
    pub(super) fn pass_until(
        &mut self,
        t: f64,
        dense: &DenseOutput<'_>,
        mechanism: &mut PhaseMechanism<'_>,
        summary: &mut Summary,
        observer: &mut dyn Observer,
    ) -> Control {
        // The motion itself comes before its samples.
        if self.passed.is_none() && observer.wants_segments() && dense.t1 != dense.t0 {
            self.take_segment(dense, mechanism);
            observer.segment(&self.segment);
        }

        let (mut from, mut control) = (self.passed.unwrap_or(dense.t0), Control::Continue);
        while let Some(t) = self.due(t) {
            self.schedule.next_idx += 1;
            self.work_until(dense, [from, t], mechanism, summary);
            if !dense.has_work {
                dense.at(t, &mut self.y);
            }
            from = t;
            self.take(dense, t, mechanism, summary);
            if self.is_undefined {
                return Control::Stop;
            }
            if control == Control::Stop {
                // A run that goes on from the end of the step has lost its polynomial.
                self.is_cut = self.pending.len() == MAX_PENDING;
                if self.is_cut {
                    return control;
                }
                self.pending.push(self.sample.clone());
            } else {
                control = self.hand_out(summary, observer);
            }
        }
        self.passed = Some(from);
        control
    }

    /// A step has been taken, and nothing of it passed yet.
    pub(super) fn begin_step(&mut self, stepper: &dyn Stepper, summary: &Summary, atol: f64) {
        let (before, nq) = (summary.energy.work, self.sample.q.len());
        (self.passed, self.work_start) = (None, before);
        // Forces do as much work along what positions may be off by.
        let speed = largest(&stepper.y()[nq..2 * nq]);
        let force = if speed > 0.0 { stepper.power().abs() / speed } else { 0.0 };
        let tolerance = &mut self.work_tolerance;
        (tolerance.atol, tolerance.turnover) = (atol * force.max(1.0), summary.energy.turnover);
        let is_needed = self.is_powered
            && stepper
                .work()
                .is_none_or(|work| stepper.work_error() > tolerance.allows((work - before).abs()));
        self.work_over = if is_needed { WorkOver::Needed } else { WorkOver::Known };
    }

    /// A step has been taken by an integrator that does not know its work, and nothing of it passed yet.
    pub(crate) fn begin_step_without_work(&mut self, summary: &Summary) {
        (self.passed, self.work_start) = (None, summary.energy.work);
        self.work_tolerance.turnover = summary.energy.turnover;
        self.work_over = if self.is_powered { WorkOver::Needed } else { WorkOver::Known };
    }

    /// Whether the integrator does not know the work over the step, or not well enough.
    pub(super) fn needs_work(&self) -> bool {
        !matches!(self.work_over, WorkOver::Known)
    }

    /// The step has been passed to its end.
    pub(crate) fn end_step(&self, summary: &mut Summary) {
        let energy = &mut summary.energy;
        energy.turnover += match &self.work_over {
            WorkOver::Found(work) => work.turnover,
            _ => (energy.work - self.work_start).abs(),
        };
    }

    /// Makes `t` the next output time, in place of all others before the end.
    pub(super) fn ask(&mut self, t: f64) {
        self.schedule.ask(t);
    }

    /// Samples the one instant of `dense` if it lies beyond the last sample.
    pub(super) fn take_last(
        &mut self,
        dense: &DenseOutput<'_>,
        mechanism: &mut PhaseMechanism<'_>,
        summary: &mut Summary,
        observer: &mut dyn Observer,
    ) {
        // Samples that are kept back come before it.
        let is_next = self.pending.is_empty() && self.schedule.is_after(dense.t1, summary.t);
        if !self.is_undefined && is_next {
            dense.at(dense.t1, &mut self.y);
            self.take(dense, dense.t1, mechanism, summary);
            if !self.is_undefined {
                // The run has ended: there is nothing left to stop.
                let _ = self.hand_out(summary, observer);
            }
        }
    }

    /// When the next sample is due, if that is not after `t`.
    pub(super) fn due(&self, t: f64) -> Option<f64> {
        self.schedule.due(t, self.sample.t).filter(|&due| !self.is_held_back(due))
    }

    /// Keeps back what is due at a tick, until that is passed.
    pub(super) fn hold_back(&mut self, tick: Option<Tick>) {
        self.held_back = tick.map_or(f64::INFINITY, |tick| tick.begin());
    }

    /// True where samples at `t` are kept back.
    pub(super) fn is_held_back(&self, t: f64) -> bool {
        t >= self.held_back
    }

    /// Hands out what is due at the instant of `dense`, a tick that has been passed; keeps it for a run that
    /// goes on where this one is stopping.
    pub(super) fn take_tick(
        &mut self,
        dense: &DenseOutput<'_>,
        mechanism: &mut PhaseMechanism<'_>,
        summary: &mut Summary,
        (observer, mut is_stopping): (&mut dyn Observer, bool),
    ) -> Control {
        self.hold_back(None);
        // No step follows the end of the run to show what holds there.
        if observer.wants_segments() && self.schedule.is_end(dense.t1) {
            self.take_segment(dense, mechanism);
            observer.segment(&self.segment);
        }
        while let Some(t) = self.due(dense.t1) {
            self.schedule.next_idx += 1;
            dense.at(t, &mut self.y);
            self.take(dense, t, mechanism, summary);
            if self.is_undefined {
                return Control::Stop;
            }
            if is_stopping {
                self.pending.push(self.sample.clone());
            } else {
                is_stopping = self.hand_out(summary, observer) == Control::Stop;
            }
        }
        if is_stopping { Control::Stop } else { Control::Continue }
    }

    fn take_segment(&mut self, dense: &DenseOutput<'_>, mechanism: &PhaseMechanism<'_>) {
        let Self { segment, y, sample, .. } = self;
        let mut at = |t: f64, state: &mut [f64]| {
            dense.at(t, y);
            state.copy_from_slice(&y[..state.len()]);
        };
        segment.take([dense.t0, dense.t1], dense.degree(), 2 * sample.q.len(), &mut at);
        segment.modes.clear();
        segment.modes.extend_from_slice(mechanism.modes());
        segment.dependent.clone_from(&mechanism.inactive);
    }

    /// Follows the work of loads and drives to `to`; where the dense output knows it, its state there is then left
    /// in `y`.
    fn work_until(
        &mut self,
        dense: &DenseOutput<'_>,
        [from, to]: [f64; 2],
        mechanism: &mut PhaseMechanism<'_>,
        summary: &mut Summary,
    ) {
        if dense.has_work {
            // Otherwise it is there.
            if from != to || to == dense.t0 {
                dense.at(to, &mut self.y);
            }
            summary.energy.work = self.y[2 * self.sample.q.len()];
        } else if self.needs_work() {
            let work = match std::mem::replace(&mut self.work_over, WorkOver::Needed) {
                WorkOver::Found(work) => work,
                _ => self.work_by_quadrature(dense, mechanism),
            };
            summary.energy.work = work.at(to);
            self.work_over = WorkOver::Found(work);
        }
    }

    /// The work over a step by quadrature.
    fn work_by_quadrature(
        &mut self,
        dense: &DenseOutput<'_>,
        mechanism: &mut PhaseMechanism<'_>,
    ) -> StepWork {
        let Self { multipliers, sample, y, work_start, work_tolerance, .. } = self;
        let (nq, evaluator) = (sample.q.len(), &mut mechanism.evaluator);
        let (mut vdot, mut lambda) = (vec![0.0; nq], vec![0.0; sample.lambda.len()]);
        StepWork::new([dense.t0, dense.t1], *work_start, *work_tolerance, |t| {
            dense.at(t, y);
            let (q, v) = y[..2 * nq].split_at(nq);
            let (a, own) = (&mut vdot[..], &mut lambda[..]);
            let is_solved = multipliers.line_into(evaluator, t, (q, v), a, own)
                || multipliers.accelerations_into(evaluator, t, (q, v), a, own).is_ok();
            if is_solved { evaluator.power(t, q, v, &lambda) } else { 0.0 }
        })
    }

    /// Samples the state of the dense output at `t`, which is in `y`.
    fn take(
        &mut self,
        dense: &DenseOutput<'_>,
        t: f64,
        mechanism: &mut PhaseMechanism<'_>,
        summary: &Summary,
    ) {
        let Self { multipliers, sample, y, .. } = self;
        let nq = sample.q.len();
        sample.t = t;
        sample.q.copy_from_slice(&y[..nq]);
        sample.v.copy_from_slice(&y[nq..2 * nq]);
        sample.step_size = dense.h;
        sample.stats = dense.stats;
        sample.work = summary.energy.work;
        let completed = complete_state(&mut mechanism.evaluator, multipliers, sample);
        self.share(mechanism);
        self.note_drives(mechanism);
        // Numbers too large to be held are no result either.
        self.is_undefined = completed.is_err() || !self.sample.is_finite();
    }

    /// Follows ∫ Σ |λ ∂g/∂t| dt, the work that goes in and out of drives, from sample to sample.
    fn note_drives(&mut self, mechanism: &mut PhaseMechanism<'_>) {
        let Some([before, last, sum]) = self.driven else { return };
        let Sample { t, q, lambda, .. } = &self.sample;
        let rates = mechanism.evaluator.constraints(*t, q).rate;
        let power: f64 = rates.iter().zip(lambda).map(|(rate, lambda)| (rate * lambda).abs()).sum();
        if power.is_finite() {
            self.driven = Some([*t, power, sum + 0.5 * (power + last) * (*t - before).abs()]);
        }
    }

    /// Brings the multipliers of friction and the reactions of a complete sample to what they are in these modes.
    fn share(&mut self, mechanism: &mut PhaseMechanism<'_>) {
        let Sample { t, q, v, lambda, reactions, .. } = &mut self.sample;
        let driving = mechanism.fill_slip_friction(*t, q, v, lambda);
        self.driving = self.driving.or(driving.map(|load| (*t, load)));
        let compiled = mechanism.compiled();
        if let (Some(turns), None) = (&compiled.rope_turns, self.left) {
            let is_first = self.turns.is_none();
            let buffers = self.turns.get_or_insert_with(|| turns.buffers(mechanism.parameters()));
            self.left = turns.left(buffers, *t, q).map(|number| (*t, number));
            if is_first {
                self.wound = turns.nearly_round(buffers, *t, q);
            }
        }
        compiled.share(mechanism.parameters(), (*t, q), &|_| true, (reactions, lambda));
        measure_contacts(compiled, &mut mechanism.evaluator, &mut self.sample);
    }

    fn hand_out(&mut self, summary: &mut Summary, observer: &mut dyn Observer) -> Control {
        if summary.n_samples == 0 {
            summary.wound = self.wound;
        }
        summary.take(&self.sample, self.potential_start, &self.second_angles);
        let through = self.driven.map_or(0.0, |[.., sum]| sum);
        summary.energy.scale = summary.energy.scale.max(through);
        summary.driving = summary.driving.or(self.driving);
        summary.left = summary.left.or(self.left);
        let Sample { t, lambda, .. } = &self.sample;
        let rounding = -1e-9 * largest(lambda);
        let pushing = || self.taut_ropes.iter().find(|&&row| lambda[row] < rounding);
        summary.pushing = summary.pushing.or_else(|| pushing().map(|&row| (*t, row)));
        observer.sample(&self.sample, &[])
    }

    /// Saves the sampler, and the summary between its numbers, which is their order in checkpoints.
    pub(super) fn save(&self, saver: &mut Saver, summary: &Summary) {
        self.multipliers.save(saver);
        saver.count(self.schedule.next_idx);
        self.sample.save(saver);
        saver.count(self.pending.len());
        for sample in &self.pending {
            sample.save(saver);
        }
        summary.save(saver);
        saver.real(self.potential_start);
        saver.slice(&self.driven.unwrap_or_default());
    }

    /// Goes on with what was saved by a run of the same mechanism in the modes that it has now;
    /// returns the summary.
    pub(super) fn load(
        &mut self,
        loader: &mut Loader<'_>,
        mechanism: &PhaseMechanism<'_>,
    ) -> Result<Summary, SolveError> {
        let compiled: &CompiledSystem = mechanism.compiled();
        self.multipliers = mechanism.multipliers();
        self.multipliers.load(&compiled.shape, loader)?;
        self.schedule.next_idx = loader.index(usize::MAX)?.max(1);
        self.sample = Sample::load(loader, compiled)?;
        let n_pending = loader.count()?;
        self.pending =
            (0..n_pending).map(|_| Sample::load(loader, compiled)).collect::<Result<_, _>>()?;
        let summary = Summary::load(loader, compiled)?;
        self.potential_start = loader.real()?;
        let mut driven = [0.0; 3];
        loader.fill(&mut driven)?;
        self.driven = self.driven.map(|_| driven);
        Ok(summary)
    }
}
