//! [`Equations`] of a start near a state, and [`WithSlopes`], the compiled functions that they come from.
//!
//! A search evaluates them some hundred times for each start. Which entries they have never changes: it takes their
//! [`Numbers`] alone, into room that is kept.

use bksim_expr::{Expr, Pool, SymbolId, Tape, TapeError, Workspace};

use crate::evaluator::ConstraintsAt;
use crate::linear::rows::SparseRows;
use bksim_mbs::system::SymbolicSystem;

/// Equations values = 0 near a state, with their slopes by q or v.
pub(super) struct Equations {
    pub(super) values: Vec<f64>,
    pub(super) gradients: SparseRows,
}

impl Equations {
    /// No equations in so many unknowns.
    pub(super) fn new(n_unknowns: usize) -> Self {
        Self { values: Vec::new(), gradients: SparseRows::new(n_unknowns) }
    }

    /// These and some more.
    pub(super) fn with(mut self, more: &Self) -> Self {
        self.values.extend(&more.values);
        for row in 0..more.gradients.n_rows() {
            self.gradients.push(more.gradients.row(row).iter().copied());
        }
        self
    }
}

/// Numbers of equations whose entries are known.
#[derive(Clone, Debug, Default)]
pub(super) struct Numbers {
    pub(super) values: Vec<f64>,
    /// The slopes of each row, one row after the other.
    pub(super) slopes: Vec<f64>,
}

impl Numbers {
    /// Takes all equations out.
    pub(super) fn clear(&mut self) {
        self.values.clear();
        self.slopes.clear();
    }

    /// Adds rows: their values, and all their slopes.
    pub(super) fn add(&mut self, values: &[f64], slopes: &[f64]) {
        self.values.extend_from_slice(values);
        self.slopes.extend_from_slice(slopes);
    }
}

impl ConstraintsAt<'_> {
    /// Adds g = 0 with the rows of ∂g/∂q: those of G, and empty ones of what holds between rates.
    pub(super) fn add_to(&self, equations: &mut Equations) {
        equations.values.extend(self.value);
        let of_rates = &self.shape.of_rates;
        if of_rates.is_empty() {
            self.add_jacobian_rows_to(&mut equations.gradients);
            return;
        }
        let rows = self.jacobian_rows();
        for row in 0..rows.n_rows() {
            let entries = if of_rates.contains(&row) { &[][..] } else { rows.row(row) };
            equations.gradients.push(entries.iter().copied());
        }
    }

    /// Adds the numbers of these rows.
    pub(super) fn add_numbers_to(&self, numbers: &mut Numbers) {
        let of_rates = &self.shape.of_rates;
        if of_rates.is_empty() {
            numbers.add(self.value, self.jacobian);
            return;
        }
        let entries = self.shape.jacobian.iter().zip(self.jacobian);
        let entries = entries.filter(|((row, _), _)| !of_rates.contains(row));
        let slopes: Vec<f64> = entries.map(|(_, &slope)| slope).collect();
        numbers.add(self.value, &slopes);
    }
}

/// Functions of the state with their slopes, compiled.
#[derive(Clone, Debug)]
pub(super) struct WithSlopes {
    /// Each function, then its slopes.
    tape: Tape,
    /// The coordinates that each one's slopes are by.
    pub(super) moving: Vec<Vec<usize>>,
    /// Where each function stands among the outputs.
    first: Vec<usize>,
}

/// Values of the parameters of [`WithSlopes`], and room for its arguments and results.
pub(super) struct SlopeBuffers {
    workspace: Workspace,
    inputs: Vec<f64>,
    outputs: Vec<f64>,
}

impl WithSlopes {
    /// Functions with the symbols of all coordinates, or of all velocities, that they are
    /// differentiated by.
    pub(super) fn compile(
        system: &SymbolicSystem,
        pool: &Pool,
        functions: &[(Expr, &[SymbolId])],
        (inputs, parameters): (&[SymbolId], &[SymbolId]),
    ) -> Result<Self, TapeError> {
        let (mut outputs, mut moving, mut first) = (Vec::new(), Vec::new(), Vec::new());
        for &(function, symbols) in functions {
            first.push(outputs.len());
            outputs.push(function);
            let coordinates = system.kinematics.coordinates_in(pool, &[function]);
            let by: Vec<SymbolId> = coordinates.iter().map(|&i| symbols[i]).collect();
            outputs.extend(pool.gradient(function, &by));
            moving.push(coordinates);
        }
        Ok(Self { tape: Tape::compile(pool, &outputs, inputs, parameters)?, moving, first })
    }

    /// Buffers with these values of the parameters.
    pub(super) fn buffers(&self, parameters: &[f64]) -> SlopeBuffers {
        SlopeBuffers {
            workspace: self.tape.workspace(parameters),
            inputs: Vec::new(),
            outputs: vec![0.0; self.tape.n_outputs()],
        }
    }

    /// Adds some of the functions at a state as equations.
    pub(super) fn add_to(
        &self,
        equations: &mut Equations,
        buffers: &mut SlopeBuffers,
        which: impl ExactSizeIterator<Item = usize>,
        state: (f64, &[f64], &[f64]),
    ) {
        self.for_each(buffers, which, state, |k, value, slopes| {
            equations.values.push(value);
            equations.gradients.push(self.moving[k].iter().copied().zip(slopes.iter().copied()));
        });
    }

    /// Adds the numbers of these equations.
    pub(super) fn add_numbers_to(
        &self,
        numbers: &mut Numbers,
        buffers: &mut SlopeBuffers,
        which: impl ExactSizeIterator<Item = usize>,
        state: (f64, &[f64], &[f64]),
    ) {
        self.for_each(buffers, which, state, |_, value, slopes| numbers.add(&[value], slopes));
    }

    /// Shows some of the functions at a state with their slopes.
    fn for_each(
        &self,
        buffers: &mut SlopeBuffers,
        which: impl ExactSizeIterator<Item = usize>,
        state: (f64, &[f64], &[f64]),
        mut show: impl FnMut(usize, f64, &[f64]),
    ) {
        if which.len() == 0 {
            return;
        }
        self.evaluate(buffers, state);
        for k in which {
            let (value, slopes) = self.outcome(buffers, k);
            show(k, value, slopes);
        }
    }

    /// Evaluates all functions at a state.
    fn evaluate(&self, buffers: &mut SlopeBuffers, (t, q, v): (f64, &[f64], &[f64])) {
        let SlopeBuffers { workspace, inputs, outputs } = buffers;
        inputs.clear();
        inputs.push(t);
        inputs.extend_from_slice(q);
        inputs.extend_from_slice(v);
        self.tape.evaluate(workspace, inputs, outputs);
    }

    /// A function with its slopes, as evaluated last.
    fn outcome<'b>(&self, buffers: &'b SlopeBuffers, k: usize) -> (f64, &'b [f64]) {
        let first = self.first[k];
        (buffers.outputs[first], &buffers.outputs[first + 1..][..self.moving[k].len()])
    }
}
