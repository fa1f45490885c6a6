//! Turns a second that are read as radians: `rate = "1 Hz"`, `sin(5 Hz*t)`.

use std::ops::Range;

use bksim_expr::{BinaryOperator as Operator, Syntax, SyntaxKind};

use super::codes;
use super::degrees::factors;
use super::reader::Reader;
use super::tree::Quoted;
use super::units::Quantity;
use crate::diagnostic::Diagnostic;

/// Units in which people count turns, by name and exponent, then as turns and as what is read.
const TURNS: [(&str, i32, &str, &str); 3] =
    [("Hz", 1, "rev/s", "rad/s"), ("kHz", 1, "rev/ms", "rad/ms"), ("min", -1, "rpm", "rad/min")];

/// Turns in time as they are written.
struct Counted {
    span: Range<usize>,
    /// Bytes of the number.
    number: Range<usize>,
    /// Row of [`TURNS`].
    row: usize,
}

/// The first term of the expression at `root` that counts turns; none of those in which π, a unit of angles or a parameter
/// may make an angle of them.
fn bare_turns(syntax: &Syntax, root: usize) -> Option<Counted> {
    match &syntax.nodes[root].kind {
        SyntaxKind::Binary {
            operator: Operator::Add | Operator::Subtract, left, right, ..
        } => {
            return bare_turns(syntax, *left).or_else(|| bare_turns(syntax, *right));
        }
        SyntaxKind::Negate(operand) => return bare_turns(syntax, *operand),
        _ => (),
    }
    let (mut above, mut under) = (Vec::new(), Vec::new());
    factors(syntax, root, &mut above, &mut under);
    let row_of = |name: &str, exponent| {
        TURNS.iter().position(|(known, own, ..)| *known == name && *own == exponent)
    };
    let mut found = None;
    let mut number = None;
    for (idx, sign) in
        above.into_iter().map(|idx| (idx, 1)).chain(under.into_iter().map(|idx| (idx, -1)))
    {
        let node = &syntax.nodes[idx];
        match &node.kind {
            SyntaxKind::Number(_) if sign > 0 => number = Some(node.span.clone()),
            SyntaxKind::Number(_) => (),
            SyntaxKind::Name(name) if name == "t" => (),
            SyntaxKind::Quantity { factors, value_span, .. } => {
                let [only] = factors.as_slice() else { return None };
                match row_of(&only.name, sign * only.exponent) {
                    // The unit of `60/min` stands alone, and has the number before it.
                    Some(row) if value_span.is_empty() => {
                        let number = number.clone()?;
                        found = Some(Counted { span: number.start..node.span.end, number, row });
                    }
                    Some(row) => {
                        let (span, number) = (node.span.clone(), value_span.clone());
                        found = Some(Counted { span, number, row });
                    }
                    None if only.name == "s" => (),
                    None => return None,
                }
            }
            _ => return None,
        }
    }
    found
}

impl Reader<'_> {
    /// Warns of hertz, and of what is per minute, in an angle, an angular velocity or the argument of a sine, which count radians.
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
            let Some(Counted { span, number, row }) = bare_turns(syntax, root) else { continue };
            let (.., turns, radians) = TURNS[row];
            let (written, number) = (&quoted.text[span.clone()], &quoted.text[number]);
            let [turns, read] = [turns, radians].map(|unit| format!("{number} {unit}"));
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
