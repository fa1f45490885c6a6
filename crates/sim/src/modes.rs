//! The modes of everything that could switch: numbers that stay as they are between two events.
//!
//! ```text
//! switch     σ            sign of the function u that decides it, ±1; 0: of multipliers, as it is written
//! stop       κ            1 in contact, else 0
//! friction   κ, ς, p₀     κ = 1 while it sticks at p₀; ς = sign p′ while it slips
//! signal     x            its value since the last tick of its clock, or the last condition
//! ```
//!
//! The compiled functions take them as parameters after the model's own, in this order: all σ, then
//! the numbers of every contact, then the signals that are held.

pub(crate) mod indicators;

use bksim_dae::{Loader, Saver, SolveError};

use crate::sampled::Held;

/// The branches and contacts that hold until the next event.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct Modes {
    /// σ of every switch, ±1; 0 where an expression of multipliers is evaluated as it is written.
    pub(crate) signs: Vec<f64>,
    /// Modes of the contacts, in the order of the system.
    pub(crate) contacts: Vec<ContactMode>,
    /// Values of the signals that are held.
    pub(crate) held: Held,
}

/// The mode of one contact.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum ContactMode {
    /// A stop apart: φ ≤ 0, λ = 0.
    Open,
    /// A stop in contact: φ = 0, λ ≥ 0.
    Closed,
    /// Friction that slips, with the sign ς of p′: λ = −ς F. Zero where friction gives no force.
    Slip(f64),
    /// Friction that sticks at the position p₀: p = p₀, |λ| ≤ F₀.
    Stick(f64),
}

impl ContactMode {
    /// True if the constraint row of the contact is active.
    pub(crate) fn is_active(self) -> bool {
        matches!(self, Self::Closed | Self::Stick(_))
    }
}

impl Modes {
    /// Saves the modes as numbers.
    pub(crate) fn save(&self, saver: &mut Saver) {
        saver.slice(&self.signs);
        for mode in &self.contacts {
            let (kind, value) = match *mode {
                ContactMode::Open => (0, 0.0),
                ContactMode::Closed => (1, 0.0),
                ContactMode::Slip(sign) => (2, sign),
                ContactMode::Stick(position) => (3, position),
            };
            saver.count(kind);
            saver.real(value);
        }
        self.held.save(saver);
    }

    /// Takes over the modes of the same switches and contacts; stops and friction keep their kinds.
    pub(crate) fn load(&mut self, loader: &mut Loader<'_>) -> Result<(), SolveError> {
        const OTHER: SolveError = SolveError::Checkpoint { reason: "saved with other contacts" };
        loader.fill(&mut self.signs)?;
        for mode in &mut self.contacts {
            let is_friction = matches!(mode, ContactMode::Slip(_) | ContactMode::Stick(_));
            let (kind, value) = (loader.count()?, loader.real()?);
            *mode = match (kind, is_friction) {
                (0, false) => ContactMode::Open,
                (1, false) => ContactMode::Closed,
                (2, true) => ContactMode::Slip(value),
                (3, true) => ContactMode::Stick(value),
                _ => return Err(OTHER),
            };
        }
        self.held.load(loader)
    }

    /// The model's parameters followed by the numbers of these modes, as
    /// `SymbolicSystem::parameters` has their symbols.
    pub(crate) fn parameters_with_modes(&self, parameters: &[f64]) -> Vec<f64> {
        let mut all = parameters.to_vec();
        all.extend(&self.signs);
        for mode in &self.contacts {
            match *mode {
                ContactMode::Open => all.push(0.0),
                ContactMode::Closed => all.push(1.0),
                ContactMode::Slip(sign) => all.extend([0.0, sign, 0.0]),
                ContactMode::Stick(position) => all.extend([1.0, 0.0, position]),
            }
        }
        all.extend(&self.held.values);
        all
    }
}
