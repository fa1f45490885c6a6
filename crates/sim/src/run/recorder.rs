//! From steps to samples: output times, projection, accelerations, reactions, energies.

use bksim_dae::{Control, Loader, NotFinite, Saver, SolveError, Stats};

use super::{Observer, Sample, Segment, Summary};
use crate::compiled::CompiledSystem;
use crate::evaluator::Evaluator;
use crate::hybrid::Switching;
use crate::multiplier::MultiplierSystem;
use crate::start::Start;
use bksim_model::{Outputs, SolveOptions};

/// A stretch of motion whose positions and velocities are known at every instant.
pub(crate) struct Stretch<'a> {
    pub(crate) t0: f64,
    pub(crate) t1: f64,
    /// Writes q and v at a time to the first 2 nq numbers.
    pub(crate) at: &'a dyn Fn(f64, &mut [f64]),
    /// Degree of the polynomial that `at` is.
    pub(crate) degree: usize,
    /// Whether the number behind them is the work of loads and drives.
    pub(crate) has_work: bool,
    /// Size of the step, signed.
    pub(crate) h: f64,
    pub(crate) stats: Stats,
}

/// Samples that are kept of a step in which a run was stopped.
const MAX_PENDING: usize = 10_000;

/// Turns steps into samples.
pub(crate) struct Recorder<'a> {
    pub(crate) switching: Switching<'a>,
    pub(crate) evaluator: Evaluator<'a>,
    pub(crate) multipliers: MultiplierSystem,
    is_powered: bool,
    t_start: f64,
    t_end: f64,
    every: f64,
    /// Times, if given, in the order of the run.
    outputs: Outputs,
    next_idx: usize,
    /// The equations had no value at the last output time; that sample was not handed out.
    pub(crate) is_undefined: bool,
    pub(crate) sample: Sample,
    /// Samples of the last step that were not handed out: the observer had asked to stop.
    pub(crate) pending: Vec<Sample>,
    /// There were too many of those: the run cannot go on.
    pub(crate) is_cut: bool,
    y: Vec<f64>,
    segment: Segment,
    /// Constraint rows that follow from the others.
    pub(crate) dependent: Vec<usize>,
    pub(crate) summary: Summary,
    potential_start: f64,
}

impl<'a> Recorder<'a> {
    pub(crate) fn new(
        compiled: &'a CompiledSystem,
        start: &Start,
        parameters: &[f64],
        options: &SolveOptions,
        n_unknowns: usize,
    ) -> Self {
        let n = n_unknowns.max(2 * compiled.nq() + 1);
        let switching = Switching::new(
            compiled,
            parameters,
            options,
            &start.modes,
            (start.t, &start.q, &start.v),
        );
        Self {
            evaluator: compiled.evaluator(&switching.parameters),
            switching,
            multipliers: MultiplierSystem::new(&compiled.shape, start.inactive_rows()),
            is_powered: compiled.power.is_some(),
            t_start: start.t,
            t_end: options.t_end,
            every: options.interval(),
            outputs: ordered(&options.outputs, start.t, options.t_end),
            next_idx: 1,
            is_undefined: false,
            sample: Sample::default(),
            pending: Vec::new(),
            is_cut: false,
            y: vec![0.0; n],
            segment: Segment::default(),
            dependent: start.inactive_rows().to_vec(),
            summary: Summary::default(),
            potential_start: 0.0,
        }
    }

    pub(crate) fn record_start(&mut self, start: &Start, observer: &mut dyn Observer) -> Control {
        let sample = &mut self.sample;
        sample.t = start.t;
        sample.q.clone_from(&start.q);
        sample.v.clone_from(&start.v);
        sample.a.clone_from(&start.a);
        sample.lambda.clone_from(&start.lambda);
        sample.position_residual = [start.position_residual; 2];
        sample.velocity_residual = [start.velocity_residual; 2];
        self.complete();
        self.potential_start = self.sample.energy.potential;
        self.summary.energy.initial = self.sample.energy.kinetic + self.sample.energy.potential;
        self.hand_out(observer)
    }

    /// As numbers.
    pub(crate) fn save(&self, saver: &mut Saver) {
        self.switching.save(saver);
        self.multipliers.save(saver);
        saver.count(self.next_idx);
        self.sample.save(saver);
        saver.count(self.pending.len());
        for sample in &self.pending {
            sample.save(saver);
        }
        self.summary.save(saver);
        saver.real(self.potential_start);
    }

    /// Goes on with what was saved by a run of the same mechanism, without these rows.
    pub(crate) fn load(
        &mut self,
        loader: &mut Loader<'_>,
        compiled: &'a CompiledSystem,
        dependent: &[usize],
    ) -> Result<(), SolveError> {
        self.switching.load(loader)?;
        self.evaluator = compiled.evaluator(&self.switching.parameters);
        self.multipliers = MultiplierSystem::new(&compiled.shape, dependent);
        self.dependent = dependent.to_vec();
        self.multipliers.load(&compiled.shape, loader)?;
        self.next_idx = loader.index(usize::MAX)?.max(1);
        self.sample = Sample::load(loader, compiled)?;
        let n_pending = loader.count()?;
        self.pending =
            (0..n_pending).map(|_| Sample::load(loader, compiled)).collect::<Result<_, _>>()?;
        self.summary = Summary::load(loader, compiled)?;
        self.potential_start = loader.real()?;
        Ok(())
    }

    /// Hands out the samples that a run had kept back when it was stopped.
    pub(crate) fn hand_out_pending(&mut self, observer: &mut dyn Observer) -> Control {
        let mut control = Control::Continue;
        let mut pending = std::mem::take(&mut self.pending).into_iter();
        for sample in pending.by_ref() {
            self.sample = sample;
            control = self.hand_out(observer);
            if control == Control::Stop {
                break;
            }
        }
        self.pending = pending.collect();
        control
    }

    /// Samples the output times of a stretch, and follows the work over it.
    pub(crate) fn pass(&mut self, stretch: &Stretch, observer: &mut dyn Observer) -> Control {
        self.tell(stretch, observer);
        let (mut from, mut control) = (stretch.t0, Control::Continue);
        while let Some(t) = self.due(stretch.t1) {
            self.next_idx += 1;
            self.work_until(stretch, from, t);
            from = t;
            self.take(stretch, t);
            if self.is_undefined {
                return Control::Stop;
            }
            if control == Control::Stop {
                // A run that goes on from here has lost the step by then.
                self.is_cut = self.pending.len() == MAX_PENDING;
                if self.is_cut {
                    return control;
                }
                self.pending.push(self.sample.clone());
            } else {
                control = self.hand_out(observer);
            }
        }
        self.work_until(stretch, from, stretch.t1);
        control
    }

    /// Hands out the motion over a stretch to who wants it.
    fn tell(&mut self, stretch: &Stretch, observer: &mut dyn Observer) {
        if observer.wants_segments() && stretch.t1 != stretch.t0 {
            self.segment.take(stretch, self.sample.q.len(), &mut self.y);
            self.segment.modes.clear();
            self.segment.modes.extend_from_slice(self.switching.modes());
            self.segment.dependent.clone_from(&self.dependent);
            observer.segment(&self.segment);
        }
    }

    /// The next output time, if it is not after `t` in the direction of the run.
    pub(crate) fn due(&self, t: f64) -> Option<f64> {
        let forward = (self.t_end - self.t_start).signum();
        let due = match &self.outputs {
            Outputs::Even => {
                #[expect(clippy::cast_precision_loss, reason = "2^53 outputs are not reached")]
                let grid = self.t_start + forward * self.every * self.next_idx as f64;
                // The end is an output of its own; a time that rounds onto it counts as the end.
                let near_end = (self.t_end - grid) * forward < 1e-9 * self.every;
                if near_end { self.t_end } else { grid }
            }
            Outputs::Steps if t == self.sample.t => return None,
            Outputs::Steps => t,
            Outputs::Times(times) => times.get(self.next_idx - 1).copied().unwrap_or(self.t_end),
        };
        let passed = self.sample.t == self.t_end && self.next_idx > 1;
        (!passed && (t - due) * forward >= 0.0).then_some(due)
    }

    /// Follows the work of loads and drives: ∫ P dt by Gauss quadrature of order 6, unless the
    /// stretch knows it.
    fn work_until(&mut self, stretch: &Stretch, from: f64, to: f64) {
        const OFFSET: f64 = 0.774_596_669_241_483_4; // √(3/5)
        const NODES: [(f64, f64); 3] =
            [(-OFFSET, 5.0 / 18.0), (0.0, 8.0 / 18.0), (OFFSET, 5.0 / 18.0)];
        let nq = self.sample.q.len();
        if stretch.has_work {
            (stretch.at)(to, &mut self.y);
            self.summary.energy.work = self.y[2 * nq];
            return;
        }
        if !self.is_powered {
            return;
        }
        let (mut vdot, mut lambda) = (vec![0.0; nq], vec![0.0; self.sample.lambda.len()]);
        for (node, weight) in NODES {
            let t = 0.5 * (from + to) + 0.5 * node * (to - from);
            (stretch.at)(t, &mut self.y);
            let (q, v) = self.y[..2 * nq].split_at(nq);
            let at = self.evaluator.dynamics(t, q, v);
            if self.multipliers.accelerations_into(&at, &mut vdot, &mut lambda).is_ok() {
                let power = self.evaluator.power(t, q, v, &lambda);
                self.summary.energy.work += weight * (to - from) * power;
            }
        }
    }

    /// Samples the stretch at `t`: projection, then accelerations.
    fn take(&mut self, stretch: &Stretch, t: f64) {
        let nq = self.sample.q.len();
        (stretch.at)(t, &mut self.y);
        let Self { evaluator, multipliers, sample, .. } = self;
        sample.t = t;
        sample.q.copy_from_slice(&self.y[..nq]);
        sample.v.copy_from_slice(&self.y[nq..2 * nq]);
        sample.step_size = stretch.h;
        sample.stats = stretch.stats;
        sample.work = self.summary.energy.work;
        self.is_undefined = settle(evaluator, multipliers, sample).is_err();
        self.complete();
    }

    /// Samples the one instant of `stretch` if it lies beyond the last sample.
    pub(crate) fn take_last(&mut self, stretch: &Stretch, observer: &mut dyn Observer) {
        let forward = (self.t_end - self.t_start).signum();
        if !self.is_undefined && (stretch.t1 - self.summary.t) * forward > 0.0 {
            self.take(stretch, stretch.t1);
            if !self.is_undefined {
                // The run has ended: there is nothing left to stop.
                let _ = self.hand_out(observer);
            }
        }
    }

    /// Energies and reactions of the sample's state.
    fn complete(&mut self) {
        let Sample { t, q, v, a, lambda, reactions, inputs, energy, .. } = &mut self.sample;
        inputs.clear();
        inputs.extend_from_slice(self.evaluator.inputs(*t, q, v));
        *energy = self.evaluator.energy(*t, q, v, lambda);
        self.evaluator.reactions_into(*t, [q, v, a, lambda], reactions);
        self.switching.fill_slip_friction(*t, q, v, lambda);
    }

    fn hand_out(&mut self, observer: &mut dyn Observer) -> Control {
        let summary = &mut self.summary;
        let sample = &mut self.sample;
        let total = sample.energy.kinetic + sample.energy.potential;
        let balance = &mut summary.energy;
        balance.last = total;
        balance.worst_error =
            balance.worst_error.max((total - sample.work - balance.initial).abs());
        let moved = (sample.energy.potential - self.potential_start).abs();
        balance.scale = balance.scale.max(sample.energy.kinetic.abs() + moved + sample.work.abs());
        for side in 0..2 {
            let [position, velocity] =
                [sample.position_residual[side], sample.velocity_residual[side]];
            summary.position_residual[side] = summary.position_residual[side].max(position);
            summary.velocity_residual[side] = summary.velocity_residual[side].max(velocity);
        }
        summary.t = sample.t;
        summary.n_samples += 1;
        summary.stats = sample.stats;
        observer.sample(sample, &[])
    }
}

/// Projects a sample of an integrator onto the constraints and gives it accelerations and
/// multipliers; they are NaN where the equations have no value.
pub(super) fn settle(
    evaluator: &mut Evaluator<'_>,
    multipliers: &mut MultiplierSystem,
    sample: &mut Sample,
) -> Result<(), NotFinite> {
    const MAX_CORRECTIONS: usize = 4;
    let Sample { t, q, v, a, lambda, .. } = sample;
    // A step may straddle a pole of a drive; an output time may hit it.
    let factored = multipliers.factor(&evaluator.dynamics(*t, q, v));
    let drift = multipliers.project(evaluator, *t, (&mut *q, &mut *v), MAX_CORRECTIONS);
    let solved =
        factored.and_then(|()| multipliers.complete_into(evaluator, *t, (q, v), a, lambda));
    if solved.is_err() {
        a.fill(f64::NAN);
        lambda.fill(f64::NAN);
    }
    sample.position_residual = drift.position;
    sample.velocity_residual = drift.velocity;
    solved
}

/// Given times in the order of a run, without those that are not inside it.
fn ordered(outputs: &Outputs, t_start: f64, t_end: f64) -> Outputs {
    let Outputs::Times(times) = outputs else { return outputs.clone() };
    let forward = (t_end - t_start).signum();
    let is_inside = |t: &f64| (t - t_start) * forward > 0.0 && (t_end - t) * forward > 0.0;
    let mut times: Vec<f64> = times.iter().copied().filter(is_inside).collect();
    times.sort_by(|a, b| (forward * a).total_cmp(&(forward * b)));
    times.dedup();
    Outputs::Times(times)
}
