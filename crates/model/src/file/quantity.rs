//! Values of the file: bare numbers, quantities and expressions, as expressions in SI.

use bksim_expr::{Expr, Number, ParseError, ParseErrorKind, ParseOptions, Syntax, parse};

use super::codes;
use super::dimension::Dimension;
use super::reader::Reader;
use super::replay::Constant;
use super::tree::{Node, Quoted, Value};
use super::units::{Quantity, Scale, UNITS, find_unit};
use super::value::{Kind, Lowered, Scalar, Scope, describe};
use super::words::{closest, cut, suggest};
use super::written_unit::join_units;
use crate::diagnostic::{Diagnostic, Span};
use crate::message::short;

impl Reader<'_> {
    /// The value that a node must be: a number, or a quantity or expression in quotes.
    pub(super) fn scalar(
        &mut self,
        node: &Node,
        quantity: Quantity,
        what: &str,
        scope: Scope,
    ) -> Option<Scalar> {
        let span = match node.text(self.text) {
            Some(quoted) => quoted.span_of(&(0..quoted.text.len())),
            None => node.span.clone(),
        };
        let lowered = match &node.value {
            Value::Number { value, digits } => {
                self.literal(*value, digits, what, quantity.example, &node.span)?
            }
            Value::Text(_) => {
                let quoted = node.text(self.text)?;
                let syntax = self.parse(&quoted, what, quantity.example)?;
                self.lower(&syntax, &quoted, what, scope)?
            }
            other => {
                let example = format!("for example \"{}\"", quantity.example);
                self.wrong_kind(node, what, "a quantity", other, &example);
                return None;
            }
        };
        let is_bare = lowered.kind == Kind::Bare;
        let (expr, value) = self.accept(&lowered, quantity, what)?;
        if let Some(value) = value {
            self.check_turns(quantity, what, value.look(), &span)?;
        }
        if let Some(value) = value.filter(|_| is_bare) {
            self.check_angle(&lowered, quantity, what, value.look());
        }
        Some(Scalar { expr, value, is_bare, span })
    }

    /// A number without quotes.
    pub(super) fn literal(
        &mut self,
        value: f64,
        digits: &str,
        what: &str,
        example: &str,
        span: &Span,
    ) -> Option<Lowered> {
        let mantissa = digits.split(['e', 'E']).next().unwrap_or_default();
        let vanished = value == 0.0 && mantissa.contains(|c: char| ('1'..='9').contains(&c));
        if !value.is_finite() || vanished {
            let fault = match (value.is_nan(), vanished) {
                (true, _) => "is not a number",
                (_, true) => "is too small a number",
                _ => "is not a finite number",
            };
            self.report(
                Diagnostic::error(codes::NOT_FINITE, format!("{what} {fault}"))
                    .at(span.clone(), "")
                    .help(format!("write for example \"{example}\"")),
            );
            return None;
        }
        let exact = Number::parse(digits).map_or(Number::float(value), |number| {
            if value.is_sign_negative() { number.negated() } else { number }
        });
        Some(Lowered::number(&self.pool, exact, span.clone()))
    }

    /// Reads an expression into its syntax tree.
    pub(super) fn parse(
        &mut self,
        quoted: &Quoted<'_>,
        what: &str,
        example: &str,
    ) -> Option<Syntax> {
        if quoted.text.trim().is_empty() {
            self.report(
                Diagnostic::error(codes::EXPRESSION, format!("{what} is empty"))
                    .at(quoted.whole.clone(), "")
                    .help(format!("write for example \"{example}\"")),
            );
            return None;
        }
        let is_own = |name: &str| {
            let is_local = self.local.as_ref().is_some_and(|(local, _)| local == name);
            is_local || self.names.plain(name).is_some()
        };
        match syntax_of(quoted.text, self.nesting, &is_own) {
            Ok(syntax) => Some(syntax),
            Err(error) => {
                self.report_parse_error(&error, quoted, what);
                None
            }
        }
    }

    fn report_parse_error(&mut self, error: &ParseError, quoted: &Quoted<'_>, what: &str) {
        let location = quoted.span_of(&error.span);
        let fault = |message: String| Diagnostic::error(codes::EXPRESSION, message);
        let fault = match &error.kind {
            // Parentheses.
            ParseErrorKind::UnclosedParenthesis => fault("`(` is not closed".to_owned())
                .at(location, "opened here")
                .help("add `)` where it ends"),
            ParseErrorKind::UnopenedParenthesis => fault("`)` closes nothing".to_owned())
                .at(location, "never opened")
                .help("remove it, or add `(` before it"),
            ParseErrorKind::TooDeep { limit } => {
                Diagnostic::error(codes::NESTING, format!("parentheses nested deeper than {limit}"))
                    .at(location, "the first one too deep")
                    .help("use a parameter for a part of it, or allow more with `--max-nesting`")
            }
            // Words and their order.
            ParseErrorKind::UnknownUnit { name } => {
                let units: Vec<&str> = UNITS.iter().map(|unit| unit.name).collect();
                let help = if self.names.plain(name).is_some() {
                    format!("write `*` between the number and `{name}`")
                } else if closest(name, &units).is_some() {
                    suggest(name, &units)
                } else {
                    "units: `bksim explain M030` lists them".to_owned()
                };
                let message = format!("unknown unit `{}`", cut(name));
                Diagnostic::error(codes::UNKNOWN_UNIT, message)
                    .at(location, "not a unit")
                    .help(help)
            }
            ParseErrorKind::UnexpectedEnd { expected } => {
                fault(format!("{what} ends where {expected} must follow"))
                    .at(location, "ends here")
                    .help(format!("write {expected} at the end"))
            }
            ParseErrorKind::UnexpectedToken { found, expected } => {
                let help = if *expected == "an operator" {
                    format!("write `*` before `{}` to multiply", cut(found))
                } else {
                    format!("write {expected} before it, or remove it")
                };
                fault(format!("found `{}` where {expected} must stand", cut(found)))
                    .at(location, "not expected here")
                    .help(help)
            }
            // Characters and digits.
            ParseErrorKind::UnexpectedCharacter { found: found @ ('=' | '!') } => {
                fault(format!("an expression cannot contain `{found}`"))
                    .at(location, "")
                    .help("the comparisons are `<`, `<=`, `>` and `>=`")
            }
            ParseErrorKind::UnexpectedCharacter { found } => {
                fault(format!("an expression cannot contain `{}`", found.escape_debug()))
                    .at(location, "")
                    .help(
                        "use + - * / ^ ( ), numbers, units, names, functions; a point in decimals",
                    )
            }
            ParseErrorKind::BadNumber { found } => fault(format!("`{}` is no number", cut(found)))
                .at(location, "")
                .help("write digits and one point, such as 0.5 or 1.2e-3"),
            other => {
                fault(format!("{what}: {other}")).at(location, "").help("see `bksim explain M020`")
            }
        };
        self.report(fault);
    }

    /// The value as the quantity that is needed.
    pub(super) fn accept(
        &mut self,
        lowered: &Lowered,
        quantity: Quantity,
        what: &str,
    ) -> Option<(Expr, Option<Constant>)> {
        match lowered.kind {
            Kind::Bare => {
                let scale = self.units.scale(quantity);
                let value = lowered.value.map(|value| self.constants.scaled(value, scale));
                Some((self.scaled(lowered.expr, scale), value))
            }
            Kind::Known(found) if found == quantity.dimension() => {
                Some((lowered.expr, lowered.value))
            }
            Kind::Known(found) => {
                let noun = describe(found, lowered.is_angle);
                let expected = quantity.noun;
                let location = lowered.unit_span.clone().unwrap_or_else(|| lowered.span.clone());
                let message = format!("{what}: expected {expected}, found {noun}");
                let label =
                    if found == Dimension::NONE { String::new() } else { format!("in {found}") };
                let fault = Diagnostic::error(codes::WRONG_DIMENSION, message).at(location, label);
                self.report(fault.help(format!("write for example \"{}\"", quantity.example)));
                None
            }
        }
    }

    /// The expression times a conversion factor.
    pub(super) fn scaled(&self, expr: Expr, scale: Scale) -> Expr {
        if scale.is_one() {
            return expr;
        }
        let pool = &self.pool;
        let factor =
            pool.div(pool.number(Number::float(scale.up)), pool.number(Number::float(scale.down)));
        let pi = pool.powi(pool.pi(), i64::from(scale.pi));
        pool.product([expr, factor, pi])
    }

    /// Refuses an angle of whose sine too few digits are left.
    fn check_turns(
        &mut self,
        quantity: Quantity,
        what: &str,
        value: f64,
        span: &Span,
    ) -> Option<()> {
        /// rad: a sine has seven digits there.
        const LARGEST: f64 = 1e9;
        if !quantity.is_angle() || value.abs() <= LARGEST {
            return Some(());
        }
        let turn = 2.0 * std::f64::consts::PI;
        let message = format!("{what} is {} rad = {} turns", short(value), short(value / turn));
        self.report(
            Diagnostic::error(codes::NOT_FINITE, message)
                .at(span.clone(), "too large to be an angle: its sine has lost its digits")
                .help("write the angle without its whole turns, for example \"30 deg\""),
        );
        None
    }

    /// Warns of a bare angle that is more than a turn and looks like degrees.
    fn check_angle(&mut self, lowered: &Lowered, quantity: Quantity, what: &str, value: f64) {
        let turn = 2.0 * std::f64::consts::PI;
        let looks_round = (2.0 * value).fract() == 0.0;
        if !quantity.is_angle() || self.units.angle_stated || value.abs() <= turn || !looks_round {
            return;
        }
        let Some((name, location)) = self.bare_source(lowered) else { return };
        let what = name.map_or_else(|| what.to_owned(), |name| format!("the angle `{name}`"));
        self.report(
            Diagnostic::warning(
                codes::LOOKS_LIKE_DEGREES,
                format!("{what} is {} rad = {:.1} turns", short(value), value / turn),
            )
            .at(location, "a number without unit is in radians")
            .help(format!("write \"{0} deg\", or \"{0} rad\" if it is right", short(value))),
        );
    }

    /// Position of a bare number: here, or in the definition of the parameter that it is.
    fn bare_source(&self, lowered: &Lowered) -> Option<(Option<String>, Span)> {
        if lowered.is_literal {
            return Some((None, lowered.span.clone()));
        }
        let known = self.parameters.iter().find(|p| p.symbol == lowered.expr)?;
        Some((Some(known.name.clone()), known.span.clone()))
    }
}

/// The syntax of an expression. A unit goes on after a space or `/`, so that a parameter `m` leaves `3 N/m` alone;
/// after a written `*` a name of the model, which `is_own` tells, comes first, as in `3 kg*h^2`. `t` is the time
/// always.
///
/// # Errors
/// [`ParseError`] when the text is no expression.
pub(super) fn syntax_of(
    written: &str,
    max_depth: usize,
    is_own: &dyn Fn(&str) -> bool,
) -> Result<Syntax, ParseError> {
    let text = join_units(written);
    let is_name = |name: &str| {
        let before = written[..place_within(&text, name)].trim_end();
        name == "t" || before.ends_with('*') && is_own(name)
    };
    let is_unit = |name: &str| find_unit(name).is_some();
    parse(&text, &ParseOptions { max_depth, is_unit: &is_unit, is_name: &is_name })
}

/// Start of a part of a text; the parser hands out parts of the text it was given.
fn place_within(text: &str, part: &str) -> usize {
    let location = (part.as_ptr() as usize).saturating_sub(text.as_ptr() as usize);
    if text.is_char_boundary(location) { location } else { 0 }
}
