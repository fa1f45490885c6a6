//! The derivatives of the equations along changes of the state and of the parameters, compiled.
//!
//! A change of one parameter is a direction in the space of all: those that are defined through it
//! follow. Directions of the state are inputs of the tapes, so each tape serves every quantity.

use bksim_expr::{Expr, SymbolId, TapeError};

use crate::function::Function;

use super::{Sensitive, SensitivityError};
use crate::compiled::CompiledSystem;
use crate::formulate::{acceleration_level, parameter_columns};
use bksim_mbs::levels::constraint_velocity;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{Formulation, Model};

/// The derivatives that sensitivities need, compiled.
#[derive(Clone, Debug)]
pub struct SensitivityEquations {
    pub(super) sensitive: Vec<Sensitive>,
    /// F_p of (t, y, y′), one column after the other.
    pub(super) columns: Function,
    /// Changes of g, G v + ∂g/∂t, M a + Gᵀ λ − f and G a + γ, of (t, q, v, a, λ) and ∂(q, v, P).
    pub(super) levels: Function,
    /// Changes of the entries of G, of (t, q) and ∂(q, P).
    pub(super) jacobian: Function,
    /// Row and coordinate of each of these entries.
    pub(super) cells: Vec<(usize, usize)>,
    /// By initial value: see [`super::start`].
    pub(super) closing: Function,
    /// ∂P/∂p: all parameters of the model, one direction after the other.
    pub(super) directions: Vec<f64>,
    pub(super) n_parameters: usize,
}

/// Derives and compiles the derivatives of the motion by `sensitive`, at these parameter values.
///
/// # Errors
/// [`SensitivityError`] when something in the model switches or is sampled, or cannot be compiled.
pub fn differentiate(
    model: &Model,
    system: &SymbolicSystem,
    compiled: &CompiledSystem,
    formulation: Formulation,
    sensitive: &[Sensitive],
    parameters: &[f64],
) -> Result<SensitivityEquations, SensitivityError> {
    if !compiled.indicators.is_empty() {
        return Err(SensitivityError::Switches);
    }
    if !compiled.sampled.is_empty() {
        return Err(SensitivityError::Sampled);
    }
    if !model.inputs.is_empty() {
        return Err(SensitivityError::Inputs);
    }
    let derivation = Direction::new(model, system);
    let directions: Vec<Vec<Expr>> =
        sensitive.iter().map(|&by| parameter_direction(model, by)).collect();
    let evaluated = |values: &[Expr]| -> Result<Vec<f64>, TapeError> {
        let function = Function::compile(model, values, &[], &derivation.own)?;
        Ok(function.evaluate(&mut function.buffers(parameters), &[]).to_vec())
    };
    let (jacobian, cells) = derivation.jacobian()?;
    Ok(SensitivityEquations {
        sensitive: sensitive.to_vec(),
        columns: parameter_columns(model, system, formulation, &derivation.own, &directions)?,
        levels: derivation.levels()?,
        jacobian,
        cells,
        closing: derivation.closing()?,
        directions: evaluated(&directions.concat())?,
        n_parameters: model.parameters.len(),
    })
}

impl SensitivityEquations {
    /// Quantities that the motion is differentiated by.
    pub fn sensitive(&self) -> &[Sensitive] {
        &self.sensitive
    }

    /// ∂P/∂p_k of all parameters P of the model.
    pub(super) fn direction(&self, k: usize) -> &[f64] {
        &self.directions[k * self.n_parameters..(k + 1) * self.n_parameters]
    }
}

/// ∂P/∂p: one for the parameter itself, and what follows for those defined through it.
pub(crate) fn parameter_direction(model: &Model, by: Sensitive) -> Vec<Expr> {
    let pool = &model.pool;
    let mut rates: Vec<(SymbolId, Expr)> = Vec::with_capacity(model.parameters.len());
    for (k, parameter) in model.parameters.iter().enumerate() {
        let is_it = by == Sensitive::Parameter(k);
        // Definitions use parameters that come before them.
        let rate =
            if is_it { pool.one() } else { pool.total_derivative(parameter.definition, &rates) };
        rates.push((parameter.symbol, rate));
    }
    rates.into_iter().map(|(_, rate)| rate).collect()
}

/// Symbols of the state, and of a direction in which it and the parameters change.
struct Direction<'a> {
    model: &'a Model,
    system: &'a SymbolicSystem,
    own: Vec<SymbolId>,
    q: Vec<SymbolId>,
    v: Vec<SymbolId>,
    dq: Vec<SymbolId>,
    dv: Vec<SymbolId>,
    dp: Vec<SymbolId>,
}

impl<'a> Direction<'a> {
    fn new(model: &'a Model, system: &'a SymbolicSystem) -> Self {
        let pool = &model.pool;
        // Not identifiers, so that no name of the model can meet them.
        let fresh = |kind: &str, n: usize| -> Vec<SymbolId> {
            let symbol = |k: usize| pool.symbol(&format!("'{kind}{k}"));
            let id = |e: Expr| pool.symbol_id(e).expect("a symbol was just made");
            (0..n).map(|k| id(symbol(k))).collect()
        };
        let coordinates = system.coordinates();
        let (nq, np) = (coordinates.len(), model.parameters.len());
        Self {
            model,
            system,
            own: model.parameters.iter().map(|p| p.symbol).collect(),
            q: coordinates.iter().map(|c| c.q).collect(),
            v: coordinates.iter().map(|c| c.v).collect(),
            dq: fresh("change of q", nq),
            dv: fresh("change of v", nq),
            dp: fresh("change of p", np),
        }
    }

    /// Derivatives along the direction of q, v and the parameters.
    fn along(&self, outputs: &[Expr]) -> Vec<Expr> {
        let pool = &self.model.pool;
        let wrt = [self.q.as_slice(), &self.v, &self.own].concat();
        let direction = self.dq.iter().chain(&self.dv).chain(&self.dp);
        let direction: Vec<Expr> = direction.map(|&symbol| pool.symbol_expr(symbol)).collect();
        pool.jvp(outputs, &wrt, &direction)
    }

    /// Compiles functions of time and some groups of symbols.
    fn compile(&self, outputs: &[Expr], arguments: &[&[SymbolId]]) -> Result<Function, TapeError> {
        let time = [self.model.time];
        let arguments = [&[&time[..]], arguments].concat();
        Function::compile(self.model, outputs, &arguments, &self.system.parameters(self.model))
    }

    fn levels(&self) -> Result<Function, TapeError> {
        let Self { model, system, q, v, dq, dv, dp, .. } = self;
        let a: Vec<SymbolId> = system.coordinates().iter().map(|c| c.a).collect();
        let lambda: Vec<SymbolId> = system.constraints.iter().map(|c| c.lambda).collect();
        let mut rows: Vec<Expr> = system.constraints.iter().map(|c| c.expression).collect();
        rows.extend((0..rows.len()).map(|row| constraint_velocity(&model.pool, system, row)));
        rows.extend(acceleration_level(model, system));
        self.compile(&self.along(&rows), &[q, v, &a, &lambda, dq, dv, dp])
    }

    /// Changes of the entries of G, and the row and column of each.
    fn jacobian(&self) -> Result<(Function, Vec<(usize, usize)>), TapeError> {
        let rows: Vec<Expr> = self.system.constraints.iter().map(|c| c.expression).collect();
        let entries = self.model.pool.jacobian(&rows, &self.q).entries;
        let (cells, entries): (Vec<(usize, usize)>, Vec<Expr>) =
            entries.into_iter().map(|(row, i, entry)| ((row, i), entry)).unzip();
        let changes = self.compile(&self.along(&entries), &[&self.q, &self.dq, &self.dp])?;
        Ok((changes, cells))
    }

    /// By initial value: measure m, stated value, their changes, gradient of m by q (positions) or
    /// v (velocities), its change.
    fn closing(&self) -> Result<Function, TapeError> {
        let Self { model, system, q, v, dq, dv, dp, .. } = self;
        let mut outputs = Vec::new();
        for initial in &model.initial {
            let measure = system.kinematics.measure(model, initial.measure);
            let by = if initial.measure.is_velocity() { v } else { q };
            let gradient = model.pool.gradient(measure, by);
            outputs.extend([measure, initial.value]);
            outputs.extend(self.along(&[measure, initial.value]));
            let turned = self.along(&gradient);
            outputs.extend(gradient.into_iter().chain(turned));
        }
        self.compile(&outputs, &[q, v, dq, dv, dp])
    }
}
