//! Registers and instructions before their final numbers are known.

use super::Action;

/// A register before its final number is known: its kind and its index within the kind.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Register {
    Constant(u32),
    Parameter(u32),
    Input(u32),
    Prologue(u32),
    Body(u32),
}

impl Register {
    /// True if the value is known before the inputs are.
    pub(super) fn is_early(self) -> bool {
        !matches!(self, Self::Input(_) | Self::Body(_))
    }
}

/// An instruction on registers without final numbers.
pub(super) type Key = (Action, Register, Register, Register);

/// A count of registers as their number.
pub(super) fn index(n: usize) -> u32 {
    u32::try_from(n).expect("a tape holds fewer than 2^32 registers")
}
