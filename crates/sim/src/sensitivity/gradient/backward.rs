//! [`Backward`]: the costates of a goal, from the end of a recorded run to its start.

use bksim_dae::{AdjointCollocation, Control, Costates, LinearCoefficients, Stages};

use super::super::derive::Way;
use super::super::follower::{Follower, stages};
use super::super::pace::Pace;
use super::super::written::Instants;
use super::phase::PhaseAdjoint;
use super::recording::Piece;
use super::{GradientPlan, SampleWeights};
use crate::hybrid::Passage;
use crate::run::{NoSensitivity, Problem, Sample, Segment, Undefined};

/// The costates at an instant, and what has gone into the gradient on the way there.
pub(super) struct Backward<'a> {
    problem: Problem<'a>,
    plan: &'a GradientPlan,
    phase: PhaseAdjoint<'a>,
    collocation: AdjointCollocation,
    coefficients: Vec<LinearCoefficients>,
    pace: Pace,
    /// Largest |β| so far.
    scale: f64,
    costates: Costates,
    /// By the parameters that any quantity moves, and by quantity.
    by_parameters: Vec<f64>,
    by_quantity: Vec<f64>,
    /// The nodes of a step, with q and v at each.
    nodes: (Vec<f64>, Vec<f64>),
    n_steps: usize,
}

impl<'a> Backward<'a> {
    /// In the phase of the start, without a goal yet.
    pub(super) fn new(problem: Problem<'a>, plan: &'a GradientPlan) -> Self {
        let Problem { compiled, start, parameters, options, .. } = problem;
        let nq = compiled.nq();
        let parameters = start.parameters_with_modes(parameters);
        let inactive = start.inactive_rows().to_vec();
        let stages: Stages = stages(nq);
        let n_nodes = stages.count();
        Self {
            problem,
            plan,
            phase: PhaseAdjoint::new(problem, plan, parameters, inactive),
            collocation: AdjointCollocation::new(stages, nq),
            coefficients: vec![LinearCoefficients::zeros(nq, nq + compiled.nc()); n_nodes],
            pace: Pace::new(options.rtol),
            scale: 0.0,
            costates: Costates::zeros(nq),
            by_parameters: vec![0.0; plan.forces.n_outputs()],
            by_quantity: vec![0.0; plan.start.len()],
            nodes: (vec![0.0; n_nodes], vec![0.0; n_nodes * 2 * nq]),
            n_steps: 0,
        }
    }

    /// Goes from the end of a run to its start, with the weights of its samples.
    ///
    /// # Errors
    /// [`NoSensitivity`] where the motion has no derivative.
    pub(super) fn go(
        &mut self,
        pieces: &[Piece],
        (samples, weights): (&[Sample], &[Option<SampleWeights>]),
        stop: &dyn Fn() -> bool,
    ) -> Result<Control, NoSensitivity> {
        let fault = |t: f64| move |why: Undefined| NoSensitivity { t, why };
        let weighted = |i: usize| Some((&samples[i], weights.get(i)?.as_ref()?));

        // Samples come after the segment that they are in.
        let mut pending: Vec<usize> = Vec::new();
        for (k, piece) in pieces.iter().enumerate().rev() {
            match piece {
                Piece::Sample(i) => pending.push(*i),
                Piece::Segment(segment) => {
                    self.enter_segment(segment);
                    let mut t = segment.t1;
                    for (sample, weights) in pending.drain(..).filter_map(weighted) {
                        if segment.contains(sample.t) {
                            self.descend(segment, [t, sample.t]).map_err(fault(t))?;
                            t = sample.t;
                        }
                        self.add(sample, weights).map_err(fault(sample.t))?;
                    }
                    self.descend(segment, [t, segment.t0]).map_err(fault(t))?;
                }
                Piece::Passage(passage) => {
                    let after = &passage.after;
                    let parameters = after.modes.parameters_with_modes(self.problem.parameters);
                    self.enter(parameters, &after.inactive);
                    for (sample, weights) in pending.drain(..).filter_map(weighted) {
                        self.add(sample, weights).map_err(fault(sample.t))?;
                    }
                    let before = pieces[..k].iter().rev().find_map(|piece| match piece {
                        Piece::Segment(segment) => Some(segment.t1),
                        _ => None,
                    });
                    let from = before.unwrap_or(self.problem.start.t);
                    self.jump(passage, from).map_err(fault(passage.t()))?;
                }
            }
            if stop() {
                return Ok(Control::Stop);
            }
        }
        let start = self.problem.start;
        let parameters = start.parameters_with_modes(self.problem.parameters);
        self.enter(parameters, start.inactive_rows());
        for (sample, weights) in pending.drain(..).filter_map(weighted) {
            self.add(sample, weights).map_err(fault(sample.t))?;
        }
        Ok(Control::Continue)
    }

    /// The gradient by each quantity, once the start is reached.
    pub(super) fn gradient(&self) -> Vec<f64> {
        let Self { plan, costates, by_parameters, by_quantity, .. } = self;
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let n_moved = by_parameters.len();
        let by = |k: usize| {
            let start = &plan.start[k];
            let of_start =
                dot(&costates.by_position, &start.q) + dot(&costates.by_velocity, &start.v);
            let direction = &plan.directions[k * n_moved..][..n_moved];
            of_start + by_quantity[k] + dot(by_parameters, direction)
        };
        (0..plan.start.len()).map(by).collect()
    }

    /// Steps taken.
    pub(super) fn n_steps(&self) -> usize {
        self.n_steps
    }

    fn enter_segment(&mut self, segment: &Segment) {
        let n = self.problem.parameters.len();
        if self.phase.parameters[n..] != segment.modes {
            let parameters = [self.problem.parameters, &segment.modes].concat();
            self.enter(parameters, &segment.dependent);
        } else if self.phase.inactive != segment.dependent {
            self.enter(self.phase.parameters.clone(), &segment.dependent);
        }
    }

    fn enter(&mut self, parameters: Vec<f64>, inactive: &[usize]) {
        if self.phase.parameters != parameters || self.phase.inactive != inactive {
            let Self { problem, plan, .. } = self;
            self.phase = PhaseAdjoint::new(*problem, plan, parameters, inactive.to_vec());
        }
    }

    /// Takes in the weights of a sample.
    fn add(&mut self, sample: &Sample, weights: &SampleWeights) -> Result<(), Undefined> {
        let Self { phase, costates, by_parameters, .. } = self;
        phase.add_sample(sample, weights, costates, by_parameters)?;
        self.note_scale();
        Ok(())
    }

    fn note_scale(&mut self) {
        let beta = self.costates.by_velocity.iter();
        self.scale = beta.fold(self.scale, |scale, value| scale.max(value.abs()));
    }

    /// Goes along a part of a segment.
    fn descend(&mut self, segment: &Segment, [from, to]: [f64; 2]) -> Result<(), Undefined> {
        let Costates { by_position, by_velocity } = &self.costates;
        if by_position.iter().chain(by_velocity).all(|value| *value == 0.0) {
            return Ok(());
        }
        let whole = segment.t1 - segment.t0;
        let mut t = from;
        while t != to {
            let (h, is_last) = self.pace.step(to - t);
            let Self { collocation, coefficients, phase, nodes, costates, .. } = self;
            let (times, states) = nodes;
            let width = states.len() / times.len().max(1);
            let at_nodes = times.iter_mut().zip(states.chunks_exact_mut(width.max(1)));
            for ((time, state), c) in at_nodes.zip(collocation.nodes()) {
                *time = t + c * h;
                segment.at(*time, state);
            }
            let instants = Instants { t: times, states };
            if !phase.coefficients_at(instants, coefficients) {
                return Err(Undefined::Singular);
            }
            let step = collocation.step(h, costates, coefficients).ok_or(Undefined::Singular)?;

            // Relative to the largest β, that of the step included.
            let scale = step.by_velocity.iter().fold(self.scale, |s, value| s.max(value.abs()));
            let error = if step.error == 0.0 { 0.0 } else { step.error / scale };
            let longest = |h: f64, error: f64| collocation.longest_step(h, error);
            if !self.pace.accepts((h, whole), error, longest) {
                continue;
            }
            let weights: Vec<f64> = collocation.weights().iter().map(|b| -h * b).collect();
            let along = (&step.by_velocity[..], &weights[..]);
            phase.add_forces(instants, coefficients, along, &mut self.by_parameters);
            self.costates = step.end;
            self.note_scale();
            self.n_steps += 1;
            t = if is_last { to } else { t + h };
        }
        Ok(())
    }

    /// Takes the costates back across an event: by the transpose of what it does to every change of the state, one by
    /// one. `from` is where the segment before it ends.
    fn jump(&mut self, passage: &Passage, from: f64) -> Result<(), Undefined> {
        let Some(plan) = &self.plan.events else { return Ok(()) };
        let Way::Followed(following) = &plan.equations.way else { return Ok(()) };
        let mut ignored = |_: &Sample| Control::Continue;
        let mut follower = Follower::new(self.problem, plan, following, &mut ignored);
        follower.t = from;
        follower.jump(passage)?;

        let Costates { by_position, by_velocity } = &self.costates;
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let of_column = |k: usize| {
            let (dq, dv) = follower.column(k);
            dot(by_position, &dq) + dot(by_velocity, &dv)
        };
        let (nq, n) = (by_position.len(), self.by_quantity.len());
        for (k, sum) in self.by_quantity.iter_mut().enumerate() {
            *sum += of_column(k);
        }
        let by_position = (n..n + nq).map(of_column).collect();
        let by_velocity = (n + nq..n + 2 * nq).map(of_column).collect();
        self.costates = Costates { by_position, by_velocity };
        Ok(())
    }
}
