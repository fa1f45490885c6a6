//! Angles that look like degrees: numbers of more than a turn to which nobody gave a unit.

use std::ops::Range;

use bksim_expr::{BinaryOperator as Operator, ParseOptions, Syntax, SyntaxKind, parse};

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
pub fn looks_like_degrees(value: f64) -> bool {
    value.abs() > TURN && (2.0 * value).fract() == 0.0
}

/// A number without unit in a motion of an angle that looks like degrees.
struct Amplitude<'s> {
    value: f64,
    span: &'s Range<usize>,
    /// Name of the parameter that it is.
    name: Option<&'s str>,
    /// Power of the time in the same term: 1 in `90*t`.
    power: i32,
}

/// The first amplitude in the expression at `root` that looks like degrees; `power` is that of the time around it, and
/// `parameter` gives the value of a parameter without unit.
fn amplitude<'s>(
    syntax: &'s Syntax,
    root: usize,
    power: i32,
    parameter: &dyn Fn(&str) -> Option<f64>,
) -> Option<Amplitude<'s>> {
    let node = &syntax.nodes[root];
    let found = |value: f64, name| {
        looks_like_degrees(value).then_some(Amplitude { value, span: &node.span, name, power })
    };
    let below = |root: usize| amplitude(syntax, root, power, parameter);
    match &node.kind {
        SyntaxKind::Number(number) => found(number.to_f64(), None),
        SyntaxKind::Name(name) => found(parameter(name)?, Some(name)),
        SyntaxKind::Negate(operand) => below(*operand),
        SyntaxKind::Binary {
            operator: Operator::Add | Operator::Subtract, left, right, ..
        } => below(*left).or_else(|| below(*right)),
        SyntaxKind::Binary { operator: Operator::Multiply | Operator::Divide, .. } => {
            let (mut above, mut under) = (Vec::new(), Vec::new());
            factors(syntax, root, &mut above, &mut under);
            let of_time = |all: &[usize]| -> Option<i32> {
                all.iter().map(|idx| time_power(syntax, *idx, parameter)).sum()
            };
            let power = power + of_time(&above)? - of_time(&under)?;
            above.into_iter().find_map(|idx| amplitude(syntax, idx, power, parameter))
        }
        SyntaxKind::Call { name, arguments, .. }
            if ["if", "min", "max"].contains(&name.as_str()) =>
        {
            arguments.iter().skip(usize::from(name == "if")).find_map(|idx| below(*idx))
        }
        _ => None,
    }
}

/// Functions whose values are pure numbers.
const PURE: [&str; 8] = ["sin", "cos", "tan", "exp", "tanh", "sign", "sinh", "cosh"];

/// The factors of a product above and under its fraction line.
pub(super) fn factors(
    syntax: &Syntax,
    root: usize,
    above: &mut Vec<usize>,
    under: &mut Vec<usize>,
) {
    match &syntax.nodes[root].kind {
        SyntaxKind::Binary { operator: Operator::Multiply, left, right, .. } => {
            factors(syntax, *left, above, under);
            factors(syntax, *right, above, under);
        }
        SyntaxKind::Binary { operator: Operator::Divide, left, right, .. } => {
            factors(syntax, *left, above, under);
            factors(syntax, *right, under, above);
        }
        _ => above.push(root),
    }
}

/// The power of the time that a factor is, 2 of `t^2` and 1 of `3 s`; `None` of one with another unit.
fn time_power(syntax: &Syntax, idx: usize, parameter: &dyn Fn(&str) -> Option<f64>) -> Option<i32> {
    match &syntax.nodes[idx].kind {
        SyntaxKind::Quantity { factors, .. } => match factors.as_slice() {
            [only] if ["s", "ms", "min", "h"].contains(&only.name.as_str()) => Some(only.exponent),
            _ => None,
        },
        SyntaxKind::Name(name) if name == "t" => Some(1),
        SyntaxKind::Name(name) => (name == "pi" || parameter(name).is_some()).then_some(0),
        SyntaxKind::Call { name, .. } => PURE.contains(&name.as_str()).then_some(0),
        SyntaxKind::Binary { operator: Operator::Power, left, right, .. } => {
            let SyntaxKind::Number(exponent) = &syntax.nodes[*right].kind else { return Some(0) };
            let whole = [1, 2, 3].into_iter().find(|n| exponent.to_f64() == f64::from(*n));
            Some(time_power(syntax, *left, parameter)? * whole.unwrap_or(0))
        }
        SyntaxKind::Unit { .. } => None,
        _ => Some(0),
    }
}

/// The amplitude of an angle in time that looks like degrees, rad: 90 of `90*sin(2*t)`.
pub fn amplitude_like_degrees(formula: &str) -> Option<f64> {
    let syntax = parse(formula, &ParseOptions::default()).ok()?;
    let is_wave = syntax.nodes.iter().any(|node| matches!(node.kind, SyntaxKind::Call { .. }));
    let root = syntax.nodes.len().checked_sub(1)?;
    amplitude(&syntax, root, 0, &|_| None).map(|found| found.value).filter(|_| is_wave)
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
        self.warn_in_radians(message, location, help);
    }

    fn warn_in_radians(&mut self, message: String, location: Span, help: String) {
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

    /// Warns of a number without unit that is the amplitude of an angle in time: `90*sin(2 rad/s*t)`, `90*t`.
    pub(super) fn check_amplitude(&mut self, syntax: &Syntax, quoted: &Quoted<'_>, what: &str) {
        if self.units.angle_stated {
            return;
        }
        let known = |name: &str| {
            let Some(Meaning::Parameter(idx)) = self.names.plain(name) else { return None };
            self.parameters[idx].result.as_ref().filter(|known| known.kind == Kind::Bare)
        };
        let parameter = |name: &str| known(name)?.value.map(Constant::look);
        let Some(root) = syntax.nodes.len().checked_sub(1) else { return };
        let Some(found) = amplitude(syntax, root, 0, &parameter) else { return };
        let source = found.name.and_then(known).and_then(|bare| self.bare_source(bare));
        let (location, mark) = match source {
            Some((_, location)) => (location, '"'),
            None => (quoted.span_of(found.span), '`'),
        };
        self.warn_of_amplitude(&found, what, location, mark);
    }

    /// The warning of an amplitude in `what`; the cure is written between `mark`s.
    fn warn_of_amplitude(&mut self, found: &Amplitude<'_>, what: &str, location: Span, mark: char) {
        let shown = short(found.value);
        let per_time = match found.power {
            1 => "/s",
            2 => "/s^2",
            _ => "",
        };
        let what = match found.name {
            Some(name) => format!("`{name}` in {what}"),
            None => format!("{shown} in {what}"),
        };
        let help = format!(
            "write {mark}{shown} deg{per_time}{mark}, or {mark}{shown} rad{per_time}{mark} if it is right"
        );
        let turns = match found.power {
            1 => " a second",
            2 => " a second, more each second",
            _ => "",
        };
        let n_turns = found.value / TURN;
        let message = format!("{what} is {shown} rad{per_time} = {n_turns:.1} turns{turns}");
        self.warn_in_radians(message, location, help);
    }

    /// Warns of sines and cosines whose argument grows by whole quarters of a turn in degrees: `sin(360*t)`.
    pub(super) fn check_sines(&mut self, syntax: &Syntax, quoted: &Quoted<'_>, what: &str) {
        if self.units.angle_stated {
            return;
        }
        for node in &syntax.nodes {
            let SyntaxKind::Call { name, arguments, .. } = &node.kind else { continue };
            let [argument] = arguments.as_slice() else { continue };
            if !["sin", "cos"].contains(&name.as_str()) {
                continue;
            }
            let Some(found) = amplitude(syntax, *argument, 0, &|_| None) else { continue };
            // Other rates may be angular frequencies.
            if found.power == 1 && found.value % 90.0 == 0.0 {
                let place = format!("a sine in {what}");
                self.warn_of_amplitude(&found, &place, quoted.span_of(found.span), '`');
            }
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
