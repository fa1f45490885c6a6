//! Bounces that are too low to be seen, in the search for modes: bodies rest instead, or go on where they turn back.

use super::mode_search::ModeSearch;
use crate::modes::ContactMode;
use crate::modes::indicators::{ContactState, IndicatorValues};

/// Bounces no higher than this many bands of rounding come to rest.
const HIDDEN: f64 = 1e3;

impl ModeSearch<'_> {
    /// Notes stops that the impact parts for a flight of rounding: bodies between two would else hit them without end.
    pub(super) fn note_grazes(&mut self, closed: &[usize]) {
        let values = self.indicators(&self.modes);
        let is_parting = |k: &usize| values.contacts[*k].rate() < -self.at.bands.rate;
        let parting: Vec<usize> = closed.iter().copied().filter(is_parting).collect();
        let Some(pressing) = self.pressing(closed, &parting) else { return };
        for &k in closed {
            let rate = values.contacts[k].rate();
            self.grazes[k] = rate < 0.0 && rate * rate <= 2.0 * pressing[k] * self.hidden();
        }
    }

    /// φ″ of all contacts with these closed stops open, or with those alone that part, whichever is larger: bodies of a pile
    /// fall side by side where nothing holds them, and onto each other where the rest does.
    fn pressing(&self, closed: &[usize], parting: &[usize]) -> Option<Vec<f64>> {
        let without = |open: &[usize]| {
            let mut modes = self.modes.clone();
            for &k in closed {
                let is_open = open.contains(&k);
                modes.contacts[k] = if is_open { ContactMode::Open } else { ContactMode::Closed };
            }
            self.motion_in(&modes).map(|motion| motion.contact_accelerations)
        };
        let free = without(closed)?;
        let held = if parting.len() < closed.len() { without(parting) } else { None };
        let Some(held) = held else { return Some(free) };
        Some(free.iter().zip(&held).map(|(free, held)| free.max(*held)).collect())
    }

    /// Takes stops out that bodies only touch: left alone, they would turn back within the absolute tolerance. A motion that
    /// comes back to a stop on which it began at rest does so, and an impact there would be one of rounding.
    pub(super) fn leave_out_touched(&self, closed: &mut Vec<usize>, values: &IndicatorValues) {
        let [depth, _] = self.at.bands.rest;
        let may_touch = |k: usize| {
            let is_open = self.modes.contacts[k] == ContactMode::Open;
            is_open && !self.contacts()[k].is_outline && values.contacts[k].rate() > 0.0
        };
        if !closed.iter().any(|&k| may_touch(k)) {
            return;
        }
        let Some(motion) = self.motion_in(&self.modes) else { return };
        closed.retain(|&k| {
            let (rate, acceleration) = (values.contacts[k].rate(), motion.contact_accelerations[k]);
            !(may_touch(k) && acceleration < 0.0 && rate * rate <= -2.0 * acceleration * depth)
        });
    }

    /// Height of flights that are of rounding.
    pub(super) fn hidden(&self) -> f64 {
        HIDDEN * self.at.bands.position
    }

    /// ε of each closed stop; none where the bounces to come are too small to be seen.
    ///
    /// Left alone, the bodies come back with φ″ > 0 after a flight of height (ε u)²/2φ″.
    pub(super) fn restitutions(&self, closed: &[usize], values: &IndicatorValues) -> Vec<f64> {
        let approaches = |k: &usize| self.at.bands.is_approaching(values.contacts[*k].rate());
        let parting: Vec<usize> = closed.iter().copied().filter(approaches).collect();
        let pressing = self.pressing(closed, &parting);
        let [height, speed] = self.at.bands.rest;
        let hidden = self.hidden();
        let of_stop = |&k: &usize| {
            let ContactState::Stop { rate, restitution, .. } = values.contacts[k] else {
                unreachable!("friction is never among the closed stops")
            };
            let parting = restitution * rate;
            let pressing = pressing.as_ref().map_or(0.0, |accelerations| accelerations[k]);
            let square = parting * parting;
            let is_small = rate <= speed && square <= 2.0 * pressing * height;
            let is_hidden = square <= 2.0 * pressing * hidden;
            if is_small || is_hidden { 0.0 } else { restitution }
        };
        closed.iter().map(of_stop).collect()
    }
}
