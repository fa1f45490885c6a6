//! [`EventMonitor`]: the indicators of one phase of a run, in which nothing switches.
//!
//! Every indicator is signed so that it is positive in the phase, and raised by a band of the size of
//! rounding, so that rounding about zero is no event; an event is where the indicator itself has passed
//! zero:
//!
//! ```text
//! kink       σ u                          λ of the accelerations where u is a function of multipliers
//! stop       −φ, −r apart          λ, r in contact        r: how far it reaches; the larger, the smaller of both
//! friction   ς p′ slipping         F₀ − |λ| sticking
//! ```

use bksim_dae::{Crossing, Event, EventSearch, Events, Loader, Saver, SolveError, Start, Step};

use super::bands::Bands;
use super::fixed::FixedModes;
use crate::compiled::CompiledSystem;
use crate::modes::indicators::{ContactState, Indicator, IndicatorEvaluator};
use crate::modes::{ContactMode, Modes};

/// Newtons for a metre by which a stop ends: a force is smaller until then.
const STEEP: f64 = 1e9;
/// Forces within this part of the largest are rounding.
const FORCE_BAND: f64 = 1e-9;

/// The indicators that first crossed zero, and when.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Crossed {
    /// s.
    pub(crate) t: f64,
    pub(crate) fired: Vec<Indicator>,
}

/// The signed indicators of one phase and the search for their crossings.
pub(crate) struct EventMonitor<'a> {
    indicators: SignedIndicators<'a>,
    /// Made with the first step.
    search: Option<EventSearch>,
}

impl<'a> EventMonitor<'a> {
    /// The monitor of a phase that starts at (t, q, v); `parameters` end with the modes.
    pub(crate) fn new(
        compiled: &'a CompiledSystem,
        parameters: &[f64],
        modes: &Modes,
        inactive: &[usize],
        bands: &Bands,
        (t, q, v): (f64, &[f64], &[f64]),
    ) -> Self {
        let mut indicators = SignedIndicators {
            evaluator: compiled.indicators.at(parameters),
            compiled,
            fixed: FixedModes::new(compiled, parameters),
            nq: q.len(),
            modes: modes.clone(),
            inactive: inactive.to_vec(),
            bands: vec![0.0; modes.signs.len() + modes.contacts.len()],
            lambda: Vec::new(),
        };
        indicators.raise(bands, (t, q, v));
        Self { indicators, search: None }
    }

    /// Saves how far the phase has come.
    pub(crate) fn save(&self, saver: &mut Saver) {
        let Self { indicators, search } = self;
        saver.slice(&indicators.bands);
        saver.flag(search.is_some());
        if let Some(search) = search {
            let (values, is_fresh) = search.remembered();
            saver.slice(&values);
            saver.flag(is_fresh);
        }
        indicators.fixed.save(saver);
    }

    /// Goes on with the numbers saved where the phase has come to; `state` is the integrator's.
    pub(crate) fn load(
        &mut self,
        loader: &mut Loader<'_>,
        state: &Start,
    ) -> Result<(), SolveError> {
        let Self { indicators, search } = self;
        loader.fill(&mut indicators.bands)?;
        if loader.flag()? {
            let mut resumed = EventSearch::new(indicators, state);
            resumed.resume(loader.slice()?, loader.flag()?)?;
            *search = Some(resumed);
        }
        let SignedIndicators { fixed, inactive, .. } = indicators;
        fixed.load(loader, inactive)
    }

    /// The indicators that first cross zero in a step.
    pub(crate) fn first_in(&mut self, step: &Step<'_>) -> Option<Crossed> {
        let Self { indicators, search } = self;
        let search = search.get_or_insert_with(|| {
            let (y, ydot) = (step.y0().to_vec(), step.ydot1().to_vec());
            EventSearch::new(indicators, &Start { t: step.t0(), y, ydot })
        });
        let found = search.first_crossings(indicators, step);
        let t = found.first()?.t;
        let is_now = |event: &&Event| (event.t - t).abs() <= SAME_INSTANT * t.abs();
        let events = found.iter().take_while(is_now);
        Some(Crossed { t, fired: events.map(|event| indicators.indicator(event.i)).collect() })
    }
}

/// Events this near to one another, as a part of t, are one.
const SAME_INSTANT: f64 = 16.0 * f64::EPSILON;

/// The indicators of fixed modes as functions that are positive while the modes last.
struct SignedIndicators<'a> {
    evaluator: IndicatorEvaluator<'a>,
    compiled: &'a CompiledSystem,
    fixed: FixedModes<'a>,
    nq: usize,
    modes: Modes,
    /// Rows of open contacts, and rows that follow from others.
    inactive: Vec<usize>,
    /// The amount that each indicator is raised by.
    bands: Vec<f64>,
    /// The multipliers at the state that they were last evaluated at; empty where they were not needed, or there are none.
    lambda: Vec<f64>,
}

impl SignedIndicators<'_> {
    /// Raises every indicator by its band, and by what it lacks to zero at the start of the phase:
    /// that is on the right side whatever rounding says.
    ///
    /// Friction that begins to slip at rest may be of a motion that other rows hold, which drifts as they do.
    fn raise(&mut self, bands: &Bands, (t, q, v): (f64, &[f64], &[f64])) {
        let mut start = vec![0.0; self.bands.len()];
        let force = self.signed_into(t, q, v, &mut start);
        let mut of_kinks = bands.kinks.clone();
        for k in self.compiled.indicators.of_multipliers() {
            of_kinks[k] = bands.of_multipliers(k, &self.lambda);
        }
        let values = &start[self.modes.signs.len()..];
        let states = &self.evaluator.values(t, q, v).contacts;
        let of_contact = |((mode, &value), state): ((_, &f64), &ContactState)| match mode {
            // Bodies that only touch a stop turn back within the tolerance.
            ContactMode::Open if bands.is_closed(-value) && state.rate() > 0.0 => bands.rest[0],
            ContactMode::Open => bands.position,
            ContactMode::Slip(_) if bands.is_at_rest(value) => bands.drift(v),
            ContactMode::Slip(_) => bands.rate,
            ContactMode::Closed | ContactMode::Stick(_) => FORCE_BAND * force,
        };
        let of_contacts = self.modes.contacts.iter().copied().zip(values).zip(states);
        let of_contacts = of_contacts.map(of_contact);
        let all = of_kinks.into_iter().chain(of_contacts);
        let raised = all.zip(&start).map(|(band, &value)| band + (-value).max(0.0));
        self.bands = raised.collect();
    }

    fn indicator(&self, i: usize) -> Indicator {
        match i.checked_sub(self.modes.signs.len()) {
            None => Indicator::Kink(i),
            Some(contact) => Indicator::Contact(contact),
        }
    }

    /// Writes the signed indicators; returns the size of the forces in active contacts.
    ///
    /// Multipliers are NaN, which is no crossing, where the motion has none.
    fn signed_into(&mut self, t: f64, q: &[f64], v: &[f64], out: &mut [f64]) -> f64 {
        let Self { evaluator, compiled, fixed, modes, inactive, lambda, .. } = self;
        let indicators = &compiled.indicators;
        let has_active = modes.contacts.iter().any(|mode| mode.is_active());
        let is_needed = has_active || indicators.of_multipliers().next().is_some();
        let found = if is_needed { fixed.acceleration((t, q, v), inactive) } else { None };
        lambda.clear();
        lambda.extend(found.iter().flat_map(|found| &found.lambda));
        let values = match found {
            Some(found) => evaluator.values_with(t, (q, v), &found.lambda),
            None => evaluator.values(t, q, v),
        };

        let (kinks, of_contacts) = out.split_at_mut(values.kinks.len());
        for ((value, u), sign) in kinks.iter_mut().zip(&values.kinks).zip(&modes.signs) {
            *value = sign * u;
        }
        if found.is_none() {
            indicators.of_multipliers().for_each(|k| kinks[k] = f64::NAN);
        }
        let contacts = &indicators.contacts;
        let mut size: f64 = 0.0;
        for (k, value) in of_contacts.iter_mut().enumerate() {
            let (mode, state) = (modes.contacts[k], values.contacts[k]);
            let force_of = |k: usize| found.map_or(f64::NAN, |found| found.lambda[contacts[k].row]);
            let force = force_of(k);
            *value = match contacts[k].other {
                None => signed(mode, state, force),
                Some(other) if other > k => {
                    let sticks = state.sticking() - force.hypot(force_of(other));
                    let rates = [k, other].map(|k| values.contacts[k].rate());
                    in_plane([mode, modes.contacts[other]], rates, sticks)
                }
                // The first of two directions stands for both.
                Some(_) => 1.0,
            };
            if mode.is_active() {
                size = size.max(force.abs()).max(largest_force(state));
            }
        }
        size
    }
}

/// The indicator of a contact, positive while its mode lasts.
fn signed(mode: ContactMode, state: ContactState, force: f64) -> f64 {
    match (mode, state) {
        (ContactMode::Open, ContactState::Stop { penetration, reach, .. }) => {
            (-penetration).max(-reach)
        }
        (ContactMode::Closed, ContactState::Stop { reach, .. }) => force.min(STEEP * reach),
        (ContactMode::Slip(sign), ContactState::Friction { rate, .. }) => sign * rate,
        (ContactMode::Stick(_), ContactState::Friction { sticking, .. }) => sticking - force.abs(),
        _ => unreachable!("stops are open or closed, friction slips or sticks"),
    }
}

/// The indicator of friction in two directions: slip is along its direction as long as less of it is across, which ends where
/// it comes to rest and where it has turned by an eighth of a turn.
fn in_plane(modes: [ContactMode; 2], [w1, w2]: [f64; 2], sticks: f64) -> f64 {
    match modes {
        [ContactMode::Slip(c), ContactMode::Slip(s)] => (c * w1 + s * w2) - (c * w2 - s * w1).abs(),
        _ => sticks,
    }
}

/// A force that an active contact may reach, by which rounding is measured besides its own.
fn largest_force(state: ContactState) -> f64 {
    match state {
        // A number without unit: kept, since it moves the last digits of events.
        ContactState::Stop { restitution, .. } => restitution.max(0.0),
        ContactState::Friction { sticking, .. } => sticking,
    }
}

/// An indicator raised by its band; a function that is zero all along has not crossed.
fn raised(value: f64, band: f64) -> f64 {
    let raised = value + band;
    if raised == 0.0 { f64::MIN_POSITIVE } else { raised }
}

impl Events for SignedIndicators<'_> {
    fn count(&self) -> usize {
        self.bands.len()
    }

    fn crossing(&self, _: usize) -> Crossing {
        Crossing::Falling
    }

    /// Band of an indicator: none where it lacked this to zero when the phase began, as it has been below all along.
    fn band(&self, i: usize) -> f64 {
        self.bands[i]
    }

    fn values(&mut self, t: f64, y: &[f64], out: &mut [f64]) {
        let (q, v) = y[..2 * self.nq].split_at(self.nq);
        self.signed_into(t, q, v, out);
        for (value, band) in out.iter_mut().zip(&self.bands) {
            *value = raised(*value, *band);
        }
    }

    /// Without the forces of contacts where a gap is all that is asked for.
    fn value(&mut self, i: usize, t: f64, y: &[f64], room: &mut [f64]) -> f64 {
        let open = i.checked_sub(self.modes.signs.len());
        let open = open.filter(|&k| self.modes.contacts[k] == ContactMode::Open);
        let Some(k) = open else {
            self.values(t, y, room);
            return room[i];
        };
        let (q, v) = y[..2 * self.nq].split_at(self.nq);
        let state = self.evaluator.values(t, q, v).contacts[k];
        raised(signed(ContactMode::Open, state, f64::NAN), self.bands[i])
    }
}
