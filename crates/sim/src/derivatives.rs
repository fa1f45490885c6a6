//! Quantities of the motion and the functions of its equations, with their exact derivatives by the state and by
//! parameters.
//!
//! ```text
//! y = h(t, q, v, z, p)        z = (a, λ)
//! 0 = F(t, q, v, z, p)        M a + Gᵀ λ − f and G a + γ
//! dy = h_x dx + h_z dz        F_z dz = −F_x dx,        x any of t, q, v and p
//! ```
//!
//! All of h_x, h_z, F_x and F_z are derived from the expressions and compiled. What switches is on the branch of
//! each state, and contacts are open, as in [`Functions`].

use bksim_expr::{Expr, SymbolId, TapeError};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;
use nalgebra::DMatrix;

use crate::compiled::{Terms, terms};
use crate::formulate::acceleration_level;
use crate::function::{Buffers, Function};
use crate::functions::Functions;
use crate::input::{input_symbols, without_inputs};
use crate::mechanism::Mechanism;
use crate::modes::Modes;
use crate::quantities::Quantities;
use crate::sensitivity::{Sensitive, parameter_direction};
use crate::state::{AccelerationRef, StateRef};

/// The function h that is evaluated and differentiated.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Subject {
    /// M, nq × nq, row by row.
    MassMatrix,
    /// f, nq.
    Forces,
    /// G, nc × nq, row by row.
    ConstraintJacobian,
    /// g, nc.
    Constraints,
    /// v̇, nq, which keeps the constraints.
    Accelerations,
    /// λ, nc.
    Multipliers,
    /// M a + Gᵀ λ − f and g, nq + nc, at a and λ that are given.
    Residual,
    /// Quantities by name: channels of a run, measures, reactions.
    Quantities(Vec<String>),
}

/// A variable that it is differentiated by.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum By {
    /// Time, one column.
    Time,
    /// Coordinates, nq columns.
    Positions,
    /// Their rates, nq columns.
    Velocities,
    /// Accelerations, nq columns, of [`Subject::Residual`].
    Accelerations,
    /// Multipliers, nc columns, of [`Subject::Residual`].
    Multipliers,
    /// A parameter of the model, by its index; those defined through it follow.
    Parameter(usize),
}

/// Why there are no derivatives.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DerivativeError {
    /// Nothing has this name, or no formula of the state.
    #[error("nothing is called `{0}` that follows from the state")]
    Unknown(String),
    /// Multipliers are not unique.
    #[error(
        "multipliers, and reactions made of them, are shared by joints that repeat each other: they have no \
         derivatives"
    )]
    Shared,
    /// Accelerations and multipliers follow from the state.
    #[error("only the residual is differentiated by accelerations and multipliers")]
    NotGiven,
    /// An expression cannot be compiled.
    #[error(transparent)]
    Tape(#[from] TapeError),
}

/// A function with its derivatives, compiled.
#[derive(Clone, Debug)]
pub struct Derivatives {
    /// Outputs: h; then the entries of the blocks.
    function: Function,
    n_rows: usize,
    /// Columns of x, by variable.
    n_columns: usize,
    /// h_x, h_z, F_x and F_z; the last three only where z follows from the state and h depends on it.
    blocks: [Vec<(usize, usize)>; 4],
    /// The part that a and λ have in h.
    needs: Needs,
    /// Rows of F, and columns of z, that others do not repeat.
    kept: Vec<usize>,
}

/// The part that a and λ have.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Needs {
    Nothing,
    Given,
    Solved,
}

/// The symbols of the state.
struct Symbols {
    t: SymbolId,
    q: Vec<SymbolId>,
    v: Vec<SymbolId>,
    a: Vec<SymbolId>,
    lambda: Vec<SymbolId>,
}

impl Symbols {
    fn new(model: &Model, system: &SymbolicSystem) -> Self {
        let coordinates = system.coordinates();
        Self {
            t: model.time,
            q: coordinates.iter().map(|c| c.q).collect(),
            v: coordinates.iter().map(|c| c.v).collect(),
            a: coordinates.iter().map(|c| c.a).collect(),
            lambda: system.constraints.iter().map(|c| c.lambda).collect(),
        }
    }

    fn z(&self) -> Vec<SymbolId> {
        [self.a.as_slice(), &self.lambda].concat()
    }
}

impl Derivatives {
    /// Derives and compiles `subject` and its derivatives; the constraint rows `dependent` follow from the others.
    ///
    /// # Errors
    /// [`DerivativeError`].
    pub fn compile(
        mechanism: &Mechanism,
        subject: &Subject,
        by: &[By],
        dependent: &[usize],
    ) -> Result<Self, DerivativeError> {
        let Mechanism { model, system: written, .. } = mechanism;
        let system = written.integrated();
        let symbols = Symbols::new(model, system);
        let rows = rows(model, written, &symbols, subject)?;

        // Whether a and λ have a part in it, and where they come from.
        let pool = &model.pool;
        let has = |all: &[SymbolId]| {
            rows.iter().any(|&row| pool.symbols_of(row).iter().any(|id| all.contains(id)))
        };
        let is_residual = *subject == Subject::Residual;
        let needs = match has(&symbols.z()) {
            false => Needs::Nothing,
            true if is_residual => Needs::Given,
            true => Needs::Solved,
        };
        let of_given = |by: &By| matches!(by, By::Accelerations | By::Multipliers);
        if !is_residual && by.iter().any(of_given) {
            return Err(DerivativeError::NotGiven);
        }
        if needs == Needs::Solved && !dependent.is_empty() && !by.is_empty() && has(&symbols.lambda)
        {
            return Err(DerivativeError::Shared);
        }

        // h_x, and where z follows from the state, what dz follows from.
        let (h_x, n_columns) = block(model, &rows, &symbols, by);
        let mut blocks = vec![h_x];
        if needs == Needs::Solved && !by.is_empty() {
            let z = symbols.z();
            let equations = acceleration_level(model, system);
            blocks.push(pool.jacobian(&rows, &z).entries);
            blocks.push(block(model, &equations, &symbols, by).0);
            blocks.push(pool.jacobian(&equations, &z).entries);
        }
        blocks.resize_with(4, Vec::new);

        let entries = blocks.iter().flatten().map(|&(.., entry)| entry);
        let outputs: Vec<Expr> = rows.iter().copied().chain(entries).collect();
        let Symbols { t, q, v, a, lambda } = &symbols;
        let u = input_symbols(model);
        let arguments: [&[SymbolId]; 6] = [std::slice::from_ref(t), q, v, a, lambda, &u];
        let parameters = without_inputs(model, written.parameters(model));
        let n_z = a.len() + lambda.len();
        let is_kept = |k: &usize| !dependent.iter().any(|row| a.len() + row == *k);
        let mut cells = blocks
            .into_iter()
            .map(|block| block.into_iter().map(|(row, column, _)| (row, column)).collect());
        Ok(Self {
            function: Function::compile(model, &outputs, &arguments, &parameters)?,
            n_rows: rows.len(),
            n_columns,
            blocks: std::array::from_fn(|_| cells.next().unwrap_or_default()),
            needs,
            kept: (0..n_z).filter(is_kept).collect(),
        })
    }

    /// Values of h.
    pub fn n_rows(&self) -> usize {
        self.n_rows
    }

    /// Columns of the derivatives: all variables, one after the other.
    pub fn n_columns(&self) -> usize {
        self.n_columns
    }

    /// These derivatives at the parameters of `functions`, with buffers.
    pub fn with<'a>(&'a self, functions: Functions<'a>) -> DerivativesAt<'a> {
        let (nq, nc) = (functions.compiled().nq(), functions.compiled().nc());
        DerivativesAt {
            derivatives: self,
            buffers: self.function.buffers(&functions.parameters_with_modes()),
            modes: functions.modes().clone(),
            results: vec![0.0; self.function.n_outputs()],
            a: vec![0.0; nq],
            lambda: vec![0.0; nc],
            functions,
        }
    }
}

/// The rows of h as expressions.
fn rows(
    model: &Model,
    written: &SymbolicSystem,
    symbols: &Symbols,
    subject: &Subject,
) -> Result<Vec<Expr>, DerivativeError> {
    let pool = &model.pool;
    let system = written.integrated();
    let (nq, nc) = (symbols.q.len(), symbols.lambda.len());
    let all = |ids: &[SymbolId]| ids.iter().map(|&id| pool.symbol_expr(id)).collect();
    let closed = || system.constraints.iter().map(|c| c.expression);
    let dense = |n: usize| vec![pool.zero(); n];
    Ok(match subject {
        Subject::MassMatrix => {
            let mut rows = dense(nq * nq);
            for (i, j, entry) in system.mass_matrix.lower() {
                (rows[i * nq + j], rows[j * nq + i]) = (entry, entry);
            }
            rows
        }
        Subject::ConstraintJacobian => {
            let mut rows = dense(nc * nq);
            for (row, i, entry) in system.constraint_jacobian.entries() {
                rows[row * nq + i] = entry;
            }
            rows
        }
        Subject::Forces => {
            let Terms { force, .. } = terms(model, system);
            force
        }
        Subject::Constraints => closed().collect(),
        Subject::Accelerations => all(&symbols.a),
        Subject::Multipliers => all(&symbols.lambda),
        Subject::Residual => {
            let mut rows = acceleration_level(model, system);
            rows.truncate(nq);
            rows.extend(closed());
            rows
        }
        Subject::Quantities(names) => {
            let quantities = Quantities::new(model, written);
            let named = |name: &String| {
                quantities.named(name).ok_or_else(|| DerivativeError::Unknown(name.clone()))
            };
            names.iter().map(named).collect::<Result<_, _>>()?
        }
    })
}

/// The entries of ∂rows/∂x that are not zero, and the number of columns of x.
fn block(
    model: &Model,
    rows: &[Expr],
    symbols: &Symbols,
    by: &[By],
) -> (Vec<(usize, usize, Expr)>, usize) {
    let pool = &model.pool;
    let mut entries = Vec::new();
    let mut first = 0;
    let own: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
    for &variable in by {
        let columns: &[SymbolId] = match variable {
            By::Time => std::slice::from_ref(&symbols.t),
            By::Positions => &symbols.q,
            By::Velocities => &symbols.v,
            By::Accelerations => &symbols.a,
            By::Multipliers => &symbols.lambda,
            By::Parameter(k) => {
                let direction = parameter_direction(model, Sensitive::Parameter(k));
                let along = pool.jvp(rows, &own, &direction).into_iter().enumerate();
                let along = along.filter(|&(_, entry)| !pool.is_zero(entry));
                entries.extend(along.map(|(row, entry)| (row, first, entry)));
                first += 1;
                continue;
            }
        };
        let found = pool.jacobian(rows, columns).entries.into_iter();
        entries.extend(found.map(|(row, column, entry)| (row, first + column, entry)));
        first += columns.len();
    }
    (entries, first)
}

/// [`Derivatives`] at one set of parameters, with their buffers.
#[derive(Clone, Debug)]
pub struct DerivativesAt<'a> {
    derivatives: &'a Derivatives,
    functions: Functions<'a>,
    buffers: Buffers,
    /// Modes that the buffers are for.
    modes: Modes,
    results: Vec<f64>,
    a: Vec<f64>,
    lambda: Vec<f64>,
}

impl DerivativesAt<'_> {
    /// Writes h and its derivatives, row by row, at a state; `given` are the accelerations and multipliers of a
    /// residual. Where there is no value, all are NaN.
    ///
    /// # Panics
    /// If a length is not that of the mechanism or of the derivatives.
    pub fn at(
        &mut self,
        state: StateRef<'_>,
        given: Option<AccelerationRef<'_>>,
        values: &mut [f64],
        derivatives: &mut [f64],
    ) {
        let StateRef { t, q, v } = state;
        // Accelerations and multipliers, on the branches of the state.
        let solved = match (self.derivatives.needs, given) {
            (Needs::Solved, _) => {
                self.functions.accelerations_into(state, &mut self.a, &mut self.lambda).is_ok()
            }
            (_, Some(AccelerationRef { a, lambda })) => {
                self.a.copy_from_slice(a);
                self.lambda.copy_from_slice(lambda);
                self.functions.follow(t, q, v);
                true
            }
            (needs, None) => {
                self.functions.follow(t, q, v);
                needs == Needs::Nothing
            }
        };
        if !solved {
            values.fill(f64::NAN);
            derivatives.fill(f64::NAN);
            return;
        }
        let function = &self.derivatives.function;
        if self.modes != *self.functions.modes() {
            self.buffers = function.buffers(&self.functions.parameters_with_modes());
            self.modes.clone_from(self.functions.modes());
        }
        let u = self.functions.inputs(t, q, v);
        let arguments = [&[t], q, v, self.a.as_slice(), &self.lambda, u];
        function.evaluate_into(&mut self.buffers, &arguments, &mut self.results);

        // h and h_x as they are; h_z dz added.
        let (found, entries) = self.results.split_at(self.derivatives.n_rows);
        values.copy_from_slice(found);
        derivatives.fill(0.0);
        let n = self.derivatives.n_columns;
        let [h_x, h_z, ..] = &self.derivatives.blocks;
        let (direct, implicit) = entries.split_at(h_x.len());
        for (&(row, column), entry) in h_x.iter().zip(direct) {
            derivatives[row * n + column] += entry;
        }
        if h_z.is_empty() || n == 0 {
            return;
        }
        let Some(dz) = self.derivatives.dz(&implicit[h_z.len()..]) else {
            derivatives.fill(f64::NAN);
            return;
        };
        for (&(row, k), entry) in h_z.iter().zip(implicit) {
            let out = &mut derivatives[row * n..][..n];
            out.iter_mut().enumerate().for_each(|(column, out)| *out += entry * dz[(k, column)]);
        }
    }
}

impl Derivatives {
    /// dz/dx, all of z by all columns, from the entries of F_x and F_z; none in a singular pose.
    fn dz(&self, entries: &[f64]) -> Option<DMatrix<f64>> {
        let [_, _, f_x, f_z] = &self.blocks;
        let n_z = self.kept.last().map_or(0, |last| last + 1);
        let mut position = vec![usize::MAX; n_z];
        self.kept.iter().enumerate().for_each(|(k, &of)| position[of] = k);
        let place = |of: usize| position.get(of).copied().filter(|&k| k != usize::MAX);
        let n = self.kept.len();
        let mut right = DMatrix::zeros(n, self.n_columns);
        let mut matrix = DMatrix::zeros(n, n);
        let (of_x, of_z) = entries.split_at(f_x.len());
        for (&(row, column), entry) in f_x.iter().zip(of_x) {
            if let Some(row) = place(row) {
                right[(row, column)] = -entry;
            }
        }
        for (&(row, column), entry) in f_z.iter().zip(of_z) {
            if let Some((row, column)) = place(row).zip(place(column)) {
                matrix[(row, column)] = *entry;
            }
        }
        let solved = matrix.lu().solve(&right)?;
        // Multipliers that others stand for do not change.
        let n_all = n_z.max(f_z.iter().map(|&(_, column)| column + 1).max().unwrap_or(0));
        let of = |k: usize, column: usize| place(k).map_or(0.0, |row| solved[(row, column)]);
        Some(DMatrix::from_fn(n_all, self.n_columns, of))
    }
}
