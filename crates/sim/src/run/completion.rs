//! From a state of an integrator to a sample: onto the constraints, accelerations and multipliers, and what follows from
//! them; of small mechanisms as one function once that pays, with the same bits.

use bksim_dae::NotFinite;

use super::sample::{Energy, Sample};
use crate::compiled::CompiledSystem;
use crate::evaluator::Evaluator;
use crate::multiplier::MultiplierSystem;
use crate::multiplier::projection::{CLOSED, size_of};
use crate::state::{AccelerationRef, StateRef};
use crate::whole_sample::{N_CORRECTIONS, SampleResults};
use crate::whole_step::are_finite;

/// Moves the state of a sample onto the constraints and completes it. Accelerations, multipliers and what follows from
/// them are NaN where the equations have no value.
///
/// # Errors
/// [`NotFinite`] there.
pub(super) fn complete_state(
    evaluator: &mut Evaluator<'_>,
    multipliers: &mut MultiplierSystem,
    sample: &mut Sample,
) -> Result<(), NotFinite> {
    if complete_whole(evaluator, multipliers, sample) {
        return Ok(());
    }
    let projected = project(evaluator, multipliers, sample);
    complete(evaluator, sample);
    projected
}

/// Completes a sample by the one function; false where it does not serve.
fn complete_whole(
    evaluator: &mut Evaluator<'_>,
    multipliers: &mut MultiplierSystem,
    sample: &mut Sample,
) -> bool {
    if !multipliers.is_whole(evaluator.shape().nc) {
        return false;
    }
    let Sample { t, q, v, .. } = &*sample;
    let Some(found) = evaluator.whole_sample(*t, q, v) else { return false };
    let SampleResults { pivots, numbers, residuals, motion, lambda, energy, reactions, signals } =
        found;
    let [before, after, rate_before, rate_after] = residuals;
    let is_closed = after <= CLOSED * size_of(motion[0]);
    if !is_closed || !are_finite(numbers) || !multipliers.accept_sample(pivots) {
        return false;
    }
    let [kinetic, potential, power] = energy;
    sample.q.copy_from_slice(motion[0]);
    sample.v.copy_from_slice(motion[1]);
    sample.a.copy_from_slice(motion[2]);
    sample.lambda.copy_from_slice(lambda);
    sample.position_residual = [before, after];
    sample.velocity_residual = [rate_before, rate_after];
    sample.energy = Energy { kinetic, potential, power };
    refill(&mut sample.reactions, reactions);
    refill(&mut sample.signals, signals);
    sample.inputs.clear();
    true
}

/// Projects the state of a sample onto the constraints and gives it accelerations and multipliers.
fn project(
    evaluator: &mut Evaluator<'_>,
    multipliers: &mut MultiplierSystem,
    sample: &mut Sample,
) -> Result<(), NotFinite> {
    let Sample { t, q, v, a, lambda, .. } = sample;
    // A step may straddle a pole of a drive; an output time may hit it.
    let factored = if multipliers.factored_line_into(evaluator, *t, (q, v), a, lambda) {
        Ok(())
    } else {
        multipliers.factor(&evaluator.dynamics(*t, q, v))
    };
    let mut drift = multipliers.project(evaluator, *t, (&mut *q, &mut *v), N_CORRECTIONS);
    // Long steps leave a gap that these do not close.
    let is_closed = drift.position[1] <= CLOSED * size_of(q);
    if !is_closed {
        let more = multipliers.project(evaluator, *t, (&mut *q, &mut *v), N_CORRECTIONS);
        (drift.position[1], drift.velocity[1]) = (more.position[1], more.velocity[1]);
    }
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

/// Completes a sample by what follows from its state, accelerations and multipliers: inputs,
/// energies, reactions.
pub(super) fn complete(evaluator: &mut Evaluator<'_>, sample: &mut Sample) {
    let Sample { t, q, v, a, lambda, reactions, inputs, signals, energy, .. } = sample;
    let state = StateRef { t: *t, q, v };
    refill(signals, evaluator.signals(state, AccelerationRef { a, lambda }));
    refill(inputs, evaluator.inputs(*t, q, v));
    *energy = evaluator.energy(*t, q, v, lambda);
    evaluator.reactions_into(state, AccelerationRef { a, lambda }, reactions);
}

/// Takes the signals of a sample again where they may measure the friction of contacts, whose multipliers a sample has
/// only once it is complete.
pub(super) fn measure_contacts(
    compiled: &CompiledSystem,
    evaluator: &mut Evaluator<'_>,
    sample: &mut Sample,
) {
    if sample.signals.is_empty() || !compiled.indicators.has_tracks() {
        return;
    }
    let Sample { t, q, v, a, lambda, signals, .. } = sample;
    refill(signals, evaluator.signals(StateRef { t: *t, q, v }, AccelerationRef { a, lambda }));
}

fn refill<T: Copy>(own: &mut Vec<T>, values: &[T]) {
    own.clear();
    own.extend_from_slice(values);
}
