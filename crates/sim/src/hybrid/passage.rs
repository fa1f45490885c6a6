//! [`Passage`]: an event that a run has passed.

use super::consistent::ConsistentModes;
use crate::modes::Modes;
use crate::modes::indicators::Indicator;
use crate::state::State;

/// An event that a run has passed: an instant at which something switched.
#[derive(Clone, PartialEq, Debug)]
pub struct Passage {
    /// The state until then.
    pub(crate) state: State,
    /// The modes until then.
    pub(crate) before: Modes,
    /// Rows that took no part until then.
    pub(crate) inactive: Vec<usize>,
    /// The functions that passed zero.
    pub(crate) fired: Vec<Indicator>,
    /// The modes from then on, with the state that they start from.
    pub(crate) after: ConsistentModes,
}

impl Passage {
    /// When it was, s.
    pub fn t(&self) -> f64 {
        self.state.t
    }
}
