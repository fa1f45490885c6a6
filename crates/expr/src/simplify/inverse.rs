//! Functions of functions that undo them: the sine of an arc sine, the logarithm of a power.
//!
//! A fold of [`Pool::folded_call`] has a value exactly where the call has one, but for poles. A fold
//! of [`Pool::fold_under_condition`] has more values or fewer, and says where it holds.

use crate::number::Number;
use crate::op::{Function, Op};
use crate::pool::{Expr, ONE, Pool, fact};

/// The condition of a fold.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Condition {
    /// The expression is not zero.
    NotZero(Expr),
    /// The expression is not negative.
    NotNegative(Expr),
}

impl Pool {
    /// A call of a function on an inverse function in a form without either; `None` without one.
    pub(super) fn folded_call(&self, e: Expr) -> Option<Expr> {
        use Function::{Acos, Asin, Atan, Atan2, Cos, Exp, Ln, Sin, Sqrt, Tan};
        let Some((outer, inner, a, b)) = self.nested_call(e) else {
            return self.folded_double(e);
        };
        let other_leg = || self.sqrt(self.sub(ONE, self.powi(a, 2)));
        let hypotenuse = || self.sqrt(self.add(ONE, self.powi(a, 2)));
        Some(match (outer, inner) {
            (Tan, Atan) => a,
            (Sin, Atan) => self.div(a, hypotenuse()),
            (Cos, Atan) => self.powi(hypotenuse(), -1),
            (Cos, Asin) | (Sin, Acos) => other_leg(),
            (Tan, Asin) => self.div(a, other_leg()),
            (Tan, Acos) => self.div(other_leg(), a),
            // Where the point is never the origin.
            (Sin | Cos | Tan, Atan2) if self.is_never_zero(a) || self.is_never_zero(b) => {
                self.direction(outer, a, b)
            }
            (Exp, Ln) if self.is_never_negative(a) => a,
            (Ln, Sqrt) => self.mul(self.rational(1, 2), self.ln(a)),
            (Sqrt, Exp) => self.exp(self.mul(self.rational(1, 2), a)),
            _ => return None,
        })
    }

    /// Sine or cosine of twice an inverse function: sin(2 atan a) = 2 a / (1 + a²).
    fn folded_double(&self, e: Expr) -> Option<Expr> {
        use Function::{Acos, Asin, Atan, Cos, Sin};
        let node = self.node(e);
        let Op::Call(outer @ (Sin | Cos)) = node.op else { return None };
        if self.node(node.left).op != Op::Mul {
            return None;
        }
        let terms = self.terms_of(node.left);
        let [(angle, factor)] = terms.as_slice() else { return None };
        let two = self.rational(2, 1);
        let Op::Call(inner) = self.node(*angle).op else { return None };
        if self.number(factor.clone()) != two {
            return None;
        }
        let a = self.node(*angle).left;
        let square = self.powi(a, 2);
        Some(match (outer, inner) {
            (Sin, Atan) => self.div(self.mul(two, a), self.add(ONE, square)),
            (Cos, Atan) => self.div(self.sub(ONE, square), self.add(ONE, square)),
            (Sin, Asin | Acos) => self.mul(self.mul(two, a), self.sqrt(self.sub(ONE, square))),
            _ => return None,
        })
    }

    /// Fold ([`Pool::folded_call`]) that holds under a condition only.
    pub(super) fn fold_under_condition(&self, e: Expr) -> Option<(Expr, Condition)> {
        use Function::{Acos, Asin, Atan2, Cos, Exp, Ln, Sin, Sqrt, Tan};
        let node = self.node(e);
        if node.op == Op::Pow {
            // sqrt(x)² = x where x is not negative.
            let (base, n) = self.split_power(e);
            let root = self.node(base);
            let is_even_root = root.op == Op::Call(Sqrt) && n % 2 == 0;
            let power = || (self.powi(root.left, n / 2), Condition::NotNegative(root.left));
            return is_even_root.then(power);
        }
        let (outer, inner, a, b) = self.nested_call(e)?;
        Some(match (outer, inner) {
            (Sin, Asin) | (Cos, Acos) => {
                (a, Condition::NotNegative(self.sub(ONE, self.powi(a, 2))))
            }
            (Exp, Ln) => (a, Condition::NotNegative(a)),
            (Sin | Cos | Tan, Atan2) => {
                let squares = self.add(self.powi(a, 2), self.powi(b, 2));
                (self.direction(outer, a, b), Condition::NotZero(squares))
            }
            _ => return None,
        })
    }

    /// A function of one argument, the function that this is a call of, and its arguments.
    fn nested_call(&self, e: Expr) -> Option<(Function, Function, Expr, Expr)> {
        let node = self.node(e);
        let Op::Call(outer) = node.op else { return None };
        let inner = self.node(node.left);
        match inner.op {
            Op::Call(function) if outer.arity() == 1 => {
                Some((outer, function, inner.left, inner.right))
            }
            _ => None,
        }
    }

    /// Sine, cosine or tangent of the angle of the point (x, y).
    fn direction(&self, function: Function, y: Expr, x: Expr) -> Expr {
        let distance = || self.sqrt(self.add(self.powi(x, 2), self.powi(y, 2)));
        match function {
            Function::Sin => self.div(y, distance()),
            Function::Cos => self.div(x, distance()),
            _ => self.div(y, x),
        }
    }

    /// True if the value can be shown never to be zero.
    pub(super) fn is_never_zero(&self, e: Expr) -> bool {
        let node = self.node(e);
        match node.op {
            Op::Number => !self.is_zero(e),
            Op::Pi | Op::Call(Function::Exp | Function::Cosh) => true,
            // A positive number and terms that are never negative.
            Op::Add => {
                let terms = self.terms_of(e);
                let is_positive =
                    |(monic, c): &(Expr, Number)| *monic == ONE && !c.is_negative() && !c.is_zero();
                terms.iter().any(is_positive) && self.is_never_negative(e)
            }
            Op::Mul => self.operands_of(e).into_iter().all(|factor| self.is_never_zero(factor)),
            Op::Pow => self.is_never_zero(node.left) && !self.has_fact(e, fact::POISONED),
            _ => false,
        }
    }
}
