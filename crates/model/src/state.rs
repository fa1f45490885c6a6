//! States, signals and clocks: quantities of controllers, motors and other parts that are not bodies.

use bksim_expr::{Expr, SymbolId};

use crate::diagnostic::Span;
use crate::ids::ClockId;

/// A quantity of first order, integrated together with the motion.
#[derive(Clone, Debug)]
pub struct State {
    /// Name as written.
    pub name: String,
    /// Rate of the state: an expression of time, parameters and signals.
    pub rate: Expr,
    /// SI units as text of its integral, of the state and of its rate; of a state without unit as of a pure
    /// number.
    pub units: [String; 3],
    /// Exponents of kilogram, metre, second and ampere in the unit of the state; none of a state without unit,
    /// and where they are not whole.
    pub exponents: Option<[i64; 4]>,
    /// Position of the rate.
    pub span: Span,
}

/// An expression of the motion that the author gave a name.
#[derive(Clone, Debug)]
pub struct NamedSignal {
    /// Name as written.
    pub name: String,
    /// Value of the signal, SI.
    pub value: Expr,
    /// SI unit as text, empty of a pure number and where the author gave none.
    pub unit: String,
    /// True of an output, which results have but nothing of the motion depends on: it may use accelerations.
    pub is_output: bool,
    /// Position of the value.
    pub span: Span,
}

/// Instants at which sampled signals change: `start` + k `every`, k = 0, 1, 2, …
#[derive(Clone, Debug)]
pub struct Clock {
    /// Name as written.
    pub name: String,
    /// First tick, s, an expression of parameters.
    pub start: Expr,
    /// From tick to tick, s, an expression of parameters.
    pub every: Expr,
    /// Position of the name.
    pub span: Span,
}

/// A signal that keeps its value in between: from tick to tick of a clock, or from event to event.
#[derive(Clone, Debug)]
pub struct HeldSignal {
    /// Name as written.
    pub name: String,
    /// Symbol of the value that is held.
    pub held: SymbolId,
    /// Symbol of the value before the last tick of its clock, which sampled signals may use.
    pub previous: SymbolId,
    /// Value at first, an expression of parameters.
    pub start: Expr,
    /// The occasions on which it changes.
    pub change: HeldChange,
    /// Position of the value, or of the rows.
    pub span: Span,
}

/// The occasions on which a signal that is held takes another value.
#[derive(Clone, Debug)]
pub enum HeldChange {
    /// The ticks of a clock: the signal is sampled.
    Tick {
        /// Clock of the change.
        clock: ClockId,
        /// The value that it takes: an expression of time, parameters, signals and values held.
        value: Expr,
    },
    /// Conditions that come to hold: the signal is latched.
    Event {
        /// In file order; the first that comes to hold counts.
        rows: Vec<LatchRow>,
    },
    /// Half a turn of a direction against the start: the signal counts them, so that the angle below stays within one
    /// turn and the whole one runs on.
    HalfTurn {
        /// Angle since the start less π times the count, rad: an expression of signals and of the count.
        left_over: Expr,
    },
}

/// A condition, and the value that a latched signal takes where it comes to hold.
#[derive(Clone, Copy, Debug)]
pub struct LatchRow {
    /// One where it holds, zero elsewhere: comparisons of time, parameters, signals and values held.
    pub condition: Expr,
    /// An expression of time, parameters, signals and values held.
    pub value: Expr,
}

impl HeldSignal {
    /// The rows of a latched signal; none of one that is sampled.
    pub fn rows(&self) -> &[LatchRow] {
        match &self.change {
            HeldChange::Tick { .. } | HeldChange::HalfTurn { .. } => &[],
            HeldChange::Event { rows } => rows,
        }
    }

    /// True of a count of half turns, which changes no value of the motion.
    pub fn is_count(&self) -> bool {
        matches!(self.change, HeldChange::HalfTurn { .. })
    }
}
