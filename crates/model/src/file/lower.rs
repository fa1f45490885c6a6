//! Syntax tree to expression, with the dimension and, where it is constant, the value of every
//! node.
//!
//! A bare number has no dimension of its own ([`Kind::Bare`]) and takes the one that is needed
//! where it is added, or where the whole value is used; it is then in the units of the file.

use bksim_expr::{BinaryOperator, Expr, Number, Syntax, SyntaxKind, UnitFactor};

use super::codes;
use super::dimension::Dimension;
use super::names::Meaning;
use super::names::PREVIOUS;
use super::reader::Reader;
use super::replay::Constant;
use super::tree::Quoted;
use super::units::{Quantity, Scale};
use super::value::{Kind, Lowered, Scope, describe};
use super::words::cut;
use super::written_unit::{MAX_UNIT_EXPONENT, WrittenUnit};
use crate::diagnostic::{Diagnostic, Span};
use crate::message::short;

/// True if a value is known to be zero; the values that follow from it are not finite then.
fn is_zero(value: Option<Constant>) -> bool {
    value.is_some_and(|value| value.look() == 0.0)
}

/// The position of an expression and the symbols it may use.
pub(super) struct Context<'c> {
    pub(super) quoted: &'c Quoted<'c>,
    pub(super) what: &'c str,
    pub(super) scope: Scope,
    pub(super) syntax: &'c Syntax,
}

impl Reader<'_> {
    /// Lowers a whole expression of any dimension. Every fault in it is reported; `None` when there was one, here
    /// or in a parameter that it uses.
    pub(super) fn lower(
        &mut self,
        syntax: &Syntax,
        quoted: &Quoted<'_>,
        what: &str,
        scope: Scope,
    ) -> Option<Lowered> {
        self.lower_as(syntax, quoted, (what, scope), None)
    }

    /// Lowers an expression, with parameters as they are.
    pub(super) fn lower_once(
        &mut self,
        syntax: &Syntax,
        quoted: &Quoted<'_>,
        what: &str,
        scope: Scope,
    ) -> Option<Lowered> {
        let context = Context { quoted, what, scope, syntax };
        let mut nodes: Vec<Option<Lowered>> = Vec::with_capacity(syntax.nodes.len());
        for (idx, node) in syntax.nodes.iter().enumerate() {
            if self.has_seen_enough() {
                return None;
            }
            let span = quoted.span_of(&node.span);
            let lowered = match &node.kind {
                SyntaxKind::Number(number) => self.finite(number.clone(), span, what),
                SyntaxKind::Quantity { value, factors, .. } => {
                    self.with_unit(value.clone(), factors, span, &context)
                }
                SyntaxKind::Unit { operand, factors } => nodes[*operand]
                    .clone()
                    .and_then(|operand| self.given_unit(&operand, factors, span, &context)),
                SyntaxKind::Name(name) => self.named(name, &node.span, &context),
                SyntaxKind::Negate(operand) => nodes[*operand].clone().map(|operand| Lowered {
                    expr: self.pool.neg(operand.expr),
                    value: operand.value.map(|value| self.constants.negate(value)),
                    span,
                    unit_span: None,
                    ..operand
                }),
                SyntaxKind::Binary { operator, left, right, .. } => {
                    let operands = (nodes[*left].clone(), nodes[*right].clone());
                    let (Some(a), Some(b)) = operands else {
                        nodes.push(None);
                        continue;
                    };
                    self.binary(*operator, &a, &b, (span, *right), &context)
                }
                SyntaxKind::Call { name, arguments, .. } if name == PREVIOUS => {
                    self.previous(arguments, span, &context)
                }
                SyntaxKind::Call { name, name_span, arguments } => {
                    let arguments: Vec<Option<Lowered>> =
                        arguments.iter().map(|&at| nodes[at].clone()).collect();
                    self.call(name, name_span, &arguments, span, &context)
                }
            };
            debug_assert_eq!(nodes.len(), idx);
            let lowered = lowered.and_then(|lowered| self.real(lowered, &context));
            nodes.push(lowered);
        }
        let whole = quoted.span_of(&(0..quoted.text.len()));
        let root = nodes.pop().flatten()?;
        // The position of the whole value, with parentheses and spaces.
        let span = if root.unit_span.is_some() { root.span.clone() } else { whole };
        Some(Lowered { span, ..root })
    }

    fn finite(&mut self, number: Number, span: Span, what: &str) -> Option<Lowered> {
        if number.to_f64().is_finite() {
            return Some(Lowered::number(&self.pool, number, span));
        }
        self.report(
            Diagnostic::error(codes::NOT_FINITE, format!("{what} holds too large a number"))
                .at(span, "")
                .help("write a number below 1e308"),
        );
        None
    }

    /// A unit; reports exponents that no quantity has.
    fn written_unit(
        &mut self,
        factors: &[UnitFactor],
        context: &Context<'_>,
    ) -> Option<WrittenUnit> {
        if let Some(factor) = factors.iter().find(|f| f.exponent.abs() > MAX_UNIT_EXPONENT) {
            let exponent = factor.exponent;
            let message = format!("the unit `{}` has the exponent {exponent}", factor.name);
            self.report(
                Diagnostic::error(codes::UNKNOWN_UNIT, message)
                    .at(context.quoted.span_of(&factor.span), "")
                    .help(format!("write an exponent up to {MAX_UNIT_EXPONENT}")),
            );
            return None;
        }
        WrittenUnit::of(factors)
    }

    /// A number with a unit.
    fn with_unit(
        &mut self,
        number: Number,
        factors: &[UnitFactor],
        span: Span,
        context: &Context<'_>,
    ) -> Option<Lowered> {
        let unit = self.written_unit(factors, context)?;
        let number = self.finite(number, span, context.what)?;
        self.in_unit(number, unit, factors, context)
    }

    /// A value that has no unit yet, with the unit that is written after it.
    fn given_unit(
        &mut self,
        operand: &Lowered,
        factors: &[UnitFactor],
        span: Span,
        context: &Context<'_>,
    ) -> Option<Lowered> {
        let unit = self.written_unit(factors, context)?;
        // Radians change nothing: `atan(x) rad` is an angle.
        let is_radian = unit.is_angle && unit.scale.is_one() && unit.dimension == Dimension::NONE;
        if let Kind::Known(found) = operand.kind
            && (found != Dimension::NONE || operand.is_angle && !is_radian)
        {
            let noun = describe(found, operand.is_angle);
            let written = factors.first()?.span.start..factors.last()?.span.end;
            let name = context.quoted.text.get(written.clone()).unwrap_or_default();
            let message = format!("{}: `{}` after {noun}", context.what, cut(name));
            let label = if found == Dimension::NONE {
                "an angle".to_owned()
            } else {
                format!("in {found}")
            };
            self.report(
                Diagnostic::error(codes::WRONG_DIMENSION, message)
                    .at(context.quoted.span_of(&written), "a second unit")
                    .at(operand.span.clone(), label)
                    .help("remove the unit, or write it after the number that it belongs to"),
            );
            return None;
        }
        self.in_unit(Lowered { span, ..operand.clone() }, unit, factors, context)
    }

    /// A pure number as one of a unit.
    fn in_unit(
        &mut self,
        number: Lowered,
        WrittenUnit { scale, dimension, is_angle }: WrittenUnit,
        factors: &[UnitFactor],
        context: &Context<'_>,
    ) -> Option<Lowered> {
        let unit_range = factors.first()?.span.start..factors.last()?.span.end;
        let value = number.value.map(|value| self.constants.scaled(value, scale));
        Some(Lowered {
            is_angle,
            unit_span: Some(context.quoted.span_of(&unit_range)),
            ..Lowered::new(
                self.scaled(number.expr, scale),
                Kind::Known(dimension),
                value,
                number.span,
            )
        })
    }

    /// Refuses constant values that are no finite numbers although their parts were.
    fn real(&mut self, lowered: Lowered, context: &Context<'_>) -> Option<Lowered> {
        if lowered.value.is_none_or(|value| value.look().is_finite()) {
            return Some(lowered);
        }
        let value = lowered.value.map_or(f64::NAN, Constant::look);
        let fault = if value.is_nan() { "has no real value" } else { "is too large" };
        self.report(
            Diagnostic::error(codes::NOT_REAL, format!("{} {fault} here", context.what))
                .at(lowered.span, fault)
                .help("change the parameters it uses so that it stays in range"),
        );
        None
    }

    fn binary(
        &mut self,
        operator: BinaryOperator,
        a: &Lowered,
        b: &Lowered,
        (span, right): (Span, usize),
        context: &Context<'_>,
    ) -> Option<Lowered> {
        let is_literal = a.is_literal && b.is_literal;
        let both = a.value.zip(b.value);
        let lowered = match operator {
            BinaryOperator::Add | BinaryOperator::Subtract => {
                let is_sum = operator == BinaryOperator::Add;
                // Terms have one dimension; a number among them may turn out to be an angle.
                let is_constant = |term: &&Lowered| term.kind == Kind::Bare && term.value.is_some();
                let addend = [a, b].into_iter().find(is_constant);
                let addend = addend.map(|term| Box::new(Lowered { addend: None, ..term.clone() }));
                let (a, b) = self.alike(a, b, if is_sum { "add" } else { "subtract" })?;
                let value = a.value.zip(b.value).map(|(a, b)| {
                    let constants = &mut self.constants;
                    if is_sum { constants.add(a, b) } else { constants.subtract(a, b) }
                });
                let expr = if is_sum {
                    self.pool.add(a.expr, b.expr)
                } else {
                    self.pool.sub(a.expr, b.expr)
                };
                let is_angle = a.is_angle || b.is_angle;
                let addend = addend.or(a.addend).or(b.addend);
                Lowered { is_angle, addend, ..Lowered::new(expr, a.kind, value, span) }
            }
            BinaryOperator::Multiply => {
                // Dimensions multiply with the factors.
                let kind = self.product_kind(a, b, Dimension::times, context.scope)?;
                let expr = self.pool.mul(a.expr, b.expr);
                let is_angle = a.is_angle != b.is_angle;
                let value = both.map(|(a, b)| self.constants.multiply(a, b));
                Lowered { is_angle, ..Lowered::new(expr, kind, value, span) }
            }
            BinaryOperator::Divide => {
                if is_zero(b.value) {
                    self.division_by_zero(b, right, context);
                    return None;
                }
                let kind = self.product_kind(a, b, Dimension::over, context.scope)?;
                let expr = self.pool.div(a.expr, b.expr);
                let is_angle = a.is_angle && !b.is_angle;
                let value = both.map(|(a, b)| self.constants.divide(a, b));
                Lowered { is_angle, ..Lowered::new(expr, kind, value, span) }
            }
            BinaryOperator::Power => {
                // The exponent is a pure number, known if the base has a dimension.
                let exponent = self.pure(b, "an exponent", context)?;
                if is_zero(a.value) && exponent.1.is_some_and(|n| n.look() < 0.0) {
                    self.division_by_zero(a, right, context);
                    return None;
                }
                let kind = self.power_kind(a, exponent.1, &span, context)?;
                let value = a.value.zip(exponent.1).map(|(a, n)| self.constants.power(a, n));
                Lowered::new(self.pool.pow(a.expr, exponent.0), kind, value, span)
            }
        };
        Some(Lowered { is_literal, ..lowered })
    }

    /// Both operands with one dimension, the bare one converted.
    pub(super) fn alike(
        &mut self,
        a: &Lowered,
        b: &Lowered,
        verb: &str,
    ) -> Option<(Lowered, Lowered)> {
        match (a.kind, b.kind) {
            (Kind::Known(first), Kind::Known(second)) if first != second => {
                let unit = |d: Dimension, is_angle: bool| match d {
                    Dimension::NONE => describe(d, is_angle),
                    _ => d.to_string(),
                };
                let time = Dimension::new(0, 0, 1);
                let lacks_rate = a.is_angle && second == time || b.is_angle && first == time;
                let (first, second) = (unit(first, a.is_angle), unit(second, b.is_angle));
                let message = match verb {
                    "subtract" => format!("cannot subtract {second} from {first}"),
                    _ => format!("cannot {verb} {first} and {second}"),
                };
                let help = if lacks_rate {
                    "write the time times a rate, such as `2 rad/s*t`"
                } else {
                    "bring both to one dimension: check each unit, and which factor is missing"
                };
                self.report(
                    Diagnostic::error(codes::CANNOT_ADD, message)
                        .at(a.span.clone(), first)
                        .at(b.span.clone(), second)
                        .help(help),
                );
                None
            }
            (Kind::Known(d), Kind::Bare) => {
                if a.is_angle && d == Dimension::NONE {
                    self.check_among_angles(b);
                }
                Some((a.clone(), self.adopt(b, d, a.is_angle)))
            }
            (Kind::Bare, Kind::Known(d)) => {
                if b.is_angle && d == Dimension::NONE {
                    self.check_among_angles(a);
                }
                Some((self.adopt(a, d, b.is_angle), b.clone()))
            }
            _ => Some((a.clone(), b.clone())),
        }
    }

    /// A bare number as a quantity of this dimension in the units of the file.
    pub(super) fn adopt(
        &mut self,
        bare: &Lowered,
        dimension: Dimension,
        is_angle: bool,
    ) -> Lowered {
        let scale = match (dimension, is_angle) {
            (Dimension::NONE, true) => self.units.scale(Quantity::ANGLE),
            (Dimension::NONE, false) => Scale::ONE,
            _ => self.units.scale_of(dimension),
        };
        Lowered {
            expr: self.scaled(bare.expr, scale),
            kind: Kind::Known(dimension),
            value: bare.value.map(|value| self.constants.scaled(value, scale)),
            ..bare.clone()
        }
    }

    /// A value that must be a pure number, with its value.
    pub(super) fn pure(
        &mut self,
        lowered: &Lowered,
        role: &str,
        context: &Context<'_>,
    ) -> Option<(Expr, Option<Constant>)> {
        match lowered.kind {
            Kind::Known(found) if found != Dimension::NONE => {
                let noun = describe(found, false);
                let message =
                    format!("{}: {role} must be a pure number, found {noun}", context.what);
                self.report(
                    Diagnostic::error(codes::WRONG_DIMENSION, message)
                        .at(lowered.span.clone(), format!("in {found}"))
                        .help(format!(
                            "divide it by a quantity in {found}, or give a number in it its unit"
                        )),
                );
                None
            }
            _ => Some((lowered.expr, lowered.value)),
        }
    }

    fn division_by_zero(&mut self, divisor: &Lowered, node_idx: usize, context: &Context<'_>) {
        // The divisor's own nodes are those inside its position; their parameters explain the zero.
        let mut used: Vec<String> = Vec::new();
        for node in &context.syntax.nodes[..=node_idx] {
            let SyntaxKind::Name(name) = &node.kind else { continue };
            let inside = context.quoted.start.is_none() || {
                let location = context.quoted.span_of(&node.span);
                location.start >= divisor.span.start && location.end <= divisor.span.end
            };
            let Some(Meaning::Parameter(idx)) = self.names.plain(name) else { continue };
            let Some(known) = self.parameters[idx].result.as_ref().filter(|_| inside) else {
                continue;
            };
            let unit = match known.kind {
                Kind::Known(d) if d != Dimension::NONE => format!(" {d}"),
                _ => String::new(),
            };
            let fact =
                format!("`{name}` = {}{unit}", short(known.value.map_or(0.0, Constant::look)));
            if !used.contains(&fact) {
                used.push(fact);
            }
        }
        let written = context.quoted.start.and_then(|_| self.text.get(divisor.span.clone()));
        let shown = match written.filter(|text| text.parse::<f64>().is_err()) {
            Some(text) => format!(": `{}` = 0", cut(text)),
            None => String::new(),
        };
        let message = format!("division by zero in {}{shown}", context.what);
        let mut fault =
            Diagnostic::error(codes::DIVISION_BY_ZERO, message).at(divisor.span.clone(), "is 0");
        if !used.is_empty() {
            fault = fault.note(used.join(", "));
        }
        self.report(fault.help("change one of the values, so that the divisor is not 0"));
    }
}
