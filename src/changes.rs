//! Settings of a solution that stand in place of the model's own.

use bksim_mbs::model::{Formulation, Jit, Method, Outputs, SolveOptions};

/// Settings in place of those of the model; `None` leaves the model's.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct SolveChanges {
    /// End, s.
    pub t_end: Option<f64>,
    /// Relative tolerance.
    pub rtol: Option<f64>,
    /// Absolute tolerance.
    pub atol: Option<f64>,
    /// Fixed step, s.
    pub step: Option<f64>,
    /// Output interval, s.
    pub every: Option<f64>,
    /// What integrates.
    pub method: Option<Method>,
    /// Which equations Radau integrates.
    pub formulation: Option<Formulation>,
    /// When the equations become machine code.
    pub jit: Option<Jit>,
}

impl SolveChanges {
    /// Puts them in place.
    pub fn apply(&self, solve: &mut SolveOptions) {
        solve.t_end = self.t_end.unwrap_or(solve.t_end);
        solve.rtol = self.rtol.unwrap_or(solve.rtol);
        solve.atol = self.atol.unwrap_or(solve.atol);
        solve.step = self.step.or(solve.step);
        if self.every.is_some() {
            (solve.every, solve.outputs) = (self.every, Outputs::Even);
        }
        solve.method = self.method.unwrap_or(solve.method);
        solve.formulation = self.formulation.unwrap_or(solve.formulation);
        solve.jit = self.jit.unwrap_or(solve.jit);
    }
}
