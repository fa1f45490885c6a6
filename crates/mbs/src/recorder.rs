//! From steps to samples: output times, projection, accelerations, reactions, energies.

use bksim_dae::{Control, Stats};
use nalgebra::DVector;

use crate::compile::{CompiledSystem, Evaluator};
use crate::linear::{accelerations, project};
use crate::model::SolveOptions;
use crate::run::{Sample, Summary};
use crate::start::Start;
use crate::switch::Switching;

/// A stretch of motion whose positions and velocities are known at every instant.
pub(crate) struct Stretch<'a> {
    pub(crate) t0: f64,
    pub(crate) t1: f64,
    /// Writes q and v at a time to the first 2 nq numbers.
    pub(crate) at: &'a dyn Fn(f64, &mut [f64]),
    /// Size of the step, signed.
    pub(crate) h: f64,
    pub(crate) stats: Stats,
}

/// Turns steps into samples.
pub(crate) struct Recorder<'a> {
    pub(crate) compiled: &'a CompiledSystem,
    pub(crate) switching: Switching<'a>,
    pub(crate) evaluator: Evaluator<'a>,
    pub(crate) dependent: Vec<usize>,
    has_drives: bool,
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
        let switching = Switching::new(compiled, parameters, options, start);
        Self {
            evaluator: compiled.evaluator(&switching.parameters),
            compiled,
            switching,
            dependent: start.dependent_rows().to_vec(),
            has_drives: !compiled.drives.is_empty(),
            t_start: start.t,
            t_end: options.t_end,
            every: options.every.unwrap_or((options.t_end - start.t) / 500.0),
            next_idx: 1,
            is_undefined: false,
            sample: Sample::default(),
            y: vec![0.0; n_unknowns],
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

    /// Samples the output times of a stretch and integrates the work over it.
    pub(crate) fn pass(
        &mut self,
        stretch: &Stretch,
        observer: &mut dyn FnMut(&Sample) -> Control,
    ) -> Control {
        let mut from = stretch.t0;
        while let Some(t) = self.next_output(stretch.t1) {
            self.summary.energy.work += self.work_between(stretch, from, t);
            from = t;
            self.take(stretch, t);
            if self.is_undefined || self.hand_out(observer) == Control::Stop {
                return Control::Stop;
            }
        }
        self.summary.energy.work += self.work_between(stretch, from, stretch.t1);
        Control::Continue
    }

    /// The next output time not after `t`, in the direction of the run.
    fn next_output(&mut self, t: f64) -> Option<f64> {
        let forward = (self.t_end - self.t_start).signum();
        #[expect(clippy::cast_precision_loss, reason = "2^53 outputs are not reached")]
        let grid = self.t_start + forward * self.every * self.next_idx as f64;
        // The end is an output of its own; a grid time that rounds onto it counts as the end.
        let near_end = (self.t_end - grid) * forward < 1e-9 * self.every;
        let due = if near_end { self.t_end } else { grid };
        let passed = self.sample.t == self.t_end && self.next_idx > 1;
        if passed || (t - due) * forward < 0.0 {
            return None;
        }
        self.next_idx += 1;
        Some(due)
    }

    /// ∫ P dt by Gauss quadrature of order 6.
    fn work_between(&mut self, stretch: &Stretch, from: f64, to: f64) -> f64 {
        const OFFSET: f64 = 0.774_596_669_241_483_4; // √(3/5)
        const NODES: [(f64, f64); 3] =
            [(-OFFSET, 5.0 / 18.0), (0.0, 8.0 / 18.0), (OFFSET, 5.0 / 18.0)];
        let nq = self.sample.q.len();
        let mut work = 0.0;
        for (node, weight) in NODES {
            let t = 0.5 * (from + to) + 0.5 * node * (to - from);
            (stretch.at)(t, &mut self.y);
            let (q, v) = self.y[..2 * nq].split_at(nq);
            let lambda = if self.has_drives {
                let at = self.evaluator.dynamics(t, q, v);
                accelerations(at, &self.dependent).map(|found| found.lambda)
            } else {
                Some(DVector::zeros(self.sample.lambda.len()))
            };
            if let Some(lambda) = lambda {
                let power = self.evaluator.energy(t, q, v, lambda.as_slice()).power;
                work += weight * (to - from) * power;
            }
        }
        work
    }

    /// Samples the stretch at `t`: projection, then accelerations.
    fn take(&mut self, stretch: &Stretch, t: f64) {
        let nq = self.sample.q.len();
        (stretch.at)(t, &mut self.y);
        let sample = &mut self.sample;
        sample.t = t;
        sample.q.copy_from_slice(&self.y[..nq]);
        sample.v.copy_from_slice(&self.y[nq..2 * nq]);
        sample.step_size = stretch.h;
        sample.stats = stretch.stats;

        let drift = project(&mut self.evaluator, t, &mut sample.q, &mut sample.v, &self.dependent);
        sample.position_residual = drift.position;
        sample.velocity_residual = drift.velocity;
        let at = self.evaluator.dynamics(t, &sample.q, &sample.v);
        // A step may straddle a pole of a drive; an output time may hit it.
        self.is_undefined = !at.is_finite();
        if let Some(found) = accelerations(at, &self.dependent) {
            sample.a.copy_from_slice(found.vdot.as_slice());
            sample.lambda.copy_from_slice(found.lambda.as_slice());
        } else {
            sample.a.fill(f64::NAN);
            sample.lambda.fill(f64::NAN);
        }
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
