//! Operation counts of equations as an engineer writes them.
//!
//! Products and sums of parameters alone are named once and cost nothing afterwards; all other
//! operations count one each: additions, subtractions, multiplications, divisions, function calls.
//! Signs are free, and `x^n` takes n − 1 multiplications.

use bksim_expr::{BinaryOperator, Expr, Number, ParseOptions, Pool, Syntax, SyntaxKind, parse};

use crate::error::BenchError;

/// Number of operations of `roots` written out in full, with names for groups of parameters;
/// `is_state` is true for names that are no parameters.
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

/// A part of an expression, whose sum or product may still get more terms or factors.
#[derive(Clone, Copy)]
enum Part {
    /// A number, one if it is ±1.
    Number { is_unit: bool },
    /// Parameters alone.
    Group,
    /// A part with state in it that is complete, with its operations.
    Whole(u64),
    /// Terms with state in them, their operations, and whether a group is added.
    Sum { n_terms: u64, inner: u64, has_group: bool },
    /// Factors and divisors with state in them, their operations, and whether a group multiplies.
    Product { n_factors: u64, n_divisors: u64, inner: u64, has_group: bool },
}

impl Part {
    /// Number of operations in it.
    fn operations(self) -> u64 {
        match self {
            Self::Number { .. } | Self::Group => 0,
            Self::Whole(operations) => operations,
            Self::Sum { n_terms, inner, has_group } => inner + n_terms + u64::from(has_group) - 1,
            Self::Product { n_factors, n_divisors, inner, has_group } => {
                // One division by the product of all divisors.
                let n_multiplied = n_factors + u64::from(has_group);
                inner + n_multiplied.saturating_sub(1) + n_divisors
            }
        }
    }

    fn has_state(self) -> bool {
        !matches!(self, Self::Number { .. } | Self::Group)
    }

    /// The part as a sum: its terms, their operations, and whether a group is added.
    fn terms(self) -> (u64, u64, bool) {
        match self {
            Self::Sum { n_terms, inner, has_group } => (n_terms, inner, has_group),
            _ if self.has_state() => (1, self.operations(), false),
            _ => (0, 0, true),
        }
    }

    /// The part as a product: its factors and divisors, their operations, and whether a group
    /// multiplies.
    fn factors(self) -> ([u64; 2], u64, bool) {
        match self {
            Self::Product { n_factors, n_divisors, inner, has_group } => {
                ([n_factors, n_divisors], inner, has_group)
            }
            _ if self.has_state() => ([1, 0], self.operations(), false),
            _ => ([0, 0], 0, !matches!(self, Self::Number { is_unit: true })),
        }
    }

    fn plus(self, other: Self) -> Self {
        let (a, a_inner, a_group) = self.terms();
        let (b, b_inner, b_group) = other.terms();
        Self::Sum { n_terms: a + b, inner: a_inner + b_inner, has_group: a_group || b_group }
    }

    fn times(self, other: Self) -> Self {
        let ([factors, divisors], inner, group) = other.factors();
        self.times_factors(factors, divisors, inner, group)
    }

    fn over(self, other: Self) -> Self {
        let ([factors, divisors], inner, group) = other.factors();
        self.times_factors(divisors, factors, inner, group)
    }

    fn times_factors(self, factors: u64, divisors: u64, inner: u64, group: bool) -> Self {
        let ([own_factors, own_divisors], own_inner, own_group) = self.factors();
        Self::Product {
            n_factors: own_factors + factors,
            n_divisors: own_divisors + divisors,
            inner: own_inner + inner,
            has_group: own_group || group,
        }
    }
}

/// Number of operations of an expression.
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
            // No unit is printed.
            SyntaxKind::Negate(operand) | SyntaxKind::Unit { operand, .. } => parts[*operand],
            SyntaxKind::Binary { operator, left, right, .. } => {
                binary(syntax, *operator, (parts[*left], parts[*right]), *right)
            }
        };
        parts.push(part);
    }
    parts.last().expect("an expression has at least one node").operations()
}

/// The part of a binary operation on two parts; `right` is the node of the second.
fn binary(syntax: &Syntax, operator: BinaryOperator, ab: (Part, Part), right: usize) -> Part {
    let (a, b) = ab;
    if !a.has_state() && !b.has_state() {
        return Part::Group;
    }
    match operator {
        BinaryOperator::Add | BinaryOperator::Subtract => a.plus(b),
        BinaryOperator::Multiply => a.times(b),
        BinaryOperator::Divide => a.over(b),
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
