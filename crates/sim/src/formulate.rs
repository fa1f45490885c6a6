//! [`MotionEquations`]: the equations of motion as 0 = F(t, y, y′), in one of several formulations.
//!
//! ```text
//!            index3            index2              ggl                 index1
//! nq   q̇ − v              q̇ − v               q̇ − v + Gᵀ μ        q̇ − v
//! nq   M v̇ − f + Gᵀ λ     M v̇ − f + Gᵀ λ      M v̇ − f + Gᵀ λ      M v̇ − f + Gᵀ λ
//! nc   g(t, q)            G v + ∂g/∂t         G v + ∂g/∂t         G v̇ + γ
//! nc   —                  —                   g(t, q)             —
//! ```
//!
//! Rows between rates have no g: index 3 has G v + r of them, too, and their μ is zero.
//!
//! Sources: HW2 §VII.1 for index 3 and 2; C. W. Gear, B. Leimkuhler and G. K. Gupta, *Automatic
//! integration of Euler–Lagrange equations with constraints*, J. Comput. Appl. Math. 12 & 13
//! (1985), for the stabilised form. Residual and Jacobian are straight-line code, and the Jacobian
//! is exact: it is differentiated from the residual's own expressions, but for ∂u/∂q and ∂u/∂v of
//! [inputs](crate::input), which are arguments of it.

use crate::input::{input_symbols, without_inputs};
use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};

use bksim_dae::{Index, Layout, NotFinite, Pattern, Start, System, Tolerance};
use bksim_expr::{Composition, Expr, SparseJacobian, SymbolId, TapeError, Value};

use crate::function::{Buffers, Function};
use crate::input::{InputValues, Inputs};
use crate::state::{AccelerationRef, StateRef};
use bksim_mbs::constraint::Source;
use bksim_mbs::levels::{constraint_acceleration, constraint_velocity};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{Formulation, Model};

/// [`MotionEquations`] that are derived when they are used first: only Radau needs them, and their
/// Jacobian is the costliest derivation of all.
pub type LazyMotionEquations =
    LazyLock<Arc<MotionEquations>, Box<dyn FnOnce() -> Arc<MotionEquations> + Send>>;

/// The compiled residual and Jacobian of one formulation.
#[derive(Clone, Debug)]
pub struct MotionEquations {
    formulation: Formulation,
    nq: usize,
    nc: usize,
    layout: Layout,
    pattern: Pattern,
    /// Constraint rows of the lengths of quaternions.
    lengths: Vec<usize>,
    /// The rows q̇ − v (+ Gᵀ μ), which give the velocities.
    velocity_rows: Vec<(usize, usize)>,
    residual: Function,
    jacobian: Function,
    /// Position in the pattern of each output of the Jacobian tape: first ∂F/∂y, then ∂F/∂y′.
    jacobian_slots: Vec<usize>,
    n_y_entries: usize,
    inputs: Inputs,
}

/// [`MotionEquations`] at one set of parameters, as the integrator takes them.
///
/// Inactive constraint rows, which depend on others or belong to open contacts, are replaced by
/// λ = 0 (and μ = 0): this leaves the motion as it is and the iteration matrix regular.
#[derive(Clone, Debug)]
pub struct MotionSystem<'a> {
    equations: &'a MotionEquations,
    residual: Buffers,
    jacobian: Buffers,
    inputs: InputValues,
    /// Unknowns held at zero: multipliers of inactive rows; also the rows of F that hold them there.
    held: Vec<usize>,
}

/// Derives and compiles one formulation.
///
/// # Errors
/// [`TapeError`] names a symbol that is neither time, a parameter nor part of the state.
#[expect(clippy::missing_panics_doc, reason = "every entry lies in a pattern made of all entries")]
pub fn formulate(
    model: &Model,
    system: &SymbolicSystem,
    formulation: Formulation,
) -> Result<MotionEquations, TapeError> {
    let system = system.integrated();
    let (nq, nc) = (system.coordinates().len(), system.constraints.len());
    let unknowns = UnknownSymbols::new(model, system, formulation);
    let rows = unknowns.residual(model, system, formulation);
    let n = rows.len();

    let dy = unknowns.jacobian(model, &rows);
    let dydot = model.pool.jacobian(&rows, &unknowns.ydot);
    let cells = |j: &SparseJacobian| -> Vec<(usize, usize)> {
        j.entries.iter().map(|&(row, col, _)| (row, col)).collect()
    };
    // The diagonal of the multipliers is empty, but held rows need it.
    let diagonal = (2 * nq..n).map(|i| (i, i));
    let all = cells(&dy).into_iter().chain(cells(&dydot)).chain(diagonal);
    let pattern = Pattern::new(n, all).expect("rows and columns are those of the residual");
    let slot = |&(row, col): &(usize, usize)| {
        pattern.position(row, col).expect("the pattern holds every entry")
    };
    let jacobian_slots = cells(&dy).iter().chain(&cells(&dydot)).map(slot).collect();
    // The nonzero entries of both, first ∂F/∂y.
    let entries: Vec<Expr> =
        dy.entries.iter().chain(&dydot.entries).map(|&(_, _, entry)| entry).collect();
    let compiled =
        |outputs: &[Expr], slopes: &[SymbolId]| unknowns.compile(model, system, outputs, slopes);
    let is_length = |row: usize| matches!(system.constraints[row].source, Source::Quaternion(_));
    Ok(MotionEquations {
        formulation,
        nq,
        nc,
        layout: unknowns.layout(model, system, formulation),
        residual: compiled(&rows, &[])?,
        jacobian: compiled(&entries, &unknowns.slopes)?,
        jacobian_slots,
        n_y_entries: dy.entries.len(),
        inputs: Inputs::of(model),
        lengths: (0..nc).filter(|&row| is_length(row)).collect(),
        velocity_rows: (0..nq).map(|i| (i, nq + i)).collect(),
        pattern,
    })
}

/// Compiles ∂F/∂p of one formulation along each direction of the parameters `wrt`: one column of n
/// after the other, of the inputs of the residual.
///
/// # Errors
/// [`TapeError`] as [`formulate`].
pub(crate) fn parameter_columns(
    model: &Model,
    system: &SymbolicSystem,
    formulation: Formulation,
    wrt: &[SymbolId],
    directions: &[Vec<Expr>],
) -> Result<Function, TapeError> {
    let system = system.integrated();
    let unknowns = UnknownSymbols::new(model, system, formulation);
    let rows = unknowns.residual(model, system, formulation);
    let column = |direction: &Vec<Expr>| model.pool.jvp(&rows, wrt, direction);
    let columns: Vec<Expr> = directions.iter().flat_map(column).collect();
    unknowns.compile(model, system, &columns, &[])
}

/// Compiles loads on the rows of F at the level of accelerations after those of q̇ − v: one column of n after the
/// other, of the inputs of the residual.
///
/// # Errors
/// [`TapeError`] as [`formulate`].
pub(crate) fn load_columns(model: &Model, system: &SymbolicSystem) -> Result<Function, TapeError> {
    let unknowns = UnknownSymbols::new(model, system, Formulation::Index1);
    let (nq, n) = (system.coordinates().len(), unknowns.y.len());
    let [zero, one] = [model.pool.zero(), model.pool.one()];
    let column = |load: usize| (0..n).map(move |row| if row == load { one } else { zero });
    let columns: Vec<Expr> = (nq..n).flat_map(column).collect();
    unknowns.compile(model, system, &columns, &[])
}

/// M a + Gᵀ λ − f, then G a + γ.
pub fn acceleration_level(model: &Model, system: &SymbolicSystem) -> Vec<Expr> {
    let unknowns = UnknownSymbols::new(model, system, Formulation::Index1);
    unknowns.residual(model, system, Formulation::Index1).split_off(system.coordinates().len())
}

impl MotionEquations {
    /// Equations with the values of the inputs by the law of `inputs`.
    #[must_use]
    pub(crate) fn with_inputs(mut self, inputs: &Inputs) -> Self {
        self.inputs = inputs.clone();
        self
    }

    /// Number of unknowns: q, v, λ and, for the stabilised form, μ.
    pub fn n(&self) -> usize {
        self.layout.n()
    }

    /// Names of the unknowns.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Binds parameter values, modes included; `dependent` are the constraint rows that follow from
    /// the others, and those of contacts that are open.
    pub fn at(&self, parameters: &[f64], dependent: &[usize]) -> MotionSystem<'_> {
        let held_lambda = dependent.iter().map(|row| 2 * self.nq + row);
        let held_mu = dependent.iter().map(|row| 2 * self.nq + self.nc + row);
        let has_mu = self.formulation == Formulation::Ggl;
        MotionSystem {
            equations: self,
            residual: self.residual.buffers(parameters),
            jacobian: self.jacobian.buffers(parameters),
            inputs: InputValues::new(&self.inputs),
            held: held_lambda.chain(held_mu.filter(|_| has_mu)).collect(),
        }
    }

    /// Absolute tolerances of the unknowns for one in the units of each coordinate.
    ///
    /// The μ of the stabilised form are zero but for rounding, which a weak pose amplifies: a
    /// tolerance near it would make Newton's iteration fail there for nothing.
    ///
    /// So are the λ of the lengths of quaternions, on which nothing depends; without errors of their own they
    /// are as small as rounding leaves them at each step size.
    pub(crate) fn tolerances(&self, atol: f64) -> Tolerance {
        const SMALLEST_OF_MU: f64 = 1e-10;
        const OF_LENGTH: f64 = 1.0;
        let mut tolerances = vec![atol; self.n()];
        tolerances[2 * self.nq + self.nc..].fill(atol.max(SMALLEST_OF_MU));
        for row in &self.lengths {
            tolerances[2 * self.nq + row] = OF_LENGTH;
        }
        Tolerance::PerUnknown(tolerances)
    }

    /// The entries of ∂F/∂y written down, with their rows and columns, as functions of t, y and y′; of a mechanism
    /// without inputs.
    pub(crate) fn record_jacobian(
        &self,
        recorder: &mut Composition,
        arguments: &[Value],
    ) -> Vec<((usize, usize), Value)> {
        let places: Vec<(usize, usize)> = self.pattern.entries().collect();
        let values = recorder.call(self.jacobian.tape(), arguments);
        let slots = self.jacobian_slots[..self.n_y_entries].iter();
        slots.zip(values).map(|(&slot, value)| (places[slot], value)).collect()
    }

    /// A consistent state as the integrator takes it: t, y and y′.
    pub fn unknowns(
        &self,
        StateRef { t, q, v }: StateRef<'_>,
        AccelerationRef { a, lambda }: AccelerationRef<'_>,
    ) -> Start {
        let mut y = [q, v, lambda].concat();
        let mut ydot = [v, a].concat();
        y.resize(self.n(), 0.0);
        ydot.resize(self.n(), 0.0);
        Start { t, y, ydot }
    }
}

impl MotionSystem<'_> {
    /// Rows, and unknowns, that are held at zero.
    pub(crate) fn held(&self) -> &[usize] {
        &self.held
    }
}

impl System for MotionSystem<'_> {
    fn layout(&self) -> &Layout {
        &self.equations.layout
    }

    fn pattern(&self) -> &Pattern {
        &self.equations.pattern
    }

    fn explicit_rows(&self) -> &[(usize, usize)] {
        &self.equations.velocity_rows
    }

    fn residual(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        out: &mut [f64],
    ) -> Result<(), NotFinite> {
        let Self { equations, residual, inputs, .. } = self;
        let (q, v) = y[..2 * equations.nq].split_at(equations.nq);
        let arguments = [&[t], y, ydot, inputs.at(t, q, v)];
        equations.residual.evaluate_into(residual, &arguments, out);
        for &i in &self.held {
            out[i] = y[i];
        }
        // The solver looks whether they are finite.
        Ok(())
    }

    fn jacobian(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        df_dy: &mut [f64],
        df_dydot: &mut [f64],
    ) -> Result<(), NotFinite> {
        let Self { equations, jacobian, inputs, .. } = self;
        let (q, v) = y[..2 * equations.nq].split_at(equations.nq);
        let [u, slopes] = inputs.with_slopes(t, q, v);
        let values = equations.jacobian.evaluate(jacobian, &[&[t], y, ydot, u, slopes]);
        df_dy.fill(0.0);
        df_dydot.fill(0.0);
        let (y_slots, ydot_slots) = equations.jacobian_slots.split_at(equations.n_y_entries);
        let (y_values, ydot_values) = values.split_at(equations.n_y_entries);
        y_slots.iter().zip(y_values).for_each(|(&slot, &value)| df_dy[slot] = value);
        ydot_slots.iter().zip(ydot_values).for_each(|(&slot, &value)| df_dydot[slot] = value);
        if !self.held.is_empty() {
            for (slot, (row, col)) in equations.pattern.entries().enumerate() {
                if self.held.contains(&row) {
                    df_dy[slot] = f64::from(u8::from(row == col));
                    df_dydot[slot] = 0.0;
                }
            }
        }
        let entries = equations.pattern.entries().zip(df_dy.iter().zip(df_dydot.iter()));
        first_not_finite(entries.map(|((row, _), (dy, dydot))| (row, dy + dydot)))
    }
}

fn first_not_finite(values: impl Iterator<Item = (usize, f64)>) -> Result<(), NotFinite> {
    let mut values = values;
    match values.find(|(_, value)| !value.is_finite()) {
        Some((row, _)) => Err(NotFinite { row }),
        None => Ok(()),
    }
}

/// Symbols of y and y′: q, v, λ(, μ) and their derivatives.
struct UnknownSymbols {
    y: Vec<SymbolId>,
    ydot: Vec<SymbolId>,
    mu: Vec<Expr>,
    /// ∂u/∂q and ∂u/∂v, a row for each input.
    slopes: Vec<SymbolId>,
}

impl UnknownSymbols {
    fn new(model: &Model, system: &SymbolicSystem, formulation: Formulation) -> Self {
        let pool = &model.pool;
        // Not identifiers, so that no name of the model can meet them.
        let fresh = |name: String| pool.symbol(&name);
        let id = |e: Expr| pool.symbol_id(e).expect("a symbol was just made");
        let coordinates = system.coordinates();
        let lambda = system.constraints.iter().map(|c| c.lambda);
        let n_mu = if formulation == Formulation::Ggl { system.constraints.len() } else { 0 };
        let mu: Vec<Expr> = (0..n_mu).map(|row| fresh(format!("'mu{row}"))).collect();
        let qdot = coordinates.iter().map(|c| id(fresh(format!("'{}'", c.name))));
        let y: Vec<SymbolId> = coordinates
            .iter()
            .map(|c| c.q)
            .chain(coordinates.iter().map(|c| c.v))
            .chain(lambda)
            .chain(mu.iter().map(|&m| id(m)))
            .collect();
        let mut ydot: Vec<SymbolId> = qdot.chain(coordinates.iter().map(|c| c.a)).collect();
        let rest = ydot.len()..y.len();
        ydot.extend(rest.map(|i| id(fresh(format!("'rate{i}")))));
        let n_slopes = model.inputs.len() * 2 * coordinates.len();
        let slopes = (0..n_slopes).map(|k| id(fresh(format!("'slope{k}")))).collect();
        Self { y, ydot, mu, slopes }
    }

    /// Compiles functions of t, y, y′, the inputs, their `slopes` and the parameters.
    fn compile(
        &self,
        model: &Model,
        system: &SymbolicSystem,
        outputs: &[Expr],
        slopes: &[SymbolId],
    ) -> Result<Function, TapeError> {
        let u = input_symbols(model);
        let arguments = [&[model.time], &self.y[..], &self.ydot[..], &u, slopes];
        let parameters = without_inputs(model, system.parameters(model));
        Function::compile(model, outputs, &arguments, &parameters)
    }

    /// ∂F/∂y, what it has through the inputs included: Σ ∂F/∂u_k · ∂u_k/∂y.
    fn jacobian(&self, model: &Model, rows: &[Expr]) -> SparseJacobian {
        let pool = &model.pool;
        let mut jacobian = pool.jacobian(rows, &self.y);
        if model.inputs.is_empty() {
            return jacobian;
        }
        let mut sums: BTreeMap<(usize, usize), Vec<Expr>> = BTreeMap::new();
        for (row, column, entry) in jacobian.entries {
            sums.entry((row, column)).or_default().push(entry);
        }
        let by_inputs = pool.jacobian(rows, &input_symbols(model));
        let n_state = self.slopes.len() / by_inputs.n_columns;
        for (row, input, entry) in by_inputs.entries {
            for (column, &slope) in self.slopes[input * n_state..][..n_state].iter().enumerate() {
                let part = pool.mul(entry, pool.symbol_expr(slope));
                sums.entry((row, column)).or_default().push(part);
            }
        }
        let entries = sums.into_iter().map(|((row, column), sum)| (row, column, pool.sum(sum)));
        jacobian.entries = entries.collect();
        jacobian
    }

    fn residual(
        &self,
        model: &Model,
        system: &SymbolicSystem,
        formulation: Formulation,
    ) -> Vec<Expr> {
        let pool = &model.pool;
        let coordinates = system.coordinates();
        let (nq, nc) = (coordinates.len(), system.constraints.len());
        let columns = system.constraint_jacobian.transposed();
        // Row i of Gᵀ times some factors, of which there may be none.
        let is_of_rates = |row: &usize| system.constraints[*row].is_of_rates();
        let transposed = |i: usize, factors: &[Expr]| -> Vec<Expr> {
            let entries = columns.row(i).iter();
            entries.filter_map(|&(row, g)| Some(pool.mul(g, *factors.get(row)?))).collect()
        };
        let positional: Vec<Expr> = (self.mu.iter().enumerate())
            .map(|(row, &mu)| if is_of_rates(&row) { pool.zero() } else { mu })
            .collect();
        let kinematic = |i: usize| {
            let qdot = pool.symbol_expr(self.ydot[i]);
            let v = pool.symbol_expr(coordinates[i].v);
            pool.sum([vec![qdot, pool.neg(v)], transposed(i, &positional)].concat())
        };
        let lambda: Vec<Expr> =
            system.constraints.iter().map(|c| pool.symbol_expr(c.lambda)).collect();
        let needed = system.inverse_dynamics(pool);
        let dynamic = |i: usize| {
            let mut terms = vec![needed[i], pool.neg(system.applied_force[i])];
            terms.extend(transposed(i, &lambda));
            pool.sum(terms)
        };
        let mut rows: Vec<Expr> = (0..nq).map(kinematic).collect();
        rows.extend((0..nq).map(dynamic));
        let velocity = |row: usize| constraint_velocity(pool, system, row);
        let velocities = || (0..nc).map(velocity);
        let position = |row: usize| system.constraints[row].expression;
        match formulation {
            Formulation::Index3 => {
                let row = |row| if is_of_rates(&row) { velocity(row) } else { position(row) };
                rows.extend((0..nc).map(row));
            }
            Formulation::Index2 => rows.extend(velocities()),
            Formulation::Ggl => {
                let row = |row| if is_of_rates(&row) { self.mu[row] } else { position(row) };
                rows.extend(velocities().chain((0..nc).map(row)));
            }
            Formulation::Index1 => {
                rows.extend((0..nc).map(|row| constraint_acceleration(model, system, row)));
            }
        }
        rows
    }

    fn layout(&self, model: &Model, system: &SymbolicSystem, formulation: Formulation) -> Layout {
        let (nq, nc) = (system.coordinates().len(), system.constraints.len());
        let groups = match formulation {
            Formulation::Index3 => {
                vec![(nq, Index::One), (nq, Index::Two), (nc, Index::Three)]
            }
            Formulation::Index2 => vec![(2 * nq, Index::One), (nc, Index::Two)],
            Formulation::Ggl => vec![(2 * nq, Index::One), (2 * nc, Index::Two)],
            Formulation::Index1 => vec![(2 * nq + nc, Index::One)],
        };
        // The μ of a constraint is named like its λ: messages name multipliers that the author knows.
        let n_named = self.y.len() - self.mu.len();
        let known = self.y[..n_named].iter().chain(&self.y[n_named - self.mu.len()..n_named]);
        let names = known.map(|&symbol| model.pool.symbol_name(symbol)).collect();
        Layout::from_groups(&groups).with_names(names)
    }
}
