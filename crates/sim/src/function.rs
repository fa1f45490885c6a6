//! [`Function`]: expressions as one compiled function of groups of symbols and of parameters.

use bksim_expr::{Expr, Runner, SymbolId, Tape, TapeError, Workspace};
use bksim_model::Model;

/// Expressions compiled as one function of numbers, as machine code where the model asks for it.
#[derive(Clone, Debug)]
pub(crate) struct Function {
    runner: Runner,
}

/// Values of the parameters of a [`Function`], and room for its arguments and results.
#[derive(Clone, Debug)]
pub(crate) struct Buffers {
    workspace: Workspace,
    arguments: Vec<f64>,
    results: Vec<f64>,
}

impl Function {
    /// Compiles `outputs` as a function of `arguments`, one group after the other, and of `parameters`.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither an argument nor a parameter.
    pub(crate) fn compile(
        model: &Model,
        outputs: &[Expr],
        arguments: &[&[SymbolId]],
        parameters: &[SymbolId],
    ) -> Result<Self, TapeError> {
        let tape = Tape::compile(&model.pool, outputs, &arguments.concat(), parameters)?;
        Ok(Self { runner: Runner::new(tape, model.solve.jit) })
    }

    /// The straight-line code that it runs.
    pub(crate) fn tape(&self) -> &Tape {
        self.runner.tape()
    }

    /// Number of results.
    pub(crate) fn n_outputs(&self) -> usize {
        self.tape().n_outputs()
    }

    /// Buffers with these values of the parameters.
    pub(crate) fn buffers(&self, parameters: &[f64]) -> Buffers {
        Buffers {
            workspace: self.tape().workspace(parameters),
            arguments: Vec::with_capacity(self.tape().n_inputs()),
            results: vec![0.0; self.n_outputs()],
        }
    }

    /// The results at `arguments`, given group by group as they were compiled.
    pub(crate) fn evaluate<'b>(&self, buffers: &'b mut Buffers, arguments: &[&[f64]]) -> &'b [f64] {
        let Buffers { workspace, arguments: gathered, results } = buffers;
        gather(gathered, arguments);
        self.runner.evaluate(workspace, gathered, results);
        results
    }

    /// Writes the results at `arguments` to `out`.
    pub(crate) fn evaluate_into(
        &self,
        buffers: &mut Buffers,
        arguments: &[&[f64]],
        out: &mut [f64],
    ) {
        let Buffers { workspace, arguments: gathered, .. } = buffers;
        gather(gathered, arguments);
        self.runner.evaluate(workspace, gathered, out);
    }
}

fn gather(gathered: &mut Vec<f64>, arguments: &[&[f64]]) {
    gathered.clear();
    for group in arguments {
        gathered.extend_from_slice(group);
    }
}
