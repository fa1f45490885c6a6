//! [`Scalars`]: functions of the position with their slopes along a curve, and their rates in time.

use bksim_expr::{Expr, SymbolId, Tape, TapeError, Workspace};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;

/// Functions of the position with their slopes.
#[derive(Clone, Debug)]
pub(crate) struct Scalars {
    tape: Tape,
    space: Workspace,
    outputs: Vec<f64>,
    /// Function and coordinate of each slope.
    slopes: Vec<(usize, usize)>,
    n: usize,
}

impl Scalars {
    pub(crate) fn compile(
        model: &Model,
        system: &SymbolicSystem,
        functions: &[Expr],
        parameters: &[f64],
    ) -> Result<Self, TapeError> {
        let pool = &model.pool;
        let q: Vec<SymbolId> = system.coordinates().iter().map(|c| c.q).collect();
        let jacobian = pool.jacobian(functions, &q);
        let slopes = jacobian.entries.iter().map(|&(row, column, _)| (row, column)).collect();
        let entries = jacobian.entries.iter().map(|&(.., slope)| slope);
        let outputs: Vec<Expr> = functions.iter().copied().chain(entries).collect();
        let symbols = system.parameters(model);
        let tape = Tape::compile(pool, &outputs, &[&[model.time][..], &q].concat(), &symbols)?;
        Ok(Self {
            space: tape.workspace(parameters),
            outputs: vec![0.0; tape.n_outputs()],
            tape,
            slopes,
            n: functions.len(),
        })
    }

    /// Gives the parameters other values.
    pub(crate) fn set_parameters(&mut self, parameters: &[f64]) {
        self.space = self.tape.workspace(parameters);
    }

    fn evaluate(&mut self, t: f64, q: &[f64]) {
        let inputs: Vec<f64> = std::iter::once(t).chain(q.iter().copied()).collect();
        self.tape.evaluate(&mut self.space, &inputs, &mut self.outputs);
    }

    /// Their values.
    pub(crate) fn values(&mut self, t: f64, q: &[f64]) -> Vec<f64> {
        self.evaluate(t, q);
        self.outputs[..self.n].to_vec()
    }

    /// Their slopes along a direction of the coordinates.
    pub(crate) fn along(&mut self, t: f64, q: &[f64], direction: &[f64]) -> Vec<f64> {
        self.evaluate(t, q);
        let mut along = vec![0.0; self.n];
        for (&(row, column), slope) in self.slopes.iter().zip(&self.outputs[self.n..]) {
            along[row] += slope * direction[column];
        }
        along
    }

    /// Their slopes by all coordinates, a row of `nq` for each.
    pub(crate) fn gradients(&mut self, t: f64, q: &[f64]) -> Vec<Vec<f64>> {
        self.evaluate(t, q);
        let mut rows = vec![vec![0.0; q.len()]; self.n];
        for (&(row, column), slope) in self.slopes.iter().zip(&self.outputs[self.n..]) {
            rows[row][column] = *slope;
        }
        rows
    }
}

/// Functions of the position with their first and second derivatives by time, and the third where it is asked for.
#[derive(Clone, Debug)]
pub(crate) struct Rates {
    tape: Tape,
    space: Workspace,
    n: usize,
}

impl Rates {
    pub(crate) fn compile(
        model: &Model,
        system: &SymbolicSystem,
        functions: &[Expr],
        parameters: &[f64],
    ) -> Result<Self, TapeError> {
        Self::of_order(model, system, functions, (parameters, 2))
    }

    /// Functions with derivatives up to this order, 2 or 3.
    pub(crate) fn of_order(
        model: &Model,
        system: &SymbolicSystem,
        functions: &[Expr],
        (parameters, order): (&[f64], usize),
    ) -> Result<Self, TapeError> {
        let pool = &model.pool;
        let of = |f: fn(&bksim_mbs::coordinate::Coordinate) -> SymbolId| -> Vec<SymbolId> {
            system.coordinates().iter().map(f).collect()
        };
        let (q, v, a) = (of(|c| c.q), of(|c| c.v), of(|c| c.a));
        let time_rate = [(model.time, pool.one())];
        let pairs = |of: &[SymbolId], rates: &[SymbolId]| -> Vec<(SymbolId, Expr)> {
            of.iter().zip(rates).map(|(&x, &rate)| (x, pool.symbol_expr(rate))).collect()
        };
        let first = [pairs(&q, &v), time_rate.to_vec()].concat();
        let second = [first.clone(), pairs(&v, &a)].concat();
        let rates = pool.total_derivatives(functions, &first);
        let accelerations = pool.total_derivatives(&rates, &second);
        let mut outputs = [functions, &rates, &accelerations].concat();
        let symbols = system.parameters(model);
        let mut inputs = [vec![model.time], q, v, a.clone()].concat();
        if order > 2 {
            // No identifiers, so that no name of the model can meet them.
            let jerk = |k: usize| pool.symbol_id(pool.symbol(&format!("'jerk{k}")));
            let jerks: Vec<SymbolId> = (0..a.len()).filter_map(jerk).collect();
            let third = [second, pairs(&a, &jerks)].concat();
            outputs.extend(pool.total_derivatives(&accelerations, &third));
            inputs.extend(jerks);
        }
        let tape = Tape::compile(pool, &outputs, &inputs, &symbols)?;
        Ok(Self { space: tape.workspace(parameters), tape, n: functions.len() })
    }

    /// Value, rate, acceleration and third rate of each function.
    pub(crate) fn with_jerk(&mut self, t: f64, [q, v, a, j]: [&[f64]; 4]) -> Vec<[f64; 4]> {
        let mut outputs = vec![0.0; self.tape.n_outputs()];
        self.tape.evaluate(&mut self.space, &[&[t], q, v, a, j].concat(), &mut outputs);
        let n = self.n;
        (0..n).map(|k| std::array::from_fn(|order| outputs[k + order * n])).collect()
    }

    /// Value, rate and acceleration of each function, one after the other.
    pub(crate) fn at(&mut self, t: f64, [q, v, a]: [&[f64]; 3]) -> Vec<[f64; 3]> {
        let inputs = [&[t], q, v, a].concat();
        let mut outputs = vec![0.0; self.tape.n_outputs()];
        self.tape.evaluate(&mut self.space, &inputs, &mut outputs);
        (0..self.n).map(|k| [outputs[k], outputs[k + self.n], outputs[k + 2 * self.n]]).collect()
    }
}
