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
}

/// The ropes with the nodes that they are held to, and their turns.
fn held(model: &Model) -> impl Iterator<Item = (&Rope, usize, Expr)> {
    let nodes = model
        .ropes
        .iter()
        .flat_map(|rope| rope.nodes.iter().enumerate().map(move |(k, node)| (rope, k, node)));
    nodes.filter_map(|(rope, k, node)| Some((rope, k, node.turn.filter(|_| !node.leaves)?)))
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
