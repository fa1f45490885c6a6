//! Questions of design against reference problems: optima, fits, tolerances, synthesis.

mod fits;
mod optima;
mod synthesis;
mod tolerances;
