//! From a model's text to its motion, in one value.

use std::sync::Arc;

use crate::assembly::take_sides;
use crate::compiled::{CompiledSystem, compile};
use crate::coupling::check_couplings;
use crate::fault::{diagnose_at_start, diagnose_start};
use crate::input::{Law, check_inputs};
use crate::mobility::Mobility;
use crate::sampled::Sampling;
use crate::sensitivity::{self, Sensitive, SensitivityError};
use crate::start::{Closed, Start, closed, start};
use crate::start_error::StartError;
use bksim_mbs::assemble::{assemble, assemble_positions};
use bksim_mbs::equations::{Equations, Notation, equations};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;
use bksim_model::diagnostic::{Diagnostic, Rejected};
use bksim_model::file::{Source, read};

/// A model with its equations, derived and compiled.
#[derive(Debug)]
pub struct Mechanism {
    /// The model that the author wrote.
    pub model: Model,
    /// The equations of motion.
    pub system: SymbolicSystem,
    /// The equations as functions of numbers; shared by all who evaluate them.
    pub compiled: Arc<CompiledSystem>,
    /// Parameter values in the order of the model's parameters.
    pub parameters: Vec<f64>,
    /// Warnings found on the way.
    pub warnings: Vec<Diagnostic>,
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

    /// The positions of a model alone: as [`Mechanism::derive`], but without masses and loads, for questions
    /// that only joints and drives answer.
    ///
    /// # Errors
    /// [`Rejected`] when an expression of the model cannot be compiled.
    pub fn positions(mut model: Model) -> Result<Self, Rejected> {
        // Nor have controllers a part in them, and nothing counts turns.
        model.forget_turns();
        model.held.clear();
        model.named_signals.clear();
        take_sides(&mut model);
        let system = assemble_positions(&model);
        let faults = check_couplings(&model, &system).map_err(|e| uncompiled(&e))?;
        if !faults.is_empty() {
            return Err(Rejected(faults));
        }
        let compiled = Arc::new(compile(&model, &system).map_err(|e| uncompiled(&e))?);
        let parameters = model.parameters.iter().map(|p| p.value).collect();
        Ok(Self { model, system, compiled, parameters, warnings: Vec::new() })
    }

    /// Derives and compiles the equations of a model whose inputs follow `law`.
    ///
    /// # Errors
    /// [`Rejected`] as [`Mechanism::derive`].
    pub fn derive_with(
        mut model: Model,
        law: Option<Arc<Law>>,
        warnings: Vec<Diagnostic>,
    ) -> Result<Self, Rejected> {
        take_sides(&mut model);
        let system = assemble(&model);
        let mut faults = check_inputs(&model, &system);
        faults.extend(check_couplings(&model, &system).map_err(|e| uncompiled(&e))?);
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
        self.check_assembly()?;
        let Self { model, system, compiled, parameters, .. } = self;
        start(model, system, compiled, parameters)
            .map_err(|error| Rejected(vec![diagnose_start(model, system, compiled, &error)]))
    }

    /// All warnings about a start, after those that the reading of the model gave.
    pub fn warnings_of(
        &self,
        start: &Start,
        found: &Mobility,
        read: Vec<Diagnostic>,
    ) -> Vec<Diagnostic> {
        let Self { model, system, compiled, parameters, .. } = self;
        let numbers = (compiled.as_ref(), parameters.as_slice());
        diagnose_at_start((model, system), numbers, start, found, read)
    }

    /// The positions of the start alone, which need no masses.
    ///
    /// # Errors
    /// [`Rejected`] as [`Mechanism::start`].
    pub fn closed(&self) -> Result<Closed, Rejected> {
        self.check_assembly()?;
        let Self { model, system, compiled, parameters, .. } = self;
        closed(model, system, compiled, parameters)
            .map_err(|error| Rejected(vec![diagnose_start(model, system, compiled, &error)]))
    }

    /// The sampled signals of the model, for callers who follow them along a motion of their own.
    ///
    /// # Errors
    /// [`Rejected`] names a clock that ticks too often in the time of the model's solution.
    pub fn sampling(&self) -> Result<Sampling<'_>, Rejected> {
        let Self { model, system, compiled, parameters, .. } = self;
        let sampling = compiled.sampling(parameters);
        let Some((clock, every)) = sampling.too_many(&model.solve) else { return Ok(sampling) };
        let error = StartError::TooManyTicks { clock, every };
        Err(Rejected(vec![diagnose_start(model, system, compiled, &error)]))
    }

    /// Refuses a start whose assembly nobody has looked for: that is a question of its own.
    fn check_assembly(&self) -> Result<(), Rejected> {
        let chosen = self.model.assembly.as_ref().filter(|chosen| chosen.found.is_none());
        let Some(chosen) = chosen else { return Ok(()) };
        let message = "the assembly that `[initial]` chooses has not been looked for";
        let fault = Diagnostic::error(crate::codes::AMBIGUOUS, message)
            .at(chosen.span.clone(), "")
            .help("pass the model through `bksim::analysis::with_held_assembly` first");
        Err(Rejected(vec![fault]))
    }

    /// The parameter or stated initial value of this name: `l1`, `A.rate`.
    ///
    /// # Errors
    /// [`Rejected`] when there is none, or it is a guess.
    pub fn sensitive(&self, name: &str) -> Result<Sensitive, Rejected> {
        Sensitive::find(&self.model, name).map_err(|error| insensitive(&self.model, &error))
    }

    /// The answers of [`Mechanism::sensitive`] for some names, each once.
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
}

/// A quantity that the motion cannot be differentiated by, in the author's terms.
pub(crate) fn insensitive(model: &Model, error: &SensitivityError) -> Rejected {
    Rejected(vec![sensitivity::diagnose_sensitivity(model, error)])
}

/// A model with an expression that cannot be compiled, in the author's terms.
pub(crate) fn uncompiled(error: &bksim_expr::TapeError) -> Rejected {
    let code = crate::codes::NOT_FINITE_AT_START;
    Rejected(vec![Diagnostic::error(code, error.to_string())])
}
