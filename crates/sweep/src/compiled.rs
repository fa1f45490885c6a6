//! [`Compiled`]: the functions of a mechanism that every case needs.

use std::sync::Arc;

use bksim::sim::compiled::CompiledSystem;
use bksim::sim::formulate::MotionEquations;
use bksim::sim::start::StartEquations;
use bksim::{Mechanism, Rejected};

/// The functions of a mechanism that a case needs.
#[derive(Clone, Debug)]
pub(crate) struct Compiled {
    pub(crate) system: Arc<CompiledSystem>,
    pub(crate) equations: MotionEquations,
    pub(crate) start: StartEquations,
}

impl Compiled {
    pub(crate) fn of(mechanism: &Mechanism) -> Result<Self, Rejected> {
        let (equations, start) = (mechanism.formulate()?, mechanism.start_equations()?);
        Ok(Self { system: mechanism.compiled.clone(), equations, start })
    }
}
