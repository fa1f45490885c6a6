//! Loads that depend on multipliers: friction by the reaction of its own joint, and expressions of reactions.
//!
//! ```text
//! M v̇ + Gᵀ λ = f        G v̇ + γ = 0        f with some λ in it
//! ```
//!
//! They are found by Newton's method: the multipliers that the system has under their own loads.

use std::collections::BTreeSet;

use bksim_expr::{SymbolId, TapeError};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{CouplingId, Frame, JointId, Load, Measure, Model, Signal, Surface};

use crate::function::Function;
use crate::input::{input_symbols, without_inputs};

/// The multipliers that loads depend on.
#[derive(Clone, Debug)]
pub(crate) struct PressingMultipliers {
    /// Their rows, ascending.
    pub(crate) rows: Vec<usize>,
    /// ∂f/∂λ of (t, q, v, u, λ), nq × their number, row by row.
    pub(crate) slopes: Function,
}

/// A joint whose reaction friction or an expression follows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bearing {
    pub(crate) joint: JointId,
    /// The components of its reaction that take part, in the order of `Uniqueness::reactions`; of a screw, whose
    /// axial force alone does, none.
    pub(crate) components: [bool; 6],
    /// The coupling of the joint whose force takes part.
    pub(crate) coupling: Option<CouplingId>,
}

/// The joints of a model whose reactions friction or expressions that act follow.
pub(crate) fn bearings(model: &Model) -> Vec<Bearing> {
    let bearing = |load: &Load| {
        let ((joint, _), surface) = load.kind.joint_motion().zip(load.kind.coulomb())?;
        let [f, m] = match surface {
            Surface::Guide { length } => [true, length.is_some()],
            Surface::Journal { .. } | Surface::Track | Surface::Touch { .. } => [true, false],
            Surface::Thread { .. } | Surface::Teeth { .. } => [false, false],
        };
        let coupling = match surface {
            Surface::Teeth { coupling, .. } => Some(coupling),
            _ => None,
        };
        Some(Bearing { joint, components: [f, f, f, m, m, m], coupling })
    };
    let measured = |signal: &Signal| {
        let Measure::Reaction(joint, frame, component) = signal.measure else { return None };
        if !model.acts(signal) {
            return None;
        }
        let first = component / 3 * 3;
        let takes_part = |at: usize| match frame {
            Frame::World => at == component,
            Frame::Body => (first..first + 3).contains(&at),
        };
        Some(Bearing { joint, components: std::array::from_fn(takes_part), coupling: None })
    };
    let of_loads = model.loads.iter().filter_map(bearing);
    of_loads.chain(model.signals.iter().filter_map(measured)).collect()
}

/// The rows whose multipliers the applied forces of a system depend on, ascending.
fn pressing_rows(model: &Model, system: &SymbolicSystem) -> Vec<usize> {
    let used: BTreeSet<SymbolId> =
        system.applied_force.iter().flat_map(|&force| model.pool.symbols_of(force)).collect();
    let rows = system.constraints.iter().enumerate();
    rows.filter(|(_, row)| used.contains(&row.lambda)).map(|(idx, _)| idx).collect()
}

/// The symbols of the multipliers that loads depend on, of a system with modes.
pub fn pressing_symbols(model: &Model, system: &SymbolicSystem) -> Vec<SymbolId> {
    pressing_rows(model, system).into_iter().map(|row| system.constraints[row].lambda).collect()
}

impl PressingMultipliers {
    /// Of a system with modes; `None` where no load depends on a multiplier.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither time, a parameter nor part of the state.
    pub(crate) fn compile(
        model: &Model,
        system: &SymbolicSystem,
    ) -> Result<Option<Self>, TapeError> {
        let rows = pressing_rows(model, system);
        if rows.is_empty() {
            return Ok(None);
        }
        let symbols: Vec<SymbolId> =
            rows.iter().map(|&row| system.constraints[row].lambda).collect();
        let slopes = system.applied_force.iter().flat_map(|&f| model.pool.gradient(f, &symbols));
        let coordinates = system.coordinates();
        let q: Vec<SymbolId> = coordinates.iter().map(|c| c.q).collect();
        let v: Vec<SymbolId> = coordinates.iter().map(|c| c.v).collect();
        let arguments = [&[model.time][..], &q, &v, &input_symbols(model), &symbols];
        let parameters = without_inputs(model, system.parameters(model));
        let slopes =
            Function::compile(model, &slopes.collect::<Vec<_>>(), &arguments, &parameters)?;
        Ok(Some(Self { rows, slopes }))
    }
}
