//! [`PhaseMechanism`]: the mechanism in the modes of the present phase.

use bksim_dae::{Loader, Saver, SolveError, Step};

use super::problem::Problem;
use crate::compiled::CompiledSystem;
use crate::evaluator::Evaluator;
use crate::half_turns::HalfTurn;
use crate::hybrid::{Change, ConsistentModes, Crossed, EventMonitor, NoConsistentModes, Switching};
use crate::modes::Modes;
use crate::multiplier::{MultiplierSystem, largest};
use crate::sampled::Tick;
use crate::state::State;
use bksim_model::LoadId;

/// The mechanism in the modes of the present phase: its functions, and the constraint rows that
/// hold.
pub(crate) struct PhaseMechanism<'a> {
    compiled: &'a CompiledSystem,
    switching: Switching<'a>,
    pub(crate) evaluator: Evaluator<'a>,
    /// Constraint rows that follow from the others, and those of contacts that are open.
    pub(crate) inactive: Vec<usize>,
    t_end: f64,
}

/// Inactive rows count as broken beyond this part of the mechanism's size.
const BRANCH_TOLERANCE: f64 = 1e-6;

impl<'a> PhaseMechanism<'a> {
    /// In the modes of the start.
    pub(crate) fn new(problem: Problem<'a>) -> Self {
        let Problem { compiled, start, parameters, options, .. } = problem;
        let switching = Switching::new(
            compiled,
            parameters,
            options,
            &start.modes,
            (start.t, &start.q, &start.v),
            &start.lambda,
        );
        Self {
            compiled,
            evaluator: compiled.evaluator(&switching.parameters),
            switching,
            inactive: start.inactive_rows().to_vec(),
            t_end: options.t_end,
        }
    }

    pub(crate) fn compiled(&self) -> &'a CompiledSystem {
        self.compiled
    }

    /// Values of the model's parameters, followed by the modes.
    pub(crate) fn parameters(&self) -> &[f64] {
        &self.switching.parameters
    }

    /// The modes of this phase.
    pub(crate) fn modes_now(&self) -> &Modes {
        self.switching.modes_now()
    }

    /// Rows of the contacts that are closed or stick.
    pub(super) fn closed_rows(&self) -> Vec<usize> {
        let contacts = self.compiled.indicators.contacts.iter().zip(&self.modes_now().contacts);
        contacts.filter(|(_, mode)| mode.is_active()).map(|(contact, _)| contact.row).collect()
    }

    /// The modes as numbers.
    pub(crate) fn modes(&self) -> &[f64] {
        self.switching.modes()
    }

    /// A multiplier system of the active rows.
    pub(crate) fn multipliers(&self) -> MultiplierSystem {
        self.compiled.multiplier_system(&self.inactive)
    }

    /// Friction that slides is a load in the equations; its multiplier is filled in. Returns friction whose size is
    /// below zero.
    pub(crate) fn fill_slip_friction(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        lambda: &mut [f64],
    ) -> Option<LoadId> {
        self.switching.fill_slip_friction(t, q, v, lambda)
    }

    /// True if inactive rows are broken at (t, q): a step has jumped over a singular pose onto a
    /// branch that only the active rows allow.
    pub(super) fn is_off_branch(&mut self, t: f64, q: &[f64]) -> bool {
        if self.inactive.is_empty() {
            return false;
        }
        let size = q.iter().fold(1.0, |size: f64, value| size.max(value.abs()));
        let gap = largest(self.evaluator.constraints(t, q).value);
        gap.is_nan() || gap > BRANCH_TOLERANCE * size
    }

    /// Monitor of the events that end a phase which begins at `state`; `None` when nothing ever
    /// switches.
    pub(super) fn monitor(&self, state: &State) -> Option<EventMonitor<'a>> {
        self.switching.monitor(&self.inactive, (state.t, &state.q, &state.v))
    }

    /// The kink that a motion without a value ahead is about to reach; `state` moves there.
    pub(super) fn kink_ahead(&mut self, state: &mut State) -> Option<Crossed> {
        let State { t, q, v } = state;
        self.switching.kink_ahead(t, q, v, &self.inactive)
    }

    /// Changes the modes where something has switched at `state`; `changes` gains what happened.
    ///
    /// # Errors
    /// [`NoConsistentModes`] when no modes are consistent.
    pub(super) fn switch(
        &mut self,
        crossed: &Crossed,
        state: State,
        changes: &mut Vec<Change>,
    ) -> Result<ConsistentModes, NoConsistentModes> {
        let State { t, q, v } = state;
        let entered = self.switching.pass(&crossed.fired, (t, q, v), changes)?;
        self.evaluator = self.compiled.evaluator(&self.switching.parameters);
        self.inactive.clone_from(&entered.inactive);
        Ok(entered)
    }

    /// The tick that comes next, at most at the end of the run: one that rounding puts beyond it is there.
    pub(super) fn next_tick(&self) -> Option<Tick> {
        self.switching.next_tick().filter(|tick| !tick.is_after(self.t_end))
    }

    /// Passes a tick at `state`; returns the modes from there on where they may be others.
    ///
    /// # Errors
    /// [`NoConsistentModes`] when no modes are consistent.
    pub(super) fn tick(
        &mut self,
        state: State,
        changes: &mut Vec<Change>,
    ) -> Result<Option<ConsistentModes>, NoConsistentModes> {
        let State { t, q, v } = state;
        let entered = self.switching.tick((t, q, v), changes)?;
        self.evaluator = self.compiled.evaluator(&self.switching.parameters);
        if let Some(entered) = &entered {
            self.inactive.clone_from(&entered.inactive);
        }
        Ok(entered)
    }

    /// True if ropes or belts have turns to count.
    pub(super) fn counts_half_turns(&self) -> bool {
        self.switching.counts_half_turns()
    }

    /// The first half turn of a rope or belt that is to be counted in a step.
    pub(super) fn half_turn_in(&mut self, step: &Step<'_>) -> Option<HalfTurn> {
        self.switching.half_turn_in(step)
    }

    /// Counts the half turns of ropes and belts up to `state`.
    pub(super) fn count_half_turns(&mut self, state: &State) {
        self.switching.count_half_turns(state.t, &state.q);
        self.evaluator = self.compiled.evaluator(&self.switching.parameters);
    }

    /// Saves the modes; the inactive rows are saved elsewhere.
    pub(super) fn save(&self, saver: &mut Saver) {
        self.switching.save(saver);
    }

    /// Goes on in the modes that were saved, with these rows inactive.
    pub(super) fn load(
        &mut self,
        loader: &mut Loader<'_>,
        inactive: Vec<usize>,
    ) -> Result<(), SolveError> {
        self.switching.load(loader)?;
        self.evaluator = self.compiled.evaluator(&self.switching.parameters);
        self.inactive = inactive;
        Ok(())
    }
}
