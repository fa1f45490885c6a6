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
//! each state, and contacts are open, as in [`Functions`](crate::functions::Functions).

mod at;

use bksim_expr::{Expr, SymbolId, TapeError};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;

use crate::compiled::{Terms, terms};
use crate::formulate::acceleration_level;
use crate::function::Function;
use crate::input::{input_symbols, without_inputs};
use crate::mechanism::Mechanism;
use crate::quantities::Quantities;
use crate::sensitivity::{Sensitive, parameter_direction};

pub use at::{DerivativesAt, IdleDerivatives};

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
                let found = quantities.named(name).map(|(value, _)| value);
                found.ok_or_else(|| DerivativeError::Unknown(name.clone()))
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
