//! [`WholeSample`]: a sample as one function, for small mechanisms.
//!
//! The state, projected with factors from nearby, its accelerations and multipliers, refined, and what follows from them
//! are written down one after the other and translated as a whole: what they have in common is computed once. In this it
//! gives the bits of its parts one by one (`run::completion`).

use std::sync::{Arc, OnceLock};

use bksim_expr::{Composition, Jit, Tape, Value};

use crate::function::{Buffers, Function, Uses};
use crate::linear::elimination::{n_padded, padded};
use crate::linear::shape::Shape;
use crate::linear::written::{WrittenSystem, largest};
use crate::whole_step::StepParts;

/// Steps of Newton's method for the positions of a sample.
pub(crate) const N_CORRECTIONS: usize = 2;

/// Operations of the function that a sample has about paid for: measured on the five links and the slider-crank, making it
/// takes 3400 instructions for each, and a sample by its parts 10 to 15 more for each than by the function.
const OPERATIONS_PER_SAMPLE: usize = 3;

/// The function, made when it pays; shared by all runs of a mechanism.
#[derive(Debug)]
pub(crate) struct WholeSample {
    parts: SampleParts,
    samples: Uses,
    made: OnceLock<Function>,
}

/// The functions that a sample is made of, all of the same parameters.
#[derive(Debug)]
pub(crate) struct SampleParts {
    /// Parts that a step is made of, too.
    pub(crate) step: Arc<StepParts>,
    /// M, G, f and γ of (t, q, v).
    pub(crate) dynamics: Tape,
    /// T, V and the power of (t, q, v, λ).
    pub(crate) energy: Tape,
    /// Six numbers per joint of (t, q, v, a, λ).
    pub(crate) reactions: Tape,
    /// The named signals of (t, q, v, a, λ), where there are some.
    pub(crate) signals: Option<Tape>,
}

/// The results by their meaning.
pub(crate) struct SampleResults<'a> {
    /// The pivots at the state that was given, where there are constraints, and at the sample, each [`padded`].
    pub(crate) pivots: &'a [f64],
    /// All other numbers.
    pub(crate) numbers: &'a [f64],
    /// Largest |g| before and after, m or rad, then |G v + ∂g/∂t|, m/s or rad/s.
    pub(crate) residuals: [f64; 4],
    /// q, v and a.
    pub(crate) motion: [&'a [f64]; 3],
    pub(crate) lambda: &'a [f64],
    /// T, V and the power.
    pub(crate) energy: [f64; 3],
    pub(crate) reactions: &'a [[f64; 6]],
    pub(crate) signals: &'a [f64],
}

const N_RESIDUALS: usize = 4;
const N_ENERGIES: usize = 3;

impl WholeSample {
    /// Sample that is not made yet.
    pub(crate) fn new(parts: SampleParts, jit: Jit) -> Self {
        Self { parts, samples: Uses::new(jit), made: OnceLock::new() }
    }

    /// The sample at a state of an integrator; `None` where it is computed by parts.
    pub(crate) fn evaluate<'b>(
        &self,
        buffers: &'b mut Buffers,
        (t, q, v): (f64, &[f64], &[f64]),
    ) -> Option<SampleResults<'b>> {
        if !self.samples.are_enough(self.parts.n_operations() / OPERATIONS_PER_SAMPLE) {
            return None;
        }
        let function = self.made.get_or_init(|| Function::with_code(self.parts.record(), Jit::On));
        Some(self.parts.results(function.evaluate(buffers, &[&[t], q, v])))
    }
}

impl SampleParts {
    /// About as many operations as the whole has.
    fn n_operations(&self) -> usize {
        let Self { step, energy, reactions, signals, .. } = self;
        let StepParts { constraints, line, .. } = &**step;
        let signals = signals.as_ref().map_or(0, Tape::len);
        3 * line.len() + 3 * constraints.len() + energy.len() + reactions.len() + signals
    }

    /// A sample as a function of (t, q, v): pivots, then numbers, in the order of [`SampleParts::results`].
    fn record(&self) -> Tape {
        let Self { step, dynamics, energy, reactions, signals } = self;
        let StepParts { shape, constraints, line, .. } = &**step;
        let Shape { nq, nc, .. } = *shape;
        let mut composition = Composition::new(1 + 2 * nq, line.n_parameters());
        let recorder = &mut composition;
        let inputs: Vec<Value> = (0..=2 * nq).map(|i| recorder.input(i)).collect();
        let (time, state) = inputs.split_at(1);
        let (q, v) = state.split_at(nq);
        let n = nq + nc;

        // The state on the constraints, by factors of the state that was given.
        let system = WrittenSystem::new(shape, constraints);
        let zero = recorder.constant(0.0);
        let (mut pivots, mut residuals) = (Vec::new(), vec![zero; N_RESIDUALS]);
        let (mut q, mut v) = (q.to_vec(), v.to_vec());
        if nc > 0 {
            let factors = &recorder.call(line, &inputs)[n..];
            pivots.extend(padded(&factors[..n]));
            let mut at = system.position(recorder, time[0], &q);
            let rate = system.rate(recorder, &at, &v);
            residuals = vec![at.gap, zero, largest(recorder, &rate), zero];
            for _ in 0..N_CORRECTIONS {
                at = system.newton_step(recorder, time[0], factors, &at).0;
            }
            residuals[1] = at.gap;
            let rate = system.rate(recorder, &at, &v);
            v = system.velocities(recorder, factors, &rate, &v);
            let rate = system.rate(recorder, &at, &v);
            residuals[3] = largest(recorder, &rate);
            q = at.q;
        }

        // Accelerations and multipliers there.
        let state = [time, &q, &v].concat();
        let solved = recorder.call(line, &state);
        let (solution, factors) = solved.split_at(n);
        pivots.extend(padded(&factors[..n]));
        let terms = recorder.call(dynamics, &state);
        let solution = system.refined(recorder, &terms, factors, solution);
        let (a, lambda) = solution.split_at(nq);

        // What follows from them.
        let energies = recorder.call(energy, &[&state, lambda].concat());
        let all = [&state, a, lambda].concat();
        let wrenches = recorder.call(reactions, &all);
        let named = signals.as_ref().map(|signals| recorder.call(signals, &all));
        let named = named.unwrap_or_default();
        let numbers = [&residuals, &q, &v, a, lambda, &energies, &wrenches, &named];
        let outputs = [&pivots[..]].into_iter().chain(numbers);
        let outputs: Vec<Value> = outputs.flatten().copied().collect();
        composition.finish(&outputs)
    }

    /// The results of the function by their meaning.
    fn results<'r>(&self, results: &'r [f64]) -> SampleResults<'r> {
        let Shape { nq, nc, .. } = self.step.shape;
        let n_states = if nc > 0 { 2 } else { 1 };
        let (pivots, numbers) = results.split_at(n_states * n_padded(nq + nc));
        let (residuals, rest) = numbers.split_at(N_RESIDUALS);
        let (motion, rest) = rest.split_at(3 * nq);
        let (lambda, rest) = rest.split_at(nc);
        let (energy, rest) = rest.split_at(N_ENERGIES);
        let (reactions, signals) = rest.split_at(self.reactions.n_outputs());
        SampleResults {
            pivots,
            numbers,
            residuals: std::array::from_fn(|i| residuals[i]),
            motion: std::array::from_fn(|i| &motion[i * nq..][..nq]),
            lambda,
            energy: std::array::from_fn(|i| energy[i]),
            reactions: reactions.as_chunks().0,
            signals,
        }
    }
}
