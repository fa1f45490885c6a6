//! Outputs of linear equations: all that has a formula of the state.
//!
//! ```text
//! z = z(t, q, v, a, λ, p)      δz = z_q δq + z_v δv + z_a δa + z_λ δλ + z_p δp
//! ```

use std::collections::HashSet;

use bksim_expr::{Expr, SymbolId, Tape};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{Frame, JointId, Measure, Model, ParameterId};
use bksim_sim::quantities::Quantities;
use bksim_sim::redundancy::Uniqueness;
use nalgebra::{DMatrix, RowDVector};

use crate::channels::{Channels, Input};
use crate::drive::unknown_measure;
use crate::error::AnalysisError;
use crate::forces::{At, vacated, with_definitions};
use crate::loaded::Loaded;
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
        let quantities = Quantities::new(model, system);
        let (mut columns, mut expressions) = (Vec::new(), Vec::new());
        for name in &channels.outputs {
            let unknown = || unknown_measure(model, name, |_| true);
            // A multiplier by itself is no force of a part.
            let found = quantities.named(name).filter(|_| !name.starts_with("multipliers."));
            let (e, unit) = found.ok_or_else(unknown)?;
            for force in forces_of(model, name) {
                allowed(loaded, (name, force), channels, inputs)?;
            }
            columns.push(Column::new(name.clone(), unit));
            expressions.push(with_definitions(model, free, e));
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

    /// A slope of C or D that is that of a [pole](pole_among): its output, its column, and the infinity that it is.
    pub(crate) fn pole(
        &self,
        numbers: (&[f64], &[usize]),
        at: At<'_>,
        changes: &Changes,
        [c, d]: [&DMatrix<f64>; 2],
        inputs: &[Input],
    ) -> Option<(usize, usize, f64)> {
        let n_states = c.ncols();
        let near = |k: usize, share: f64| {
            let [q, v] = [moved(at.q, &changes.q, k, share), moved(at.v, &changes.v, k, share)];
            let a = moved(at.a, &changes.a, k, share);
            let lambda = moved(at.lambda, &changes.lambda, k, share);
            let at = At { t: at.t, q: &q, v: &v, a: &a, lambda: &lambda, p: at.p };
            beside_two(&self.matrices(numbers, at, changes, n_states, inputs))
        };
        let here = beside_two(&(c.clone(), d.clone()));
        pole_among(&here, changes.q.ncols(), near)
    }
}

/// Part of a state that is moved along a column of changes.
pub(crate) fn moved(own: &[f64], by: &DMatrix<f64>, k: usize, share: f64) -> Vec<f64> {
    own.iter().zip(by.column(k).iter()).map(|(x, by)| x + share * by).collect()
}

/// A slope among those `here` that is that of a pole: its row, its column, and the infinity that it is; `near` gives the
/// slopes in a state moved along one of `n_columns` changes.
///
/// An equilibrium is known to some 1e-12, so that 1/x, ln x and √x, whose argument is zero there, have any large slope.
/// In states that are 1e-9 away on either side, along each column, such a slope has fallen to a hundredth or is no number.
pub(crate) fn pole_among(
    here: &DMatrix<f64>,
    n_columns: usize,
    mut near: impl FnMut(usize, f64) -> DMatrix<f64>,
) -> Option<(usize, usize, f64)> {
    const AWAY: f64 = 1e-9;
    const FALLS_BELOW: f64 = 1e-2;
    // Rounding of slopes that are zero is no pole.
    const LEAST: f64 = 1e-6;
    (0..n_columns).find_map(|k| {
        let sides = [near(k, AWAY), near(k, -AWAY)];
        let size = |i: usize, j: usize| match sides.each_ref().map(|side| side[(i, j)].abs()) {
            [a, b] if a.is_finite() && b.is_finite() => a.max(b),
            _ => 0.0,
        };
        let mut places = (0..here.nrows()).flat_map(|i| (0..here.ncols()).map(move |j| (i, j)));
        let largest = |i: usize| (0..here.ncols()).map(|j| size(i, j)).fold(1.0, f64::max);
        let is_pole = |&(i, j): &(usize, usize)| {
            let own = here[(i, j)].abs();
            own > LEAST * largest(i) && size(i, j) < FALLS_BELOW * own
        };
        let (i, j) = places.find(is_pole)?;
        Some((i, j, f64::INFINITY.copysign(here[(i, j)])))
    })
}

/// C and D side by side.
fn beside_two((c, d): &(DMatrix<f64>, DMatrix<f64>)) -> DMatrix<f64> {
    beside([c, d, &DMatrix::zeros(c.nrows(), 0)])
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

/// A force that an output follows.
#[derive(Clone, Copy)]
enum Force {
    /// Components of the reaction of a joint.
    Reaction(JointId, [bool; 6]),
    Coupling(usize),
    Drive(usize),
}

/// The forces that the output of a name follows: its own, or those that a named expression measures.
fn forces_of(model: &Model, name: &str) -> Vec<Force> {
    let of_measure = |measure: Measure| {
        let within = |range: std::ops::Range<usize>| std::array::from_fn(|k| range.contains(&k));
        match measure {
            Measure::Reaction(joint, Frame::World, k) => {
                Some(Force::Reaction(joint, within(k..k + 1)))
            }
            // Along the joint's axes a component has parts of all three.
            Measure::Reaction(joint, Frame::Body, k) => {
                Some(Force::Reaction(joint, within(k / 3 * 3..k / 3 * 3 + 3)))
            }
            Measure::Resultant(joint, whole) => {
                Some(Force::Reaction(joint, within(whole.components())))
            }
            Measure::Effort(drive) => Some(Force::Drive(drive.0)),
            _ => None,
        }
    };
    if let Some(measure) = Measure::named(model, name) {
        return of_measure(measure).into_iter().collect();
    }
    if let Some(own) = name.strip_prefix("couplings.") {
        let known = model.couplings.iter().position(|coupling| coupling.name == own);
        return known.map(Force::Coupling).into_iter().collect();
    }
    let Some(signal) = model.signal_named(name) else { return Vec::new() };
    let used = model.signals.iter();
    let used = used.filter(|used| model.pool.depends_on(signal.value, used.symbol));
    used.filter_map(|used| of_measure(used.measure)).collect()
}

/// Refuses forces that are not unique, and those that an effort changes directly: torques change no forces, all
/// else of a reaction depends on where the effort's counterpart is.
fn allowed(
    loaded: &Loaded,
    (name, force): (&str, Force),
    channels: &Channels,
    inputs: &[Input],
) -> Result<(), AnalysisError> {
    let Uniqueness { reactions, couplings, drives, .. } = &loaded.unique;
    let is_unique = match force {
        Force::Reaction(joint, parts) => reactions.get(joint.0).is_none_or(|six| {
            six.iter().zip(parts).all(|(unique, takes_part)| *unique || !takes_part)
        }),
        Force::Coupling(k) => couplings.get(k).copied().unwrap_or(true),
        Force::Drive(k) => drives.get(k).copied().unwrap_or(true),
    };
    if !is_unique {
        return Err(AnalysisError::NotUnique { name: name.to_owned() });
    }
    let Force::Reaction(_, [.., mx, my, mz]) = force else { return Ok(()) };
    let has_moment = mx || my || mz;
    let is_open = |input: &Input| match input {
        Input::Parameter(_) => false,
        Input::Effort(quantity) => has_moment || !quantity.is_angle(),
    };
    match inputs.iter().zip(&channels.inputs).find(|(input, _)| is_open(input)) {
        Some((_, input)) => {
            Err(AnalysisError::EffortInReaction { output: name.to_owned(), input: input.clone() })
        }
        None => Ok(()),
    }
}
