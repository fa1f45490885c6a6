//! Values between text and model: of one node of an expression, and of a whole expression in SI.

use bksim_expr::{Expr, Number, Pool};

use super::dimension::Dimension;
use super::replay::Constant;
use crate::diagnostic::Span;

/// The symbols that an expression may depend on besides parameters.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Scope {
    /// Nothing: it must not change during the motion.
    Constant,
    /// Positions, and signals that are held.
    Position,
    /// Time.
    Time,
    /// Time and everything of the motion but reactions.
    Motion,
    /// All that, and reactions.
    Load,
    /// All that, at the ticks of a clock.
    Tick,
    /// All that and accelerations, for results alone.
    Output,
}

/// A value of the file in SI.
#[derive(Clone, Debug)]
pub(super) struct Scalar {
    pub(super) expr: Expr,
    /// Value of the scalar, when it depends on parameters only.
    pub(super) value: Option<Constant>,
    /// True if the author wrote no unit.
    pub(super) is_bare: bool,
    /// Position of the text without its quotes, or of the number.
    pub(super) span: Span,
}

/// The dimension of a value as far as it is known.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    /// Written without a unit.
    Bare,
    /// Of this dimension, in SI.
    Known(Dimension),
}

/// A pure number or an angle.
pub(super) const PURE: Kind = Kind::Known(Dimension::NONE);

/// A node of an expression.
#[derive(Clone, Debug)]
pub(super) struct Lowered {
    pub(super) expr: Expr,
    pub(super) kind: Kind,
    /// Value at the parameters of the file, unless it depends on time or motion.
    pub(super) value: Option<Constant>,
    /// True if it is an angle rather than a pure number, for wording.
    pub(super) is_angle: bool,
    /// True if it is made of written numbers only.
    pub(super) is_literal: bool,
    /// Position in the file.
    pub(super) span: Span,
    /// Position of the unit, when it is a number with a unit.
    pub(super) unit_span: Option<Span>,
    /// A bare number that is a term of this sum.
    pub(super) addend: Option<Box<Self>>,
}

impl Lowered {
    /// A bare number.
    pub(super) fn number(pool: &Pool, number: Number, span: Span) -> Self {
        let value = number.to_f64();
        Self {
            expr: pool.number(number),
            kind: Kind::Bare,
            value: Some(Constant::written(value)),
            is_angle: false,
            is_literal: true,
            span,
            unit_span: None,
            addend: None,
        }
    }

    pub(super) fn new(expr: Expr, kind: Kind, value: Option<Constant>, span: Span) -> Self {
        Self {
            expr,
            kind,
            value,
            is_angle: false,
            is_literal: false,
            span,
            unit_span: None,
            addend: None,
        }
    }

    pub(super) fn varies(&self) -> bool {
        self.value.is_none()
    }
}

/// The noun for a value of a dimension.
pub(super) fn describe(dimension: Dimension, is_angle: bool) -> String {
    match dimension.noun() {
        _ if dimension == Dimension::NONE && is_angle => "angle".to_owned(),
        Some(noun) => noun.to_owned(),
        None => format!("a quantity in {dimension}"),
    }
}
