//! Functions with a kink or jump at a point, as the smooth functions they are on either side of it.
//!
//! ```text
//! |x| about 0:   −x on the left, x on the right;      min(a, b):   the one that is smaller there
//! ```
//!
//! The side is decided by the first derivative of the switching argument (a for |a| and sign a,
//! a − b for min, max and comparisons) that is not zero at the point.

use crate::op::{Function, Op};
use crate::pool::{Expr, MINUS_ONE, ONE, Pool, SymbolId, ZERO};

/// Derivatives of a switching argument that are looked at.
const MAX_ORDER: i64 = 8;

/// One side of a point on the axis of a symbol.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Side {
    Left,
    Right,
}

/// The sign of a switching argument near the point.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Sign {
    Negative,
    Zero,
    Positive,
}

impl Pool {
    /// Whether a function below `e` has a kink or jump where `x` is `about`.
    pub(crate) fn has_kink(&self, e: Expr, x: SymbolId, about: Expr) -> bool {
        let steps = self.sweep(&self.expand_named(&[e])).steps;
        steps.iter().any(|step| {
            let switch = self.switch_of(step.op, step.expr);
            switch.is_some_and(|switch| {
                self.depends_on(switch, x) && self.value_there(switch, x, about) == ZERO
            })
        })
    }

    /// `e` with each function that has a kink or jump where `x` is `about` replaced by what it is on
    /// one side; `None` where that cannot be told.
    pub(crate) fn on_side(&self, e: Expr, x: SymbolId, about: Expr, side: Side) -> Option<Expr> {
        let sweep = self.sweep(&self.expand_named(&[e]));
        let mut is_known = true;
        let mut images: Vec<Expr> = Vec::with_capacity(sweep.steps.len());
        for step in &sweep.steps {
            let operands: Vec<Expr> = sweep.operands(step).map(|o| images[o]).collect();
            let is_same = sweep.operands(step).all(|o| images[o] == sweep.steps[o].expr);
            let mut image = if is_same { step.expr } else { self.rebuild(step, &operands) };
            // What became of it may be no call any more, or another one.
            let op = self.node(image).op;
            if let Some(switch) = self.switch_of(op, image)
                && self.depends_on(switch, x)
                && self.value_there(switch, x, about) == ZERO
            {
                match self.sign_beside(switch, x, about, side) {
                    Some(sign) => image = self.branch(image, sign),
                    None => is_known = false,
                }
            }
            images.push(image);
        }
        is_known.then(|| images[sweep.roots[0]])
    }

    /// The expression whose sign decides which branch of a function with a kink or jump is taken.
    fn switch_of(&self, op: Op, e: Expr) -> Option<Expr> {
        use Function::{Abs, Ge, Gt, If, Le, Lt, Max, Min, Sign};
        let node = self.node(e);
        match op {
            Op::Call(Abs | Sign | If) => Some(node.left),
            Op::Call(Min | Max | Lt | Le | Gt | Ge) => Some(self.sub(node.left, node.right)),
            _ => None,
        }
    }

    fn value_there(&self, e: Expr, x: SymbolId, about: Expr) -> Expr {
        self.simplify(self.substitute(e, &[(x, about)]))
    }

    /// The sign of `switch`, which is zero at the point, next to it.
    fn sign_beside(&self, switch: Expr, x: SymbolId, about: Expr, side: Side) -> Option<Sign> {
        let mut derivative = switch;
        for order in 1..=MAX_ORDER {
            derivative = self.diff(derivative, x);
            if derivative == ZERO {
                return Some(Sign::Zero);
            }
            let slope = self.value_there(derivative, x, about);
            if slope == ZERO {
                continue;
            }
            let number = self.as_number(slope).filter(|n| n.is_finite() && !n.is_zero())?;
            let is_flipped = side == Side::Left && order % 2 == 1;
            let is_negative = number.is_negative() != is_flipped;
            return Some(if is_negative { Sign::Negative } else { Sign::Positive });
        }
        None
    }

    /// A call whose switching argument has the given sign.
    fn branch(&self, call: Expr, sign: Sign) -> Expr {
        let node = self.node(call);
        let Op::Call(function) = node.op else { return call };
        let flag = |holds: bool| if holds { ONE } else { ZERO };
        let pair = || self.node(node.right);
        match (function, sign) {
            (Function::Abs, Sign::Negative) => self.neg(node.left),
            (Function::Sign, Sign::Negative) => MINUS_ONE,
            (Function::Min, Sign::Positive) | (Function::Max, Sign::Negative) => node.right,
            (Function::Abs | Function::Min | Function::Max, _) => node.left,
            (Function::Lt, _) => flag(sign == Sign::Negative),
            (Function::Le, _) => flag(sign != Sign::Positive),
            (Function::Sign | Function::Gt, _) => flag(sign == Sign::Positive),
            (Function::Ge, _) => flag(sign != Sign::Negative),
            (Function::If, Sign::Zero) => pair().right,
            (Function::If, _) => pair().left,
            _ => call,
        }
    }
}
