//! What models with the same equations share: all that does not depend on the values of their
//! parameters.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, TryLockError};

use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::Recording;
use bksim::model::{Formulation, SolveOptions};
use bksim::record::Channels;
use bksim::sim::compiled::CompiledSystem;
use bksim::sim::formulate::MotionEquations;
use bksim::sim::start::StartEquations;
use bksim::{Mechanism, Rejected};
use bksim_load::Text;
use pyo3::prelude::*;
use pyo3::sync::MutexExt;

use crate::fault::Fault;

/// The equations of a model, each derived and compiled once.
pub(crate) struct Derived {
    pub(crate) source: Text,
    pub(crate) name: String,
    /// Parameters, with their SI units.
    pub(crate) units: Vec<(String, String)>,
    /// About the values that it was derived with.
    pub(crate) warnings: Vec<Diagnostic>,
    pub(crate) compiled: Arc<CompiledSystem>,
    pub(crate) channels: Channels,
    /// How values follow from those that vary, where some do.
    pub(crate) recording: Option<Recording>,
    /// Its expressions are for one thread at a time; what is compiled is for all.
    mechanism: Mutex<Mechanism>,
    start: OnceLock<StartEquations>,
    equations: Mutex<Vec<(Formulation, Arc<MotionEquations>)>>,
}

impl Derived {
    pub(crate) fn new(
        source: Text,
        mechanism: Mechanism,
        warnings: Vec<Diagnostic>,
        recording: Option<Recording>,
    ) -> Self {
        let parameters = mechanism.model.parameters.iter();
        Self {
            source,
            name: mechanism.model.name.clone(),
            units: parameters.map(|p| (p.name.clone(), p.unit.clone())).collect(),
            warnings,
            compiled: mechanism.compiled.clone(),
            channels: Channels::new(&mechanism),
            recording,
            mechanism: Mutex::new(mechanism),
            start: OnceLock::new(),
            equations: Mutex::default(),
        }
    }

    /// The mechanism with these values, for this thread alone. Who has it may wait for the interpreter, when a law
    /// is a function of Python: so nobody waits for it with the interpreter lock held.
    pub(crate) fn mechanism(
        &self,
        parameters: &[f64],
        options: &SolveOptions,
    ) -> MutexGuard<'_, Mechanism> {
        let mut mechanism = match self.mechanism.try_lock() {
            Ok(mechanism) => mechanism,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => Python::attach(|py| {
                let locked = self.mechanism.lock_py_attached(py);
                locked.unwrap_or_else(PoisonError::into_inner)
            }),
        };
        mechanism.parameters.copy_from_slice(parameters);
        for (known, value) in mechanism.model.parameters.iter_mut().zip(parameters) {
            known.value = *value;
        }
        mechanism.model.solve.clone_from(options);
        mechanism
    }

    /// What a start is found from.
    pub(crate) fn start<'s>(
        &'s self,
        mechanism: impl FnOnce() -> MutexGuard<'s, Mechanism>,
    ) -> Result<&'s StartEquations, Rejected> {
        if let Some(start) = self.start.get() {
            return Ok(start);
        }
        let start = mechanism().start_equations()?;
        Ok(self.start.get_or_init(|| start))
    }

    /// The equations of motion in one of their forms.
    pub(crate) fn equations<'s>(
        &'s self,
        form: Formulation,
        mechanism: impl FnOnce() -> MutexGuard<'s, Mechanism>,
    ) -> Result<Arc<MotionEquations>, Fault> {
        // What is behind a lock is whole between calls, also after a panic.
        let mut known = self.equations.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, equations)) = known.iter().find(|(known, _)| *known == form) {
            return Ok(equations.clone());
        }
        let mut mechanism = mechanism();
        mechanism.model.solve.formulation = form;
        let equations = mechanism.formulate();
        drop(mechanism);
        let equations =
            equations.map_err(|Rejected(faults)| Fault::model(&self.source, &faults))?;
        let equations = Arc::new(equations);
        known.push((form, equations.clone()));
        Ok(equations)
    }
}
