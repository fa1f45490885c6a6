//! The derivatives of the functions, one row each.

use crate::op::Function;
use crate::pool::{Expr, Pool};

/// How a function is differentiated.
enum Rule {
    /// `f'(a)`, given the argument and the value `f(a)`.
    One(fn(&Pool, Expr, Expr) -> Expr),
    /// `(∂f/∂a, ∂f/∂b)`.
    Two(fn(&Pool, Expr, Expr) -> (Expr, Expr)),
    /// Piecewise constant: zero wherever the derivative exists.
    Zero,
    /// Branch by branch, without the rules of this table.
    Branches,
}

use Function as F;
use Rule::{Branches, One, Two, Zero};

/// The table of rules.
#[rustfmt::skip]
fn rule(function: Function) -> Rule {
    match function {
        F::Sin   => One(|p, a, _| p.cos(a)),
        F::Cos   => One(|p, a, _| p.neg(p.sin(a))),
        F::Tan   => One(|p, _, f| p.add(p.one(), p.powi(f, 2))),
        F::Asin  => One(|p, a, _| p.powi(p.sqrt(one_minus_square(p, a)), -1)),
        F::Acos  => One(|p, a, _| p.neg(p.powi(p.sqrt(one_minus_square(p, a)), -1))),
        F::Atan  => One(|p, a, _| p.powi(p.add(p.one(), p.powi(a, 2)), -1)),
        F::Sinh  => One(|p, a, _| p.cosh(a)),
        F::Cosh  => One(|p, a, _| p.sinh(a)),
        F::Tanh  => One(|p, _, f| one_minus_square(p, f)),
        F::Exp   => One(|_, _, f| f),
        F::Ln    => One(|p, a, _| p.powi(a, -1)),
        F::Sqrt  => One(|p, _, f| p.mul(p.rational(1, 2), p.powi(f, -1))),
        F::Abs   => One(|p, a, _| p.sign(a)),
        F::Atan2 => Two(atan2),
        // At a tie the one takes a and the other b, so that min + max has the derivative of a + b.
        F::Min   => Two(|p, a, b| selected(p, p.call_two(F::Le, a, b))),
        F::Max   => Two(|p, a, b| selected(p, p.call_two(F::Gt, a, b))),
        F::Sign | F::Floor | F::Lt | F::Le | F::Gt | F::Ge => Zero,
        F::If    => Branches,
    }
}

/// `1 − a²`.
fn one_minus_square(pool: &Pool, a: Expr) -> Expr {
    pool.sub(pool.one(), pool.powi(a, 2))
}

/// d atan2(y, x) = (x dy − y dx) / (x² + y²).
fn atan2(pool: &Pool, y: Expr, x: Expr) -> (Expr, Expr) {
    let scale = pool.powi(pool.add(pool.powi(x, 2), pool.powi(y, 2)), -1);
    (pool.mul(x, scale), pool.neg(pool.mul(y, scale)))
}

/// Weights of the two operands of which `condition` takes the first where it holds.
fn selected(pool: &Pool, condition: Expr) -> (Expr, Expr) {
    (
        pool.select(condition, pool.one(), pool.zero()),
        pool.select(condition, pool.zero(), pool.one()),
    )
}

/// True if the derivative is zero wherever it exists.
pub(super) fn is_piecewise_constant(function: Function) -> bool {
    matches!(rule(function), Zero)
}

/// Partial derivatives with respect to the first and second argument of any function but `if`,
/// given its value.
pub(super) fn partial_derivatives(
    pool: &Pool,
    function: Function,
    value: Expr,
    a: Expr,
    b: Expr,
) -> (Expr, Expr) {
    match rule(function) {
        One(rule) => (rule(pool, a, value), pool.zero()),
        Two(rule) => rule(pool, a, b),
        Zero => (pool.zero(), pool.zero()),
        Branches => unreachable!("an `if` is differentiated branch by branch"),
    }
}
