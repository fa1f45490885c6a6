//! Latched signals: values that change where conditions come to hold, and are held in between.
//!
//! ```text
//! c_k(σ, x)     1 where the condition of row k holds in these modes, else 0
//! at an event   x ← the value of the first of its rows whose c_k has become 1
//! ```
//!
//! Conditions are made of modes, so they change at events only, and exactly there. What a row remembers,
//! whether its condition held before, follows from the modes before.

use bksim_expr::{SymbolId, TapeError};
use bksim_mbs::signal::signal_values;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::Model;

use crate::function::Function;
use crate::input::{InputValues, Inputs, input_symbols, without_inputs};
use crate::modes::Modes;
use crate::sampled::{Held, NoSignal};

/// The latched signals of one mechanism, compiled.
#[derive(Clone, Debug)]
pub(crate) struct Latches {
    /// The condition of every row, of parameters and modes.
    conditions: Function,
    rows: Vec<CompiledRow>,
}

#[derive(Clone, Debug)]
struct CompiledRow {
    /// Place of its signal among those that are held.
    signal: usize,
    /// Of t, q, v, the inputs, the values held, and those before.
    value: Function,
}

impl Latches {
    /// Compiles the conditions with modes in them, and the values as they were written.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither time, a parameter nor part of the state.
    pub(crate) fn compile(model: &Model, system: &SymbolicSystem) -> Result<Self, TapeError> {
        let integrated = system.integrated();
        let with_modes = without_inputs(model, integrated.parameters(model));
        let own: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
        let own = without_inputs(model, own);

        let coordinates = system.coordinates();
        let q: Vec<SymbolId> = coordinates.iter().map(|c| c.q).collect();
        let v: Vec<SymbolId> = coordinates.iter().map(|c| c.v).collect();
        let held: Vec<SymbolId> = model.held.iter().map(|s| s.held).collect();
        let previous: Vec<SymbolId> = model.held.iter().map(|s| s.previous).collect();
        let (time, inputs) = ([model.time], input_symbols(model));
        let arguments = [&time[..], &q, &v, &inputs, &held, &previous];

        let rows = model.held.iter().enumerate();
        let rows: Vec<_> =
            rows.flat_map(|(k, signal)| signal.rows().iter().map(move |row| (k, row))).collect();
        let measures =
            if rows.is_empty() { Vec::new() } else { signal_values(model, &system.kinematics) };
        let compiled = rows.into_iter().map(|(signal, row)| {
            let value = model.pool.substitute(row.value, &measures);
            let value = Function::compile(model, &[value], &arguments, &own)?;
            Ok(CompiledRow { signal, value })
        });
        Ok(Self {
            conditions: Function::compile(model, &integrated.conditions, &[], &with_modes)?,
            rows: compiled.collect::<Result<_, TapeError>>()?,
        })
    }

    /// True where no signal is latched.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// No condition, as before a start.
    pub(crate) fn none_hold(&self) -> Vec<bool> {
        vec![false; self.rows.len()]
    }

    /// True for each row whose condition holds in these modes.
    pub(crate) fn holding(&self, parameters: &[f64], modes: &Modes) -> Vec<bool> {
        if self.is_empty() {
            return Vec::new();
        }
        let mut buffers = self.conditions.buffers(modes.parameters_with_modes(parameters));
        let values = self.conditions.evaluate(&mut buffers, &[]);
        values.iter().map(|&value| value > 0.5).collect()
    }

    /// Takes the values of the signals with rows that have come to hold, all from the values held until now;
    /// returns one of these signals, or `None` where there is none.
    ///
    /// # Errors
    /// [`NoSignal`] names the first without a finite value.
    pub(crate) fn take(
        &self,
        (parameters, inputs): (&[f64], &Inputs),
        (before, now): (&[bool], &[bool]),
        (t, q, v): (f64, &[f64], &[f64]),
        held: &mut Held,
    ) -> Result<Option<usize>, NoSignal> {
        let mut inputs = InputValues::new(inputs);
        let old = held.clone();
        let mut taken = None;
        let come = before.iter().zip(now).map(|(before, now)| *now && !before);
        // Backwards, so that of several rows of a signal the first counts.
        for (row, _) in self.rows.iter().zip(come).rev().filter(|(_, come)| *come) {
            let arguments = [&[t], q, v, inputs.at(t, q, v), &old.values, &old.previous];
            let mut buffers = row.value.buffers(parameters);
            let value = row.value.evaluate(&mut buffers, &arguments)[0];
            if !value.is_finite() {
                return Err(NoSignal { signal: row.signal });
            }
            held.values[row.signal] = value;
            taken = Some(row.signal);
        }
        Ok(taken)
    }
}
