//! The equations of motion as a person reads them, and as a program parses them.
//!
//! ```text
//! SymbolicSystem ─ ReadingForm ─┬─ Equations   every formula as a string, in one notation
//!      │             │          └─ page        a document that typesets without editing
//!      │             ├─ named constants put back ──┐
//!      └─────────────┴─ derived again from T and V ─┴─ Proof   equality at random points
//! ```
//!
//! `reading` groups the terms by acceleration, velocity, potential, load and constraint force;
//! `constants` names what depends on parameters alone; `derivation` writes the same equations
//! down from first principles, unsimplified, for [`proof`] to compare with. `levels` has what a
//! homework asks for besides: velocity and acceleration equations, the balances of free bodies, and
//! `steps` the way from T and V to the equations, derivative by derivative.

mod arrange;
mod constants;
mod contact;
mod derivation;
mod dimension;
mod form;
mod functions;
mod levels;
pub mod page;
mod proof;
mod reading;
mod steps;

pub use arrange::{Kind, Part};
pub use bksim_expr::Notation;
pub use constants::Group;
pub use contact::{ContactText, contact_texts};
pub use form::ReadingForm;
pub use functions::{FunctionText, functions};
pub use levels::{Level, RowName, drive_effort, free_bodies, levels, levels_at};
pub use proof::{Counts, Proof, Work, proof};
pub use steps::steps;

use bksim_expr::{Printer, SymbolId};

use crate::system::SymbolicSystem;
use bksim_model::Model;

/// Every formula of a system, in one notation.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Equations {
    /// T.
    pub kinetic_energy: String,
    /// V.
    pub potential_energy: String,
    /// Left sides of the Lagrange equations (1.3), one per coordinate; each equals zero.
    pub equations: Vec<String>,
    /// Left sides of the constraints that always hold; each equals zero.
    pub constraints: Vec<String>,
}

/// Writes the formulas of `system` without named constants.
pub fn equations(model: &Model, system: &SymbolicSystem, notation: Notation) -> Equations {
    ReadingForm::plain(model, system).write(model, notation)
}

impl ReadingForm {
    /// Every formula as a string.
    pub fn write(&self, model: &Model, notation: Notation) -> Equations {
        let printer = self.printer(model, notation);
        Equations {
            kinetic_energy: printer.terms(&self.kinetic_energy),
            potential_energy: printer.terms(&self.potential_energy),
            equations: (0..self.equations.len())
                .map(|i| printer.terms(&self.equation_terms(&model.pool, i)))
                .collect(),
            constraints: self.constraints.iter().map(|terms| printer.terms(terms)).collect(),
        }
    }

    /// The printer of these formulas: coordinates come after parameters; velocities,
    /// accelerations and multipliers last.
    pub fn printer<'a>(&'a self, model: &'a Model, notation: Notation) -> Printer<'a> {
        Printer::new(&model.pool, notation).moving(&self.moving).trailing(&self.trailing)
    }
}

/// Symbols that come last in a product: velocities, accelerations, multipliers.
fn trailing(system: &SymbolicSystem) -> Vec<SymbolId> {
    let coordinates = system.coordinates();
    let velocities = coordinates.iter().map(|c| c.v);
    let accelerations = coordinates.iter().map(|c| c.a);
    velocities.chain(accelerations).chain(system.constraints.iter().map(|c| c.lambda)).collect()
}
