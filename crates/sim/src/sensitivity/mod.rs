//! Sensitivities of the motion: ∂q/∂p, ∂v/∂p, ∂v̇/∂p and ∂λ/∂p for a parameter or a stated initial
//! value p, all by derivatives of the equations themselves.
//!
//! ```text
//! F_y s + F_y′ s′ + F_p = 0                                s = ∂y/∂p, along the run
//! G ∂q + g_p = 0                                           positions
//! G ∂v + (G v + ∂g/∂t)_q ∂q + (G v + ∂g/∂t)_p = 0          velocities
//! M ∂a + Gᵀ ∂λ = −d(M a + Gᵀ λ − f)                        accelerations and multipliers,
//! G ∂a = −d(G a + γ)                                       d along (∂q, ∂v, p) with a, λ held
//! ```
//!
//! [`differentiate`] derives and compiles the right sides, [`start`] solves them where the run
//! begins, and [`run_with_sensitivities`] carries s along: with fixed steps of Radau IIA, or those asked for, by the
//! staggered direct method of [`bksim_dae::SensitivitySolver`]; along the steps of any method, and across events,
//! by collocation of the linear equations ([`bksim_dae::LinearCollocation`]). As with the motion itself, positions and velocities
//! are projected onto their (linearised) constraints at every output, and ∂a and ∂λ come from the
//! equations of motion there. [`gradient()`] goes the other way: back along the motion, from one number to all that it
//! depends on. Sources: M. Caracotsios and W. E. Stewart, Comput. Chem. Eng. 9
//! (1985); W. F. Feehery, J. E. Tolsma and P. I. Barton, Appl. Numer. Math. 25 (1997).

mod channels;
mod dependent;
mod derive;
mod direction;
mod fault;
mod follower;
mod following;
mod gradient;
mod pace;
mod reduction;
mod run;
mod saltation;
mod start;
mod tangent;
mod written;

use bksim_model::Model;

pub use crate::run::StateSensitivity;
pub use channels::{Channel, channels};
pub use derive::{SensitivityEquations, differentiate};
pub(crate) use direction::parameter_direction;
pub use fault::{SensitivityError, diagnose_sensitivity};
pub use gradient::{
    Goal, Goals, Gradient, GradientPlan, SampleWeights, gradient, gradients, plan_gradient,
    plan_gradient_by_some,
};
pub use run::run_with_sensitivities;
pub use start::start;

/// Quantity that a motion is differentiated by.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Sensitive {
    /// Index into `Model::parameters`; parameters defined through it change with it.
    Parameter(usize),
    /// Index into `Model::initial`, of a stated value; all others hold.
    Initial(usize),
}

/// Derivatives that a run with sensitivities needs.
#[derive(Clone, Debug)]
pub struct SensitivityPlan {
    /// The derivatives of the equations, compiled.
    pub equations: SensitivityEquations,
    /// Sensitivities of the start, one per quantity.
    pub start: Vec<StateSensitivity>,
}

impl Sensitive {
    /// The parameter, or else the stated initial value, of this name: `l1`, `A.rate`.
    ///
    /// # Errors
    /// [`SensitivityError`] when there is none, or when it is a guess, which the motion need not obey.
    pub fn find(model: &Model, name: &str) -> Result<Self, SensitivityError> {
        if let Some(k) = model.parameters.iter().position(|p| p.name == name) {
            return Ok(Self::Parameter(k));
        }
        match model.initial.iter().position(|i| i.name == name) {
            Some(k) if model.initial[k].is_guess => Err(SensitivityError::Guess(k)),
            Some(k) => Ok(Self::Initial(k)),
            None => Err(SensitivityError::Unknown(name.to_owned())),
        }
    }

    /// The name that the author gave it.
    pub fn name(self, model: &Model) -> &str {
        match self {
            Self::Parameter(k) => &model.parameters[k].name,
            Self::Initial(k) => &model.initial[k].name,
        }
    }

    /// The unit of a derivative by it, of something in this unit: `m/(N/m)`.
    pub fn unit_of_derivative(self, model: &Model, unit: &str) -> String {
        let own = self.unit(model);
        let unit = if unit.is_empty() && !own.is_empty() { "1" } else { unit };
        match own.as_str() {
            "" => unit.to_owned(),
            own if own.contains(['/', '*', ' ']) => format!("{unit}/({own})"),
            own => format!("{unit}/{own}"),
        }
    }

    /// Unit of the quantity, empty for a bare number.
    pub fn unit(self, model: &Model) -> String {
        match self {
            Self::Parameter(k) => model.parameters[k].unit.clone(),
            Self::Initial(k) => model.initial[k].unit(model).to_owned(),
        }
    }
}
