//! Events: zero crossings `g_i(t, y) = 0` along the run, what happens there, and runs with them.
//!
//! Every accepted step is searched on its dense output (see `search`), in the order of time. An
//! event may go unnoticed by the solution, end the run, or change the state: then the run goes on
//! from the changed state as from a start.

mod chatter;
mod search;

use self::chatter::Recent;
pub use self::search::EventSearch;
use crate::{
    Control, End, ExplicitSolver, Ode, Outcome, SolveError, Solver, Start, Stats, Step, System,
};

/// Which crossings of zero count, in the direction of the run.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Crossing {
    /// From negative to positive.
    Rising,
    /// From positive to negative.
    Falling,
    /// Both.
    #[default]
    Either,
}

/// A crossing that was found.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Event {
    /// Which function, counted from zero.
    pub i: usize,
    /// When, to a few units of rounding of `t`, on the far side of the crossing.
    pub t: f64,
    /// [`Crossing::Rising`] or [`Crossing::Falling`].
    pub crossing: Crossing,
}

/// What happens at an event.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Action {
    /// The run goes on; changes of the state are ignored.
    Continue,
    /// The run goes on from the state as changed by the handler.
    Restart,
    /// The run ends here.
    Stop,
}

/// Events by one function that accumulate: an impact that never comes to rest, or a switch thrown
/// forth and back.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Chatter {
    /// Which function.
    pub i: usize,
    /// Time between the last two events.
    pub interval: f64,
    /// Where the events accumulate, if their intervals shrink like a geometric series.
    pub limit: Option<f64>,
}

/// The events of a run: functions of the state, and what to do when one crosses zero.
pub trait Events {
    /// Number of functions.
    fn count(&self) -> usize;

    /// The crossings of function `i` that count.
    fn crossing(&self, _i: usize) -> Crossing {
        Crossing::Either
    }

    /// Name of function `i` for messages.
    fn name(&self, i: usize) -> String {
        format!("event {i}")
    }

    /// Writes the functions at a state to `out`. They should be continuous; a value that is not
    /// finite counts as no crossing.
    fn values(&mut self, t: f64, y: &[f64], out: &mut [f64]);

    /// What happens at `event`. The state may be changed; it must then be consistent again, `ydot`
    /// included where the equations are implicit.
    fn handle(&mut self, event: &Event, state: &mut Start) -> Action;

    /// What happens when events accumulate, in place of [`Events::handle`]; a restart should have
    /// changed the equations so that they end. `None`, the default, ends the run with
    /// [`SolveError::Chatter`].
    fn accumulate(&mut self, _chatter: &Chatter, _state: &mut Start) -> Option<Action> {
        None
    }
}

/// When events count as accumulating.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ChatterSettings {
    /// So many restarts in sequence, each by the same function. Default 10; range `≥ 2`.
    pub count: usize,
    /// Each within this time of the one before. Default `None`: 1e-6 of the length of the run.
    pub interval: Option<f64>,
}

impl Default for ChatterSettings {
    fn default() -> Self {
        Self { count: 10, interval: None }
    }
}

/// A method that advances a solution step by step.
pub trait Integrator {
    /// Takes one accepted step; `None` once the end is reached.
    ///
    /// # Errors
    /// [`SolveError`] when the run cannot go on.
    fn step(&mut self) -> Result<Option<Step<'_>>, SolveError>;

    /// Goes on from another state, as from a start.
    ///
    /// # Errors
    /// [`SolveError`] when the state does not fit.
    fn restart(&mut self, state: &Start) -> Result<(), SolveError>;

    /// Time, state and derivative reached.
    fn reached(&self) -> Start;

    /// Where the run is to end.
    fn t_end(&self) -> f64;

    /// Work done so far.
    fn stats(&self) -> Stats;
}

impl<S: System> Integrator for Solver<S> {
    fn step(&mut self) -> Result<Option<Step<'_>>, SolveError> {
        Self::step(self)
    }

    fn restart(&mut self, state: &Start) -> Result<(), SolveError> {
        Self::restart(self, state)
    }

    fn reached(&self) -> Start {
        Start { t: self.t(), y: self.y().to_vec(), ydot: self.ydot().to_vec() }
    }

    fn t_end(&self) -> f64 {
        Self::t_end(self)
    }

    fn stats(&self) -> Stats {
        *Self::stats(self)
    }
}

impl<S: Ode> Integrator for ExplicitSolver<S> {
    fn step(&mut self) -> Result<Option<Step<'_>>, SolveError> {
        Self::step(self)
    }

    fn restart(&mut self, state: &Start) -> Result<(), SolveError> {
        Self::restart(self, state.t, &state.y)
    }

    fn reached(&self) -> Start {
        Start { t: self.t(), y: self.y().to_vec(), ydot: self.ydot().to_vec() }
    }

    fn t_end(&self) -> f64 {
        Self::t_end(self)
    }

    fn stats(&self) -> Stats {
        *Self::stats(self)
    }
}

/// The end of a run with events.
#[derive(Clone, PartialEq, Debug)]
pub struct EventOutcome {
    /// Where and why it ended.
    pub outcome: Outcome,
    /// The event that ended it, if one did.
    pub terminal: Option<Event>,
    /// Events handled.
    pub n_events: usize,
}

/// Integrates to the end with events; `observer` sees every accepted step, one that an event cuts
/// short only up to that event.
///
/// # Errors
/// [`SolveError`], with [`SolveError::Chatter`] when events accumulate.
pub fn solve_events<I: Integrator, E: Events>(
    integrator: &mut I,
    events: &mut E,
    settings: ChatterSettings,
    observer: &mut dyn FnMut(&Step<'_>) -> Control,
) -> Result<EventOutcome, SolveError> {
    let mut state = integrator.reached();
    let interval = settings.interval.unwrap_or(1e-6 * (integrator.t_end() - state.t).abs());
    let mut recent = Recent::new(settings.count.max(2), interval);
    let mut search = EventSearch::new(events, &state);
    let mut n_events = 0;
    let ended = |end, state: &Start, stats, terminal, n_events| {
        let Start { t, y, ydot } = state.clone();
        EventOutcome { outcome: Outcome { end, t, y, ydot, stats }, terminal, n_events }
    };
    while let Some(step) = integrator.step()? {
        let found = search.crossings(events, &step);
        let Passed { action, event, n } = pass(events, &mut recent, found, &step, &mut state)?;
        n_events += n;

        // A step that ends at an event is shown up to there, as it was before the change.
        let control = match (action, event) {
            (Action::Continue, _) | (_, None) => observer(&step),
            (_, Some(event)) => {
                let before = search.state_at(&step, event.t);
                observer(&step.until(event.t, &before.y, &before.ydot))
            }
        };
        let is_over = control == Control::Stop;
        match action {
            Action::Continue if is_over => break,
            Action::Continue => (),
            Action::Restart => {
                integrator.restart(&state)?;
                search.restart(events, &state);
                if is_over {
                    break;
                }
            }
            Action::Stop => {
                return Ok(ended(End::Stopped, &state, integrator.stats(), event, n_events));
            }
        }
    }
    let reached = integrator.reached();
    let end = if reached.t == integrator.t_end() { End::Reached } else { End::Stopped };
    Ok(ended(end, &reached, integrator.stats(), None, n_events))
}

/// What the events of a step have led to.
struct Passed {
    action: Action,
    /// The event that decided.
    event: Option<Event>,
    /// Events handled.
    n: usize,
}

/// Handles the events of a step in their order, up to the first that changes something; others at
/// the same instant are handled with it. `state` is left as changed.
fn pass<E: Events>(
    events: &mut E,
    recent: &mut Recent,
    found: &[Event],
    step: &Step<'_>,
    state: &mut Start,
) -> Result<Passed, SolveError> {
    let mut passed = Passed { action: Action::Continue, event: None, n: 0 };
    for event in found {
        match passed.event {
            Some(first) if !search::is_same_instant(first.t, event.t) => break,
            Some(_) => (),
            None => {
                state.t = event.t;
                step.at(event.t, &mut state.y);
                step.derivative_at(event.t, &mut state.ydot);
            }
        }
        passed.n += 1;
        let action = match recent.observe(event) {
            None => events.handle(event, state),
            Some(chatter) => events.accumulate(&chatter, state).ok_or_else(|| {
                let name = events.name(event.i);
                SolveError::Chatter { name, t: event.t, chatter }
            })?,
        };
        if action != Action::Continue {
            recent.note(event);
            passed.event = Some(passed.event.unwrap_or(*event));
            // The strongest wish wins.
            if passed.action != Action::Stop {
                passed.action = action;
            }
        }
    }
    Ok(passed)
}
