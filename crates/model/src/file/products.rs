//! Dimensions of products and powers.
//!
//! Multiplied, a written number counts as a pure number, except times a factor that changes
//! with the motion (`100*x`), where in an SI file it may stand for a coefficient; outputs, from
//! which nobody asks a unit, have no such coefficients. A parameter without a unit is open in an
//! SI file, and a pure number in a file with units of its own.

use super::codes;
use super::dimension::Dimension;
use super::lower::Context;
use super::reader::Reader;
use super::replay::Constant;
use super::value::{Kind, Lowered, PURE, Scope};
use crate::diagnostic::{Diagnostic, Span};

impl Reader<'_> {
    /// Dimension of a product or quotient.
    pub(super) fn product_kind(
        &mut self,
        a: &Lowered,
        b: &Lowered,
        combine: fn(Dimension, Dimension) -> Dimension,
        scope: Scope,
    ) -> Option<Kind> {
        let is_coefficient =
            |other: &Lowered| other.varies() && self.units.is_si() && scope != Scope::Output;
        // With a number in the place of the other factor.
        let combine_at = |a: &Lowered, known: Dimension| match a.kind {
            Kind::Bare => combine(Dimension::NONE, known),
            Kind::Known(_) => combine(known, Dimension::NONE),
        };
        let kind = match (a.kind, b.kind) {
            (Kind::Known(first), Kind::Known(second)) => Kind::Known(combine(first, second)),
            (Kind::Bare, Kind::Known(known)) | (Kind::Known(known), Kind::Bare) => {
                let (bare, other) = if a.kind == Kind::Bare { (a, b) } else { (b, a) };
                if bare.is_literal && !is_coefficient(other) {
                    Kind::Known(combine_at(a, known))
                } else if known == Dimension::NONE || self.units.is_si() {
                    Kind::Bare
                } else if scope == Scope::Output {
                    self.needs_unit(bare, known);
                    return None;
                } else {
                    self.take_as_pure(bare);
                    Kind::Known(combine_at(a, known))
                }
            }
            (Kind::Bare, Kind::Bare) => {
                if a.is_literal || b.is_literal || self.units.is_si() {
                    Kind::Bare
                } else if scope == Scope::Output {
                    self.needs_unit(a, Dimension::NONE);
                    return None;
                } else {
                    self.take_as_pure(a);
                    self.take_as_pure(b);
                    PURE
                }
            }
        };
        Some(kind)
    }

    /// Dimension of a power.
    pub(super) fn power_kind(
        &mut self,
        base: &Lowered,
        exponent: Option<Constant>,
        span: &Span,
        context: &Context<'_>,
    ) -> Option<Kind> {
        // The dimension follows from the exponent, but for pure numbers.
        let pinned = exponent.filter(|_| base.kind != PURE).map(|n| self.constants.pinned(n));
        let exponent = pinned.or(exponent.map(Constant::look));
        match (base.kind, exponent) {
            (Kind::Bare, Some(1.0)) | (PURE, _) => Some(base.kind),
            (Kind::Bare, _) if base.is_literal || self.units.is_si() => Some(Kind::Bare),
            (Kind::Bare, _) if context.scope == Scope::Output => {
                self.needs_unit(base, Dimension::NONE);
                None
            }
            (Kind::Bare, _) => {
                self.take_as_pure(base);
                Some(PURE)
            }
            (Kind::Known(dimension), exponent) => {
                let power = exponent.and_then(|exponent| dimension.power(exponent));
                if power.is_none() {
                    let message = format!(
                        "{} raises a quantity in {dimension} to no fixed power",
                        context.what
                    );
                    self.report(
                        Diagnostic::error(codes::WRONG_DIMENSION, message)
                            .at(span.clone(), "the unit of this is unknown")
                            .help("make the base a pure number, or the exponent a number such as 2 or 1/2"),
                    );
                }
                power.map(Kind::Known)
            }
        }
    }
}
