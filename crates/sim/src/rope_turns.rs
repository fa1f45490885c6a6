//! Turns of ropes about the pulleys that they are held to, by which it is noticed where a rope would leave one.

use bksim_expr::{Expr, SymbolId, TapeError};
use bksim_mbs::signal::signal_values;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::message::short;
use bksim_model::{Model, Rope};

use crate::codes;
use crate::function::{Buffers, Function};

/// A turn below this, rad, is no rounding of one that is zero.
const STRAIGHT: f64 = -1e-9;
/// A turn above this at the start, rad, is more likely that of a rope on the other side.
const NEARLY_ROUND: f64 = 5.0;

/// The turns of all ropes about what they go over and do not leave, as a function of positions.
#[derive(Clone, Debug)]
pub(crate) struct RopeTurns(Function);

impl RopeTurns {
    /// `None` of a mechanism without such ropes; `parameters` are those of its functions.
    ///
    /// # Errors
    /// [`TapeError`] when an expression cannot be compiled.
    pub(crate) fn compile(
        model: &Model,
        system: &SymbolicSystem,
        q: &[SymbolId],
        parameters: &[SymbolId],
    ) -> Result<Option<Self>, TapeError> {
        let measures = signal_values(model, &system.kinematics);
        let turns: Vec<Expr> =
            held(model).map(|(.., turn)| model.pool.substitute(turn, &measures)).collect();
        if turns.is_empty() {
            return Ok(None);
        }
        Function::compile(model, &turns, &[&[model.time], q], parameters).map(Self).map(Some)
    }

    /// Buffers for these parameters.
    pub(crate) fn buffers(&self, parameters: &[f64]) -> Buffers {
        self.0.buffers(parameters)
    }

    /// The first of the turns that is below zero, by its number.
    pub(crate) fn left(&self, buffers: &mut Buffers, t: f64, q: &[f64]) -> Option<usize> {
        self.0.evaluate(buffers, &[&[t], q]).iter().position(|&turn| turn < STRAIGHT)
    }

    /// The first of the turns that goes nearly once around, by its number, with its size, rad.
    pub(crate) fn nearly_round(
        &self,
        buffers: &mut Buffers,
        t: f64,
        q: &[f64],
    ) -> Option<(usize, f64)> {
        let turns = self.0.evaluate(buffers, &[&[t], q]);
        turns.iter().copied().enumerate().find(|&(_, turn)| turn > NEARLY_ROUND)
    }
}

/// The ropes with the nodes that they are held to, and their turns.
fn held(model: &Model) -> impl Iterator<Item = (&Rope, usize, Expr)> {
    let nodes = model
        .ropes
        .iter()
        .flat_map(|rope| rope.nodes.iter().enumerate().map(move |(k, node)| (rope, k, node)));
    nodes.filter_map(|(rope, k, node)| Some((rope, k, node.turn.filter(|_| !node.leaves)?)))
}

/// The warning that a rope goes nearly once around a pulley at the start; `number` is that of the turn.
pub(crate) fn rope_wound(model: &Model, number: usize, turn: f64) -> Option<Diagnostic> {
    let (rope, node, _) = held(model).nth(number)?;
    let is_left = rope.nodes[node].is_left;
    let (own, other) = if is_left { ("left", "right") } else { ("right", "left") };
    let message = format!(
        "rope `{}` goes {}° around place {} of `over` at the start",
        rope.name,
        short(turn.to_degrees()),
        node + 1
    );
    let fault = Diagnostic::warning(codes::ROPE_WOUND, message);
    Some(fault.at(rope.span.clone(), "this rope").help(format!(
        "write `turn = \"{other}\"` of this place for a rope on its other side, or leave `turn = \"{own}\"` if it is right"
    )))
}

/// The warning that a rope would leave a pulley from a sample on; `number` is that of the turn.
pub(crate) fn rope_left(model: &Model, number: usize, t: f64) -> Option<Diagnostic> {
    let (rope, node, _) = held(model).nth(number)?;
    let message = format!(
        "rope `{}` would leave place {} of `over` at t = {} s, and is held to it",
        rope.name,
        node + 1,
        short(t)
    );
    let fault = Diagnostic::warning(codes::ROPE_LEAVES, message);
    Some(fault.at(rope.span.clone(), "this rope").help(
        "write `leaves = true` of this place for a rope that leaves it and comes to it again, or end the run before",
    ))
}
