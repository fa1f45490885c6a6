//! The modes of a run, from event to event.

use bksim_dae::{Loader, Saver, SolveError};

use super::fixed::Frozen;
use super::indicators::{Decider, Watcher};
use super::mode_search::{Bands, Instant, Settled, Unsettled, settle};
use super::modes::{Modes, Touch};
use super::monitor::{Crossed, Lookout};
use crate::compiled::CompiledSystem;
use crate::start::Start;
use bksim_model::{LoadId, SolveOptions};

/// Something that switched during a run.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Change {
    /// When, s.
    pub t: f64,
    /// What.
    pub kind: ChangeKind,
}

/// What can switch.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum ChangeKind {
    /// An expression went over a kink or a jump: the switch of this place.
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

/// The modes of a run and what is remembered of its events.
#[derive(Clone, Debug)]
pub(crate) struct Switching<'a> {
    compiled: &'a CompiledSystem,
    /// The model's own parameters.
    own: Vec<f64>,
    /// The model's own parameters with the modes behind them.
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
    watcher: Watcher<'a>,
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
            0 => of < compiled.watch.timed.len(),
            _ => compiled.watch.contacts.iter().any(|contact| contact.load == load),
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

/// Events without progress after which a run is given up.
const MAX_SHORT: usize = 1000;
/// Part of a run that counts as no progress.
const NO_PROGRESS: f64 = 1e-10;
/// Part of a run within which steps without a value stop short of a kink: a shrunken step is far
/// smaller, and the motion over this time a parabola.
const REACH: f64 = 1e-6;

impl<'a> Switching<'a> {
    pub(crate) fn new(
        compiled: &'a CompiledSystem,
        own: &[f64],
        options: &SolveOptions,
        start: &Start,
    ) -> Self {
        let modes = start.modes.clone();
        let parameters = modes.behind(own);
        let mut watcher = compiled.watch.at(&parameters);
        let view = watcher.view(start.t, &start.q, &start.v).clone();
        Self {
            compiled,
            own: own.to_vec(),
            parameters,
            modes,
            bands: Bands::new(options.atol, &view, &compiled.watch),
            atol: options.atol,
            rtol: options.rtol,
            fastest: 0.0,
            shortest: NO_PROGRESS * (options.t_end - start.t).abs(),
            reach: REACH * (options.t_end - start.t).abs(),
            last_event: f64::NEG_INFINITY,
            n_short: 0,
            watcher,
        }
    }

    /// The modes and what is remembered.
    pub(crate) fn save(&self, saver: &mut Saver) {
        self.modes.save(saver);
        let Bands { kinks, position, rate, rest } = &self.bands;
        saver.slice(kinks);
        saver.slice(&[*position, *rate, rest[0], rest[1], self.fastest, self.last_event]);
        saver.count(self.n_short);
    }

    /// Goes on with what was saved in another run of the same mechanism.
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
        self.parameters = self.modes.behind(&self.own);
        self.watcher = self.compiled.watch.at(&self.parameters);
        Ok(())
    }

    /// What ends a leg that starts at (t, q, v); `None` when nothing ever switches.
    pub(crate) fn lookout(
        &self,
        dependent: &[usize],
        at: (f64, &[f64], &[f64]),
    ) -> Option<Lookout<'a>> {
        let Self { compiled, parameters, modes, bands, .. } = self;
        let is_needed = !compiled.watch.is_empty();
        is_needed.then(|| Lookout::new(compiled, parameters, modes, dependent, bands, at))
    }

    /// The kink that a motion without a value ahead is about to reach, and the state there.
    pub(crate) fn kink_ahead(
        &mut self,
        t: &mut f64,
        q: &mut [f64],
        v: &mut [f64],
        dependent: &[usize],
    ) -> Option<Crossed> {
        if self.modes.signs.is_empty() {
            return None;
        }
        let mut frozen = Frozen::new(self.compiled, &self.parameters);
        let (a, _) = frozen.accelerations((*t, q, v), dependent)?;
        let kinks = self.watcher.view(*t, q, v).kinks.clone();
        let rates = self.watcher.rates(*t, q, v, &a);
        let times = kinks.iter().zip(rates).map(|(u, rate)| -u / rate).enumerate();
        let ahead = times.filter(|(_, dt)| (0.0..=self.reach).contains(dt));
        let (kink, dt) = ahead.min_by(|a, b| a.1.total_cmp(&b.1))?;
        *t += dt;
        for i in 0..q.len() {
            q[i] += dt * (v[i] + 0.5 * dt * a[i]);
            v[i] += dt * a[i];
        }
        Some(Crossed { t: *t, fired: vec![Decider::Kink(kink)] })
    }

    /// Passes the event that ended a leg at (t, q, v); `changes` gains what happened.
    ///
    /// # Errors
    /// [`Unsettled`] when the motion cannot go on.
    pub(crate) fn pass(
        &mut self,
        fired: &[Decider],
        (t, q, v): (f64, Vec<f64>, Vec<f64>),
        changes: &mut Vec<Change>,
    ) -> Result<Settled, Unsettled> {
        self.check_progress(fired, t)?;
        let view = self.watcher.view(t, &q, &v).clone();
        let wider = Bands::new(self.atol, &view, &self.compiled.watch);
        for (band, now) in self.bands.kinks.iter_mut().zip(wider.kinks) {
            *band = band.max(now);
        }
        // Bounces that the tolerances cannot tell from rest.
        self.bands.rest = [self.atol, self.atol.max(self.rtol * self.fastest)];
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
        let settled = settle(instant)?;
        for &(_, speed) in &settled.hits {
            self.fastest = self.fastest.max(speed);
        }
        self.note(t, fired, &settled, changes);
        self.modes.clone_from(&settled.modes);
        self.parameters = self.modes.behind(&self.own);
        self.watcher = self.compiled.watch.at(&self.parameters);
        Ok(settled)
    }

    /// Friction that slides shows as its multiplier, which it has not in the equations.
    pub(crate) fn fill_friction(&mut self, t: f64, q: &[f64], v: &[f64], lambda: &mut [f64]) {
        self.modes.fill_friction(&mut self.watcher, (t, q, v), lambda);
    }

    /// The modes as they stand behind the model's own parameters.
    pub(crate) fn modes(&self) -> &[f64] {
        &self.parameters[self.own.len()..]
    }

    fn check_progress(&mut self, fired: &[Decider], t: f64) -> Result<(), Unsettled> {
        let is_short = (t - self.last_event).abs() <= self.shortest;
        self.n_short = if is_short { self.n_short + 1 } else { 0 };
        self.last_event = t;
        if self.n_short < MAX_SHORT {
            return Ok(());
        }
        Err(match fired.first() {
            Some(&Decider::Kink(kink)) => Unsettled::Chatter { kink },
            Some(&Decider::Contact(contact)) => Unsettled::Contacts { contacts: vec![contact] },
            None => Unsettled::Contacts { contacts: Vec::new() },
        })
    }

    fn note(&self, t: f64, fired: &[Decider], settled: &Settled, changes: &mut Vec<Change>) {
        let contacts = &self.compiled.watch.contacts;
        let mut add = |kind| changes.push(Change { t, kind });
        for decider in fired {
            if let Decider::Kink(kink) = decider {
                add(ChangeKind::Kink(*kink));
            }
        }
        for &(k, speed) in &settled.hits {
            add(ChangeKind::Hit(contacts[k].load, speed));
        }
        let touches = self.modes.touches.iter().zip(&settled.modes.touches);
        for (contact, (before, after)) in contacts.iter().zip(touches) {
            let load = contact.load;
            match (before, after) {
                (Touch::Apart, Touch::Resting) => add(ChangeKind::Rest(load)),
                (Touch::Resting, Touch::Apart) => add(ChangeKind::Part(load)),
                (Touch::Sliding(_), Touch::Sticking(_)) => add(ChangeKind::Stick(load)),
                (Touch::Sticking(_), Touch::Sliding(_)) => add(ChangeKind::Slide(load)),
                _ => (),
            }
        }
    }
}
