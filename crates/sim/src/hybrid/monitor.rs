//! What is watched during one leg of a run, where nothing switches.
//!
//! Every function is signed so that it is positive in the leg, and shifted by a band of the size of
//! rounding, so that rounding about zero is no event:
//!
//! ```text
//! kink              σ u
//! stop apart        −φ
//! stop at rest      λ
//! friction sliding  ς p′
//! friction sticking F₀ − |λ|
//! ```

use bksim_dae::{Crossing, Event, EventSearch, Events, Loader, Saver, SolveError, Start, Step};

use super::fixed::Frozen;
use super::indicators::{Decider, Watch, Watcher};
use super::mode_search::Bands;
use super::modes::{Modes, Touch};
use crate::compiled::CompiledSystem;

/// Forces within this part of the largest are rounding.
const FORCE_BAND: f64 = 1e-9;

/// What switched, and when.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Crossed {
    /// s.
    pub(crate) t: f64,
    pub(crate) fired: Vec<Decider>,
}

/// The functions of one leg and the search for their crossings.
pub(crate) struct Lookout<'a> {
    functions: Functions<'a>,
    /// Made with the first step.
    search: Option<EventSearch>,
}

impl<'a> Lookout<'a> {
    /// The functions of a leg that starts at (t, q, v); `parameters` end with the modes.
    pub(crate) fn new(
        compiled: &'a CompiledSystem,
        parameters: &[f64],
        modes: &Modes,
        dependent: &[usize],
        bands: &Bands,
        (t, q, v): (f64, &[f64], &[f64]),
    ) -> Self {
        let functions = Functions::new(compiled, parameters, modes, dependent, bands, (t, q, v));
        Self { functions, search: None }
    }

    /// What the leg has come to.
    pub(crate) fn save(&self, saver: &mut Saver) {
        let Self { functions, search } = self;
        saver.slice(&functions.bands);
        saver.flag(search.is_some());
        if let Some(search) = search {
            let (values, is_fresh) = search.remembered();
            saver.slice(&values);
            saver.flag(is_fresh);
        }
        functions.frozen.save(saver);
    }

    /// Goes on with what was saved where the leg has come to; `state` is the integrator's.
    pub(crate) fn load(
        &mut self,
        loader: &mut Loader<'_>,
        state: &Start,
    ) -> Result<(), SolveError> {
        let Self { functions, search } = self;
        loader.fill(&mut functions.bands)?;
        if loader.flag()? {
            let mut resumed = EventSearch::new(functions, state);
            resumed.resume(loader.slice()?, loader.flag()?)?;
            *search = Some(resumed);
        }
        let Functions { frozen, dependent, .. } = functions;
        frozen.load(loader, dependent)
    }

    /// What first crosses zero in a step.
    pub(crate) fn first_in(&mut self, step: &Step<'_>) -> Option<Crossed> {
        let Self { functions, search } = self;
        let search = search.get_or_insert_with(|| {
            let (y, ydot) = (step.y0().to_vec(), step.ydot1().to_vec());
            EventSearch::new(functions, &Start { t: step.t0(), y, ydot })
        });
        let found = search.crossings(functions, step);
        let t = found.first()?.t;
        let is_now = |event: &&Event| (event.t - t).abs() <= SAME_INSTANT * t.abs();
        let events = found.iter().take_while(is_now);
        Some(Crossed { t, fired: events.map(|event| functions.decider(event.i)).collect() })
    }
}

/// Events this near to one another, as a part of t, are one.
const SAME_INSTANT: f64 = 16.0 * f64::EPSILON;

struct Functions<'a> {
    watch: &'a Watch,
    watcher: Watcher<'a>,
    frozen: Frozen<'a>,
    nq: usize,
    modes: Modes,
    /// Rows that are open or follow from others.
    dependent: Vec<usize>,
    /// What each function is raised by.
    bands: Vec<f64>,
}

impl<'a> Functions<'a> {
    fn new(
        compiled: &'a CompiledSystem,
        parameters: &[f64],
        modes: &Modes,
        dependent: &[usize],
        bands: &Bands,
        (t, q, v): (f64, &[f64], &[f64]),
    ) -> Self {
        let watch = &compiled.watch;
        let mut functions = Self {
            watch,
            watcher: watch.at(parameters),
            frozen: Frozen::new(compiled, parameters),
            nq: q.len(),
            modes: modes.clone(),
            dependent: dependent.to_vec(),
            bands: vec![0.0; modes.signs.len() + modes.touches.len()],
        };
        let mut start = vec![0.0; functions.bands.len()];
        let force = functions.signed_into(t, q, v, &mut start);
        let of_touch = |touch: &Touch| match touch {
            Touch::Apart => bands.position,
            Touch::Sliding(_) => bands.rate,
            Touch::Resting | Touch::Sticking(_) => FORCE_BAND * force,
        };
        let all = bands.kinks.iter().copied().chain(modes.touches.iter().map(of_touch));
        // A leg starts on the right side whatever rounding says.
        let raised = all.zip(&start).map(|(band, &value)| band + (-value).max(0.0));
        functions.bands = raised.collect();
        functions
    }

    fn decider(&self, i: usize) -> Decider {
        match i.checked_sub(self.modes.signs.len()) {
            None => Decider::Kink(i),
            Some(contact) => Decider::Contact(contact),
        }
    }

    /// Writes the signed functions; returns the size of the forces in contact.
    fn signed_into(&mut self, t: f64, q: &[f64], v: &[f64], out: &mut [f64]) -> f64 {
        let holds = self.modes.touches.iter().any(|touch| touch.is_closed());
        let found =
            if holds { self.frozen.accelerations((t, q, v), &self.dependent) } else { None };
        let view = self.watcher.view(t, q, v);
        let (kinks, contacts) = out.split_at_mut(view.kinks.len());
        for ((value, u), sign) in kinks.iter_mut().zip(&view.kinks).zip(&self.modes.signs) {
            *value = sign * u;
        }
        let mut size: f64 = 0.0;
        for (k, value) in contacts.iter_mut().enumerate() {
            let seen = view.contacts[k];
            let force = || {
                found.as_ref().map_or(f64::NAN, |(_, lambda)| lambda[self.watch.contacts[k].row])
            };
            *value = match self.modes.touches[k] {
                Touch::Apart => -seen.position,
                Touch::Resting => force(),
                Touch::Sliding(sign) => sign * seen.rate,
                Touch::Sticking(_) => seen.limit - force().abs(),
            };
            if self.modes.touches[k].is_closed() {
                size = size.max(force().abs()).max(seen.limit);
            }
        }
        size
    }
}

impl Events for Functions<'_> {
    fn count(&self) -> usize {
        self.bands.len()
    }

    fn crossing(&self, _: usize) -> Crossing {
        Crossing::Falling
    }

    fn values(&mut self, t: f64, y: &[f64], out: &mut [f64]) {
        let (q, v) = y[..2 * self.nq].split_at(self.nq);
        self.signed_into(t, q, v, out);
        for (value, band) in out.iter_mut().zip(&self.bands) {
            *value += band;
            // A function that is zero all along has not crossed.
            if *value == 0.0 {
                *value = f64::MIN_POSITIVE;
            }
        }
    }
}
