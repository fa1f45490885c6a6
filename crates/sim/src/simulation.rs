//! [`Simulation`]: a mechanism that is ready to run.

mod derived;
mod differentiated;
mod together;

use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

use bksim_dae::Control;
use bksim_model::diagnostic::{Diagnostic, Rejected};
use bksim_model::{Compliance, Outputs, ParameterId, SolveOptions};

use crate::compiled::CompiledSystem;
use crate::fault::{diagnose_run, diagnose_slowness, diagnose_start, diagnose_worth};
use crate::formulate::{LazyMotionEquations, MotionEquations};
use crate::input::{InputError, InputValues, UnknownInput, check_inputs};
use crate::mechanism::{Mechanism, uncompiled};
use crate::modes::Modes;
use crate::redundancy::SelfStress;
use crate::run::{
    Failure, Observer, Problem, Run, RunCheckpoint, Sample, Slowness, Summary, Unresumed, resume,
    run,
};
use crate::sensitivity::StateSensitivity;
use crate::start::{Start, StartEquations, StartError, start_at};
use crate::state::State;
use derived::Derived;

/// A compiled mechanism with the values, options and initial values of a run.
///
/// It holds no expressions that could change, so threads share it, and a copy costs a few small vectors:
/// the functions, and what faults are explained with, are common to all copies.
///
/// ```
/// use bksim_sim::Mechanism;
///
/// let pendulum = Mechanism::from_toml(
///     r#"
///     [parameters]
///     l = "0.5 m"
///     [bodies.bob]
///     mass = "2 kg"
///     com = [0, "-l"]
///     [joints.A]
///     type = "revolute"
///     between = ["ground", "bob"]
///     [loads.gravity]
///     type = "gravity"
///     acceleration = [0, "-9.81 m/s^2"]
///     [initial]
///     A = { angle = "30 deg" }
///     [solve]
///     t_end = "1 s"
///     "#,
///     "pendulum",
/// )?;
/// let short = pendulum.simulation()?;
/// let mut long = short.clone();
/// long.set_parameters(&[0.7]);
/// let [short, long] = [short.solve()?, long.solve()?];
/// assert!(long.samples[100].q[0] > short.samples[100].q[0], "a longer pendulum swings slower");
/// # Ok::<(), bksim_model::diagnostic::Rejected>(())
/// ```
#[derive(Clone, Debug)]
pub struct Simulation {
    derivation: Arc<Derived>,
    compiled: Arc<CompiledSystem>,
    /// In the formulation of the options.
    equations: Arc<LazyMotionEquations>,
    parameters: Vec<f64>,
    /// Initial values that replace those of the model, by their index there, SI.
    initial: Vec<(usize, f64)>,
    options: SolveOptions,
    /// Output times in place of those of the options.
    samples: Option<Outputs>,
}

/// A motion from the start to the end time.
#[derive(Clone, PartialEq, Debug)]
pub struct Motion {
    /// The consistent start.
    pub start: Start,
    /// One sample per output time.
    pub samples: Vec<Sample>,
    /// How the run went.
    pub summary: Summary,
}

/// A motion with its derivatives by some quantities.
#[derive(Clone, PartialEq, Debug)]
pub struct SensitivityMotion {
    /// The motion itself.
    pub motion: Motion,
    /// By output time, then by quantity.
    pub sensitivities: Vec<Vec<StateSensitivity>>,
}

impl Mechanism {
    /// This mechanism ready to run, with the values and options that it has now.
    ///
    /// # Errors
    /// [`Rejected`] when an expression of the model cannot be compiled.
    pub fn simulation(&self) -> Result<Simulation, Rejected> {
        Simulation::of(self)
    }

    /// Finds the start, runs to the end and keeps every sample.
    ///
    /// # Errors
    /// [`Rejected`] when there is no consistent start or the run stops early.
    pub fn solve(&self) -> Result<Motion, Rejected> {
        self.simulation()?.solve()
    }
}

impl Simulation {
    /// The simulation of `mechanism` with the values and options that it has now.
    ///
    /// # Errors
    /// [`Rejected`] when an expression of the model cannot be compiled.
    pub fn of(mechanism: &Mechanism) -> Result<Self, Rejected> {
        let Mechanism { model, system, compiled, parameters, .. } = mechanism;
        let start = StartEquations::compile(model, system).map_err(|e| uncompiled(&e))?;
        let derivation = Derived {
            model: model.snapshot(),
            system: system.clone(),
            start,
            equations: Default::default(),
            not_only_loads: OnceLock::new(),
        };
        let derivation = Arc::new(derivation);
        Ok(Self {
            equations: derivation.equations_on_demand(model.solve.formulation, compiled),
            derivation,
            compiled: compiled.clone(),
            parameters: parameters.clone(),
            initial: Vec::new(),
            options: model.solve.clone(),
            samples: None,
        })
    }

    /// The equations as functions of numbers.
    pub fn compiled(&self) -> &Arc<CompiledSystem> {
        &self.compiled
    }

    /// Values of the parameters, in the order of the model's parameters, SI.
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// The options of the run.
    pub fn options(&self) -> &SolveOptions {
        &self.options
    }

    /// Takes other values of the parameters, in the order of the model's, SI. Each is taken as it is: a
    /// parameter that the model defines by others does not follow them.
    ///
    /// # Panics
    /// If they are not as many as in the model.
    pub fn set_parameters(&mut self, values: &[f64]) {
        self.parameters.copy_from_slice(values);
    }

    /// Takes initial values in place of the model's, by their index in
    /// [`Model::initial`](bksim_model::Model::initial), SI.
    pub fn set_initial(&mut self, values: &[(usize, f64)]) {
        values.clone_into(&mut self.initial);
    }

    /// Takes other options.
    pub fn set_options(&mut self, options: &SolveOptions) {
        if options.formulation != self.options.formulation {
            self.equations =
                self.derivation.equations_on_demand(options.formulation, &self.compiled);
        }
        self.options.clone_from(options);
    }

    /// Takes samples at other times than those of the options, or at those again. Methods are chosen as without, so
    /// that the motion is the same to the last bit.
    pub fn set_samples(&mut self, samples: Option<Outputs>) {
        self.samples = samples;
    }

    /// Lets other joints yield than those of the model; see
    /// [`Model::compliances`](bksim_model::Model::compliances).
    pub fn set_compliances(&mut self, compliances: &[Compliance]) {
        let mut compiled = CompiledSystem::clone(&self.compiled);
        compiled.transmissions.set_compliances(compliances);
        self.compiled = Arc::new(compiled);
    }

    /// The values of the inputs at a state, SI, in the order of
    /// [`Model::inputs`](bksim_model::Model::inputs); none without a law.
    pub fn input_values(&self, t: f64, q: &[f64], v: &[f64]) -> Vec<f64> {
        InputValues::new(&self.compiled.inputs).at(t, q, v).to_vec()
    }

    /// The mechanism with the values and options of this simulation, its expressions made again.
    pub fn mechanism(&self) -> Mechanism {
        let mut model = self.derivation.model.to_model();
        for (parameter, &value) in model.parameters.iter_mut().zip(&self.parameters) {
            parameter.value = value;
        }
        model.solve = self.options.clone();
        self.compiled.transmissions.compliances().clone_into(&mut model.compliances);
        Mechanism {
            model,
            system: self.derivation.system.clone(),
            compiled: self.compiled.clone(),
            parameters: self.parameters.clone(),
            warnings: Vec::new(),
        }
    }

    /// The residual and Jacobian in the formulation of the options.
    pub fn equations(&self) -> &MotionEquations {
        &self.equations
    }

    /// The consistent start.
    ///
    /// # Errors
    /// [`Rejected`] says which loop cannot close, which stated values exclude each other, or that the options
    /// ask for more samples than any log holds.
    pub fn start(&self) -> Result<Start, Rejected> {
        let Self { derivation, compiled, parameters, initial, options, .. } = self;
        start_at(&derivation.start, compiled, parameters, initial, options)
            .map_err(|error| Rejected(vec![self.diagnose_start(&error)]))
    }

    /// Refuses a start of which a number that a run reports is not finite: a reaction, an energy, a signal, an output.
    ///
    /// # Errors
    /// [`Rejected`] names the quantity and the part of the model that it is about.
    pub fn check_first_sample(&self, start: &Start) -> Result<(), Rejected> {
        let failed = |failure: &Failure| Rejected(vec![self.diagnose(failure)]);
        let start = self.beginning(start).map_err(|failure| failed(&failure))?;
        let begun = Run::begin(self.problem(&start), &mut |_: &Sample| Control::Continue);
        match begun.undefined() {
            Some(failure) => Err(failed(&failure)),
            None => Ok(()),
        }
    }

    /// The start of a motion that goes on from a state of the one that began at `start`, in which `modes`
    /// held until now, with the values that this simulation has.
    ///
    /// # Errors
    /// [`Diagnostic`] when the motion cannot go on from there.
    pub(crate) fn going_on(
        &self,
        start: &Start,
        state: State,
        modes: &Modes,
    ) -> Result<Start, Diagnostic> {
        let Self { compiled, parameters, options, .. } = self;
        let before = (modes, compiled.latches.holding(parameters, modes));
        let next = start.going_on(compiled, parameters, options, state, before);
        next.map_err(|error| self.diagnose_start(&error))
    }

    /// The parameter of this name, if nothing but loads depends on it, and no law gives its values.
    ///
    /// # Errors
    /// [`InputError`] says why it cannot be set in the middle of a motion.
    pub(crate) fn settable(&self, name: &str) -> Result<ParameterId, InputError> {
        let Derived { model, not_only_loads, .. } = &*self.derivation;
        let found = model.parameters.iter().position(|parameter| parameter.name == name);
        let id = found.map(ParameterId).ok_or_else(|| UnknownInput(name.to_owned()))?;
        if model.inputs.contains(&id) {
            return Err(InputError::HasLaw(name.to_owned()));
        }
        let faults = not_only_loads.get_or_init(|| {
            let Mechanism { mut model, system, .. } = self.mechanism();
            let all = (0..model.parameters.len()).map(ParameterId);
            all.map(|id| {
                model.inputs = vec![id];
                check_inputs(&model, &system).pop()
            })
            .collect()
        });
        match &faults[id.0] {
            Some(fault) => Err(InputError::NotOnlyLoads(Box::new(fault.clone()))),
            None => Ok(id),
        }
    }

    /// A basis of the self-stresses at `start`: what may be added to its reactions in any multiple
    /// without disturbing the equilibrium. Empty where all reactions are unique.
    pub fn self_stresses(&self, start: &Start) -> Vec<SelfStress> {
        self.compiled.self_stresses(&self.parameters, (start.t, &start.q), &start.modes)
    }

    /// Everything that the motion from `start` follows from.
    pub fn problem<'a>(&'a self, start: &'a Start) -> Problem<'a> {
        let Self { compiled, equations, parameters, options, samples, .. } = self;
        let outputs = samples.as_ref().unwrap_or(&options.outputs);
        Problem { compiled, equations, start, parameters, options, outputs }
    }

    /// Runs from `start` and hands every sample to `observer`, which may stop the run; `stop` is
    /// asked after every step.
    ///
    /// # Errors
    /// [`Failure`] when the integrator cannot go on; see [`Simulation::diagnose`].
    pub fn run(
        &self,
        start: &Start,
        observer: &mut dyn Observer,
        stop: &dyn Fn() -> bool,
    ) -> Result<Summary, Box<Failure>> {
        let start = self.beginning(start)?;
        run(self.problem(&start), observer, stop)
    }

    /// The start with the modes of what it is now; a caller may have changed its state.
    ///
    /// # Errors
    /// [`StartError`] when the motion cannot begin in that state.
    pub(crate) fn up_to_date<'a>(&self, start: &'a Start) -> Result<Cow<'a, Start>, StartError> {
        let Self { compiled, parameters, options, .. } = self;
        start.up_to_date(compiled, parameters, options)
    }

    /// Beginning ([`Simulation::up_to_date`]) of a run that fails where it begins.
    fn beginning<'a>(&self, start: &'a Start) -> Result<Cow<'a, Start>, Box<Failure>> {
        let fresh = self.up_to_date(start);
        fresh.map_err(|error| Box::new(Failure::at_start(start, error)))
    }

    /// Continues a run that was stopped, as if it had not been; `start` is where it began. See
    /// [`resume`].
    ///
    /// # Errors
    /// [`Unresumed`] when the checkpoint belongs to another run, or the integrator cannot go on.
    pub fn resume(
        &self,
        start: &Start,
        checkpoint: &RunCheckpoint,
        observer: &mut dyn Observer,
        stop: &dyn Fn() -> bool,
    ) -> Result<Summary, Unresumed> {
        let start = self.beginning(start).map_err(Unresumed::Failed)?;
        resume(self.problem(&start), checkpoint, observer, stop)
    }

    /// Finds the start, runs to the end and keeps every sample.
    ///
    /// # Errors
    /// [`Rejected`] when there is no consistent start or the run stops early.
    pub fn solve(&self) -> Result<Motion, Rejected> {
        self.solve_from(self.start()?)
    }

    /// Motion ([`Simulation::solve`]) from a start whose state the caller may have changed.
    ///
    /// # Errors
    /// [`Rejected`] when the motion cannot begin there or the run stops early.
    pub fn solve_from(&self, start: Start) -> Result<Motion, Rejected> {
        self.solve_watched(start, &mut |_| (), &|| false)
    }

    /// Motion ([`Simulation::solve_from`]) with `reached` called with the time of every sample; it ends where `stop`, asked
    /// after every step, wishes so.
    ///
    /// # Errors
    /// [`Rejected`] as [`Simulation::solve_from`].
    pub fn solve_watched(
        &self,
        start: Start,
        reached: &mut dyn FnMut(f64),
        stop: &dyn Fn() -> bool,
    ) -> Result<Motion, Rejected> {
        let mut samples = Vec::new();
        let mut keep = |sample: &Sample| {
            samples.push(sample.clone());
            reached(sample.t);
            Control::Continue
        };
        let summary = self
            .run(&start, &mut keep, stop)
            .map_err(|failure| Rejected(vec![self.diagnose(&failure)]))?;
        Ok(Motion { start, samples, summary })
    }

    /// A start that was not found, in the author's terms.
    pub fn diagnose_start(&self, error: &StartError) -> Diagnostic {
        let Mechanism { model, system, compiled, .. } = &self.mechanism();
        diagnose_start(model, system, compiled, error)
    }

    /// Warnings about a run whose numbers are worse than its tolerances promise.
    pub fn diagnose_worth(&self, summary: &Summary) -> Vec<Diagnostic> {
        let Mechanism { model, system, .. } = &self.mechanism();
        diagnose_worth(model, system, &self.options, summary)
    }

    /// The warning about a run that takes far more steps than expected.
    pub fn diagnose_slowness(&self, slowness: &Slowness) -> Diagnostic {
        let Mechanism { model, system, compiled, parameters, .. } = &self.mechanism();
        diagnose_slowness(model, system, compiled, parameters, slowness)
    }

    /// A failed run in the author's terms.
    pub fn diagnose(&self, failure: &Failure) -> Diagnostic {
        let Mechanism { model, system, compiled, parameters, .. } = &self.mechanism();
        diagnose_run(model, system, compiled, &self.equations, parameters, failure)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_share_simulations() {
        fn assert_shared<T: Send + Sync + Clone>() {}
        assert_shared::<Simulation>();
    }
}
