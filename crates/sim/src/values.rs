//! Expressions of an instant at one set of parameters, with the modes that hold there.

use bksim_expr::{Expr, SymbolId, TapeError};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;

use crate::compiled::CompiledSystem;
use crate::function::{Buffers, Function};
use crate::input::{InputValues, input_symbols, without_inputs};

/// Time, coordinates and velocities: s, nq, nq.
pub type State<'a> = (f64, &'a [f64], &'a [f64]);

/// Expressions of t, q, v, λ and accelerations, with their buffers.
#[derive(Clone, Debug)]
pub(crate) struct Values {
    function: Function,
    buffers: Buffers,
    inputs: InputValues,
    /// Values of the model's parameters, then the modes that `buffers` are made for.
    parameters: Vec<f64>,
    n_parameters: usize,
}

impl Values {
    /// Compiles expressions that may hold these modes; signals of reactions stand for multipliers.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither time, a parameter, a mode nor part of the state.
    pub(crate) fn compile(
        model: &Model,
        system: &SymbolicSystem,
        compiled: &CompiledSystem,
        parameters: &[f64],
        (outputs, modes): (&[Expr], &[SymbolId]),
    ) -> Result<Self, TapeError> {
        let outputs = model.pool.substitute_all(outputs, &system.reaction_values);
        let coordinates = system.coordinates();
        let [q, v, a] = [
            coordinates.iter().map(|c| c.q).collect::<Vec<SymbolId>>(),
            coordinates.iter().map(|c| c.v).collect(),
            coordinates.iter().map(|c| c.a).collect(),
        ];
        let lambda: Vec<SymbolId> = system.constraints.iter().map(|c| c.lambda).collect();
        let arguments = [&[model.time][..], &q, &v, &a, &lambda, &input_symbols(model)];
        let own = model.parameters.iter().map(|p| p.symbol);
        let symbols = without_inputs(model, own.chain(modes.iter().copied()).collect());
        let function = Function::compile(model, &outputs, &arguments, &symbols)?;
        let n_parameters = parameters.len();
        let parameters = [parameters, &vec![0.0; modes.len()]].concat();
        Ok(Self {
            buffers: function.buffers(&parameters[..]),
            function,
            inputs: InputValues::new(&compiled.inputs),
            parameters,
            n_parameters,
        })
    }

    /// The values at an instant with the modes that hold there; accelerations are empty where no expression has them.
    ///
    /// # Panics
    /// If the state or the modes are not as long as those of the model.
    pub(crate) fn at(
        &mut self,
        (t, q, v): State<'_>,
        a: &[f64],
        lambda: &[f64],
        modes: &[f64],
    ) -> &[f64] {
        let own = &mut self.parameters[self.n_parameters..];
        if *own != *modes {
            own.copy_from_slice(modes);
            self.buffers = self.function.buffers(&self.parameters[..]);
        }
        let a = if a.is_empty() { v } else { a };
        let arguments = [&[t], q, v, a, lambda, self.inputs.at(t, q, v)];
        self.function.evaluate(&mut self.buffers, &arguments)
    }
}

/// Everything that switches in a run, as [`Values::compile`] takes it.
pub(crate) fn modes_of(model: &Model, system: &SymbolicSystem) -> Vec<SymbolId> {
    system.integrated().parameters(model).split_off(model.parameters.len())
}
