//! Consistent modes at one instant, and the impact that leads to them.
//!
//! Signs and contacts that are clearly on one side follow from the state. The rest — indicators that
//! are zero, closed stops, friction at rest — must agree with the accelerations that follow:
//!
//! ```text
//! kink      σ u′ ≥ 0
//! stop      λ ≥ 0 in contact,         φ″ ≤ 0 apart
//! friction  |λ| ≤ F₀ sticking,        ς p″ ≥ 0 slipping
//! ```
//!
//! All combinations are tried in a fixed order, contacts closed first, until one is consistent.

use nalgebra::DVector;

use super::complementarity::{
    holds, leaves_to_its_side, pushes, slips_against_friction, stays_apart,
};
use super::consistent::{ConsistentModes, Hit, ImpactRecord, Instant, NoConsistentModes};
use super::fixed::{FixedModes, JUMP};
use super::impact::{ImpactEquations, Rubbing, independent_without};
use super::mode_sets::ModeSets;
use super::signs::as_written;
use super::undecided::{TrialMotion, Undecided, differ, none_consistent};
use crate::linear::matrix::Matrix;
use crate::modes::indicators::{CompiledContact, ContactState, Indicator, IndicatorValues};
use crate::modes::{ContactMode, Modes};
use crate::multiplier::largest;

/// Relative rounding of forces.
pub(super) const ROUNDING: f64 = 1e-9;
/// Part of the largest velocity that is rounding of a difference.
const ROUNDING_OF_RATE: f64 = 2.0 * f64::EPSILON;
/// The end of an outline is known to this, m.
const OF_END: f64 = 1e-12;
/// Impacts that may follow one another at one instant.
const MAX_IMPACTS: usize = 8;

/// Finds consistent modes at an instant: impacts first, then the contacts that stay.
///
/// # Errors
/// [`NoConsistentModes`] says why there are none.
pub(crate) fn consistent_modes(instant: Instant<'_>) -> Result<ConsistentModes, NoConsistentModes> {
    let mut search = ModeSearch::new(instant);
    search.decide();
    for _ in 0..MAX_IMPACTS {
        if !search.pass_impact()? {
            break;
        }
        search.decide();
    }
    let undecided = search.undecided();
    search.choose(&undecided)
}

/// Modes of [`consistent_modes`], but bodies that run into a stop are left to do so.
///
/// # Errors
/// [`NoConsistentModes`] says why there are none.
pub(crate) fn consistent_modes_without_impact(
    instant: Instant<'_>,
) -> Result<ConsistentModes, NoConsistentModes> {
    let mut search = ModeSearch::new(instant);
    search.decide();
    let undecided = search.undecided();
    search.choose(&undecided)
}

/// The search at one instant, with the modes that are decided so far.
pub(super) struct ModeSearch<'a> {
    pub(super) at: Instant<'a>,
    pub(super) modes: Modes,
    impact_work: f64,
    hits: Vec<Hit>,
    impacts: Vec<ImpactRecord>,
    /// By contact: parted by an impact for a flight too low to be seen.
    pub(super) grazes: Vec<bool>,
    /// By contact: an impact has ended its slip.
    pub(super) stuck: Vec<bool>,
}

impl<'a> ModeSearch<'a> {
    fn new(mut at: Instant<'a>) -> Self {
        // The rate of a limit that follows others is a difference of such rates.
        at.bands.rate = at.bands.rate.max(ROUNDING_OF_RATE * largest(&at.v));
        let grazes = vec![false; at.before.contacts.len()];
        let stuck = grazes.clone();
        let (modes, hits, impacts) = (as_written(&at), Vec::new(), Vec::new());
        Self { modes, at, impact_work: 0.0, hits, impacts, grazes, stuck }
    }

    pub(super) fn fixed(&self, modes: &Modes) -> FixedModes<'a> {
        FixedModes::new(self.at.compiled, &modes.parameters_with_modes(self.at.parameters))
    }

    pub(super) fn indicators(&self, modes: &Modes) -> IndicatorValues {
        let Instant { t, q, v, compiled, parameters, .. } = &self.at;
        let parameters = modes.parameters_with_modes(parameters);
        compiled.indicators.at(&parameters).values(*t, q, v).clone()
    }

    pub(super) fn contacts(&self) -> &'a [CompiledContact] {
        &self.at.compiled.indicators.contacts
    }

    pub(super) fn has_fired(&self, indicator: Indicator) -> bool {
        self.at.fired.contains(&indicator)
    }

    /// Decides every mode that the state decides. A kink inside another is decided first, and the
    /// indicators are taken again: the outer function has a mode of the inner one in it.
    fn decide(&mut self) {
        for _ in 0..=self.modes.signs.len() {
            let values = self.indicators(&self.modes);
            let before = self.modes.clone();
            self.decide_kinks(&values.kinks);
            self.decide_contacts(&values.contacts);
            if self.modes == before {
                break;
            }
        }
    }

    /// σ = sign u; a function that has just crossed zero has changed its sign.
    fn decide_kinks(&mut self, functions: &[f64]) {
        for (k, &u) in functions.iter().enumerate() {
            if self.at.compiled.indicators.is_of_multipliers(k) {
                continue;
            }
            if u.abs() > self.at.bands.kinks[k] {
                self.modes.signs[k] = u.signum();
            } else if self.has_fired(Indicator::Kink(k)) {
                self.modes.signs[k] = -self.at.before.signs[k];
            }
        }
    }

    /// φ < 0, or φ = 0 and φ′ < 0: open. p′ ≠ 0: slipping.
    fn decide_contacts(&mut self, contacts: &[ContactState]) {
        for (k, &state) in contacts.iter().enumerate() {
            let is_at_rest = self.is_at_rest(k, state);
            match state {
                ContactState::Friction { rate, speed, .. } if !is_at_rest => {
                    let has_two = self.contacts()[k].other.is_some();
                    let way = if has_two { rate / speed } else { rate.signum() };
                    self.modes.contacts[k] = ContactMode::Slip(way);
                }
                ContactState::Stop { rate, .. }
                    if !self.is_closed(k, state) || rate < 0.0 && !is_at_rest =>
                {
                    self.modes.contacts[k] = ContactMode::Open;
                }
                _ => (),
            }
        }
    }

    /// True where the rate of a contact is zero. That of friction which has just fired is: it is known no better than
    /// the instant at which it passes zero, a bit of the time times the acceleration.
    pub(super) fn is_at_rest(&self, k: usize, state: ContactState) -> bool {
        let has_passed = matches!(state, ContactState::Friction { .. })
            && !self.at.before.contacts[k].is_active()
            && self.contacts()[k].other.is_none()
            && self.has_fired(Indicator::Contact(k));
        has_passed
            || self.grazes[k]
            || self.stuck[k]
            || self.is_kept(k, state)
            || self.at.bands.is_at_rest(state.speed())
    }

    /// True where a stop that was held until now has the rate of one: no more than a run lets it drift by.
    fn is_kept(&self, k: usize, state: ContactState) -> bool {
        let is_stop = matches!(state, ContactState::Stop { .. });
        let drift = self.at.bands.drift(&self.at.v);
        is_stop && self.at.before.contacts[k].is_active() && state.rate().abs() <= drift
    }

    /// True where a stop is closed, as one that the run holds is unless its limit jumps away, as far as outlines reach.
    pub(super) fn is_closed(&self, k: usize, state: ContactState) -> bool {
        let ContactState::Stop { penetration, reach, .. } = state else { return false };
        let has_left =
            self.at.before.contacts[k].is_active() && self.has_fired(Indicator::Contact(k));
        if reach < -OF_END || has_left && reach <= OF_END {
            return false;
        }
        let is_kept = penetration > -JUMP * largest(&self.at.q).max(1.0);
        self.modes.contacts[k].is_active() && is_kept || self.at.bands.is_closed(penetration)
    }

    /// Closed stops, whether or not they are about to part.
    pub(super) fn closed_stops(&self, values: &IndicatorValues) -> Vec<usize> {
        let contacts = values.contacts.iter().enumerate();
        let closed = contacts.filter(|&(k, &state)| match state {
            ContactState::Stop { .. } => self.is_closed(k, state),
            ContactState::Friction { .. } => false,
        });
        closed.map(|(k, _)| k).collect()
    }

    /// Passes an impact where bodies run into stops, or a prescribed rate jumps: velocities change at
    /// once. False when there is neither.
    fn pass_impact(&mut self) -> Result<bool, NoConsistentModes> {
        let values = self.indicators(&self.modes);
        let mut closed = self.closed_stops(&values);
        self.leave_out_touched(&mut closed, &values);
        let (t, bands) = (self.at.t, &self.at.bands);
        let approaching = |k: &usize| {
            let state = values.contacts[*k];
            bands.is_approaching(state.rate()) && !self.is_kept(*k, state)
        };
        let hit: Vec<usize> = closed.iter().copied().filter(approaching).collect();
        let tracks = self.tracks_of(&closed);
        let modes = self.modes_of_impact(&closed, &tracks);
        let mut fixed = self.fixed(&modes);

        // Onto the stops themselves, which the event has passed by rounding.
        fixed.put_onto_rows(t, &mut self.at.q, &self.at.v)?;

        // The rows that hold throughout, and whether the velocities break them.
        let rows: Vec<usize> = closed.iter().map(|&k| self.contacts()[k].row).collect();
        let at = fixed.matrices(t, &self.at.q, &self.at.v);
        let rubbing: Vec<usize> = tracks.iter().map(|&k| self.contacts()[k].row).collect();
        let held = independent_without(&at.jacobian, &[&rows[..], &rubbing].concat());
        let g = at.jacobian.select(&held);
        let g_rate: Vec<f64> = held.iter().map(|&row| at.rate[row]).collect();
        let velocity = DVector::from_column_slice(&self.at.v);
        let broken = Matrix::of(g.clone()).times(&velocity) + DVector::from_column_slice(&g_rate);
        let has_jumped = largest(broken.as_slice()) > 10.0 * JUMP * (1.0 + largest(&self.at.v));
        if hit.is_empty() && !has_jumped {
            return Ok(false);
        }

        // The impact itself, on all closed stops.
        let stops = at.jacobian.select(&rows);
        let restitution = self.restitutions(&closed, &values);
        let equations = ImpactEquations {
            mass: &at.mass,
            g: &g,
            g_rate: &g_rate,
            stops: &stops,
            restitution: &restitution,
        };
        let found = if tracks.is_empty() {
            equations.solve(&velocity)
        } else {
            let rows = at.jacobian.select(&rubbing);
            let (mu, pressed_by) = self.rubbing(&tracks, &closed, &values);
            let is_spatial = self.at.compiled.indicators.has_planes();
            let rubbing = Rubbing { rows: &rows, mu: &mu, pressed_by: &pressed_by, is_spatial };
            equations.solve_rubbing(&velocity, &rubbing)
        };
        let Some(impact) = found else {
            return Err(NoConsistentModes::Contacts { contacts: closed });
        };
        let energy = |v: &DVector<f64>| 0.5 * at.mass.times(v).dot(v);
        self.impact_work += energy(&impact.v) - energy(&velocity);
        let hits = hit.iter().map(|&k| Hit { contact: k, speed: values.contacts[k].rate() });
        self.hits.extend(hits);
        let pushed = closed.iter().zip(&restitution).zip(impact.impulses.iter());
        let stops = pushed.filter(|(_, impulse)| **impulse > 0.0);
        let stops = stops.map(|((&contact, &restitution), _)| (contact, restitution)).collect();
        let after = impact.v.as_slice().to_vec();
        let before = std::mem::replace(&mut self.at.v, after.clone());
        self.impacts.push(ImpactRecord { modes, held, stops, velocities: [before, after] });
        self.note_grazes(&closed);
        self.note_stuck(&tracks);
        Ok(true)
    }

    /// The modes that the state leaves open, with their choices.
    fn undecided(&self) -> Vec<Undecided> {
        let values = self.indicators(&self.modes);
        let mut undecided = Vec::new();
        for (kink, &u) in values.kinks.iter().enumerate() {
            let is_near = u.abs() <= self.at.bands.kinks[kink];
            let is_open = is_near || self.has_fired(Indicator::Kink(kink));
            if is_open && !self.at.compiled.indicators.is_of_multipliers(kink) {
                let sign = self.modes.signs[kink];
                undecided.push(Undecided::Kink { kink, signs: [sign, -sign] });
            }
        }
        for (contact, state) in values.contacts.iter().enumerate() {
            if self.is_at_rest(contact, *state)
                && self.may_rub(contact, &values)
                && let Some(modes) = self.choices(contact, *state)
            {
                undecided.push(Undecided::Contact { contact, modes });
            }
        }
        undecided
    }

    /// The modes that a contact at rest may have, held first; `None` for a stop that is open.
    fn choices(&self, contact: usize, state: ContactState) -> Option<Vec<ContactMode>> {
        let (before, own) = (self.at.before.contacts[contact], Indicator::Contact(contact));
        let mut modes = match state {
            ContactState::Friction { position, .. } => {
                let position = match before {
                    ContactMode::Stick(held) => held,
                    _ => position,
                };
                vec![ContactMode::Stick(position), ContactMode::Slip(1.0), ContactMode::Slip(-1.0)]
            }
            ContactState::Stop { .. } if self.is_closed(contact, state) => {
                vec![ContactMode::Closed, ContactMode::Open]
            }
            ContactState::Stop { .. } => return None,
        };
        // A stop that friction has kept from moving, which now lets go, bears nothing yet: it closes only where it must.
        if before == ContactMode::Open && self.has_let_go() && !self.has_fired(own) {
            modes.rotate_left(1);
        }
        // A contact that has just let go does not hold, unless nothing else is consistent.
        if self.has_fired(own) && before.is_active() {
            modes.rotate_left(1);
        }
        Some(modes)
    }

    /// True where friction that stuck has just reached its limit.
    fn has_let_go(&self) -> bool {
        let contacts = self.at.before.contacts.iter().enumerate();
        let mut stuck = contacts.filter(|(_, mode)| matches!(mode, ContactMode::Stick(_)));
        stuck.any(|(k, _)| self.has_fired(Indicator::Contact(k)))
    }

    /// The first consistent combination of choices.
    ///
    /// At the very instant at which friction lets go, the accelerations of all combinations but one vanish where it slides with
    /// the force that it holds with: their rounding is then that of the largest among the combinations. The event was found on
    /// the dense output, off the rows by the tolerances; on them a contact that has let go may still hold by as much. It then
    /// goes on holding, and lets go at the next event.
    fn choose(self, undecided: &[Undecided]) -> Result<ConsistentModes, NoConsistentModes> {
        if self.at.compiled.indicators.has_planes() {
            return self.choose_in_cones(undecided);
        }
        let mut largest_met: f64 = 0.0;
        let values = self.indicators(&self.modes);
        let weak = self.weak_contact(&values);
        if weak.is_none()
            && let Some(modes) = self.modes_of_many(undecided, &values)
        {
            return Ok(self.start_in(modes));
        }
        let mut found: Option<(Modes, Vec<f64>)> = None;
        for (is_first, may_hold) in [(true, false), (false, false), (false, true)] {
            if weak.is_none() && self.is_beyond_trying(undecided) {
                break;
            }
            let scale = if is_first { 0.0 } else { largest_met };
            for set in ModeSets::new(undecided.iter().map(Undecided::n_choices).collect()) {
                let mut modes = self.modes.clone();
                for (undecided, choice) in undecided.iter().zip(set) {
                    undecided.take(choice, &mut modes);
                }
                self.press_together(&values, &mut modes);
                if !may_hold && self.is_held_after_event(undecided, &modes) {
                    continue;
                }
                let Some(motion) = self.motion_in(&modes) else { continue };
                if self.is_consistent(undecided, &modes, &motion, scale) {
                    let Some(contact) = weak else { return Ok(self.start_in(modes)) };
                    match &found {
                        None => found = Some((modes, motion.a.clone())),
                        Some((_, first)) if differ(first, &motion.a, 1e3 * ROUNDING) => {
                            return Err(NoConsistentModes::Paradox { contact, has_several: true });
                        }
                        Some(_) => (),
                    }
                }
                largest_met = largest_met.max(largest(&motion.a));
            }
        }
        if let Some((modes, _)) = found {
            return Ok(self.start_in(modes));
        }
        Err(match weak {
            Some(contact) => NoConsistentModes::Paradox { contact, has_several: false },
            None => none_consistent(undecided),
        })
    }

    /// True where a contact that has let go is held again.
    pub(super) fn is_held_after_event(&self, undecided: &[Undecided], modes: &Modes) -> bool {
        undecided.iter().any(|undecided| match *undecided {
            Undecided::Contact { contact, .. } => {
                self.has_fired(Indicator::Contact(contact))
                    && self.at.before.contacts[contact].is_active()
                    && modes.contacts[contact].is_active()
            }
            Undecided::Kink { .. } => false,
        })
    }

    /// True if every mode that was chosen agrees with the motion that follows.
    fn is_consistent(
        &self,
        undecided: &[Undecided],
        modes: &Modes,
        motion: &TrialMotion,
        scale: f64,
    ) -> bool {
        self.first_misfit(undecided, modes, motion, (scale, ROUNDING)).is_none()
    }

    /// The first mode that was chosen and does not agree with the motion that follows; accelerations have this relative
    /// rounding of `scale`, or of their own.
    pub(super) fn first_misfit(
        &self,
        undecided: &[Undecided],
        modes: &Modes,
        motion: &TrialMotion,
        (scale, rounding): (f64, f64),
    ) -> Option<usize> {
        let Instant { t, q, v, compiled, parameters, .. } = &self.at;
        let mut indicators = compiled.indicators.at(&modes.parameters_with_modes(parameters));
        let values = indicators.values_with(*t, (q, v), &motion.lambda);
        let (a, lambda) = (largest(&motion.a), largest(&motion.lambda));
        let small = rounding * a.max(scale) + motion.noise + f64::MIN_POSITIVE;
        undecided.iter().position(|undecided| !match *undecided {
            Undecided::Kink { kink, .. } => {
                let rate = motion.kink_rates[kink];
                leaves_to_its_side(modes.signs[kink], rate, ROUNDING * rate.abs().max(motion.scale))
            }
            Undecided::Contact { contact, .. } => {
                let acceleration = motion.contact_accelerations[contact];
                let force = motion.force(self.contacts(), contact);
                match (modes.contacts[contact], values.contacts[contact]) {
                    (ContactMode::Closed, _) => pushes(force, rounding * lambda),
                    (ContactMode::Open, _) => stays_apart(acceleration, small),
                    (ContactMode::Stick(_), ContactState::Friction { sticking, .. }) => {
                        let bears = sticking > ROUNDING * lambda;
                        holds(force, sticking, rounding * sticking.max(lambda))
                            && (bears || !self.is_held_by_others(contact, modes))
                    }
                    (ContactMode::Slip(sign), _) => {
                        slips_against_friction(sign, acceleration, small)
                    }
                    (ContactMode::Stick(_), ContactState::Stop { .. }) => {
                        unreachable!("stops do not stick")
                    }
                }
            }
        })
    }

    /// True where other rows hold what a contact does that sticks: bearing nothing, it must slip as they will ask for.
    fn is_held_by_others(&self, contact: usize, modes: &Modes) -> bool {
        let mut slipping = modes.clone();
        slipping.contacts[contact] = ContactMode::Slip(1.0);
        let n = |modes: &Modes| self.fixed(modes).inactive_rows(self.at.t, &self.at.q).len();
        n(modes) == n(&slipping)
    }

    /// The accelerations in a set of modes; `None` where there are none.
    pub(super) fn motion_in(&self, modes: &Modes) -> Option<TrialMotion> {
        let Instant { t, q, v, compiled, parameters, .. } = &self.at;
        let parameters = modes.parameters_with_modes(parameters);
        let mut fixed = FixedModes::new(compiled, &parameters);
        let inactive = fixed.inactive_rows(*t, q);
        let found = fixed.acceleration((*t, q, v), &inactive)?.clone();
        let noise = fixed.noise((*t, q, v));
        let mut evaluator = compiled.indicators.at(&parameters);
        let rates = evaluator.rates(*t, q, v, &found.a);
        Some(TrialMotion {
            kink_rates: rates.kinks.to_vec(),
            contact_accelerations: rates.contacts.to_vec(),
            scale: largest(&found.a) + largest(v),
            noise,
            a: found.a,
            lambda: found.lambda,
        })
    }

    /// The state on all active rows, from which the motion goes on.
    pub(super) fn start_in(self, modes: Modes) -> ConsistentModes {
        let mut fixed = self.fixed(&modes);
        let Instant { t, mut q, mut v, compiled, .. } = self.at;
        let inactive = fixed.inactive_rows(t, &q);
        fixed.project(t, &mut q, &mut v, &inactive);
        let found = fixed.acceleration((t, &q, &v), &inactive);
        let (a, lambda) = match found {
            Some(found) => (found.a.clone(), found.lambda.clone()),
            None => (vec![f64::NAN; q.len()], vec![f64::NAN; compiled.nc()]),
        };
        let Self { impact_work, hits, impacts, .. } = self;
        ConsistentModes { modes, q, v, a, lambda, inactive, impact_work, hits, impacts }
    }
}
