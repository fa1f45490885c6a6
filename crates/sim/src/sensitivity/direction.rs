//! Directions in which the state, the time and the parameters change: as numbers, and as symbols.

use bksim_expr::{Expr, SymbolId, TapeError};

use crate::compiled::CompiledSystem;
use crate::formulate::acceleration_level;
use crate::function::Function;

use super::{Sensitive, SensitivityError};

use bksim_mbs::levels::constraint_velocity;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;

/// Direction in which time and the parameters change.
#[derive(Clone, Copy)]
pub(super) struct Change<'c> {
    /// Of time.
    pub(super) dt: f64,
    /// Of all parameters of the model.
    pub(super) dp: &'c [f64],
}

/// Symbols of the state, and of a direction in which it and the parameters change.
pub(super) struct Direction<'a> {
    pub(super) model: &'a Model,
    pub(super) system: &'a SymbolicSystem,
    pub(super) own: Vec<SymbolId>,
    pub(super) q: Vec<SymbolId>,
    pub(super) v: Vec<SymbolId>,
    pub(super) dt: SymbolId,
    pub(super) dq: Vec<SymbolId>,
    pub(super) dv: Vec<SymbolId>,
    pub(super) dp: Vec<SymbolId>,
}

impl<'a> Direction<'a> {
    pub(super) fn new(model: &'a Model, system: &'a SymbolicSystem) -> Self {
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
    pub(super) fn along_with(
        &self,
        outputs: &[Expr],
        others: &[(&[SymbolId], &[SymbolId])],
    ) -> Vec<Expr> {
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
    pub(super) fn along(&self, outputs: &[Expr]) -> Vec<Expr> {
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

    /// ∂P/∂p by each quantity.
    ///
    /// # Errors
    /// [`SensitivityError`] when something in the model is sampled, or follows a law that is not known.
    pub(super) fn checked(
        &self,
        compiled: &CompiledSystem,
        sensitive: &[Sensitive],
    ) -> Result<Vec<Vec<Expr>>, SensitivityError> {
        if !compiled.sampled.is_empty() {
            return Err(SensitivityError::Sampled);
        }
        if !self.model.inputs.is_empty() {
            return Err(SensitivityError::Inputs);
        }
        if !self.model.contacts.is_empty() {
            return Err(SensitivityError::Contacts);
        }
        if self.system.constraints.iter().any(bksim_mbs::constraint::Constraint::is_of_rates) {
            return Err(SensitivityError::Rates);
        }
        let directions: Vec<Vec<Expr>> =
            sensitive.iter().map(|&by| parameter_direction(self.model, by)).collect();
        self.check_latches(&directions)?;
        Ok(directions)
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
    pub(super) fn compile(
        &self,
        outputs: &[Expr],
        arguments: &[&[SymbolId]],
    ) -> Result<Function, TapeError> {
        let time = [self.model.time];
        let arguments = [&[&time[..]], arguments].concat();
        Function::compile(self.model, outputs, &arguments, &self.system.parameters(self.model))
    }

    pub(super) fn levels(&self) -> Result<Function, TapeError> {
        let Self { model, system, q, v, dt, dq, dv, dp, .. } = self;
        let a: Vec<SymbolId> = system.coordinates().iter().map(|c| c.a).collect();
        let lambda: Vec<SymbolId> = system.constraints.iter().map(|c| c.lambda).collect();
        let mut rows: Vec<Expr> = system.constraints.iter().map(|c| c.expression).collect();
        rows.extend((0..rows.len()).map(|row| constraint_velocity(&model.pool, system, row)));
        rows.extend(acceleration_level(model, system));
        self.compile(&self.along(&rows), &[q, v, &a, &lambda, &[*dt], dq, dv, dp])
    }

    /// Changes of the entries of G, and the row and column of each.
    pub(super) fn jacobian(&self) -> Result<(Function, Vec<(usize, usize)>), TapeError> {
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
    pub(super) fn closing(&self) -> Result<Function, TapeError> {
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
