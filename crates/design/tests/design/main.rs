//! Questions of design against reference problems: optima, fits, tolerances, synthesis.

#![expect(clippy::unreadable_literal, reason = "reference values as they are printed")]

mod adjoint;
mod fits;
mod fronts;
mod laws;
mod optima;
mod paths;
mod synthesis;
mod tolerances;
