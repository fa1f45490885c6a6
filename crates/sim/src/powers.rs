//! [`Powers`]: the power of every part of a mechanism that gives or takes energy, as functions of the state.

use bksim_expr::{Expr, TapeError};
use bksim_mbs::power::{Actor, powers};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;

use crate::compiled::CompiledSystem;
use crate::values::{State, Values, modes_of};

/// The powers and potentials of the parts of a mechanism at one set of parameters, with their buffers.
#[derive(Clone, Debug)]
pub struct Powers {
    actors: Vec<Actor>,
    values: Values,
}

impl Powers {
    /// Compiles the powers of all parts that have one or a potential.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither time, a parameter nor part of the state.
    ///
    /// # Panics
    /// If `parameters` are not as many as in the model.
    pub fn compile(
        model: &Model,
        system: &SymbolicSystem,
        compiled: &CompiledSystem,
        parameters: &[f64],
    ) -> Result<Self, TapeError> {
        let found = powers(model, system);
        let powers = found.iter().map(|power| power.power);
        let outputs: Vec<Expr> = powers.chain(found.iter().map(|power| power.potential)).collect();
        let modes = modes_of(model, system);
        let values = Values::compile(model, system, compiled, parameters, (&outputs, &modes))?;
        Ok(Self { actors: found.iter().map(|power| power.actor).collect(), values })
    }

    /// The parts, in the order of [`Powers::at`].
    pub fn actors(&self) -> &[Actor] {
        &self.actors
    }

    /// The powers of all parts, W, then their potentials, J, at an instant with the modes that hold there.
    ///
    /// # Panics
    /// If the state or the modes are not as long as those of the model.
    pub fn at(&mut self, state: State<'_>, lambda: &[f64], modes: &[f64]) -> (&[f64], &[f64]) {
        self.values.at(state, &[], lambda, modes).split_at(self.actors.len())
    }
}
