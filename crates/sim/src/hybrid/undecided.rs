//! [`Undecided`]: modes at one instant that only the motion from there on decides, with this motion in some of them.

use super::consistent::NoConsistentModes;
use crate::modes::indicators::CompiledContact;
use crate::modes::{ContactMode, Modes};
use crate::multiplier::largest;

/// A mode that the state alone does not decide, with its choices in order of preference.
pub(super) enum Undecided {
    Kink { kink: usize, signs: [f64; 2] },
    Contact { contact: usize, modes: Vec<ContactMode> },
}

impl Undecided {
    pub(super) fn n_choices(&self) -> usize {
        match self {
            Self::Kink { signs, .. } => signs.len(),
            Self::Contact { modes, .. } => modes.len(),
        }
    }

    /// Takes the choice of this index.
    pub(super) fn take(&self, choice: usize, modes: &mut Modes) {
        match self {
            Self::Kink { kink, signs } => modes.signs[*kink] = signs[choice],
            Self::Contact { contact, modes: choices } => modes.contacts[*contact] = choices[choice],
        }
    }
}

/// Accelerations in one set of modes, and the rates that follow from them.
pub(super) struct TrialMotion {
    pub(super) a: Vec<f64>,
    pub(super) lambda: Vec<f64>,
    /// u′ of every switch.
    pub(super) kink_rates: Vec<f64>,
    /// φ″ or p″ of every contact.
    pub(super) contact_accelerations: Vec<f64>,
    /// Size of velocities and accelerations, and rounding of the latter where rows hold what forces would move.
    pub(super) scale: f64,
    pub(super) noise: f64,
}

impl TrialMotion {
    /// The multiplier of a contact; of friction in two directions the size of both.
    pub(super) fn force(&self, contacts: &[CompiledContact], contact: usize) -> f64 {
        let of = |k: usize| self.lambda[contacts[k].row];
        contacts[contact].other.map_or(of(contact), |other| of(contact).hypot(of(other)))
    }
}

/// The fault where no combination is consistent: a kink where there is one, else the contacts.
pub(super) fn none_consistent(undecided: &[Undecided]) -> NoConsistentModes {
    let mut contacts = Vec::new();
    for undecided in undecided {
        match *undecided {
            Undecided::Kink { kink, .. } => return NoConsistentModes::Chatter { kink },
            Undecided::Contact { contact, .. } => contacts.push(contact),
        }
    }
    NoConsistentModes::Contacts { contacts }
}

/// True of accelerations that differ by more than a part of the largest.
pub(super) fn differ(first: &[f64], second: &[f64], part: f64) -> bool {
    let size = largest(first).max(largest(second));
    first.iter().zip(second).any(|(a, b)| (a - b).abs() > part * size)
}
