//! The derivatives of the equations along changes of the state and of the parameters, compiled.
//!
//! A change of one parameter is a direction in the space of all: those that are defined through it
//! follow. Directions of the state are inputs of the tapes, so each tape serves every quantity.

use bksim_expr::{Expr, SymbolId, TapeError};

use crate::function::Function;

use super::channels::Channels;
use super::following::Following;
use super::{Sensitive, SensitivityError};
use crate::compiled::CompiledSystem;
use crate::formulate::{acceleration_level, parameter_columns};
use bksim_mbs::levels::constraint_velocity;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{Method, Model, SolveOptions};

/// The derivatives that sensitivities need, compiled.
#[derive(Clone, Debug)]
pub struct SensitivityEquations {
    pub(super) sensitive: Vec<Sensitive>,
    pub(super) way: Way,
    /// Changes of g, G v + ∂g/∂t, M a + Gᵀ λ − f and G a + γ, of (t, q, v, a, λ) and ∂(t, q, v, P).
    pub(super) levels: Function,
    /// Changes of the entries of G, of (t, q) and ∂(t, q, P).
    pub(super) jacobian: Function,
    /// Row and coordinate of each of these entries.
    pub(super) cells: Vec<(usize, usize)>,
    /// Everything else that a run shows.
    pub(super) channels: Channels,
    /// By initial value: see [`super::start`].
    pub(super) closing: Function,
    /// ∂P/∂p: all parameters of the model, one direction after the other.
    pub(super) directions: Vec<f64>,
    pub(super) n_parameters: usize,
}

/// The way in which the derivatives are carried along the motion.
#[derive(Clone, Debug)]
pub(super) enum Way {
    /// With the steps of Radau IIA, whose stages they share: F_p of (t, y, y′), one column after the other.
    Staggered(Box<Function>),
    /// Along a motion that any method has found.
    Followed(Box<Following>),
}

/// Direction in which time and the parameters change.
#[derive(Clone, Copy)]
pub(super) struct Change<'c> {
    /// Of time.
    pub(super) dt: f64,
    /// Of all parameters of the model.
    pub(super) dp: &'c [f64],
}

/// Most coordinates of a mechanism whose linear equations are solved at all nodes of a step at once, where the
/// staggered way is open.
const MOST_AT_ONCE: usize = 16;

/// Derives and compiles the derivatives of the motion by `sensitive`, at these parameter values and for these options.
///
/// # Errors
/// [`SensitivityError`] when something in the model is sampled or unknown, or cannot be compiled.
pub fn differentiate(
    model: &Model,
    system: &SymbolicSystem,
    compiled: &CompiledSystem,
    options: &SolveOptions,
    sensitive: &[Sensitive],
    parameters: &[f64],
) -> Result<SensitivityEquations, SensitivityError> {
    let system = system.integrated();
    if !compiled.sampled.is_empty() {
        return Err(SensitivityError::Sampled);
    }
    if !model.inputs.is_empty() {
        return Err(SensitivityError::Inputs);
    }
    let derivation = Direction::new(model, system);
    let directions: Vec<Vec<Expr>> =
        sensitive.iter().map(|&by| parameter_direction(model, by)).collect();
    derivation.check_latches(&directions)?;

    // Fixed steps are Radau's unless others are asked for.
    let is_radau = options.method == Method::Radau
        || options.method == Method::Auto && options.step.is_some()
        || options.method == Method::Auto && system.coordinates().len() > MOST_AT_ONCE;
    let way = if compiled.indicators.is_empty() && compiled.pressing.is_none() && is_radau {
        let form = options.formulation;
        Way::Staggered(Box::new(parameter_columns(
            model,
            system,
            form,
            &derivation.own,
            &directions,
        )?))
    } else {
        Way::Followed(Box::new(Following::new(&derivation, &directions)?))
    };
    let evaluated = |values: &[Expr]| -> Result<Vec<f64>, TapeError> {
        let function = Function::compile(model, values, &[], &derivation.own)?;
        Ok(function.evaluate(&mut function.buffers(parameters), &[]).to_vec())
    };
    let (jacobian, cells) = derivation.jacobian()?;
    Ok(SensitivityEquations {
        sensitive: sensitive.to_vec(),
        way,
        levels: derivation.levels()?,
        jacobian,
        cells,
        channels: Channels::new(&derivation)?,
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

    /// ∂P/∂p_k of all parameters P of the model, at an instant that stays.
    pub(super) fn change(&self, k: usize) -> Change<'_> {
        let dp = &self.directions[k * self.n_parameters..(k + 1) * self.n_parameters];
        Change { dt: 0.0, dp }
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
pub(super) struct Direction<'a> {
    pub(super) model: &'a Model,
    pub(super) system: &'a SymbolicSystem,
    pub(super) own: Vec<SymbolId>,
    q: Vec<SymbolId>,
    v: Vec<SymbolId>,
    dt: SymbolId,
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
            dt: fresh("change of t", 1)[0],
            dq: fresh("change of q", nq),
            dv: fresh("change of v", nq),
            dp: fresh("change of p", np),
        }
    }

    /// Derivatives along the direction of t, q, v and the parameters, and of other symbols along theirs.
    fn along_with(&self, outputs: &[Expr], others: &[(&[SymbolId], &[SymbolId])]) -> Vec<Expr> {
        let pool = &self.model.pool;
        let (mut wrt, mut direction) = (vec![self.model.time], vec![self.dt]);
        let of_state = [(&self.q, &self.dq), (&self.v, &self.dv), (&self.own, &self.dp)];
        let of_state = of_state.map(|(of, change)| (of.as_slice(), change.as_slice()));
        for (of, change) in of_state.iter().chain(others) {
            wrt.extend_from_slice(of);
            direction.extend_from_slice(change);
        }
        let direction: Vec<Expr> =
            direction.into_iter().map(|symbol| pool.symbol_expr(symbol)).collect();
        pool.jvp(outputs, &wrt, &direction)
    }

    /// Derivatives along the direction of t, q, v and the parameters.
    fn along(&self, outputs: &[Expr]) -> Vec<Expr> {
        self.along_with(outputs, &[])
    }

    /// Changes of functions of (t, q, v, a, λ) along ∂(t, q, v, P, a, λ).
    pub(super) fn changes(&self, outputs: &[Expr]) -> Result<Function, TapeError> {
        let Self { model, system, q, v, dt, dq, dv, dp, .. } = self;
        let pool = &model.pool;
        let a: Vec<SymbolId> = system.coordinates().iter().map(|c| c.a).collect();
        let lambda: Vec<SymbolId> = system.constraints.iter().map(|c| c.lambda).collect();
        let fresh = |kind: &str, n: usize| -> Vec<SymbolId> {
            let symbol = |k: usize| pool.symbol(&format!("'change of {kind}{k}"));
            (0..n).map(|k| pool.symbol_id(symbol(k)).expect("a symbol was just made")).collect()
        };
        let (da, dl) = (fresh("a", a.len()), fresh("l", lambda.len()));
        let changes = self.along_with(outputs, &[(&a, &da), (&lambda, &dl)]);
        self.compile(&changes, &[q, v, &a, &lambda, &[*dt], dq, dv, dp, &da, &dl])
    }

    /// Refuses latched signals whose values themselves follow the motion or what it is differentiated by.
    fn check_latches(&self, directions: &[Vec<Expr>]) -> Result<(), SensitivityError> {
        let pool = &self.model.pool;
        let moves = |symbol: SymbolId| {
            let place = self.own.iter().position(|&own| own == symbol);
            place.is_none_or(|k| directions.iter().any(|by| !pool.is_zero(by[k])))
        };
        let rows = self.model.held.iter().flat_map(bksim_model::HeldSignal::rows);
        let starts = self.model.held.iter().map(|signal| signal.start);
        let values = rows.map(|row| row.value).chain(starts);
        let is_moving = |value: Expr| pool.symbols_of(value).into_iter().any(moves);
        if values.into_iter().any(is_moving) { Err(SensitivityError::Sampled) } else { Ok(()) }
    }

    /// Compiles functions of time and some groups of symbols.
    fn compile(&self, outputs: &[Expr], arguments: &[&[SymbolId]]) -> Result<Function, TapeError> {
        let time = [self.model.time];
        let arguments = [&[&time[..]], arguments].concat();
        Function::compile(self.model, outputs, &arguments, &self.system.parameters(self.model))
    }

    fn levels(&self) -> Result<Function, TapeError> {
        let Self { model, system, q, v, dt, dq, dv, dp, .. } = self;
        let a: Vec<SymbolId> = system.coordinates().iter().map(|c| c.a).collect();
        let lambda: Vec<SymbolId> = system.constraints.iter().map(|c| c.lambda).collect();
        let mut rows: Vec<Expr> = system.constraints.iter().map(|c| c.expression).collect();
        rows.extend((0..rows.len()).map(|row| constraint_velocity(&model.pool, system, row)));
        rows.extend(acceleration_level(model, system));
        self.compile(&self.along(&rows), &[q, v, &a, &lambda, &[*dt], dq, dv, dp])
    }

    /// Changes of the entries of G, and the row and column of each.
    fn jacobian(&self) -> Result<(Function, Vec<(usize, usize)>), TapeError> {
        let rows: Vec<Expr> = self.system.constraints.iter().map(|c| c.expression).collect();
        let entries = self.model.pool.jacobian(&rows, &self.q).entries;
        let (cells, entries): (Vec<(usize, usize)>, Vec<Expr>) =
            entries.into_iter().map(|(row, i, entry)| ((row, i), entry)).unzip();
        let changes =
            self.compile(&self.along(&entries), &[&self.q, &[self.dt], &self.dq, &self.dp])?;
        Ok((changes, cells))
    }

    /// By initial value: measure m, stated value, their changes, gradient of m by q (positions) or
    /// v (velocities), its change.
    fn closing(&self) -> Result<Function, TapeError> {
        let Self { model, system, q, v, dt, dq, dv, dp, .. } = self;
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
        self.compile(&outputs, &[q, v, &[*dt], dq, dv, dp])
    }
}
