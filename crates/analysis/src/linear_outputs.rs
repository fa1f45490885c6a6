//! Outputs of linear equations: measures, components of reactions, states and signals.
//!
//! ```text
//! z = z(t, q, v, a, λ, p)      δz = z_q δq + z_v δv + z_a δa + z_λ δλ + z_p δp
//! ```

use std::collections::HashSet;

use bksim_expr::{Expr, SymbolId, Tape};
use bksim_mbs::reaction::reactions;
use bksim_mbs::signal::signal_values;
use bksim_mbs::spatial;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{Measure, Model, ParameterId, ReactionComponent, StateId};
use nalgebra::{DMatrix, RowDVector};

use crate::channels::{Channels, Input};
use crate::error::AnalysisError;
use crate::forces::{At, vacated, with_definitions};
use crate::loaded::{Loaded, of_forces};
use crate::table::Column;

/// Changes of the state by states and inputs of the linear equations, a column for each.
pub(crate) struct Changes {
    pub(crate) q: DMatrix<f64>,
    pub(crate) v: DMatrix<f64>,
    pub(crate) a: DMatrix<f64>,
    /// Of the rows that hold.
    pub(crate) lambda: DMatrix<f64>,
}

/// Outputs as expressions.
pub(crate) struct Outputs<'a> {
    pub(crate) columns: Vec<Column>,
    pub(crate) expressions: Vec<Expr>,
    /// Symbols that these depend on.
    used: Vec<SymbolId>,
    free: &'a [ParameterId],
}

impl<'a> Outputs<'a> {
    /// The outputs of `channels`, inputs being those with the `free` parameters among them.
    pub(crate) fn of(
        loaded: &Loaded,
        channels: &Channels,
        inputs: &[Input],
        free: &'a [ParameterId],
    ) -> Result<Self, AnalysisError> {
        let (model, system) = (loaded.model(), loaded.system());
        let pool = &model.pool;
        let components: Vec<Option<ReactionComponent>> =
            channels.outputs.iter().map(|name| ReactionComponent::named(model, name)).collect();
        let known = if components.iter().any(Option::is_some) {
            reactions(model, system)
        } else {
            Vec::new()
        };
        let (mut columns, mut expressions) = (Vec::new(), Vec::new());
        for (name, component) in channels.outputs.iter().zip(components) {
            let (e, unit) = if let Some(of) = component {
                allowed(loaded, (name, of), channels, inputs)?;
                let reaction = &known[of.joint.0];
                let vector = if of.component < 3 { &reaction.force } else { &reaction.moment };
                let k = of.component % 3;
                let e = if of.is_in_joint {
                    let sides = system.kinematics.sides(model, &model.joints[of.joint.0]);
                    let axis = sides.predecessor.rotation.apply(pool, &spatial::axes(pool)[k]);
                    spatial::dot(pool, vector, &axis)
                } else {
                    vector[k]
                };
                (with_definitions(model, free, e), of.unit())
            } else if let Some((e, unit)) = of_controller(loaded, name)? {
                columns.push(Column::new(name.clone(), unit));
                expressions.push(with_definitions(model, free, e));
                continue;
            } else {
                let unknown = || AnalysisError::UnknownMeasure { name: name.clone() };
                let measure = Measure::named(model, name).ok_or_else(unknown)?;
                (system.kinematics.measure(model, measure), measure.unit(model))
            };
            columns.push(Column::new(name.clone(), unit));
            expressions.push(e);
        }
        let used = expressions.iter().flat_map(|&e| pool.symbols_of(e)).collect();
        Ok(Self { columns, expressions, used, free })
    }

    /// The symbol of one of the free parameters.
    pub(crate) fn symbol(&self, model: &Model, idx: usize) -> SymbolId {
        model.parameters[self.free[idx].0].symbol
    }

    /// True where one of them follows accelerations or multipliers.
    pub(crate) fn follows_forces(&self, system: &SymbolicSystem) -> bool {
        let symbols: HashSet<SymbolId> = (system.coordinates().iter().map(|c| c.a))
            .chain(system.constraints.iter().map(|c| c.lambda))
            .collect();
        self.used.iter().any(|symbol| symbols.contains(symbol))
    }

    /// Their slopes as functions of numbers.
    pub(crate) fn slopes(&self, loaded: &Loaded) -> Result<OutputSlopes, AnalysisError> {
        let (model, system) = (loaded.model(), loaded.system());
        let pool = &model.pool;
        let coordinates = system.coordinates();
        let of = |f: fn(&bksim_mbs::coordinate::Coordinate) -> SymbolId| -> Vec<SymbolId> {
            coordinates.iter().map(f).collect()
        };
        let multipliers: Vec<SymbolId> = system.constraints.iter().map(|c| c.lambda).collect();
        let parameters = self.free.iter().map(|id| model.parameters[id.0].symbol);
        let arguments: Vec<SymbolId> = [of(|c| c.q), of(|c| c.v), of(|c| c.a), multipliers]
            .concat()
            .into_iter()
            .chain(parameters)
            .collect();
        let slopes: Vec<Expr> =
            self.expressions.iter().flat_map(|&e| pool.gradient(e, &arguments)).collect();
        let symbols = vacated(pool, system.parameters(model), self.free);
        let tape =
            Tape::compile(pool, &slopes, &[&[model.time], &arguments[..]].concat(), &symbols)?;
        Ok(OutputSlopes {
            tape,
            n_outputs: self.expressions.len(),
            n_arguments: arguments.len(),
            n_rows: system.constraints.len(),
        })
    }
}

/// Slopes of outputs, compiled.
pub(crate) struct OutputSlopes {
    tape: Tape,
    n_outputs: usize,
    n_arguments: usize,
    /// Of all constraints.
    n_rows: usize,
}

impl OutputSlopes {
    /// C and D about a state with the multipliers of `rows`, of as many states as `n_states`.
    pub(crate) fn matrices(
        &self,
        (parameters, rows): (&[f64], &[usize]),
        At { t, q, v, a, lambda, p }: At<'_>,
        changes: &Changes,
        n_states: usize,
        inputs: &[Input],
    ) -> (DMatrix<f64>, DMatrix<f64>) {
        let mut of_all_rows = vec![0.0; self.n_rows];
        rows.iter().zip(lambda).for_each(|(&row, &value)| of_all_rows[row] = value);
        let numbers = [&[t], q, v, a, &of_all_rows, p].concat();
        let mut values = vec![0.0; self.n_outputs * self.n_arguments];
        self.tape.evaluate(&mut self.tape.workspace(parameters), &numbers, &mut values);

        let (n, n_inputs) = (q.len(), inputs.len());
        let mut c = DMatrix::zeros(self.n_outputs, n_states);
        let mut d = DMatrix::zeros(self.n_outputs, n_inputs);
        for (k, slopes) in values.chunks(self.n_arguments.max(1)).enumerate() {
            let row =
                |from: usize, len: usize| RowDVector::from_row_slice(&slopes[from..from + len]);
            let by_row = |&row: &usize| slopes[3 * n + row];
            let by_lambda = RowDVector::from_iterator(rows.len(), rows.iter().map(by_row));
            let whole = row(0, n) * &changes.q
                + row(n, n) * &changes.v
                + row(2 * n, n) * &changes.a
                + by_lambda * &changes.lambda;
            c.row_mut(k).copy_from(&whole.columns(0, n_states));
            d.row_mut(k).copy_from(&whole.columns(n_states, n_inputs));
            // Parameters that it depends on directly.
            for (j, input) in inputs.iter().enumerate() {
                if let Input::Parameter(idx) = input {
                    d[(k, j)] += slopes[3 * n + self.n_rows + idx];
                }
            }
        }
        (c, d)
    }
}

/// Matrices side by side.
pub(crate) fn beside(parts: [&DMatrix<f64>; 3]) -> DMatrix<f64> {
    let columns: Vec<_> = parts.iter().flat_map(|part| part.column_iter()).collect();
    if columns.is_empty() {
        DMatrix::zeros(parts[0].nrows(), 0)
    } else {
        DMatrix::from_columns(&columns)
    }
}

/// A state, `i` or `states.i`, or a named signal, `u` or `signals.u`, as an expression with its unit.
///
/// # Errors
/// Those that follow from reactions or efforts of drives are refused.
fn of_controller(loaded: &Loaded, name: &str) -> Result<Option<(Expr, String)>, AnalysisError> {
    let (model, system) = (loaded.model(), loaded.system());
    let own = name.strip_prefix("states.").unwrap_or(name);
    if let Some(k) = model.states.iter().position(|state| state.name == own) {
        let value = system.kinematics.measure(model, Measure::State(StateId(k)));
        return Ok(Some((value, model.states[k].units[1].replace(' ', "*"))));
    }
    let own = name.strip_prefix("signals.").unwrap_or(name);
    let Some(signal) = model.named_signals.iter().find(|signal| signal.name == own) else {
        return Ok(None);
    };
    let is_force = |of: Measure| of.is_reaction() || matches!(of, Measure::Effort(_));
    let mut forces = model.signals.iter().filter(|known| is_force(known.measure));
    if forces.any(|force| model.pool.depends_on(signal.value, force.symbol)) {
        return Err(of_forces(name, &signal.span));
    }
    let value = model.pool.substitute(signal.value, &signal_values(model, &system.kinematics));
    Ok(Some((value, signal.unit.replace(' ', "*"))))
}

/// Refuses components that are not unique, and those that an effort changes directly: torques change no forces, all
/// else depends on where the effort's counterpart is.
fn allowed(
    loaded: &Loaded,
    (name, of): (&str, ReactionComponent),
    channels: &Channels,
    inputs: &[Input],
) -> Result<(), AnalysisError> {
    let six = loaded.unique.get(of.joint.0).copied().unwrap_or([true; 6]);
    // Along the joint's axes a component has parts of all three.
    let own = if of.component < 3 { &six[..3] } else { &six[3..] };
    let is_unique =
        if of.is_in_joint { own.iter().all(|unique| *unique) } else { six[of.component] };
    if !is_unique {
        return Err(AnalysisError::NotUnique { name: name.to_owned() });
    }
    let is_open = |input: &Input| match input {
        Input::Parameter(_) => false,
        Input::Effort(quantity) => of.component >= 3 || !quantity.is_angle(),
    };
    match inputs.iter().zip(&channels.inputs).find(|(input, _)| is_open(input)) {
        Some((_, input)) => {
            Err(AnalysisError::EffortInReaction { output: name.to_owned(), input: input.clone() })
        }
        None => Ok(()),
    }
}
