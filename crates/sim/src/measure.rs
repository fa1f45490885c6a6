//! Measures of the motion as functions of the state.

use bksim_expr::{Expr, SymbolId, TapeError};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{Measure, Model};

use crate::function::{Buffers, Function};

/// Measures at one set of parameters, with their buffers.
#[derive(Clone, Debug)]
pub struct Measures {
    function: Function,
    buffers: Buffers,
}

impl Measures {
    /// Compiles measures as functions of the state.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither a parameter nor part of the state.
    ///
    /// # Panics
    /// If `parameters` are not as many as in the model.
    pub fn compile(
        model: &Model,
        system: &SymbolicSystem,
        measures: &[Measure],
        parameters: &[f64],
    ) -> Result<Self, TapeError> {
        let coordinates = system.coordinates();
        let outputs: Vec<Expr> =
            measures.iter().map(|&measure| system.kinematics.measure(model, measure)).collect();
        let q: Vec<SymbolId> = coordinates.iter().map(|c| c.q).collect();
        let v: Vec<SymbolId> = coordinates.iter().map(|c| c.v).collect();
        let a: Vec<SymbolId> = coordinates.iter().map(|c| c.a).collect();
        let symbols: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
        let function = Function::compile(model, &outputs, &[&q, &v, &a], &symbols)?;
        Ok(Self { buffers: function.buffers(parameters), function })
    }

    /// Writes the measures at coordinates, velocities and accelerations, in the order they were given in.
    ///
    /// # Panics
    /// If a length is not that of the model, or `values` are not as many as the measures.
    pub fn at(&mut self, [q, v, a]: [&[f64]; 3], values: &mut [f64]) {
        self.function.evaluate_into(&mut self.buffers, &[q, v, a], values);
    }
}
