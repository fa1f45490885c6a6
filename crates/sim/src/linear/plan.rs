//! [`EliminationPlan`]: the order of elimination, chosen once for the rows that take part in most starts.

use std::sync::{Arc, OnceLock};

use super::elimination::Elimination;
use super::shape::Shape;

/// The plan for the rows that took part first; clones share it.
#[derive(Clone, Debug, Default)]
pub(crate) struct EliminationPlan(Arc<OnceLock<(Vec<usize>, Elimination)>>);

impl EliminationPlan {
    /// The elimination with these rows, planned again where they are others than the first ones.
    pub(crate) fn of(&self, shape: &Shape, active: &[usize]) -> Elimination {
        let plan = || (active.to_vec(), Elimination::new(shape, active));
        match self.0.get_or_init(plan) {
            (planned, elimination) if planned == active => elimination.clone(),
            _ => Elimination::new(shape, active),
        }
    }
}
