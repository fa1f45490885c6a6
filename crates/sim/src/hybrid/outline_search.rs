//! Contacts of outlines in the search for modes: which friction goes with which stops, and combinations that are found
//! without trying all.

use nalgebra::DVector;

use super::impact::{ImpactEquations, Rubbing, independent_without};
use super::mode_search::{ModeSearch, ROUNDING};
use super::mode_sets::ModeSets;
use super::rubbing_impact::Response;
use super::undecided::Undecided;
use crate::linear::rows::SparseRows;
use crate::modes::indicators::{ContactState, IndicatorValues};
use crate::modes::{ContactMode, Modes};
use crate::multiplier::largest;

/// Changes of a choice, for each of them, after which another way is tried.
const PIVOTS: usize = 8;
/// Part of the largest velocity that is rounding of an impact.
const STUCK: f64 = 1e-13;
/// Undecided modes up to which one choice after the other is changed; of more, a complementarity problem is solved.
const MOST_PIVOTED: usize = 12;
/// Relative rounding of forces where many places touch.
const OF_MANY: f64 = 1e-7;
/// Most choices of contacts of outlines that are tried one after the other.
const MOST_TRIED: usize = 4;

/// How much of what holds without being needed is taken as holding.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Needed {
    All,
    /// No stops without a force, no friction at its limit.
    Least,
    /// Neither friction without a force.
    None,
}

impl ModeSearch<'_> {
    /// All closed stops hold; friction is bounded, so that it gives no impulse but where its stops do.
    pub(super) fn modes_of_impact(&self, closed: &[usize], tracks: &[usize]) -> Modes {
        let mut modes = self.modes.clone();
        for &k in closed {
            modes.contacts[k] = ContactMode::Closed;
        }
        for mode in &mut modes.contacts {
            if let ContactMode::Stick(_) = mode {
                *mode = ContactMode::Slip(0.0);
            }
        }
        for &k in tracks {
            modes.contacts[k] = ContactMode::Stick(0.0);
        }
        modes
    }

    /// The friction of contacts that some of these stops press together.
    pub(super) fn tracks_of(&self, closed: &[usize]) -> Vec<usize> {
        let pressed_by = &self.at.compiled.indicators.pressed_by;
        let is_pressed = |k: &usize| pressed_by[*k].iter().any(|stop| closed.contains(stop));
        (0..pressed_by.len()).filter(is_pressed).collect()
    }

    /// μ of each of these frictions, and the places among `closed` of the stops that press it together.
    pub(super) fn rubbing(
        &self,
        tracks: &[usize],
        closed: &[usize],
        values: &IndicatorValues,
    ) -> (Vec<f64>, Vec<Vec<usize>>) {
        let coefficient = |&k: &usize| match values.contacts[k] {
            ContactState::Friction { position, .. } => position,
            ContactState::Stop { .. } => 0.0,
        };
        let pressed_by = &self.at.compiled.indicators.pressed_by;
        let stops = |&k: &usize| {
            let places = pressed_by[k].iter().map(|stop| closed.iter().position(|c| c == stop));
            places.flatten().collect()
        };
        (tracks.iter().map(coefficient).collect(), tracks.iter().map(stops).collect())
    }

    /// Notes friction that has ended the slip: its speed is zero up to rounding of the impact.
    pub(super) fn note_stuck(&mut self, tracks: &[usize]) {
        let values = self.indicators(&self.modes);
        let size = STUCK * largest(&self.at.v).max(f64::MIN_POSITIVE);
        for &k in tracks {
            self.stuck[k] = values.contacts[k].speed() <= size;
        }
    }

    /// Gives friction of contacts the mode that goes with those of its stops: none where they are open, that of its slip
    /// where they have closed.
    pub(super) fn press_together(&self, values: &IndicatorValues, modes: &mut Modes) {
        for (k, stops) in self.at.compiled.indicators.pressed_by.iter().enumerate() {
            if stops.is_empty() {
                continue;
            }
            if !stops.iter().any(|&stop| modes.contacts[stop].is_active()) {
                modes.contacts[k] = ContactMode::Slip(0.0);
            } else if modes.contacts[k] == ContactMode::Slip(0.0) {
                modes.contacts[k] = ContactMode::Slip(values.contacts[k].rate().signum());
            }
        }
    }

    /// False of friction of a contact whose stops are all open.
    pub(super) fn may_rub(&self, contact: usize, values: &IndicatorValues) -> bool {
        let stops = &self.at.compiled.indicators.pressed_by[contact];
        stops.is_empty() || stops.iter().any(|&stop| self.is_closed(stop, values.contacts[stop]))
    }

    /// Consistent modes where there are contacts of outlines, or more combinations than are tried: by changing what does not
    /// fit, or else, with outlines, by a complementarity problem.
    pub(super) fn modes_of_many(
        &self,
        undecided: &[Undecided],
        values: &IndicatorValues,
    ) -> Option<Modes> {
        if !self.contacts().iter().any(|contact| contact.is_outline) {
            let n_choices: Vec<usize> = undecided.iter().map(Undecided::n_choices).collect();
            let are_many = ModeSets::are_too_many(&n_choices);
            return are_many.then(|| self.pivoted(undecided, values)).flatten();
        }
        let pivoted = (undecided.len() <= MOST_PIVOTED).then(|| self.pivoted(undecided, values));
        pivoted.flatten().or_else(|| self.complementary(undecided, values))
    }

    /// The response of the mechanism to forces of these stops and frictions.
    pub(super) fn response(&self, closed: &[usize], tracks: &[usize]) -> Option<Response> {
        self.response_in(&self.modes_of_impact(closed, tracks), closed, tracks)
    }

    /// The response in these modes, in which all of them hold.
    pub(super) fn response_in(
        &self,
        modes: &Modes,
        closed: &[usize],
        tracks: &[usize],
    ) -> Option<Response> {
        let rows: Vec<usize> = closed.iter().map(|&k| self.contacts()[k].row).collect();
        let rubbing: Vec<usize> = tracks.iter().map(|&k| self.contacts()[k].row).collect();
        let at = self.fixed(modes).matrices(self.at.t, &self.at.q, &self.at.v);
        let held = independent_without(&at.jacobian, &[&rows[..], &rubbing].concat());
        let zeros = vec![0.0; held.len().max(rows.len())];
        let equations = ImpactEquations {
            mass: &at.mass,
            g: &at.jacobian.select(&held),
            g_rate: &zeros[..held.len()],
            stops: &at.jacobian.select(&rows),
            restitution: &zeros[..rows.len()],
        };
        equations.response(&DVector::zeros(self.at.v.len()), &at.jacobian.select(&rubbing))
    }

    /// Consistent modes by a linear complementarity problem of the accelerations of contacts of outlines, as far as
    /// others leave them alone; `None` where none touch, or they do not fit.
    fn complementary(&self, undecided: &[Undecided], values: &IndicatorValues) -> Option<Modes> {
        let at_rest = |k: usize| {
            let is_it =
                |of: &Undecided| matches!(of, Undecided::Contact { contact, .. } if *contact == k);
            undecided.iter().any(is_it)
        };
        let mut closed = self.closed_stops(values);
        closed.retain(|&k| at_rest(k));
        let tracks = self.tracks_of(&closed);
        if closed.is_empty() {
            return None;
        }
        let mut modes = self.modes.clone();
        for &k in &closed {
            modes.contacts[k] = ContactMode::Open;
        }
        for &k in &tracks {
            modes.contacts[k] = ContactMode::Slip(0.0);
        }
        let without = self.motion_in(&modes)?;
        let scale = largest(&without.a);
        let free = without.contact_accelerations;
        let all: Vec<usize> = closed.iter().chain(&tracks).copied().collect();
        let rates = DVector::from_iterator(all.len(), all.iter().map(|&k| free[k]));
        let slip = |&k: &usize| if at_rest(k) { 0.0 } else { values.contacts[k].rate().signum() };
        let slips: Vec<f64> = tracks.iter().map(slip).collect();
        let (mu, pressed_by) = self.rubbing(&tracks, &closed, values);
        let rows = SparseRows::new(self.at.v.len());
        let rubbing = Rubbing { rows: &rows, mu: &mu, pressed_by: &pressed_by, is_spatial: false };
        let response = self.response(&closed, &tracks)?;
        let (response, resting) = response.of_forces(&rates, &slips, &rubbing);
        let mu: Vec<f64> = resting.iter().map(|&k| mu[k]).collect();
        let pressed_by: Vec<Vec<usize>> = resting.iter().map(|&k| pressed_by[k].clone()).collect();
        let rubbing = Rubbing { rows: &rows, mu: &mu, pressed_by: &pressed_by, is_spatial: false };
        let chosen = response.choices(&rubbing)?;
        for (&k, slip) in tracks.iter().zip(&slips).filter(|(_, slip)| **slip != 0.0) {
            modes.contacts[k] = ContactMode::Slip(*slip);
        }
        // Where more holds than is needed, its forces are not unique, and the smallest need not be in the bounds of friction:
        // then those that repeat others are left alone, and friction at its limit takes no part in holding.
        [Needed::All, Needed::Least, Needed::None].into_iter().find_map(|needed| {
            let mut modes = modes.clone();
            for (place, &k) in closed.iter().enumerate() {
                let stays = needed == Needed::All && chosen.stays[place];
                if chosen.pushes[place] || stays {
                    modes.contacts[k] = ContactMode::Closed;
                }
            }
            let resting = resting.iter().map(|&track| tracks[track]).enumerate();
            for (place, track) in resting.clone() {
                modes.contacts[track] = match chosen.slips[place] {
                    Some((sense, slips)) if slips || needed != Needed::All => {
                        ContactMode::Slip(sense)
                    }
                    _ => ContactMode::Stick(0.0),
                };
            }
            self.press_together(values, &mut modes);
            for (place, track) in resting {
                let is_idle = chosen.slips[place].is_none() && !chosen.rubs[place];
                if is_idle && needed == Needed::None {
                    modes.contacts[track] = ContactMode::Slip(0.0);
                }
            }
            let motion = self.motion_in(&modes)?;
            self.first_misfit(undecided, &modes, &motion, (scale, OF_MANY))
                .is_none()
                .then_some(modes)
        })
    }

    /// A place that slides so that its own force, with the friction that it brings about, does not part the bodies: then
    /// there may be no motion, or more than one.
    pub(super) fn weak_contact(&self, values: &IndicatorValues) -> Option<usize> {
        let closed = self.closed_stops(values);
        let tracks = self.tracks_of(&closed);
        let slips = |k: usize| !self.is_at_rest(k, values.contacts[k]);
        if !tracks.iter().any(|&k| slips(k)) {
            return None;
        }
        let response = self.response(&closed, &tracks)?;
        let (mu, pressed_by) = self.rubbing(&tracks, &closed, values);
        for (track, &k) in tracks.iter().enumerate().filter(|(_, k)| slips(**k)) {
            let slip = values.contacts[k].rate().signum();
            for &stop in &pressed_by[track] {
                if response.own(stop, track, slip, mu[track]) <= 0.0 {
                    return Some(closed[stop]);
                }
            }
        }
        None
    }

    /// A consistent combination, found by changing one choice after the other: always the first that does not fit, which
    /// finds the one there is where each force parts its own bodies more than those of others press them together.
    /// `None` where that leads nowhere.
    pub(super) fn pivoted(
        &self,
        undecided: &[Undecided],
        values: &IndicatorValues,
    ) -> Option<Modes> {
        let mut set = vec![0; undecided.len()];
        for _ in 0..PIVOTS * (undecided.len() + 1) {
            let mut modes = self.modes.clone();
            undecided.iter().zip(&set).for_each(|(of, &choice)| of.take(choice, &mut modes));
            self.press_together(values, &mut modes);
            if self.is_held_after_event(undecided, &modes) {
                return None;
            }
            let motion = self.motion_in(&modes)?;
            let Some(k) = self.first_misfit(undecided, &modes, &motion, (0.0, ROUNDING)) else {
                return Some(modes);
            };
            set[k] = match &undecided[k] {
                Undecided::Kink { .. } => 1 - set[k],
                Undecided::Contact { contact, modes: choices } => {
                    let force = motion.lambda[self.contacts()[*contact].row];
                    let wanted = |mode: &ContactMode| match modes.contacts[*contact] {
                        ContactMode::Closed => *mode == ContactMode::Open,
                        ContactMode::Open => *mode == ContactMode::Closed,
                        ContactMode::Stick(_) => *mode == ContactMode::Slip(-force.signum()),
                        ContactMode::Slip(_) => matches!(mode, ContactMode::Stick(_)),
                    };
                    choices.iter().position(wanted)?
                }
            };
        }
        None
    }

    /// True where there are so many choices that what was tried before is all that there is to do.
    pub(super) fn is_beyond_trying(&self, undecided: &[Undecided]) -> bool {
        let of_outline = |of: &&Undecided| match of {
            Undecided::Contact { contact, .. } => self.contacts()[*contact].is_outline,
            Undecided::Kink { .. } => false,
        };
        undecided.iter().filter(of_outline).count() > MOST_TRIED * 2
    }
}
