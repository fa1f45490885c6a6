//! States, signals and clocks: quantities of controllers, motors and other parts that are not bodies.

use bksim_expr::{Expr, SymbolId};

use crate::diagnostic::Span;
use crate::ids::ClockId;

/// A quantity of first order, integrated together with the motion.
#[derive(Clone, Debug)]
pub struct State {
    /// Name as written.
    pub name: String,
    /// Its rate: an expression of time, parameters and signals.
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
    /// Its value, SI.
    pub value: Expr,
    /// SI unit as text, empty of a pure number and where the author gave none.
    pub unit: String,
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

/// A signal that changes at the ticks of a clock and is held in between.
#[derive(Clone, Debug)]
pub struct SampledSignal {
    /// Its clock.
    pub clock: ClockId,
    /// Symbol of the value that is held.
    pub held: SymbolId,
    /// Symbol of the value before the last tick of its clock, which other sampled signals may use.
    pub previous: SymbolId,
    /// The value that it takes at a tick: an expression of time, parameters, signals and values held.
    pub value: Expr,
    /// Its value before the first tick, an expression of parameters.
    pub start: Expr,
    /// Name as written.
    pub name: String,
    /// Position of the value.
    pub span: Span,
}
