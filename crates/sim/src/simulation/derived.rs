//! [`Derived`]: the part of a simulation that all of its copies share.

use std::sync::{Arc, OnceLock};

use bksim_expr::PoolSnapshot;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::{Formulation, Model};

use crate::compiled::CompiledSystem;
use crate::formulate::{LazyMotionEquations, MotionEquations, formulate};
use crate::start::StartEquations;

/// Everything that does not depend on values: common to all copies of a simulation.
#[derive(Debug)]
pub(super) struct Derived {
    pub(super) model: Model<PoolSnapshot>,
    pub(super) system: SymbolicSystem,
    pub(super) start: StartEquations,
    /// The equations of motion in each formulation that has been asked for.
    pub(super) equations: [OnceLock<Arc<MotionEquations>>; 4],
    /// Why a parameter cannot be an input, for each that cannot; found when it is asked for first.
    pub(super) not_only_loads: OnceLock<Vec<Option<Diagnostic>>>,
}

impl Derived {
    /// The equations of motion in a formulation, compiled when they are asked for first.
    pub(super) fn equations(&self, formulation: Formulation) -> &Arc<MotionEquations> {
        self.equations[formulation as usize].get_or_init(|| {
            let equations = formulate(&self.model.to_model(), &self.system, formulation);
            Arc::new(equations.expect("every symbol is one of the dynamics, which have compiled"))
        })
    }

    /// Equations that are compiled when they are used first, with the values of inputs from where `compiled` takes them.
    pub(super) fn equations_on_demand(
        self: &Arc<Self>,
        formulation: Formulation,
        compiled: &Arc<CompiledSystem>,
    ) -> Arc<LazyMotionEquations> {
        let (derivation, compiled) = (self.clone(), compiled.clone());
        Arc::new(LazyMotionEquations::new(Box::new(move || {
            let equations = derivation.equations(formulation);
            if compiled.inputs.is_empty() {
                return equations.clone();
            }
            Arc::new(MotionEquations::clone(equations).with_inputs(&compiled.inputs))
        })))
    }
}
