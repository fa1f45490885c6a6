//! [`Function`]: expressions as one compiled function of groups of symbols and of parameters.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use bksim_expr::{
    Expr, Jit, LaneRunner, LaneValues, LaneWorkspace, Runner, SymbolId, Tape, TapeError, Workspace,
};
use bksim_model::Model;

/// Points at which a function in lanes is evaluated at once.
pub(crate) const LANES: usize = 4;

/// A number at each of them.
pub(crate) type Lanes = [f64; LANES];

/// Expressions compiled as one function of numbers, as machine code where the model asks for it.
#[derive(Clone, Debug)]
pub(crate) struct Function {
    runner: Runner,
    /// Code for several points at once, where that is asked for.
    lanes: Option<LaneRunner<LANES>>,
}

/// Values of the parameters of a [`Function`], and room for its arguments and results, which is made when it is first
/// evaluated: of most functions of a mechanism, a run evaluates few.
#[derive(Clone, Debug)]
pub(crate) struct Buffers {
    parameters: Arc<[f64]>,
    room: Option<Room>,
}

#[derive(Clone, Debug)]
struct Room {
    workspace: Workspace,
    arguments: Vec<f64>,
    results: Vec<f64>,
}

/// Buffers for several points at once.
#[derive(Clone, Debug)]
pub(crate) struct LaneBuffers {
    workspace: LaneWorkspace<LANES>,
    arguments: LaneValues<LANES>,
    results: LaneValues<LANES>,
}

impl Buffers {
    /// Buffers of a function of these parameters.
    pub(crate) fn new(parameters: Arc<[f64]>) -> Self {
        Self { parameters, room: None }
    }
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
        Ok(Self::of(tape, model))
    }

    /// The function that a tape computes.
    pub(crate) fn of(tape: Tape, model: &Model) -> Self {
        Self::with_code(tape, model.solve.jit)
    }

    /// Function with machine code when `jit` says so.
    pub(crate) fn with_code(tape: Tape, jit: Jit) -> Self {
        Self { runner: Runner::new(tape, jit), lanes: None }
    }

    /// Function that can be evaluated at several points at once, too.
    pub(crate) fn in_lanes(self, model: &Model) -> Self {
        let lanes = LaneRunner::new(self.tape().clone(), model.solve.jit);
        Self { lanes: Some(lanes), ..self }
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
    pub(crate) fn buffers(&self, parameters: impl Into<Arc<[f64]>>) -> Buffers {
        let parameters = parameters.into();
        assert_eq!(parameters.len(), self.tape().n_parameters(), "number of parameters");
        Buffers::new(parameters)
    }

    /// The room of buffers, made where there is none yet.
    fn room<'b>(&self, Buffers { parameters, room }: &'b mut Buffers) -> &'b mut Room {
        room.get_or_insert_with(|| Room {
            workspace: self.tape().workspace(parameters),
            arguments: vec![0.0; self.tape().n_inputs()],
            results: vec![0.0; self.n_outputs()],
        })
    }

    /// Buffers for several points at once, with these values of the parameters; `None` for a function of one
    /// point.
    pub(crate) fn lane_buffers(&self, parameters: &[f64]) -> Option<LaneBuffers> {
        let workspace = self.lanes.as_ref()?.workspace(parameters);
        let zeros = LaneValues::zeros;
        let (arguments, results) = (zeros(self.tape().n_inputs()), zeros(self.n_outputs()));
        Some(LaneBuffers { workspace, arguments, results })
    }

    /// The results at several points at once, as [`Function::evaluate`].
    pub(crate) fn evaluate_lanes<'b>(
        &self,
        buffers: &'b mut LaneBuffers,
        arguments: &[&[Lanes]],
    ) -> &'b [Lanes] {
        let LaneBuffers { workspace, arguments: gathered, results } = buffers;
        gather(gathered, arguments);
        let runner = self.lanes.as_ref().expect("buffers are made for functions in lanes alone");
        runner.evaluate(workspace, gathered, results);
        results
    }

    /// The results at `arguments`, given group by group as they were compiled.
    pub(crate) fn evaluate<'b>(&self, buffers: &'b mut Buffers, arguments: &[&[f64]]) -> &'b [f64] {
        let Room { workspace, arguments: gathered, results } = self.room(buffers);
        gather(gathered, arguments);
        self.runner.evaluate(workspace, gathered, results);
        results
    }

    /// The results of the last [`Function::evaluate`]; none before the first.
    pub(crate) fn last(buffers: &Buffers) -> &[f64] {
        buffers.room.as_ref().map_or(&[], |room| &room.results)
    }

    /// Writes the results at `arguments` to `out`.
    pub(crate) fn evaluate_into(
        &self,
        buffers: &mut Buffers,
        arguments: &[&[f64]],
        out: &mut [f64],
    ) {
        let Room { workspace, arguments: gathered, .. } = self.room(buffers);
        gather(gathered, arguments);
        self.runner.evaluate(workspace, gathered, out);
    }
}

/// Uses of what is made of several functions once that pays; without machine code it never does.
#[derive(Debug)]
pub(crate) struct Uses {
    jit: Jit,
    n_before: AtomicUsize,
}

impl Uses {
    /// No uses yet.
    pub(crate) fn new(jit: Jit) -> Self {
        Self { jit, n_before: AtomicUsize::new(0) }
    }

    /// True where there have been as many as pay, or all pay; takes note of one otherwise.
    pub(crate) fn are_enough(&self, n_paid: usize) -> bool {
        match self.jit {
            Jit::Off => return false,
            Jit::On => return true,
            Jit::Auto => (),
        }
        let are_enough = self.n_before.load(Relaxed) >= n_paid;
        if !are_enough {
            self.n_before.fetch_add(1, Relaxed);
        }
        are_enough
    }
}

fn gather<T: Copy>(gathered: &mut [T], arguments: &[&[T]]) {
    let mut left = gathered;
    for group in arguments {
        let (place, rest) = left.split_at_mut(group.len());
        place.copy_from_slice(group);
        left = rest;
    }
    assert!(left.is_empty(), "an argument for every input");
}
