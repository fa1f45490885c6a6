//! The derivatives of the equations along changes of the state and of the parameters, compiled.
//!
//! A change of one parameter is a direction in the space of all: those that are defined through it
//! follow. Directions of the state are inputs of the tapes, so each tape serves every quantity.

use bksim_expr::Expr;

use crate::function::Function;

use super::channels::Channels;
use super::direction::{Change, Direction};
use super::following::Following;
use super::{Sensitive, SensitivityError};
use crate::compiled::CompiledSystem;
use crate::formulate::parameter_columns;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{Method, Model, SolveOptions};

/// The derivatives that sensitivities need, compiled.
#[derive(Clone, Debug)]
pub struct SensitivityEquations {
    pub(super) sensitive: Vec<Sensitive>,
    pub(super) way: Way,
    /// Changes of g, G v + ∂g/∂t, M a + Gᵀ λ − f and G a + γ, of (t, q, v, a, λ) and ∂(t, q, v, P).
    pub(super) levels: Function,
    /// Changes of the entries of G, of (t, q) and ∂(t, q, P).
    pub(super) jacobian: Function,
    /// Row and coordinate of each of these entries.
    pub(super) cells: Vec<(usize, usize)>,
    /// Everything else that a run shows.
    pub(super) channels: Channels,
    /// By initial value: see [`super::start`].
    pub(super) closing: Function,
    /// ∂P/∂p: all parameters of the model, one direction after the other; and as functions of these.
    pub(super) directions: Vec<f64>,
    pub(super) directions_by: Function,
    pub(super) n_parameters: usize,
}

/// The way in which the derivatives are carried along the motion.
#[derive(Clone, Debug)]
pub(super) enum Way {
    /// With the steps of Radau IIA, whose stages they share: F_p of (t, y, y′), one column after the other.
    Staggered(Box<Function>),
    /// Along a motion that any method has found.
    Followed(Box<Following>),
}

/// Most coordinates of a mechanism whose linear equations are solved at all nodes of a step at once, where the
/// staggered way is open.
const MOST_AT_ONCE: usize = 16;

/// Derives and compiles the derivatives of the motion by `sensitive`, at these parameter values and for these options.
///
/// # Errors
/// [`SensitivityError`] when something in the model is sampled or unknown, or cannot be compiled.
pub fn differentiate(
    model: &Model,
    system: &SymbolicSystem,
    compiled: &CompiledSystem,
    options: &SolveOptions,
    sensitive: &[Sensitive],
    parameters: &[f64],
) -> Result<SensitivityEquations, SensitivityError> {
    let system = system.integrated();
    let derivation = Direction::new(model, system);
    let directions = derivation.checked(compiled, sensitive)?;

    // Fixed steps are Radau's unless others are asked for.
    let is_radau = options.method == Method::Radau
        || options.method == Method::Auto && options.step.is_some()
        || options.method == Method::Auto && system.coordinates().len() > MOST_AT_ONCE;
    let way = if compiled.indicators.is_empty() && compiled.pressing.is_none() && is_radau {
        let form = options.formulation;
        Way::Staggered(Box::new(parameter_columns(
            model,
            system,
            form,
            &derivation.own,
            &directions,
        )?))
    } else {
        Way::Followed(Box::new(Following::new(&derivation, &directions)?))
    };
    derived(&derivation, (sensitive, &directions), way, parameters)
}

/// The derivatives besides those of the way, along at least the directions of `sensitive`.
///
/// # Errors
/// [`SensitivityError`] when an expression cannot be compiled.
pub(super) fn derived(
    derivation: &Direction<'_>,
    (sensitive, directions): (&[Sensitive], &[Vec<Expr>]),
    way: Way,
    parameters: &[f64],
) -> Result<SensitivityEquations, SensitivityError> {
    let model = derivation.model;
    let directions_by = Function::compile(model, &directions.concat(), &[], &derivation.own)?;
    let (jacobian, cells) = derivation.jacobian()?;
    let equations = SensitivityEquations {
        sensitive: sensitive.to_vec(),
        way,
        levels: derivation.levels()?,
        jacobian,
        cells,
        channels: Channels::new(derivation)?,
        closing: derivation.closing()?,
        directions: Vec::new(),
        directions_by,
        n_parameters: model.parameters.len(),
    };
    Ok(equations.at(parameters))
}

impl SensitivityEquations {
    /// Equations along the directions that hold at other values of the parameters.
    pub(super) fn at(self, parameters: &[f64]) -> Self {
        let function = &self.directions_by;
        let directions = function.evaluate(&mut function.buffers(parameters), &[]).to_vec();
        Self { directions, ..self }
    }

    /// Quantities that the motion is differentiated by.
    pub fn sensitive(&self) -> &[Sensitive] {
        &self.sensitive
    }

    /// ∂P/∂p_k of all parameters P of the model, at an instant that stays.
    pub(super) fn change(&self, k: usize) -> Change<'_> {
        let dp = &self.directions[k * self.n_parameters..(k + 1) * self.n_parameters];
        Change { dt: 0.0, dp }
    }
}
