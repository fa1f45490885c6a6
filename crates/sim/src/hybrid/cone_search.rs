//! The search for modes where surfaces in space touch: which push, stick or slide, and along which direction.

use nalgebra::DVector;

use super::cones::{Cone, Cones, Forces, Grip};
use super::consistent::{ConsistentModes, NoConsistentModes};
use super::impact::Rubbing;
use super::mode_search::ModeSearch;
use super::mode_sets::ModeSets;
use super::rubbing_impact::{Outcome, Response};
use super::undecided::{TrialMotion, Undecided, none_consistent};
use crate::modes::indicators::{ContactState, Indicator, IndicatorValues};
use crate::modes::{ContactMode, Modes};
use crate::multiplier::largest;

/// Parts of the largest force and acceleration that are none.
const APART: f64 = 1e-8;
/// Relative rounding of forces.
const ROUNDING: f64 = 1e-7;
/// Choices of joints and kinks that are tried.
const MOST_SETS: usize = 1024;

impl ModeSearch<'_> {
    /// Consistent modes: for every choice of kinks, stops and friction of joints those of contacts by their cones.
    pub(super) fn choose_in_cones(
        self,
        undecided: &[Undecided],
    ) -> Result<ConsistentModes, NoConsistentModes> {
        let values = self.indicators(&self.modes);
        let is_other = |of: &&Undecided| match **of {
            Undecided::Contact { contact, .. } => !self.contacts()[contact].is_outline,
            Undecided::Kink { .. } => true,
        };
        let others: Vec<&Undecided> = undecided.iter().filter(is_other).collect();
        let sets = ModeSets::new(others.iter().map(|of| of.n_choices()).collect());
        for set in sets.take(MOST_SETS) {
            let mut modes = self.modes.clone();
            others.iter().zip(set).for_each(|(of, choice)| of.take(choice, &mut modes));
            for keeps_idle in [true, false] {
                let Some((modes, motion, scale)) = self.in_cones(&modes, &values, keeps_idle)?
                else {
                    continue;
                };
                let is_misfit =
                    self.first_misfit(undecided, &modes, &motion, (scale, ROUNDING)).is_some();
                if !is_misfit {
                    return Ok(self.start_in(modes));
                }
            }
        }
        Err(none_consistent(undecided))
    }

    /// The modes of all contacts of surfaces for these modes of everything else, with the motion in them and the size of the
    /// accelerations without contacts.
    ///
    /// # Errors
    /// [`NoConsistentModes::Paradox`] where friction that slides leaves no motion, or more than one.
    fn in_cones(
        &self,
        modes: &Modes,
        values: &IndicatorValues,
        keeps_idle: bool,
    ) -> Result<Option<(Modes, TrialMotion, f64)>, NoConsistentModes> {
        let mut closed = self.closed_stops(values);
        closed.retain(|&k| self.contacts()[k].is_outline && self.is_at_rest(k, values.contacts[k]));
        let tracks = self.tracks_of(&closed);
        let mut modes = modes.clone();
        for (k, contact) in self.contacts().iter().enumerate().filter(|(_, of)| of.is_outline) {
            modes.contacts[k] =
                if contact.other.is_some() { ContactMode::Slip(0.0) } else { ContactMode::Open };
        }
        let Some(without) = self.motion_in(&modes) else { return Ok(None) };
        let scale = largest(&without.a);
        if closed.is_empty() {
            return Ok(Some((modes, without, scale)));
        }

        // What contacts feel of each other's forces.
        let mut held = modes.clone();
        for &k in &closed {
            held.contacts[k] = ContactMode::Closed;
        }
        for &k in &tracks {
            held.contacts[k] = ContactMode::Stick(0.0);
        }
        let Some(response) = self.response_in(&held, &closed, &tracks) else { return Ok(None) };
        let all: Vec<usize> = closed.iter().chain(&tracks).copied().collect();
        let free = all.iter().map(|&k| without.contact_accelerations[k]);
        let rates = DVector::from_iterator(all.len(), free);
        let (mu, pressed_by) = self.rubbing(&tracks, &closed, values);
        let most = self.most_that_hold(&modes);
        let mut cones = cones_of(closed.len(), &mu, &pressed_by);
        for cone in &mut cones {
            let Some([along, across]) = cone.along else { continue };
            let [first, second] = [along, across].map(|row| all[row]);
            cone.holding = most[first];
            if !self.is_at_rest(first, values.contacts[first]) {
                let [w1, w2] = [first, second].map(|k| values.contacts[k].rate());
                cone.slip = Some([w1 / w1.hypot(w2), w2 / w1.hypot(w2)]);
            }
            let has_let_go = self.has_fired(Indicator::Contact(first)) && self.was_active(first);
            cone.lets_go = has_let_go;
        }
        let (a, b) = response.as_cones(&rates, &DVector::zeros(closed.len()));
        let problem = Cones { a: &a, b: &b, places: &cones };
        if let Some(at) = problem.weak() {
            let has_several = b[at] >= 0.0;
            return Err(NoConsistentModes::Paradox { contact: closed[at], has_several });
        }
        let Some(Forces { p, grips }) = problem.solve() else { return Ok(None) };

        // Their modes, and the motion in them.
        let (largest_force, size) = (p.amax(), rates.amax());
        let parting = &b + &a * &p;
        for (cone, grip) in cones.iter().zip(&grips) {
            let k = closed[cone.normal];
            let pushes = p[cone.normal] > APART * largest_force;
            let stays = parting[cone.normal].abs() <= APART * size;
            let has_let_go = self.has_fired(Indicator::Contact(k)) && self.was_active(k);
            let is_kept = pushes || stays && keeps_idle && !has_let_go;
            if !is_kept {
                continue;
            }
            modes.contacts[k] = ContactMode::Closed;
            let Some(rows) = cone.along else { continue };
            let ways = match *grip {
                Grip::Slides(way) => way.map(ContactMode::Slip),
                Grip::Sticks | Grip::Apart => [ContactMode::Stick(0.0); 2],
            };
            rows.into_iter().zip(ways).for_each(|(row, mode)| modes.contacts[all[row]] = mode);
        }
        Ok(self.motion_in(&modes).map(|motion| (modes, motion, scale)))
    }

    /// By contact: the largest friction that holds for a pressing force of one.
    fn most_that_hold(&self, modes: &Modes) -> Vec<f64> {
        let at = &self.at;
        let parameters = modes.parameters_with_modes(at.parameters);
        let ones = vec![1.0; at.compiled.nc()];
        let mut evaluator = at.compiled.indicators.at(&parameters);
        let values = evaluator.values_with(at.t, (&at.q, &at.v), &ones);
        values.contacts.iter().map(ContactState::sticking).collect()
    }

    fn was_active(&self, contact: usize) -> bool {
        self.at.before.contacts[contact].is_active()
    }
}

impl Response {
    /// Parting and slip by unit forces, and without forces, for contacts that are to part at these speeds.
    fn as_cones(
        &self,
        rates: &DVector<f64>,
        parting: &DVector<f64>,
    ) -> (nalgebra::DMatrix<f64>, DVector<f64>) {
        let n = parting.len();
        let mut a = self.w.clone();
        let mut b = rates.clone();
        for i in 0..n {
            a.row_mut(i).neg_mut();
            b[i] = parting[i] - b[i];
        }
        (a, b)
    }

    /// The impulses of an impact in which surfaces rub in two directions.
    pub(super) fn outcome_in_cones(
        &self,
        parting: &DVector<f64>,
        rubbing: &Rubbing<'_>,
    ) -> Option<Outcome> {
        let (a, b) = self.as_cones(&self.rates, parting);
        let cones = cones_of(parting.len(), rubbing.mu, rubbing.pressed_by);
        let impulses = Cones { a: &a, b: &b, places: &cones }.solve()?.p;
        let rates = &self.rates + &self.w * &impulses;
        Some(Outcome { impulses, rates })
    }
}

/// The cones of some stops, with the rows of the frictions that each presses: two, or none.
fn cones_of(n_stops: usize, mu: &[f64], pressed_by: &[Vec<usize>]) -> Vec<Cone> {
    let cone = |stop: usize| {
        let own: Vec<usize> = (0..mu.len()).filter(|&k| pressed_by[k].contains(&stop)).collect();
        let along = <[usize; 2]>::try_from(own.as_slice()).ok();
        let mu = along.map_or(0.0, |[first, _]| mu[first]);
        let along = along.map(|rows| rows.map(|k| n_stops + k));
        Cone { normal: stop, along, mu, holding: mu, slip: None, lets_go: false }
    };
    (0..n_stops).map(cone).collect()
}
