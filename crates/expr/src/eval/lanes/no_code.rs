//! [`AnyAngleCode`] of processors for which there is no assembler: tapes are interpreted.

use super::{Group, LaneValues, Layout};
use crate::tape::Tape;

/// Machine code of one tape; none can be made.
#[derive(Debug)]
pub(in crate::eval) enum AnyAngleCode<const N: usize> {}

impl<const N: usize> AnyAngleCode<N> {
    /// Always `None`.
    pub(in crate::eval) fn of(_: &Tape, _: Layout) -> Option<Self> {
        None
    }

    /// Never called.
    pub(in crate::eval) fn evaluate(
        &self,
        _: &Tape,
        _: &mut LaneValues<N>,
        _: Group,
        _: &[f64],
        _: &mut [f64],
    ) -> bool {
        match *self {}
    }
}

/// False: there are no registers with lanes that code could use.
pub(super) fn has_eight_lanes() -> bool {
    false
}
