//! [`Powers`]: the power of every part of a mechanism that gives or takes energy, as functions of the state.

use bksim_expr::{Expr, SymbolId, TapeError};
use bksim_mbs::power::{Actor, powers};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;

use crate::compiled::CompiledSystem;
use crate::function::{Buffers, Function};
use crate::input::{InputValues, input_symbols, without_inputs};

/// The powers and potentials of the parts of a mechanism at one set of parameters, with their buffers.
#[derive(Clone, Debug)]
pub struct Powers {
    actors: Vec<Actor>,
    function: Function,
    buffers: Buffers,
    inputs: InputValues,
    /// Values of the model's parameters, then the modes that `buffers` are made for.
    parameters: Vec<f64>,
    n_parameters: usize,
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
        let coordinates = system.coordinates();
        let q: Vec<SymbolId> = coordinates.iter().map(|c| c.q).collect();
        let v: Vec<SymbolId> = coordinates.iter().map(|c| c.v).collect();
        let lambda: Vec<SymbolId> = system.constraints.iter().map(|c| c.lambda).collect();
        let arguments = [&[model.time][..], &q, &v, &lambda, &input_symbols(model)];
        let symbols = without_inputs(model, system.integrated().parameters(model));
        let function = Function::compile(model, &outputs, &arguments, &symbols)?;
        let n_modes = symbols.len() - parameters.len();
        let n_parameters = parameters.len();
        let parameters = [parameters, &vec![0.0; n_modes]].concat();
        Ok(Self {
            actors: found.iter().map(|power| power.actor).collect(),
            buffers: function.buffers(&parameters[..]),
            function,
            inputs: InputValues::new(&compiled.inputs),
            parameters,
            n_parameters,
        })
    }

    /// The parts, in the order of [`Powers::at`].
    pub fn actors(&self) -> &[Actor] {
        &self.actors
    }

    /// The powers of all parts, W, then their potentials, J, at an instant with the modes that hold there.
    ///
    /// # Panics
    /// If the state or the modes are not as long as those of the model.
    pub fn at(
        &mut self,
        (t, q, v): (f64, &[f64], &[f64]),
        lambda: &[f64],
        modes: &[f64],
    ) -> (&[f64], &[f64]) {
        let own = &mut self.parameters[self.n_parameters..];
        if *own != *modes {
            own.copy_from_slice(modes);
            self.buffers = self.function.buffers(&self.parameters[..]);
        }
        let arguments = [&[t], q, v, lambda, self.inputs.at(t, q, v)];
        let numbers = self.function.evaluate(&mut self.buffers, &arguments);
        numbers.split_at(self.actors.len())
    }
}
