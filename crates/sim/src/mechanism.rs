//! From a model's text to its motion, in one value.

use std::sync::Arc;

use crate::compiled::{CompiledSystem, compile};
use crate::fault::{diagnose_run, diagnose_start};
use crate::formulate::{MotionEquations, formulate};
use crate::input::{Law, check_inputs};
use crate::run::{
    Failure, Observer, Problem, RunCheckpoint, Sample, Summary, Unresumed, WithSensitivities,
    resume, run,
};
pub use crate::sensitivity::SensitivityPlan;
use crate::sensitivity::{
    self, Sensitive, SensitivityError, StateSensitivity, differentiate, run_with_sensitivities,
};
use crate::start::{Start, StartEquations, StartError, start};
use bksim_dae::Control;
use bksim_mbs::assemble::assemble;
use bksim_mbs::equations::{Equations, Notation, equations};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;
use bksim_model::diagnostic::{Diagnostic, Rejected};
use bksim_model::file::{Source, read};

/// A model with its equations, derived and compiled.
#[derive(Debug)]
pub struct Mechanism {
    /// What the author wrote.
    pub model: Model,
    /// The equations of motion.
    pub system: SymbolicSystem,
    /// The equations as functions of numbers; shared by whoever evaluates them.
    pub compiled: Arc<CompiledSystem>,
    /// Parameter values in the order of the model's parameters.
    pub parameters: Vec<f64>,
    /// Warnings found on the way.
    pub warnings: Vec<Diagnostic>,
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
    /// Reads a TOML model and derives its equations; `name` is used unless the model has one.
    ///
    /// # Errors
    /// [`Rejected`] holds every fault of the model.
    pub fn from_toml(text: &str, name: &str) -> Result<Self, Rejected> {
        let reading = read(&Source::new(text, name));
        match reading.model {
            Some(model) => Self::derive(model, reading.diagnostics),
            None => Err(Rejected(reading.diagnostics)),
        }
    }

    /// Derives and compiles the equations of a model.
    ///
    /// # Errors
    /// [`Rejected`] when an expression of the model cannot be compiled, or one of its inputs is more
    /// than a part of loads.
    pub fn derive(model: Model, warnings: Vec<Diagnostic>) -> Result<Self, Rejected> {
        Self::derive_with(model, None, warnings)
    }

    /// Derives and compiles the equations of a model whose inputs follow `law`.
    ///
    /// # Errors
    /// [`Rejected`] as [`Mechanism::derive`].
    pub fn derive_with(
        model: Model,
        law: Option<Arc<Law>>,
        warnings: Vec<Diagnostic>,
    ) -> Result<Self, Rejected> {
        let system = assemble(&model);
        let faults = check_inputs(&model, &system);
        if !faults.is_empty() {
            return Err(Rejected(faults));
        }
        let compiled = compile(&model, &system).map_err(|e| uncompiled(&e))?;
        let compiled = match law {
            Some(law) => compiled.with_law(law),
            None => compiled,
        };
        let compiled = Arc::new(compiled);
        let parameters = model.parameters.iter().map(|p| p.value).collect();
        Ok(Self { model, system, compiled, parameters, warnings })
    }

    /// T, V, the Lagrange equations and the constraints as text.
    pub fn equations(&self) -> Equations {
        equations(&self.model, &self.system, Notation::Text)
    }

    /// The consistent start.
    ///
    /// # Errors
    /// [`Rejected`] says which loop cannot close or which stated values exclude each other.
    pub fn start(&self) -> Result<Start, Rejected> {
        start(&self.model, &self.system, &self.compiled, &self.parameters)
            .map_err(|error| Rejected(vec![self.diagnose_start(&error)]))
    }

    /// What the model says about its start, compiled for every parameter value.
    ///
    /// # Errors
    /// [`Rejected`] when an expression of the model cannot be compiled.
    pub fn start_equations(&self) -> Result<StartEquations, Rejected> {
        StartEquations::compile(&self.model, &self.system).map_err(|e| uncompiled(&e))
    }

    /// A start that was not found in the author's terms.
    pub fn diagnose_start(&self, error: &StartError) -> Diagnostic {
        diagnose_start(&self.model, &self.system, &self.compiled, error)
    }

    /// The compiled residual and Jacobian of the formulation the model asks for.
    ///
    /// # Errors
    /// [`Rejected`] when an expression of the model cannot be compiled.
    pub fn formulate(&self) -> Result<MotionEquations, Rejected> {
        let equations = formulate(&self.model, &self.system, self.model.solve.formulation);
        let equations = equations.map_err(|e| uncompiled(&e))?;
        Ok(equations.with_inputs(&self.compiled.inputs))
    }

    /// The motion from `start` with the parameters and options of the model.
    pub fn problem<'a>(&'a self, equations: &'a MotionEquations, start: &'a Start) -> Problem<'a> {
        let Self { model, compiled, parameters, .. } = self;
        Problem { compiled, equations, start, parameters, options: &model.solve }
    }

    /// Runs from `start` and hands every sample to `observer`, which may stop the run; `stop` is
    /// asked after every step.
    ///
    /// # Errors
    /// [`Failure`] when the integrator cannot go on; see [`Mechanism::diagnose`].
    pub fn run(
        &self,
        equations: &MotionEquations,
        start: &Start,
        observer: &mut dyn Observer,
        stop: &dyn Fn() -> bool,
    ) -> Result<Summary, Box<Failure>> {
        run(self.problem(equations, start), observer, stop)
    }

    /// Continues a run that was stopped, as if it had not been; `start` is where it began. See
    /// [`crate::run::resume`].
    ///
    /// # Errors
    /// [`Unresumed`] when the checkpoint belongs to another run, or the integrator cannot go on.
    pub fn resume(
        &self,
        equations: &MotionEquations,
        start: &Start,
        checkpoint: &RunCheckpoint,
        observer: &mut dyn Observer,
        stop: &dyn Fn() -> bool,
    ) -> Result<Summary, Unresumed> {
        resume(self.problem(equations, start), checkpoint, observer, stop)
    }

    /// A failed run in the author's terms.
    pub fn diagnose(&self, equations: &MotionEquations, failure: &Failure) -> Diagnostic {
        diagnose_run(
            &self.model,
            &self.system,
            &self.compiled,
            equations,
            &self.parameters,
            failure,
        )
    }

    /// Finds the start, runs to the end and keeps every sample.
    ///
    /// # Errors
    /// [`Rejected`] when there is no consistent start or the run stops early.
    pub fn solve(&self) -> Result<Motion, Rejected> {
        let start = self.start()?;
        let equations = self.formulate()?;
        let mut samples = Vec::new();
        let mut keep = |sample: &Sample| {
            samples.push(sample.clone());
            Control::Continue
        };
        let summary = self.run(&equations, &start, &mut keep, &|| false);
        match summary {
            Ok(summary) => Ok(Motion { start, samples, summary }),
            Err(failure) => Err(Rejected(vec![self.diagnose(&equations, &failure)])),
        }
    }

    /// The parameter or stated initial value of this name: `l1`, `A.rate`.
    ///
    /// # Errors
    /// [`Rejected`] when there is none, or it is a guess.
    pub fn sensitive(&self, name: &str) -> Result<Sensitive, Rejected> {
        Sensitive::find(&self.model, name).map_err(|error| self.insensitive(&error))
    }

    /// What [`Mechanism::sensitive`] says of some names, each once.
    ///
    /// # Errors
    /// [`Rejected`] when there is none of a name, or it is a guess.
    pub fn all_sensitive(&self, names: &[String]) -> Result<Vec<Sensitive>, Rejected> {
        let mut all = Vec::new();
        for name in names {
            let by = self.sensitive(name)?;
            if !all.contains(&by) {
                all.push(by);
            }
        }
        Ok(all)
    }

    /// The differentiated equations, and the sensitivities of the start.
    ///
    /// # Errors
    /// [`Rejected`] when the model switches, or has no motion for other values near these.
    pub fn plan_sensitivities(
        &self,
        start: &Start,
        sensitive: &[Sensitive],
    ) -> Result<SensitivityPlan, Rejected> {
        let Self { model, system, compiled, parameters, .. } = self;
        let form = model.solve.formulation;
        let plan = || {
            let equations = differentiate(model, system, compiled, form, sensitive, parameters)?;
            let start = sensitivity::start(&equations, model, compiled, start, parameters)?;
            Ok(SensitivityPlan { equations, start })
        };
        plan().map_err(|error| self.insensitive(&error))
    }

    /// As [`Mechanism::run`], with Radau IIA throughout and every sample with its sensitivities.
    ///
    /// # Errors
    /// [`Failure`] when the integrator cannot go on; see [`Mechanism::diagnose`].
    pub fn run_with_sensitivities(
        &self,
        equations: &MotionEquations,
        start: &Start,
        plan: &SensitivityPlan,
        observer: &mut dyn Observer,
        stop: &dyn Fn() -> bool,
    ) -> Result<Summary, Box<Failure>> {
        run_with_sensitivities(self.problem(equations, start), plan, observer, stop)
    }

    /// Finds the start, runs to the end with Radau IIA and keeps every sample with its derivatives by
    /// `sensitive`.
    ///
    /// # Errors
    /// [`Rejected`] when there is no consistent start, none near it, or the run stops early.
    pub fn sensitivities(&self, sensitive: &[Sensitive]) -> Result<SensitivityMotion, Rejected> {
        let start = self.start()?;
        let equations = self.formulate()?;
        let plan = self.plan_sensitivities(&start, sensitive)?;
        let (mut samples, mut sensitivities) = (Vec::new(), Vec::new());
        let mut keep = WithSensitivities(|sample: &Sample, by: &[StateSensitivity]| {
            samples.push(sample.clone());
            sensitivities.push(by.to_vec());
            Control::Continue
        });
        match self.run_with_sensitivities(&equations, &start, &plan, &mut keep, &|| false) {
            Ok(summary) => {
                let motion = Motion { start, samples, summary };
                Ok(SensitivityMotion { motion, sensitivities })
            }
            Err(failure) => Err(Rejected(vec![self.diagnose(&equations, &failure)])),
        }
    }

    fn insensitive(&self, error: &SensitivityError) -> Rejected {
        Rejected(vec![sensitivity::diagnose_sensitivity(&self.model, error)])
    }
}

fn uncompiled(error: &bksim_expr::TapeError) -> Rejected {
    let code = crate::codes::NOT_FINITE_AT_START;
    Rejected(vec![Diagnostic::error(code, error.to_string())])
}
