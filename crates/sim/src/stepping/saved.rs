//! [`SavedState`]: a state of a run that its caller advances, to come back to, also in another process.

use std::sync::Arc;

use bksim_dae::{Checkpoint, Loader, Method, Saver, SolveError};
use bksim_model::diagnostic::Diagnostic;

use super::{AdvanceError, Beginning, HeldRun, Stepping};
use crate::run::Run;
use crate::simulation::Simulation;
use crate::start::{Start, StartError};
use crate::state::State;

/// A state of a [`Stepping`] run, from which it goes on as if it had never left it.
#[derive(Clone, Debug)]
pub struct SavedState {
    beginning: Arc<Beginning>,
    parameters: Vec<f64>,
    mark: Checkpoint,
    instants: Vec<f64>,
}

/// Why bytes are no state of a run.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UnreadableState {
    /// They are damaged, or of another mechanism.
    #[error(transparent)]
    Damaged(#[from] SolveError),
    /// The run cannot go on from the state that they tell.
    #[error("{}", .0.message)]
    NoMotion(Box<Diagnostic>),
}

impl Stepping {
    /// The state in which the run is held.
    pub fn save(&self) -> SavedState {
        SavedState {
            beginning: self.held.borrow_owner().clone(),
            parameters: self.parameters.clone(),
            mark: self.mark.clone(),
            instants: self.instants.clone(),
        }
    }

    /// Holds the run in a state that was saved. What has led to a state in the middle of a step is done once
    /// more.
    ///
    /// # Errors
    /// [`AdvanceError`] when a law gives other values than it gave then, and the motion cannot go on.
    pub fn restore(&mut self, saved: &SavedState) -> Result<(), AdvanceError> {
        let SavedState { beginning, parameters, mark, instants } = saved;
        let held = HeldRun::new(beginning.clone(), |beginning| {
            let Beginning { simulation, start, .. } = &**beginning;
            Run::at_mark(simulation.problem(start), mark)
        });
        let (parameters, mark) = (parameters.clone(), mark.clone());
        *self = Self { held, parameters, mark, instants: Vec::new() };
        for &t in instants {
            self.hold_at(t, &|| false)?;
        }
        Ok(())
    }
}

impl SavedState {
    /// All that is not known from the start of the run, for [`Simulation::saved_state`].
    pub fn to_bytes(&self) -> Vec<u8> {
        let Self { beginning, parameters, mark, instants } = self;
        let mut saver = Saver::default();
        saver.slice(beginning.simulation.parameters());
        saver.flag(beginning.turn.is_some());
        if let Some((state, modes)) = &beginning.turn {
            saver.real(state.t);
            saver.slice(&state.q);
            saver.slice(&state.v);
            modes.save(&mut saver);
        }
        saver.slice(parameters);
        saver.slice(instants);
        saver.checkpoint(mark);
        saver.finish(Method::Explicit).to_bytes()
    }
}

impl Simulation {
    /// The state that [`SavedState::to_bytes`] has told of a run that began at this start, with the same values and
    /// options, to the last bit.
    ///
    /// # Errors
    /// [`UnreadableState`] when the bytes are of another run, or damaged.
    pub fn saved_state(&self, start: &Start, bytes: &[u8]) -> Result<SavedState, UnreadableState> {
        let no_start =
            |error: StartError| UnreadableState::NoMotion(Box::new(self.diagnose_start(&error)));
        let start = self.up_to_date(start).map_err(no_start)?.into_owned();
        let first = Beginning { simulation: self.without_outputs(), start, turn: None };
        let numbers = Checkpoint::from_bytes(bytes)?;
        let mut loader = Loader::new(&numbers, Method::Explicit)?;
        let mut values = first.simulation.parameters().to_vec();
        loader.fill(&mut values)?;
        let beginning = if loader.flag()? {
            let mut state =
                State { t: loader.real()?, q: first.start.q.clone(), v: first.start.v.clone() };
            loader.fill(&mut state.q)?;
            loader.fill(&mut state.v)?;
            let mut modes = first.start.modes.clone();
            modes.load(&mut loader)?;
            let next = first.going_on(&values, (state, modes));
            next.map_err(|fault| UnreadableState::NoMotion(Box::new(fault)))?
        } else {
            first
        };
        loader.fill(&mut values)?;
        let instants = loader.slice()?.to_vec();
        let mark = loader.checkpoint()?;
        // Numbers of another mechanism are found here.
        Run::try_at_mark(beginning.simulation.problem(&beginning.start), &mark)?;
        Ok(SavedState { beginning: Arc::new(beginning), parameters: values, mark, instants })
    }
}
