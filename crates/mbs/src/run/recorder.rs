//! From steps to samples: output times, projection, accelerations, reactions, energies.

use bksim_dae::{Control, Stats};

use super::{Sample, Summary};
use crate::compile::CompiledSystem;
use crate::evaluator::Evaluator;
use crate::model::SolveOptions;
use crate::multiplier::MultiplierSystem;
use crate::start::Start;
use crate::switch::Switching;

/// A stretch of motion whose positions and velocities are known at every instant.
pub(crate) struct Stretch<'a> {
    pub(crate) t0: f64,
    pub(crate) t1: f64,
    /// Writes q and v at a time to the first 2 nq numbers.
    pub(crate) at: &'a dyn Fn(f64, &mut [f64]),
    /// Whether the number behind them is the work of loads and drives.
    pub(crate) has_work: bool,
    /// Size of the step, signed.
    pub(crate) h: f64,
    pub(crate) stats: Stats,
}

/// Turns steps into samples.
pub(crate) struct Recorder<'a> {
    pub(crate) switching: Switching<'a>,
    pub(crate) evaluator: Evaluator<'a>,
    pub(crate) multipliers: MultiplierSystem,
    is_powered: bool,
    t_start: f64,
    t_end: f64,
    every: f64,
    next_idx: u64,
    /// The equations had no value at the last output time; that sample was not handed out.
    pub(crate) is_undefined: bool,
    pub(crate) sample: Sample,
    y: Vec<f64>,
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
        let switching = Switching::new(compiled, parameters, options, start);
        Self {
            evaluator: compiled.evaluator(&switching.parameters),
            switching,
            multipliers: MultiplierSystem::new(&compiled.shape, start.dependent_rows()),
            is_powered: compiled.power.is_some(),
            t_start: start.t,
            t_end: options.t_end,
            every: options.every.unwrap_or((options.t_end - start.t) / 500.0),
            next_idx: 1,
            is_undefined: false,
            sample: Sample::default(),
            y: vec![0.0; n],
            summary: Summary::default(),
            potential_start: 0.0,
        }
    }

    pub(crate) fn record_start(
        &mut self,
        start: &Start,
        observer: &mut dyn FnMut(&Sample) -> Control,
    ) -> Control {
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

    /// Samples the output times of a stretch, and follows the work over it.
    pub(crate) fn pass(
        &mut self,
        stretch: &Stretch,
        observer: &mut dyn FnMut(&Sample) -> Control,
    ) -> Control {
        let mut from = stretch.t0;
        while let Some(t) = self.due(stretch.t1) {
            self.next_idx += 1;
            self.work_until(stretch, from, t);
            from = t;
            self.take(stretch, t);
            if self.is_undefined || self.hand_out(observer) == Control::Stop {
                return Control::Stop;
            }
        }
        self.work_until(stretch, from, stretch.t1);
        Control::Continue
    }

    /// The next output time, if it is not after `t` in the direction of the run.
    pub(crate) fn due(&self, t: f64) -> Option<f64> {
        let forward = (self.t_end - self.t_start).signum();
        #[expect(clippy::cast_precision_loss, reason = "2^53 outputs are not reached")]
        let grid = self.t_start + forward * self.every * self.next_idx as f64;
        // The end is an output of its own; a grid time that rounds onto it counts as the end.
        let near_end = (self.t_end - grid) * forward < 1e-9 * self.every;
        let due = if near_end { self.t_end } else { grid };
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
        const MAX_CORRECTIONS: usize = 4;
        let nq = self.sample.q.len();
        (stretch.at)(t, &mut self.y);
        let Self { evaluator, multipliers, sample, .. } = self;
        sample.t = t;
        sample.q.copy_from_slice(&self.y[..nq]);
        sample.v.copy_from_slice(&self.y[nq..2 * nq]);
        sample.step_size = stretch.h;
        sample.stats = stretch.stats;

        let Sample { q, v, a, lambda, .. } = sample;
        // A step may straddle a pole of a drive; an output time may hit it.
        let factored = multipliers.factor(&evaluator.dynamics(t, q, v));
        let drift = multipliers.project(evaluator, t, (&mut *q, &mut *v), MAX_CORRECTIONS);
        let solved =
            factored.and_then(|()| multipliers.complete_into(evaluator, t, (q, v), a, lambda));
        self.is_undefined = solved.is_err();
        if self.is_undefined {
            a.fill(f64::NAN);
            lambda.fill(f64::NAN);
        }
        sample.position_residual = drift.position;
        sample.velocity_residual = drift.velocity;
        self.complete();
    }

    /// Samples the one instant of `stretch` if it lies beyond the last sample.
    pub(crate) fn take_last(
        &mut self,
        stretch: &Stretch,
        observer: &mut dyn FnMut(&Sample) -> Control,
    ) {
        let forward = (self.t_end - self.t_start).signum();
        if (stretch.t1 - self.sample.t) * forward > 0.0 {
            self.take(stretch, stretch.t1);
            if !self.is_undefined {
                // The run has ended: there is nothing left to stop.
                let _ = self.hand_out(observer);
            }
        }
    }

    /// Energies and reactions of the sample's state.
    fn complete(&mut self) {
        let Sample { t, q, v, a, lambda, reactions, energy, .. } = &mut self.sample;
        *energy = self.evaluator.energy(*t, q, v, lambda);
        self.evaluator.reactions_into(*t, [q, v, a, lambda], reactions);
        self.switching.fill_friction(*t, q, v, lambda);
    }

    fn hand_out(&mut self, observer: &mut dyn FnMut(&Sample) -> Control) -> Control {
        let summary = &mut self.summary;
        let sample = &mut self.sample;
        sample.work = summary.energy.work;
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
        observer(sample)
    }
}
