//! Measures of the motion as functions of the state.

use bksim_expr::{Expr, Runner, SymbolId, Tape, TapeError, Workspace};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{Measure, Model};

/// Measures at one set of parameters, with their buffers.
#[derive(Clone, Debug)]
pub struct Measures {
    runner: Runner,
    workspace: Workspace,
    inputs: Vec<f64>,
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
        let values = coordinates.iter().map(|c| c.q);
        let inputs: Vec<SymbolId> = values.chain(coordinates.iter().map(|c| c.v)).collect();
        let symbols: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
        let tape = Tape::compile(&model.pool, &outputs, &inputs, &symbols)?;
        let workspace = tape.workspace(parameters);
        let runner = Runner::new(tape, model.solve.jit);
        Ok(Self { runner, workspace, inputs: Vec::new() })
    }

    /// Writes the measures at a state, in the order they were given in.
    ///
    /// # Panics
    /// If a length is not that of the model, or `values` are not as many as the measures.
    pub fn at(&mut self, q: &[f64], v: &[f64], values: &mut [f64]) {
        self.inputs.clear();
        self.inputs.extend_from_slice(q);
        self.inputs.extend_from_slice(v);
        self.runner.evaluate(&mut self.workspace, &self.inputs, values);
    }
}
