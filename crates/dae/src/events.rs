//! Events: zero crossings `g_i(t, y) = 0` along the run, what happens there, and runs with them.
//!
//! Every accepted step is searched on its dense output (see `search`), in the order of time. An
//! event may go unnoticed by the solution, end the run, or change the state: then the run goes on
//! from the changed state as from a start.

mod chatter;
mod search;

use self::chatter::Recent;
pub use self::search::EventSearch;
use crate::checkpoint::{Checkpoint, Loader, Saver};
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

/// Events that accumulate: an impact that never comes to rest, a switch thrown forth and back, or
/// two that throw each other.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Chatter {
    /// Which function fired last.
    pub i: usize,
    /// Another one that takes turns with it.
    pub with: Option<usize>,
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
    /// So many restarts in sequence, by one function or by several in turn. Default 10; range `≥ 2`.
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
    /// Events handled since the call.
    pub n_events: usize,
}

/// What a run with events remembers between two steps, beside the state of its integrator: which
/// functions are at zero, and the restarts that may be the beginning of chatter.
///
/// [`continue_events`] leaves it so that another call goes on as if there had been none in between;
/// a [`Checkpoint`] carries it to another process. What the [`Events`] themselves remember is
/// theirs to save.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct EventMemory {
    inner: Option<Memory>,
}

#[derive(Clone, PartialEq, Debug)]
struct Memory {
    recent: Recent,
    /// The functions at the state reached; zero where one has just fired.
    values: Vec<f64>,
    is_fresh: bool,
}

impl EventMemory {
    /// Adds what is remembered to the checkpoint of an integrator.
    #[must_use]
    pub fn save_with(&self, mut checkpoint: Checkpoint) -> Checkpoint {
        let mut saver = Saver::default();
        if let Some(Memory { recent, values, is_fresh }) = &self.inner {
            recent.save(&mut saver);
            saver.slice(values);
            saver.flag(*is_fresh);
        }
        checkpoint.append_part(saver);
        checkpoint
    }

    /// What [`EventMemory::save_with`] has added.
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] when nothing was.
    pub fn of(checkpoint: &Checkpoint) -> Result<Self, SolveError> {
        let part = checkpoint.last_part()?;
        let mut loader = Loader::new(&part, part.method)?;
        if part.counts.is_empty() {
            return Ok(Self::default());
        }
        let recent = Recent::load(&mut loader)?;
        let (values, is_fresh) = (loader.slice()?.to_vec(), loader.flag()?);
        Ok(Self { inner: Some(Memory { recent, values, is_fresh }) })
    }
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
    continue_events(integrator, events, settings, &mut EventMemory::default(), observer)
}

/// As [`solve_events`], going on from what `memory` holds: after the observer had stopped the run,
/// with the same or a resumed integrator, everything is bit for bit as if it had not. `settings`
/// are those of the first call, the length of the run included.
///
/// # Errors
/// [`SolveError`], with [`SolveError::Chatter`] when events accumulate, and
/// [`SolveError::Checkpoint`] when the memory belongs to other events.
pub fn continue_events<I: Integrator, E: Events>(
    integrator: &mut I,
    events: &mut E,
    settings: ChatterSettings,
    memory: &mut EventMemory,
    observer: &mut dyn FnMut(&Step<'_>) -> Control,
) -> Result<EventOutcome, SolveError> {
    let mut state = integrator.reached();
    let mut search = EventSearch::new(events, &state);
    let mut recent = match memory.inner.take() {
        None => {
            let span = (integrator.t_end() - state.t).abs();
            Recent::new(settings.count.max(2), settings.interval.unwrap_or(1e-6 * span))
        }
        Some(Memory { recent, values, is_fresh }) => {
            search.resume(&values, is_fresh)?;
            recent
        }
    };
    let mut n_events = 0;
    let mut terminal = None;
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
        match action {
            Action::Continue => (),
            Action::Restart => {
                integrator.restart(&state)?;
                search.restart(events, &state);
            }
            Action::Stop => {
                terminal = event;
                break;
            }
        }
        if control == Control::Stop {
            break;
        }
    }
    let (values, is_fresh) = search.remembered();
    memory.inner = Some(Memory { recent, values, is_fresh });
    let is_over = terminal.is_some();
    let Start { t, y, ydot } = if is_over { state } else { integrator.reached() };
    let is_end = !is_over && t == integrator.t_end();
    let end = if is_end { End::Reached } else { End::Stopped };
    let outcome = Outcome { end, t, y, ydot, stats: integrator.stats() };
    Ok(EventOutcome { outcome, terminal, n_events })
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
                let names = std::iter::once(chatter.i).chain(chatter.with);
                let names = names.map(|i| events.name(i)).collect();
                SolveError::Chatter { names, t: event.t, chatter }
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
