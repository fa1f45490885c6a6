//! Turns of ropes about pulleys and posts, by which it is noticed where a rope would leave one that it is held to, or
//! come to one from its other side.

use std::f64::consts::TAU;

use bksim_expr::{Expr, SymbolId, TapeError};
use bksim_mbs::signal::signal_values;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::message::short;
use bksim_model::{Model, Rope};

use crate::codes;
use crate::function::{Buffers, Function};

/// A turn that is less than it may be by this, rad, is so by rounding.
const ROUNDING: f64 = 1e-9;
/// A turn above this at the start, rad, is more likely that of a rope on the other side.
const NEARLY_ROUND: f64 = 5.0;

/// The turns of all ropes about what they go over, as a function of positions.
#[derive(Clone, Debug)]
pub(crate) struct RopeTurns {
    turns: Function,
    /// The least that each may be, rad: of one that may be left a whole turn back, where the rope comes to its other side.
    least: Vec<f64>,
    /// By node, true if the rope begins within one turn: it is held there, and no whole turns are stated.
    is_single: Vec<bool>,
}

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
            turning(model).map(|(.., turn)| model.pool.substitute(turn, &measures)).collect();
        if turns.is_empty() {
            return Ok(None);
        }
        let turns = Function::compile(model, &turns, &[&[model.time], q], parameters)?;
        let nodes: Vec<_> = turning(model).map(|(rope, k, _)| rope.nodes[k]).collect();
        let least = nodes.iter().map(|node| if node.leaves { -TAU } else { 0.0 }).collect();
        let is_single = nodes.iter().map(|node| !(node.leaves || node.is_counted)).collect();
        Ok(Some(Self { turns, least, is_single }))
    }

    /// Buffers for these parameters.
    pub(crate) fn buffers(&self, parameters: &[f64]) -> Buffers {
        self.turns.buffers(parameters)
    }

    /// The first of the turns that is less than it may be, by its number.
    pub(crate) fn left(&self, buffers: &mut Buffers, t: f64, q: &[f64]) -> Option<usize> {
        let turns = self.turns.evaluate(buffers, &[&[t], q]).iter().zip(&self.least);
        turns.into_iter().position(|(turn, least)| *turn < least - ROUNDING)
    }

    /// The first of the turns that goes nearly once around, by its number, with its size, rad.
    pub(crate) fn nearly_round(
        &self,
        buffers: &mut Buffers,
        t: f64,
        q: &[f64],
    ) -> Option<(usize, f64)> {
        let turns = self.turns.evaluate(buffers, &[&[t], q]);
        let is_single = &self.is_single;
        turns.iter().copied().enumerate().find(|&(k, turn)| turn > NEARLY_ROUND && is_single[k])
    }
}

/// The ropes with the nodes that they turn about, and their turns.
fn turning(model: &Model) -> impl Iterator<Item = (&Rope, usize, Expr)> {
    let nodes = model
        .ropes
        .iter()
        .flat_map(|rope| rope.nodes.iter().enumerate().map(move |(k, node)| (rope, k, node)));
    nodes.filter_map(|(rope, k, node)| Some((rope, k, node.turn?)))
}

/// The warning that a rope goes nearly once around a pulley at the start; `number` is that of the turn.
pub(crate) fn rope_wound(model: &Model, number: usize, turn: f64) -> Option<Diagnostic> {
    let (rope, node, _) = turning(model).nth(number)?;
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

/// The warning that a rope would leave a pulley from a sample on, or come to a post from its other side; `number` is that
/// of the turn.
pub(crate) fn rope_left(model: &Model, number: usize, t: f64) -> Option<Diagnostic> {
    let (rope, node, _) = turning(model).nth(number)?;
    let (place, is_left) = (node + 1, rope.nodes[node].is_left);
    let fault = if rope.nodes[node].leaves {
        let (own, other) = if is_left { ("left", "right") } else { ("right", "left") };
        let message = format!(
            "rope `{}` comes to place {place} of `over` from its other side at t = {} s, and goes through it",
            rope.name,
            short(t)
        );
        Diagnostic::warning(codes::OTHER_SIDE, message).help(format!(
            "end the run before, or write `turn = \"{other}\"` in place of \"{own}\" if that is the side of the rope"
        ))
    } else {
        let message = format!(
            "rope `{}` would leave place {place} of `over` at t = {} s, and is held to it",
            rope.name,
            short(t)
        );
        Diagnostic::warning(codes::ROPE_LEAVES, message).help(
            "write `leaves = true` of this place for a rope that leaves it and comes to it again, or end the run before",
        )
    };
    Some(fault.at(rope.span.clone(), "this rope"))
}
