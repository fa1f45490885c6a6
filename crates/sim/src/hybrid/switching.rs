//! The modes of a run, from event to event.

use bksim_dae::{Loader, Saver, SolveError, Step};

use super::bands::Bands;
use super::consistent::{ConsistentModes, Hit, Instant, NoConsistentModes};
use super::fixed::FixedModes;
use super::mode_search::consistent_modes;
use super::monitor::{Crossed, EventMonitor};
use super::signs::{signed_modes, take_signs};
use crate::compiled::CompiledSystem;
use crate::half_turns::HalfTurn;
use crate::modes::indicators::{Indicator, IndicatorEvaluator};
use crate::modes::{ContactMode, Modes};
use crate::sampled::{Sampling, Tick};
use bksim_model::{LoadId, SolveOptions};

/// Something that switched during a run.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Change {
    /// When, s.
    pub t: f64,
    /// The switch or contact, and how it changed.
    pub kind: ChangeKind,
}

/// A switch or contact, and how it changed.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum ChangeKind {
    /// An expression went over a kink or a jump: the switch of this index.
    Kink(usize),
    /// Bodies hit a stop at this speed of approach, m/s or rad/s.
    Hit(LoadId, f64),
    /// They came to rest on it.
    Rest(LoadId),
    /// They left it.
    Part(LoadId),
    /// A motion with friction came to rest.
    Stick(LoadId),
    /// It began to slide.
    Slide(LoadId),
}

/// The modes of a run, with a memory of its events.
#[derive(Clone, Debug)]
pub(crate) struct Switching<'a> {
    compiled: &'a CompiledSystem,
    /// The model's own parameters.
    own: Vec<f64>,
    /// The model's own parameters, then the numbers of the modes.
    pub(crate) parameters: Vec<f64>,
    modes: Modes,
    bands: Bands,
    atol: f64,
    rtol: f64,
    /// Fastest approach to a stop so far, m/s or rad/s.
    fastest: f64,
    /// Events closer together than this, s, count as no progress.
    shortest: f64,
    /// How far ahead, s, a kink may lie that a motion without values ran into.
    reach: f64,
    last_event: f64,
    n_short: usize,
    evaluator: IndicatorEvaluator<'a>,
    sampling: Sampling<'a>,
}

impl Change {
    pub(crate) fn save(&self, saver: &mut Saver) {
        let (kind, of, speed) = match self.kind {
            ChangeKind::Kink(kink) => (0, kink, 0.0),
            ChangeKind::Hit(load, speed) => (1, load.0, speed),
            ChangeKind::Rest(load) => (2, load.0, 0.0),
            ChangeKind::Part(load) => (3, load.0, 0.0),
            ChangeKind::Stick(load) => (4, load.0, 0.0),
            ChangeKind::Slide(load) => (5, load.0, 0.0),
        };
        saver.real(self.t);
        saver.indices(&[kind, of]);
        saver.real(speed);
    }

    /// A change of this system.
    pub(crate) fn load(
        loader: &mut Loader<'_>,
        compiled: &CompiledSystem,
    ) -> Result<Self, SolveError> {
        const OTHER: SolveError = SolveError::Checkpoint { reason: "saved with other contacts" };
        let t = loader.real()?;
        let [kind, of] = loader.indices(usize::MAX)?[..] else { return Err(OTHER) };
        let speed = loader.real()?;
        let load = LoadId(of);
        let is_known = match kind {
            0 => of < compiled.indicators.switches.len(),
            _ => compiled.indicators.contacts.iter().any(|contact| contact.load == load),
        };
        let kind = match kind {
            0 => ChangeKind::Kink(of),
            1 => ChangeKind::Hit(load, speed),
            2 => ChangeKind::Rest(load),
            3 => ChangeKind::Part(load),
            4 => ChangeKind::Stick(load),
            5 => ChangeKind::Slide(load),
            _ => return Err(OTHER),
        };
        if is_known { Ok(Self { t, kind }) } else { Err(OTHER) }
    }
}

/// Friction below zero by as many bands of its reaction is rounding: of that it is μ times.
const BANDS_OF_FRICTION: f64 = 10.0;
/// Events without progress after which a run is given up.
const MAX_SHORT: usize = 1000;
/// Part of a run that counts as no progress.
const NO_PROGRESS: f64 = 1e-10;
/// Part of a run within which steps without a value stop short of a kink: a shrunken step is far
/// smaller, and the motion over this time a parabola.
const REACH: f64 = 1e-6;

impl<'a> Switching<'a> {
    /// The modes of a run that starts at (t, q, v) in `modes`, with these multipliers.
    pub(crate) fn new(
        compiled: &'a CompiledSystem,
        own: &[f64],
        options: &SolveOptions,
        modes: &Modes,
        (t, q, v): (f64, &[f64], &[f64]),
        lambda: &[f64],
    ) -> Self {
        let mut parameters = modes.parameters_with_modes(own);
        let mut evaluator = compiled.indicators.at(&parameters);
        let tolerances = (options.atol, options.rtol);
        let bands = Bands::new(tolerances, evaluator.values(t, q, v), &compiled.indicators);
        let mut modes = modes.clone();
        if compiled.indicators.of_multipliers().next().is_some() {
            take_signs((compiled, own, &bands), (t, q, v), lambda, &mut modes);
            parameters = modes.parameters_with_modes(own);
            evaluator = compiled.indicators.at(&parameters);
        }
        let length = (options.t_end - t).abs();
        Self {
            compiled,
            own: own.to_vec(),
            parameters,
            modes,
            bands,
            atol: options.atol,
            rtol: options.rtol,
            fastest: 0.0,
            shortest: NO_PROGRESS * length,
            reach: REACH * length,
            last_event: f64::NEG_INFINITY,
            n_short: 0,
            evaluator,
            sampling: compiled.sampling(own),
        }
    }

    /// Saves the modes and the memory of events.
    pub(crate) fn save(&self, saver: &mut Saver) {
        self.modes.save(saver);
        let Bands { kinks, position, rate, rest, .. } = &self.bands;
        saver.slice(kinks);
        saver.slice(&[*position, *rate, rest[0], rest[1], self.fastest, self.last_event]);
        saver.count(self.n_short);
    }

    /// Goes on with the numbers saved in another run of the same mechanism.
    pub(crate) fn load(&mut self, loader: &mut Loader<'_>) -> Result<(), SolveError> {
        self.modes.load(loader)?;
        loader.fill(&mut self.bands.kinks)?;
        let mut numbers = [0.0; 6];
        loader.fill(&mut numbers)?;
        let [position, rate, height, speed, fastest, last_event] = numbers;
        (self.bands.position, self.bands.rate) = (position, rate);
        self.bands.rest = [height, speed];
        (self.fastest, self.last_event) = (fastest, last_event);
        self.n_short = loader.count()?;
        self.rebind();
        Ok(())
    }

    /// The monitor of a phase that starts at (t, q, v); `None` when nothing ever switches.
    pub(crate) fn monitor(
        &self,
        inactive: &[usize],
        at: (f64, &[f64], &[f64]),
    ) -> Option<EventMonitor<'a>> {
        let Self { compiled, parameters, modes, bands, .. } = self;
        let is_needed = !compiled.indicators.is_empty();
        is_needed.then(|| EventMonitor::new(compiled, parameters, modes, inactive, bands, at))
    }

    /// The kink that a motion without a value ahead is about to reach, and the state there.
    pub(crate) fn kink_ahead(
        &mut self,
        t: &mut f64,
        q: &mut [f64],
        v: &mut [f64],
        inactive: &[usize],
    ) -> Option<Crossed> {
        if self.modes.signs.is_empty() {
            return None;
        }
        // u + dt u′ = 0, in the modes and with the accelerations of this state.
        let mut fixed = FixedModes::new(self.compiled, &self.parameters);
        let a = &fixed.acceleration((*t, q, v), inactive)?.a;
        let kinks = self.evaluator.values(*t, q, v).kinks.clone();
        let rates = self.evaluator.rates(*t, q, v, a).kinks;
        let times = kinks.iter().zip(rates).map(|(u, rate)| -u / rate).enumerate();
        let ahead = times.filter(|(_, dt)| (0.0..=self.reach).contains(dt));
        let (kink, dt) = ahead.min_by(|a, b| a.1.total_cmp(&b.1))?;
        *t += dt;
        for i in 0..q.len() {
            q[i] += dt * (v[i] + 0.5 * dt * a[i]);
            v[i] += dt * a[i];
        }
        Some(Crossed { t: *t, fired: vec![Indicator::Kink(kink)] })
    }

    /// Passes the event that ended a phase at (t, q, v); `changes` gains what happened.
    ///
    /// # Errors
    /// [`NoConsistentModes`] when the motion cannot go on.
    pub(crate) fn pass(
        &mut self,
        fired: &[Indicator],
        (t, q, v): (f64, Vec<f64>, Vec<f64>),
        changes: &mut Vec<Change>,
    ) -> Result<ConsistentModes, NoConsistentModes> {
        self.check_progress(fired, t)?;
        let holding = self.compiled.latches.holding(&self.own, &self.modes);
        self.enter(fired, holding, (t, q, v), changes)
    }

    /// The tick that comes next.
    pub(crate) fn next_tick(&self) -> Option<Tick> {
        self.sampling.next(&self.modes.held)
    }

    /// Takes the values of sampled signals at a tick; `None` where nothing else can change by that.
    ///
    /// # Errors
    /// [`NoConsistentModes`] when the motion cannot go on.
    pub(crate) fn tick(
        &mut self,
        (t, q, v): (f64, Vec<f64>, Vec<f64>),
        changes: &mut Vec<Change>,
    ) -> Result<Option<ConsistentModes>, NoConsistentModes> {
        let holding = self.compiled.latches.holding(&self.own, &self.modes);
        self.sampling.tick(t, &q, &v, &mut self.modes.held)?;
        self.rebind();
        if self.compiled.indicators.is_empty() {
            return Ok(None);
        }
        self.enter(&[], holding, (t, q, v), changes).map(Some)
    }

    /// True if ropes or belts have turns to count.
    pub(crate) fn counts_half_turns(&self) -> bool {
        self.sampling.counts_half_turns()
    }

    /// The first half turn of a rope or belt that is to be counted in a step.
    pub(crate) fn half_turn_in(&mut self, step: &Step<'_>) -> Option<HalfTurn> {
        self.sampling.half_turn_in(step, &self.modes.held)
    }

    /// Counts the half turns of ropes and belts up to a state.
    pub(crate) fn count_half_turns(&mut self, t: f64, q: &[f64]) {
        self.sampling.count_half_turns(t, q, &mut self.modes.held);
        self.rebind();
    }

    /// Finds the modes from an instant on, before which these conditions held, and takes them.
    fn enter(
        &mut self,
        fired: &[Indicator],
        holding: Vec<bool>,
        (t, q, v): (f64, Vec<f64>, Vec<f64>),
        changes: &mut Vec<Change>,
    ) -> Result<ConsistentModes, NoConsistentModes> {
        // Bands follow the largest values of the switches so far.
        let values = self.evaluator.values(t, &q, &v);
        let wider = Bands::new((self.atol, self.rtol), values, &self.compiled.indicators);
        for (band, now) in self.bands.kinks.iter_mut().zip(wider.kinks) {
            *band = band.max(now);
        }
        // Bounces that the tolerances cannot tell from rest.
        self.bands.rest = [self.atol, self.atol.max(self.rtol * self.fastest)];

        // The modes from here on.
        let instant = Instant {
            compiled: self.compiled,
            parameters: &self.own,
            t,
            q,
            v,
            before: &self.modes,
            fired,
            bands: self.bands.clone(),
        };
        let found = signed_modes(instant, holding, consistent_modes)?;
        for hit in &found.hits {
            self.fastest = self.fastest.max(hit.speed);
        }
        self.note(t, fired, &found, changes);
        self.modes.clone_from(&found.modes);
        self.rebind();
        Ok(found)
    }

    /// Binds the indicators to the modes.
    fn rebind(&mut self) {
        self.parameters = self.modes.parameters_with_modes(&self.own);
        self.evaluator = self.compiled.indicators.at(&self.parameters);
    }

    /// Writes the multipliers of friction that slips, which is a load in the equations. Returns friction whose size is
    /// below zero.
    pub(crate) fn fill_slip_friction(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        lambda: &mut [f64],
    ) -> Option<LoadId> {
        // With the sign of a reaction that is held, F is below zero by as much as that is known to.
        let held = self.compiled.indicators.of_multipliers();
        let slack = held.map(|k| self.bands.of_multipliers(k, lambda)).fold(0.0, f64::max);
        let slack = BANDS_OF_FRICTION * slack;
        self.evaluator.fill_slip_friction(&self.modes, (t, q, v), lambda, slack)
    }

    /// The modes that hold.
    pub(crate) fn modes_now(&self) -> &Modes {
        &self.modes
    }

    /// The numbers of the modes.
    pub(crate) fn modes(&self) -> &[f64] {
        &self.parameters[self.own.len()..]
    }

    /// Counts events in quick succession: a run that makes no progress is given up.
    fn check_progress(&mut self, fired: &[Indicator], t: f64) -> Result<(), NoConsistentModes> {
        let is_short = (t - self.last_event).abs() <= self.shortest;
        self.n_short = if is_short { self.n_short + 1 } else { 0 };
        self.last_event = t;
        if self.n_short < MAX_SHORT {
            return Ok(());
        }
        Err(match fired.first() {
            Some(&Indicator::Kink(kink)) => NoConsistentModes::Chatter { kink },
            Some(&Indicator::Contact(contact)) => {
                NoConsistentModes::Contacts { contacts: vec![contact] }
            }
            None => NoConsistentModes::Contacts { contacts: Vec::new() },
        })
    }

    /// Notes kinks, hits, and contacts that have changed their mode.
    fn note(
        &self,
        t: f64,
        fired: &[Indicator],
        found: &ConsistentModes,
        changes: &mut Vec<Change>,
    ) {
        let contacts = &self.compiled.indicators.contacts;
        let mut add = |kind| changes.push(Change { t, kind });
        for indicator in fired {
            // A force that turns round in a joint is no event of the model.
            if let Indicator::Kink(kink) = indicator
                && !self.compiled.indicators.is_of_multipliers(*kink)
            {
                add(ChangeKind::Kink(*kink));
            }
        }
        for &Hit { contact, speed } in &found.hits {
            add(ChangeKind::Hit(contacts[contact].load, speed));
        }
        let modes = self.modes.contacts.iter().zip(&found.modes.contacts);
        for (k, (contact, (before, after))) in contacts.iter().zip(modes).enumerate() {
            // The first of two directions stands for both.
            if contact.other.is_some_and(|other| other < k) {
                continue;
            }
            let load = contact.load;
            match (before, after) {
                (ContactMode::Open, ContactMode::Closed) => add(ChangeKind::Rest(load)),
                (ContactMode::Closed, ContactMode::Open) => add(ChangeKind::Part(load)),
                (ContactMode::Slip(_), ContactMode::Stick(_)) => add(ChangeKind::Stick(load)),
                (ContactMode::Stick(_), ContactMode::Slip(_)) => add(ChangeKind::Slide(load)),
                _ => (),
            }
        }
    }
}
