//! Derivatives of everything that a run shows, by the chain rule: reactions, energies, points, signals.
//!
//! ```text
//! dh = h_q dq + h_v dv + h_a da + h_λ dλ + h_p dp
//! ```

use bksim_expr::{Expr, TapeError};

use super::direction::{Change, Direction};
use super::tangent::TangentPoint;
use crate::function::{Buffers, Function};
use crate::quantities::Quantities;
use crate::run::StateSensitivity;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{ENERGIES, Model, Space, reaction_words};

/// A channel of a run that has a formula of the state.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Channel {
    /// Name as in a log: `reactions.A.fx`, `energy.total`, `rod.B.x`.
    pub name: String,
    /// SI unit, empty of a pure number.
    pub unit: String,
}

/// The channels of a run besides coordinates and multipliers, with their derivatives compiled.
#[derive(Clone, Debug)]
pub(super) struct Channels {
    changes: Function,
}

impl Channels {
    /// Derives and compiles the derivatives of energies, reactions, signals and points.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither time, a parameter nor part of the state.
    pub(super) fn new(direction: &Direction<'_>) -> Result<Self, TapeError> {
        let Direction { model, system, .. } = direction;
        let functions: Vec<Expr> = found(model, system).map(|(function, _)| function).collect();
        let functions = model.pool.substitute_all(&functions, &system.reaction_values);
        Ok(Self { changes: direction.changes(&functions)? })
    }

    pub(super) fn buffers(&self, parameters: &[f64]) -> Buffers {
        self.changes.buffers(parameters)
    }

    /// The derivatives of all at a point.
    pub(super) fn evaluate(
        &self,
        buffers: &mut Buffers,
        at: TangentPoint<'_>,
        change: Change<'_>,
        by: &StateSensitivity,
    ) -> Vec<f64> {
        let arguments = at.arguments(change, (&by.q, &by.v), (&by.a, &by.lambda));
        self.changes.evaluate(buffers, &[&arguments]).to_vec()
    }
}

/// The channels whose derivatives a run with sensitivities has besides those of the state, in their order in
/// [`StateSensitivity::channels`].
pub fn channels(model: &Model, system: &SymbolicSystem) -> Vec<Channel> {
    found(model, system.integrated()).map(|(_, channel)| channel).collect()
}

/// The channels of a model that have a formula of the state, with that.
pub(super) fn found<'m>(
    model: &'m Model,
    system: &'m SymbolicSystem,
) -> impl Iterator<Item = (Expr, Channel)> + 'm {
    let quantities = Quantities::new(model, system);
    named(model).into_iter().filter_map(move |name| {
        let (function, unit) = quantities.named(&name)?;
        Some((function, Channel { name, unit }))
    })
}

/// The channels of a model that are looked for.
fn named(model: &Model) -> Vec<String> {
    let energies = ENERGIES.iter().map(|(part, _)| format!("energy.{part}"));
    let reactions = model.joints.iter().flat_map(|joint| {
        let of_joint = |part| format!("reactions.{}.{part}", joint.name);
        reaction_words().take(6).map(of_joint)
    });
    let signals = model.named_signals.iter().map(|one| format!("signals.{}", one.name));
    let axes: &[&str] = if model.space == Space::Planar { &["x", "y"] } else { &["x", "y", "z"] };
    let points = model.bodies.iter().flat_map(|body| {
        let of_point = |point: &str| format!("{}.{point}", body.name);
        body.points.iter().map(move |point| of_point(&point.name)).collect::<Vec<_>>()
    });
    let points = points.flat_map(|point| {
        let of_order = |order: &'static str| axes.iter().map(move |axis| format!("{order}{axis}"));
        let words = of_order("").chain(of_order("v"));
        words.map(|word| format!("{point}.{word}")).collect::<Vec<_>>()
    });
    energies.chain(reactions).chain(signals).chain(points).collect()
}
