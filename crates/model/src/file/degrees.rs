//! Angles that look like degrees: numbers of more than a turn to which nobody gave a unit.

use std::ops::Range;

use bksim_expr::{BinaryOperator, ParseOptions, Syntax, SyntaxKind, parse};

use super::codes;
use super::names::Meaning;
use super::reader::Reader;
use super::replay::Constant;
use super::tree::Quoted;
use super::units::Quantity;
use super::value::{Kind, Lowered};
use crate::diagnostic::{Diagnostic, Span};
use crate::message::short;

/// A whole turn, rad.
const TURN: f64 = 2.0 * std::f64::consts::PI;

/// True of a number that nobody writes for radians: of more than a turn, and whole or half.
fn looks_like_degrees(value: f64) -> bool {
    value.abs() > TURN && (2.0 * value).fract() == 0.0
}

/// The number that is the amplitude of an angle in time and looks like degrees, and the names that are factors before it.
fn amplitude(syntax: &Syntax) -> (Option<(f64, Range<usize>)>, Vec<String>) {
    let mut names = Vec::new();
    let mut pending: Vec<usize> = syntax.nodes.len().checked_sub(1).into_iter().collect();
    while let Some(idx) = pending.pop() {
        let node = &syntax.nodes[idx];
        match &node.kind {
            SyntaxKind::Binary {
                operator: BinaryOperator::Add | BinaryOperator::Subtract | BinaryOperator::Multiply,
                left,
                right,
                ..
            } => pending.extend([*right, *left]),
            SyntaxKind::Binary { operator: BinaryOperator::Divide, left, .. } => {
                pending.push(*left);
            }
            SyntaxKind::Negate(operand) => pending.push(*operand),
            SyntaxKind::Call { name, arguments, .. }
                if ["if", "min", "max"].contains(&name.as_str()) =>
            {
                pending.extend(arguments.iter().skip(usize::from(name == "if")));
            }
            SyntaxKind::Number(number) if looks_like_degrees(number.to_f64()) => {
                return (Some((number.to_f64(), node.span.clone())), names);
            }
            SyntaxKind::Name(name) => names.push(name.clone()),
            _ => (),
        }
    }
    (None, names)
}

/// The amplitude of an angle in time that looks like degrees, rad: 90 of `90*sin(2*t)`.
pub fn amplitude_like_degrees(formula: &str) -> Option<f64> {
    let syntax = parse(formula, &ParseOptions::default()).ok()?;
    let is_wave = syntax.nodes.iter().any(|node| matches!(node.kind, SyntaxKind::Call { .. }));
    amplitude(&syntax).0.map(|(value, _)| value).filter(|_| is_wave)
}

impl Reader<'_> {
    /// Warns of a bare angle that is more than a turn and looks like degrees.
    pub(super) fn check_angle(
        &mut self,
        lowered: &Lowered,
        quantity: Quantity,
        what: &str,
        value: f64,
    ) {
        if !quantity.is_angle() || self.units.angle_stated || !looks_like_degrees(value) {
            return;
        }
        let Some((name, location)) = self.bare_source(lowered) else { return };
        let what = name.map_or_else(|| what.to_owned(), |name| format!("the angle `{name}`"));
        let help = format!("write \"{0} deg\", or \"{0} rad\" if it is right", short(value));
        self.warn_of_degrees(&what, value, location, help);
    }

    fn warn_of_degrees(&mut self, what: &str, value: f64, location: Span, help: String) {
        let turns = value / TURN;
        let message = format!("{what} is {} rad = {turns:.1} turns", short(value));
        let fault = Diagnostic::warning(codes::LOOKS_LIKE_DEGREES, message)
            .at(location, "a number without unit is in radians")
            .help(help);
        // A text may be read more than once.
        if !self.faults.contains(&fault) {
            self.report(fault);
        }
    }

    /// Warns of a bare number among angles, in a sum or as the argument of a sine.
    pub(super) fn check_among_angles(&mut self, bare: &Lowered) {
        let Some(value) = bare.value.map(Constant::look) else { return };
        if self.units.angle_stated || !looks_like_degrees(value) {
            return;
        }
        let Some((name, location)) = self.bare_source(bare) else { return };
        let (what, help) = match name {
            Some(name) => (
                format!("the angle `{name}`"),
                format!("write \"{0} deg\", or \"{0} rad\" if it is right", short(value)),
            ),
            None => (
                "a number among angles".to_owned(),
                format!("write `{0} deg`, or `{0} rad` if it is right", short(value)),
            ),
        };
        self.warn_of_degrees(&what, value, location, help);
    }

    /// Warns of a number without unit that is the amplitude of an angle in time: `90*sin(2 rad/s*t)`.
    pub(super) fn check_amplitude(&mut self, syntax: &Syntax, quoted: &Quoted<'_>, what: &str) {
        if self.units.angle_stated {
            return;
        }
        let (number, names) = amplitude(syntax);
        for name in names {
            let Some(Meaning::Parameter(idx)) = self.names.plain(&name) else { continue };
            let known = self.parameters[idx].result.clone();
            if let Some(bare) = known.filter(|known| known.kind == Kind::Bare) {
                self.check_among_angles(&bare);
            }
        }
        if let Some((value, span)) = number {
            let shown = short(value);
            let help = format!("write `{shown} deg`, or `{shown} rad` if it is right");
            self.warn_of_degrees(&format!("{shown} in {what}"), value, quoted.span_of(&span), help);
        }
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
