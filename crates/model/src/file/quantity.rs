//! Values of the file: bare numbers, quantities and expressions, as expressions in SI.

use bksim_expr::{
    BinaryOperator, Expr, Number, ParseError, ParseOptions, Syntax, SyntaxKind, SyntaxNode, parse,
};

use super::codes;
use super::dimension::Dimension;
use super::reader::Reader;
use super::replay::Constant;
use super::sampled::Rounding;
use super::tree::{Node, Quoted, Value};
use super::units::{Quantity, Scale, find_unit};
use super::value::{Kind, Lowered, Scalar, Scope, describe};
use super::written_unit::WrittenUnit;
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
        let mut written = None;
        let lowered = match &node.value {
            Value::Number { value, digits } => {
                self.literal(*value, digits, what, quantity.example, &node.span)?
            }
            Value::Text(_) => {
                let quoted = node.text(self.text)?;
                let syntax = self.parse(&quoted, what, quantity.example)?;
                let lowered = self.lower_as(&syntax, &quoted, (what, scope), Some(quantity));
                written = Some((syntax, quoted));
                lowered?
            }
            other => {
                let example = format!("for example \"{}\"", quantity.example);
                self.wrong_kind(node, what, "a quantity", other, &example);
                return None;
            }
        };
        if let Some((syntax, quoted)) = &written {
            self.check_hertz(syntax, quoted, quantity, what);
            self.check_sines(syntax, quoted, what);
        }
        let is_bare = lowered.kind == Kind::Bare;
        let help = self
            .factor_without_unit(node, &lowered, quantity)
            .or_else(|| Self::factor_of_time(written.as_ref(), &lowered, quantity));
        let (expr, value) = match help {
            Some(help) => {
                self.report(self.unfit(&lowered, quantity, what).help(help));
                return None;
            }
            None => self.accept(&lowered, quantity, what)?,
        };
        if let Some(value) = value {
            self.check_turns(quantity, what, value.look(), &span)?;
            if is_bare && quantity.dimension() == Quantity::DENSITY.dimension() {
                self.check_density(what, value.look(), &span);
            }
        }
        match (value, written) {
            (Some(value), _) if is_bare => {
                self.check_angle(&lowered, quantity, what, value.look());
            }
            (None, Some((syntax, quoted))) if quantity.is_angle() => {
                self.check_amplitude(&syntax, &quoted, what);
            }
            _ => (),
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
        match syntax_of(quoted.text, self.nesting, &|name| self.is_own_name(name)) {
            Ok(syntax) => {
                self.check_commas_of_calls(&syntax, quoted);
                let is_known = |name: &str| {
                    self.table_named(name).is_some() || Rounding::named(name).is_some()
                };
                Some(syntax.written_out(&is_known))
            }
            Err(error) => {
                self.report_parse_error(&error, quoted, what);
                None
            }
        }
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
            Kind::Known(_) => {
                let fault = self.unfit(lowered, quantity, what);
                self.report(fault.help(format!("write for example \"{}\"", quantity.example)));
                None
            }
        }
    }

    /// The fault of a value of another dimension than the quantity that is needed.
    fn unfit(&self, lowered: &Lowered, quantity: Quantity, what: &str) -> Diagnostic {
        let found = match lowered.kind {
            Kind::Known(found) => found,
            Kind::Bare => Dimension::NONE,
        };
        let noun = describe(found, lowered.is_angle);
        let message = format!("{what}: expected {}, found {noun}", quantity.noun);
        // In the author's own unit where one is written.
        let written = lowered.unit_span.clone().and_then(|span| self.text.get(span));
        let label = match written {
            _ if found == Dimension::NONE => String::new(),
            Some(unit) if unit.len() < 20 => format!("in {unit}"),
            _ => format!("in {found}"),
        };
        let location = lowered.unit_span.clone().unwrap_or_else(|| lowered.span.clone());
        let fault = Diagnostic::error(codes::WRONG_DIMENSION, message).at(location, label);
        self.pure_numbers().into_iter().fold(fault, Diagnostic::note)
    }

    /// The help where a factor that is written as a number lacks its unit: `2*pi*t` for an angle is
    /// `2*pi rad/s*t`. `None` where that is not the fault.
    fn factor_without_unit(
        &self,
        node: &Node,
        lowered: &Lowered,
        quantity: Quantity,
    ) -> Option<String> {
        let Kind::Known(found) = lowered.kind else { return None };
        let missing = quantity.dimension().over(found);
        if missing == Dimension::NONE {
            return None;
        }
        let quoted = node.text(self.text)?;
        let syntax = syntax_of(quoted.text, self.nesting, &|name| self.is_own_name(name)).ok()?;
        let end = end_of_numbers(&syntax)?;
        let mut unit = missing.to_string();
        // Of a motion that turns, the unit names the angle.
        if quantity.is_turning()
            && let Some(rest) = unit.strip_prefix("1/")
        {
            unit = format!("rad/{rest}");
        }
        let unit = self.units.in_place_of(&unit);
        WrittenUnit::parse(&unit)?;
        let (before, after) = (quoted.text.get(..end)?, quoted.text.get(end..)?);
        Some(format!("the number needs its unit: write \"{before} {unit}{after}\""))
    }

    /// The help where a motion is a rate, or its rate a value: `100 rpm` for `100 rpm*t`, `60 deg*t` for `60 deg/s*t`.
    /// `None` where that is not the fault.
    fn factor_of_time(
        written: Option<&(Syntax, Quoted<'_>)>,
        lowered: &Lowered,
        quantity: Quantity,
    ) -> Option<String> {
        let Kind::Known(found) = lowered.kind else { return None };
        let (syntax, quoted) = written?;
        let text = quoted.text.trim();
        let (needed, time) = (quantity.dimension(), Quantity::TIME.dimension());
        let is_motion = needed == Dimension::NONE || needed == Quantity::LENGTH.dimension();
        if !is_motion {
            return None;
        }
        if found == needed.over(time) && !lowered.varies() {
            let whole = if syntax.nodes.len() == 1 { text.to_owned() } else { format!("({text})") };
            return Some(format!("a rate times the time is a motion: write \"{whole}*t\""));
        }
        let mut quantities = syntax.nodes.iter().filter_map(|node| match &node.kind {
            SyntaxKind::Quantity { factors, .. } => factors.last(),
            _ => None,
        });
        let (unit, None) = (quantities.next()?, quantities.next()) else { return None };
        let (before, after) =
            (quoted.text.get(..unit.span.end)?, quoted.text.get(unit.span.end..)?);
        (found == needed.times(time))
            .then(|| format!("the number needs the unit of a rate: write \"{before}/s{after}\""))
    }

    /// True of a name that the model gives, which no unit is then.
    pub(super) fn is_own_name(&self, name: &str) -> bool {
        let is_local = self.local.as_ref().is_some_and(|(local, _)| local == name);
        is_local || self.names.plain(name).is_some()
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
}

/// The end of the factors at the start of a product that are numbers; `None` where it starts with none.
fn end_of_numbers(syntax: &Syntax) -> Option<usize> {
    let is_constant = |idx: usize| match &syntax.nodes[idx].kind {
        SyntaxKind::Number(_) => true,
        SyntaxKind::Name(name) => name == "pi",
        _ => false,
    };
    let mut end = None;
    let mut idx = syntax.nodes.len() - 1;
    // From the last factor to the first; what is not a number starts again.
    loop {
        let (first, last) = match &syntax.nodes[idx].kind {
            SyntaxKind::Binary { operator: BinaryOperator::Multiply, left, right, .. } => {
                (*left, *right)
            }
            // A unit after a divisor would be of the divisor.
            SyntaxKind::Binary { operator: BinaryOperator::Divide, left, right, .. }
                if !is_constant(*right) =>
            {
                (*left, *right)
            }
            SyntaxKind::Negate(operand) => {
                idx = *operand;
                continue;
            }
            _ => return is_constant(idx).then(|| end.unwrap_or(syntax.nodes[idx].span.end)),
        };
        end = is_constant(last).then(|| end.unwrap_or(syntax.nodes[last].span.end));
        idx = first;
    }
}

/// The names in an expression, of functions too, by their bytes; none where it is no expression. `is_own` tells
/// names of the model from units.
pub fn names_in(expression: &str, is_own: &dyn Fn(&str) -> bool) -> Vec<std::ops::Range<usize>> {
    /// Depth to which an editor looks.
    const DEPTH: usize = 64;
    let Ok(syntax) = syntax_of(expression, DEPTH, is_own) else { return Vec::new() };
    let span = |node: &SyntaxNode| match &node.kind {
        SyntaxKind::Name(_) => Some(node.span.clone()),
        SyntaxKind::Call { name_span, .. } => Some(name_span.clone()),
        _ => None,
    };
    syntax.nodes.iter().filter_map(span).collect()
}

/// The syntax of an expression. A unit goes on after a space or `/`, so that a parameter `m` leaves `3 N/m` alone;
/// after a written `*` and where a unit stands alone a name of the model, which `is_own` tells, comes first, as
/// in `3 kg*h^2`. `t` is the time always, but right after a number.
///
/// # Errors
/// [`ParseError`] when the text is no expression.
pub(super) fn syntax_of(
    text: &str,
    max_depth: usize,
    is_own: &dyn Fn(&str) -> bool,
) -> Result<Syntax, ParseError> {
    let options = ParseOptions {
        max_depth,
        is_unit: &|name| find_unit(name).is_some(),
        is_name: is_own,
        is_variable: &|name| name == "t",
    };
    parse(text, &options)
}
