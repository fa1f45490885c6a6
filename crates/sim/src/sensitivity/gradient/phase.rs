//! [`PhaseAdjoint`]: the equations of one phase along weights.

use bksim_dae::{Costates, LinearCoefficients};

use super::super::following::Variation;
use super::super::written::Instants;
use super::{GradientPlan, SampleWeights};
use crate::function::{Buffers, LANES, LaneBuffers, Lanes};
use crate::modes::{ContactMode, Modes};
use crate::run::{Problem, Sample, Undefined};
use crate::state::StateRef;

/// The equations of one phase, and their derivatives along weights.
pub(super) struct PhaseAdjoint<'a> {
    problem: Problem<'a>,
    plan: &'a GradientPlan,
    /// The parameters of the model, then the modes.
    pub(super) parameters: Vec<f64>,
    pub(super) inactive: Vec<usize>,
    modes: Modes,
    variation: Variation<'a>,
    forces: LaneBuffers,
    /// Arguments of the forces: t, q, v, a, λ, ρ.
    arguments: Vec<Lanes>,
    channels: Buffers,
}

impl<'a> PhaseAdjoint<'a> {
    /// At parameters that end with the modes, without the inactive rows.
    pub(super) fn new(
        problem: Problem<'a>,
        plan: &'a GradientPlan,
        parameters: Vec<f64>,
        inactive: Vec<usize>,
    ) -> Self {
        let Problem { compiled, .. } = problem;
        let numbers = &parameters[compiled.n_parameters..];
        let lanes = plan.forces.lane_buffers(&parameters);
        Self {
            problem,
            plan,
            modes: compiled.indicators.modes_from_numbers(numbers).unwrap_or_default(),
            variation: Variation::new(&plan.loads, compiled, &parameters, &inactive),
            forces: lanes.expect("forces are compiled for lanes"),
            arguments: vec![[0.0; LANES]; plan.forces.tape().n_inputs()],
            channels: plan.channels.buffers(&parameters[..]),
            parameters,
            inactive,
        }
    }

    /// Writes K, C and the changes by loads at some instants; false where they have no values.
    pub(super) fn coefficients_at(
        &mut self,
        instants: Instants<'_>,
        out: &mut [LinearCoefficients],
    ) -> bool {
        self.variation.coefficients_at(instants, out)
    }

    /// Adds Σ weight ρ·F_P of the instants whose coefficients were taken last, with ρ = β·B, one β after the other.
    pub(super) fn add_forces(
        &mut self,
        instants: Instants<'_>,
        coefficients: &[LinearCoefficients],
        (beta, weights): (&[f64], &[f64]),
        by_parameters: &mut [f64],
    ) {
        let (nq, nz) = (self.problem.compiled.nq(), self.variation.n_unknowns());
        let first_load = 1 + 2 * nq + nz;
        let Self { variation, arguments, .. } = self;
        let z = &variation.of_instants.unknowns;
        let all: Vec<StateRef<'_>> = instants.iter().collect();
        for (first, few) in all.chunks(LANES).enumerate().map(|(k, few)| (k * LANES, few)) {
            // Lanes beyond the last instant repeat it without weight.
            for lane in 0..LANES {
                let at = first + lane.min(few.len() - 1);
                let StateRef { t, q, v } = &all[at];
                let numbers = std::iter::once(t).chain(*q).chain(*v).chain(&z[at * nz..][..nz]);
                arguments.iter_mut().zip(numbers).for_each(|(all, &number)| all[lane] = number);
                let weight = if lane < few.len() { weights[at] } else { 0.0 };
                let loads = &mut arguments[first_load..];
                for load in loads.iter_mut() {
                    load[lane] = 0.0;
                }
                let rows = coefficients[at].forcing.chunks_exact(nz.max(1));
                for (beta, row) in beta[at * nq..][..nq].iter().zip(rows) {
                    let factor = weight * beta;
                    loads.iter_mut().zip(row).for_each(|(load, by)| load[lane] += factor * by);
                }
            }
            let found = self.plan.forces.evaluate_lanes(&mut self.forces, &[&*arguments]);
            for (sum, lanes) in by_parameters.iter_mut().zip(found) {
                *sum += lanes.iter().sum::<f64>();
            }
        }
    }

    /// Adds the weights of a sample to the costates, and to the derivatives by parameters.
    ///
    /// # Errors
    /// [`Undefined`] where accelerations and multipliers have no derivatives that these weights need.
    pub(super) fn add_sample(
        &mut self,
        sample: &Sample,
        weights: &SampleWeights,
        costates: &mut Costates,
        by_parameters: &mut [f64],
    ) -> Result<(), Undefined> {
        let Self { problem, plan, modes, variation, channels, .. } = self;
        let (nq, nc) = (problem.compiled.nq(), problem.compiled.nc());
        let Sample { t, q, v, a, lambda, .. } = sample;
        let state = StateRef { t: *t, q, v };

        // Friction that slides shows its size, against the motion.
        let contacts = &problem.compiled.indicators.contacts;
        let mut of_lambda = weights.lambda.clone();
        of_lambda.resize(nc, 0.0);
        let mut shown = weights.channels.clone();
        let n_channels = plan.channels.tape().n_inputs() - (1 + 3 * nq + nc) - contacts.len();
        shown.resize(n_channels, 0.0);
        for (contact, mode) in contacts.iter().zip(&modes.contacts) {
            let of_size = match mode {
                ContactMode::Slip(sign) => -sign * std::mem::take(&mut of_lambda[contact.row]),
                _ => 0.0,
            };
            shown.push(of_size);
        }

        // The channels.
        let add = |sum: &mut [f64], values: &[f64]| {
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        };
        let mut of_z = weights.a.clone();
        of_z.resize(nq, 0.0);
        of_z.extend(of_lambda);
        add(&mut costates.by_position, &weights.q);
        add(&mut costates.by_velocity, &weights.v);
        if shown.iter().any(|weight| *weight != 0.0) {
            let found = plan.channels.evaluate(channels, &[&[*t], q, v, a, lambda, &shown]);
            let (by_q, rest) = found.split_at(nq);
            let (by_v, rest) = rest.split_at(nq);
            let (by_z, by_own) = rest.split_at(nq + nc);
            add(&mut costates.by_position, by_q);
            add(&mut costates.by_velocity, by_v);
            add(&mut of_z, by_z);
            add(by_parameters, by_own);
        }

        // Accelerations and multipliers follow from the state.
        if of_z.iter().all(|weight| *weight == 0.0) {
            return Ok(());
        }
        let is_free = |row: &usize| contacts.iter().any(|contact| contact.row == *row);
        let is_shared = !self.inactive.iter().all(is_free);
        if is_shared && of_z[nq..].iter().any(|weight| *weight != 0.0) {
            return Err(Undefined::Shared);
        }
        if !variation.take(state) {
            return Err(Undefined::Singular);
        }
        let mut changes = vec![0.0; 2 * nq + variation.n_unknowns()];
        variation.pull_into(&of_z, &mut changes);
        let (by_q, rest) = changes.split_at(nq);
        let (by_v, loads) = rest.split_at(nq);
        add(&mut costates.by_position, by_q);
        add(&mut costates.by_velocity, by_v);
        let numbers = [&[*t], &q[..], v, &variation.a, &variation.lambda, loads].concat();
        let alone = |number: &f64| {
            let mut lanes = [0.0; LANES];
            lanes[0] = *number;
            lanes
        };
        // In other lanes all is zero, time included: their results are not looked at.
        let arguments: Vec<Lanes> = numbers.iter().map(alone).collect();
        let found = plan.forces.evaluate_lanes(&mut self.forces, &[&arguments]);
        by_parameters.iter_mut().zip(found).for_each(|(sum, lanes)| *sum += lanes[0]);
        Ok(())
    }
}
