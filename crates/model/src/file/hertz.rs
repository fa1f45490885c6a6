//! Turns a second that are read as radians: `rate = "1 Hz"`, `sin(5 Hz*t)`.

use bksim_expr::{BinaryOperator, Syntax, SyntaxKind};

use super::codes;
use super::reader::Reader;
use super::tree::Quoted;
use super::units::Quantity;
use crate::diagnostic::Diagnostic;

/// Units of turns in time, with those that count each turn as 2π.
const TURNS: [(&str, &str, &str); 2] = [("Hz", "rev/s", "rad/s"), ("kHz", "rev/ms", "rad/ms")];

/// The node of a number in hertz that is a factor of a term of the expression at `root`, with its row of [`TURNS`]; `None`
/// where π makes an angle of it.
fn bare_hertz(syntax: &Syntax, root: usize) -> Option<(usize, usize)> {
    use BinaryOperator::{Add, Divide, Multiply, Subtract};
    let mut found = None;
    let mut pending = vec![root];
    while let Some(idx) = pending.pop() {
        match &syntax.nodes[idx].kind {
            SyntaxKind::Binary {
                operator: Add | Subtract | Multiply | Divide,
                left,
                right,
                ..
            } => {
                pending.extend([*right, *left]);
            }
            SyntaxKind::Negate(operand) => pending.push(*operand),
            SyntaxKind::Name(name) if name == "pi" => return None,
            kind @ (SyntaxKind::Quantity { factors, .. } | SyntaxKind::Unit { factors, .. }) => {
                if let SyntaxKind::Unit { operand, .. } = kind {
                    pending.push(*operand);
                }
                if let [only] = factors.as_slice()
                    && only.exponent == 1
                    && let Some(row) = TURNS.iter().position(|(name, ..)| *name == only.name)
                {
                    found = Some((idx, row));
                }
            }
            _ => (),
        }
    }
    found
}

impl Reader<'_> {
    /// Warns of hertz in an angle, an angular velocity or the argument of a sine, which count radians.
    pub(super) fn check_hertz(
        &mut self,
        syntax: &Syntax,
        quoted: &Quoted<'_>,
        quantity: Quantity,
        what: &str,
    ) {
        let whole = syntax.nodes.len().checked_sub(1).filter(|_| quantity.is_rotation());
        let arguments = syntax.nodes.iter().filter_map(|node| match &node.kind {
            SyntaxKind::Call { name, arguments, .. } if ["sin", "cos"].contains(&name.as_str()) => {
                arguments.first().copied()
            }
            _ => None,
        });
        let roots: Vec<usize> = whole.into_iter().chain(arguments).collect();
        for root in roots {
            let Some((idx, row)) = bare_hertz(syntax, root) else { continue };
            let (hertz, turns, radians) = TURNS[row];
            let span = syntax.nodes[idx].span.clone();
            let written = &quoted.text[span.clone()];
            let [turns, read] = [turns, radians].map(|unit| written.replace(hertz, unit));
            let place =
                if whole == Some(root) { what.to_owned() } else { format!("a sine in {what}") };
            let fault = Diagnostic::warning(
                codes::HERTZ,
                format!("`{written}` in {place} is read as {read}, not as turns"),
            )
            .at(quoted.span_of(&span), "an angle is in radians")
            .help(format!("write `{turns}` for turns, or `{read}` if it is right"));
            // A text may be read more than once.
            if !self.faults.contains(&fault) {
                self.report(fault);
            }
        }
    }
}
