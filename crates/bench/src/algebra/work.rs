//! Operations of equations as an engineer counts them.
//!
//! Products and sums of parameters alone are named once and cost nothing afterwards; all other
//! operations count one each, whatever they are: additions, subtractions, multiplications,
//! divisions, function calls. Signs are free, and `x^n` takes n − 1 multiplications.

use bksim_expr::{BinaryOperator, Expr, Number, ParseOptions, Pool, Syntax, SyntaxKind, parse};

use crate::error::BenchError;

/// Operations of `roots` written out in full, parameter groups named; `is_state` knows the names
/// that are no parameters.
pub(crate) fn printed(
    pool: &Pool,
    roots: &[Expr],
    is_state: &dyn Fn(&str) -> bool,
) -> Result<u64, BenchError> {
    let options = ParseOptions { max_depth: usize::MAX, ..ParseOptions::default() };
    let mut total = 0;
    for &root in roots {
        total += of_syntax(&parse(&pool.to_text(root), &options)?, is_state);
    }
    Ok(total)
}

/// A part of an expression while its chain of sums or products is still open.
#[derive(Clone, Copy)]
enum Part {
    /// A number, one if it is ±1.
    Number { is_unit: bool },
    /// Parameters alone.
    Group,
    /// Anything finished, with its operations.
    Whole(u64),
    /// Terms with state in them, their operations, and whether a group is added.
    Sum { n_terms: u64, inner: u64, has_group: bool },
    /// Factors and divisors with state in them, their operations, and whether a group multiplies.
    Product { n_factors: u64, n_divisors: u64, inner: u64, has_group: bool },
}

impl Part {
    /// All operations in it.
    fn operations(self) -> u64 {
        match self {
            Self::Number { .. } | Self::Group => 0,
            Self::Whole(operations) => operations,
            Self::Sum { n_terms, inner, has_group } => inner + n_terms + u64::from(has_group) - 1,
            Self::Product { n_factors, n_divisors, inner, has_group } => {
                // The divisors are multiplied to one.
                let n_multiplied = n_factors + u64::from(has_group);
                inner + n_multiplied.saturating_sub(1) + n_divisors
            }
        }
    }

    fn has_state(self) -> bool {
        !matches!(self, Self::Number { .. } | Self::Group)
    }

    fn as_sum(self) -> Self {
        match self {
            Self::Sum { .. } => self,
            _ if self.has_state() => {
                Self::Sum { n_terms: 1, inner: self.operations(), has_group: false }
            }
            _ => Self::Sum { n_terms: 0, inner: 0, has_group: true },
        }
    }

    fn as_product(self) -> Self {
        match self {
            Self::Product { .. } => self,
            _ if self.has_state() => Self::Product {
                n_factors: 1,
                n_divisors: 0,
                inner: self.operations(),
                has_group: false,
            },
            _ => Self::Product {
                n_factors: 0,
                n_divisors: 0,
                inner: 0,
                has_group: !matches!(self, Self::Number { is_unit: true }),
            },
        }
    }

    fn plus(self, other: Self) -> Self {
        let (
            Self::Sum { n_terms: a, inner: ai, has_group: ag },
            Self::Sum { n_terms: b, inner: bi, has_group: bg },
        ) = (self.as_sum(), other.as_sum())
        else {
            return self;
        };
        Self::Sum { n_terms: a + b, inner: ai + bi, has_group: ag || bg }
    }

    fn times(self, other: Self) -> Self {
        let (
            Self::Product { n_factors: a, n_divisors: ad, inner: ai, has_group: ag },
            Self::Product { n_factors: b, n_divisors: bd, inner: bi, has_group: bg },
        ) = (self.as_product(), other.as_product())
        else {
            return self;
        };
        Self::Product { n_factors: a + b, n_divisors: ad + bd, inner: ai + bi, has_group: ag || bg }
    }

    fn inverse(self) -> Self {
        match self {
            Self::Product { n_factors, n_divisors, inner, has_group } => {
                Self::Product { n_factors: n_divisors, n_divisors: n_factors, inner, has_group }
            }
            _ if self.has_state() => self.as_product().inverse(),
            _ => self,
        }
    }
}

fn of_syntax(syntax: &Syntax, is_state: &dyn Fn(&str) -> bool) -> u64 {
    // Children come before their parents.
    let mut parts: Vec<Part> = Vec::with_capacity(syntax.nodes.len());
    for node in &syntax.nodes {
        let part = match &node.kind {
            SyntaxKind::Number(number) => {
                Part::Number { is_unit: number.magnitude() == Number::ONE }
            }
            SyntaxKind::Name(name) if is_state(name) => Part::Whole(0),
            SyntaxKind::Name(_) | SyntaxKind::Quantity { .. } => Part::Group,
            SyntaxKind::Call { arguments, .. } => {
                let has_state = arguments.iter().any(|&a| parts[a].has_state());
                let inner: u64 = arguments.iter().map(|&a| parts[a].operations()).sum();
                if has_state { Part::Whole(inner + 1) } else { Part::Group }
            }
            SyntaxKind::Negate(operand) => parts[*operand],
            SyntaxKind::Binary { operator, left, right, .. } => {
                binary(syntax, *operator, (parts[*left], parts[*right]), *right)
            }
        };
        parts.push(part);
    }
    parts.last().map_or(0, |part| part.operations())
}

fn binary(syntax: &Syntax, operator: BinaryOperator, ab: (Part, Part), right: usize) -> Part {
    let (a, b) = ab;
    if !a.has_state() && !b.has_state() {
        return Part::Group;
    }
    match operator {
        BinaryOperator::Add | BinaryOperator::Subtract => a.plus(b),
        BinaryOperator::Multiply => a.times(b),
        BinaryOperator::Divide => a.times(b.as_product().inverse()),
        BinaryOperator::Power => {
            let exponent = match &syntax.nodes[right].kind {
                SyntaxKind::Number(number) => number.as_integer(),
                _ => None,
            };
            let own = exponent.map_or(1, |n| n.unsigned_abs().max(1) - 1 + u64::from(n < 0));
            Part::Whole(a.operations() + b.operations() + own)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_of_parameters_are_free() {
        let pool = Pool::new();
        let is_state = |name: &str| ["q", "v", "w"].contains(&name);
        for (text, expected) in [
            ("a + b*l^2 + m*l*cos(q)", 3),
            ("-v", 0),
            ("-2*m*v", 1),
            ("m*(a + b)*sin(q)*v^2/2", 4),
            ("v*w/(a*b)", 2),
            ("a/(v*w)", 2),
            ("a + b", 0),
            ("cos(q + a)", 2),
            ("m*(l*v + a*w)", 4),
            ("sqrt(v^2 + w^2)", 4),
        ] {
            let e = pool.parse(text).expect(text);
            let found = printed(&pool, &[e], &is_state).expect(text);
            assert_eq!(found, expected, "{text} as {}", pool.to_text(e));
        }
    }
}
