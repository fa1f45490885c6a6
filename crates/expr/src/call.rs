//! Constructors of function calls: exact values, parities, inverse pairs.

use crate::build::{MERGE_LIMIT, Terms};
use crate::number::Number;
use crate::op::{Function, Op};
use crate::pool::{Expr, ONE, PI, Pool, ZERO, fact};

/// f(−a) = −f(a)
const ODD: [Function; 5] =
    [Function::Asin, Function::Atan, Function::Sinh, Function::Tanh, Function::Sign];
/// Exact values f(a) = b at a rational a.
const EXACT: [(Function, i64, i64); 10] = [
    (Function::Asin, 0, 0),
    (Function::Acos, 1, 0),
    (Function::Atan, 0, 0),
    (Function::Sinh, 0, 0),
    (Function::Cosh, 0, 1),
    (Function::Tanh, 0, 0),
    (Function::Exp, 0, 1),
    (Function::Ln, 1, 0),
    (Function::Sqrt, 0, 0),
    (Function::Sqrt, 1, 1),
];

/// Exact values f(π/n) = (p/q) √r as (f, n, (p, q), r), for angles within an eighth of a turn.
#[rustfmt::skip]
const SPECIAL_ANGLES: [(Function, i64, (i64, i64), i64); 6] = [
    (Function::Sin, 6, (1, 2), 1),
    (Function::Cos, 6, (1, 2), 3),
    (Function::Tan, 6, (1, 3), 3),
    (Function::Sin, 4, (1, 2), 2),
    (Function::Cos, 4, (1, 2), 2),
    (Function::Tan, 4, (1, 1), 1),
];

/// f(a + k π/2) = sign · g(a) as (f, k, sign, g); a tangent has half the period.
#[rustfmt::skip]
const QUARTER_TURNS: [(Function, i64, i32, Function); 10] = [
    (Function::Sin, 0,  1, Function::Sin),
    (Function::Sin, 1,  1, Function::Cos),
    (Function::Sin, 2, -1, Function::Sin),
    (Function::Sin, 3, -1, Function::Cos),
    (Function::Cos, 0,  1, Function::Cos),
    (Function::Cos, 1, -1, Function::Sin),
    (Function::Cos, 2, -1, Function::Cos),
    (Function::Cos, 3,  1, Function::Sin),
    (Function::Tan, 0,  1, Function::Tan),
    (Function::Tan, 2,  1, Function::Tan),
];

macro_rules! unary {
    ($($name:ident $function:ident $doc:literal)*) => { $(
        #[doc = $doc]
        pub fn $name(&self, a: Expr) -> Expr {
            self.call_one(Function::$function, a)
        }
    )* };
}

impl Pool {
    unary! {
        asin Asin "Arc sine, in [−π/2, π/2]."
        acos Acos "Arc cosine, in [0, π]."
        atan Atan "Arc tangent, in (−π/2, π/2)."
        sinh Sinh "Hyperbolic sine."
        cosh Cosh "Hyperbolic cosine."
        tanh Tanh "Hyperbolic tangent."
        exp Exp "Exponential."
        ln Ln "Natural logarithm."
        abs Abs "Absolute value."
        sign Sign "Sign: −1, 0 or 1."
        floor Floor "The largest integer that is not larger."
        sin Sin "Sine of an angle in radians."
        cos Cos "Cosine of an angle in radians."
        tan Tan "Tangent of an angle in radians."
        sqrt Sqrt "Square root."
    }

    /// Angle of the point (x, y), in (−π, π].
    pub fn atan2(&self, y: Expr, x: Expr) -> Expr {
        self.call_two(Function::Atan2, y, x)
    }

    /// The smaller of two values.
    pub fn min(&self, a: Expr, b: Expr) -> Expr {
        self.call_two(Function::Min, a, b)
    }

    /// The larger of two values.
    pub fn max(&self, a: Expr, b: Expr) -> Expr {
        self.call_two(Function::Max, a, b)
    }

    /// `then` where `condition` is not zero, `otherwise` elsewhere.
    pub fn select(&self, condition: Expr, then: Expr, otherwise: Expr) -> Expr {
        match self.as_number(condition) {
            Some(number) if number.is_zero() => otherwise,
            Some(number) if number.is_finite() => then,
            _ if then == otherwise => then,
            _ => {
                let pair = self.intern(Op::Pair, then, otherwise, 0);
                self.intern(Op::Call(Function::If), condition, pair, 0)
            }
        }
    }

    /// Calls a function; `None` when the number of arguments is not its arity.
    pub fn call(&self, function: Function, arguments: &[Expr]) -> Option<Expr> {
        match *arguments {
            [a] if function.arity() == 1 => Some(self.call_one(function, a)),
            [a, b] if function.arity() == 2 => Some(self.call_two(function, a, b)),
            [a, b, c] if function.arity() == 3 => Some(self.select(a, b, c)),
            _ => None,
        }
    }

    pub(crate) fn call_one(&self, function: Function, a: Expr) -> Expr {
        use Function::{Abs, Cos, Ln, Sin, Sqrt, Tan};
        if let Some(value) = self.value_of_number(function, a) {
            return value;
        }
        match function {
            Sin | Cos | Tan => return self.trigonometric(function, a),
            Sqrt => return self.root(a),
            Abs => return self.magnitude(a),
            Ln if self.node(a).op == Op::Call(Function::Exp) => return self.node(a).left,
            _ => (),
        }
        if ODD.contains(&function) && self.looks_negative(a) {
            return self.neg(self.plain_call(function, self.neg(a)));
        }
        if function == Function::Cosh && self.looks_negative(a) {
            return self.plain_call(function, self.neg(a));
        }
        self.plain_call(function, a)
    }

    /// |c a| = |c| |a|, without the bars where a is never negative.
    fn magnitude(&self, a: Expr) -> Expr {
        let (coefficient, monic) = self.split_coefficient(a);
        let monic = if self.looks_negative(monic) { self.neg(monic) } else { monic };
        let inner = if self.is_never_negative(monic) {
            monic
        } else {
            self.plain_call(Function::Abs, monic)
        };
        self.mul(self.number(coefficient.magnitude()), inner)
    }

    fn plain_call(&self, function: Function, a: Expr) -> Expr {
        self.intern(Op::Call(function), a, ZERO, 0)
    }

    /// The value at a number, where it is exact or the number a float.
    fn value_of_number(&self, function: Function, a: Expr) -> Option<Expr> {
        let number = self.as_number(a)?;
        if let Some(f) = number.as_float() {
            let value = function.value(f, 0.0);
            return value.is_finite().then(|| self.float(value));
        }
        match function {
            Function::Abs => return Some(self.number(number.magnitude())),
            Function::Sign => {
                let sign = number.order(Number::ZERO) as i64;
                return Some(self.int(sign));
            }
            _ => (),
        }
        let is_row =
            |row: &&(Function, i64, i64)| row.0 == function && number == Number::integer(row.1);
        EXACT.iter().find(is_row).map(|row| self.number(Number::integer(row.2)))
    }

    pub(crate) fn call_two(&self, function: Function, a: Expr, b: Expr) -> Expr {
        if let (Some(x), Some(y)) = (self.as_number(a), self.as_number(b)) {
            let is_exact = x.is_exact() && y.is_exact();
            let order = x.order(&y);
            match function {
                Function::Atan2 if is_exact => {
                    if x.is_zero() && y.order(Number::ZERO).is_gt() {
                        return ZERO;
                    }
                }
                Function::Min if is_exact => return if order.is_le() { a } else { b },
                Function::Max if is_exact => return if order.is_ge() { a } else { b },
                _ => {
                    let value = function.value(x.to_f64(), y.to_f64());
                    if value.is_finite() {
                        return self.float(value);
                    }
                }
            }
        }
        let is_symmetric = matches!(function, Function::Min | Function::Max);
        if is_symmetric && a == b {
            return a;
        }
        let swap = is_symmetric && self.canonical_order(a, b).is_gt();
        let (a, b) = if swap { (b, a) } else { (a, b) };
        self.intern(Op::Call(function), a, b, 0)
    }

    /// sqrt(c² a² r) = c |a| sqrt(r), for a positive rational c and an r that is never negative.
    fn root(&self, a: Expr) -> Expr {
        if let Some(root) = self.as_number(a).and_then(|n| n.exact_sqrt()) {
            return self.number(root);
        }
        let (coefficient, monic) = self.split_coefficient(a);
        let (outside, inside) = match coefficient.exact_sqrt() {
            Some(root) if monic != ONE => (root, Number::ONE),
            _ => (Number::ONE, coefficient),
        };
        let node = self.node(monic);
        if node.op == Op::Mul && node.data > MERGE_LIMIT {
            return self.mul(
                self.number(outside),
                self.plain_call(Function::Sqrt, self.scaled(inside, monic)),
            );
        }
        let (even, rest): (Vec<Expr>, Vec<Expr>) = self
            .chain(monic, Op::Mul)
            .into_iter()
            .partition(|&factor| self.split_power(factor).1 % 2 == 0);
        let radicand = self.product(rest.into_iter().chain([self.number(inside.clone())]));
        if even.is_empty() || !self.is_never_negative(radicand) {
            let inner = self.scaled(inside, monic);
            return self.mul(self.number(outside), self.plain_call(Function::Sqrt, inner));
        }
        let roots = even.into_iter().map(|factor| {
            let (base, exponent) = self.split_power(factor);
            let half = exponent / 2;
            if half % 2 == 0 { self.powi(base, half) } else { self.powi(self.abs(base), half) }
        });
        let outside = self.product(roots.chain([self.number(outside)]));
        match self.as_number(radicand).and_then(|n| n.exact_sqrt()) {
            Some(root) => self.mul(self.number(root), outside),
            None => self.mul(outside, self.plain_call(Function::Sqrt, radicand)),
        }
    }
}

// Sine, cosine, tangent: the argument is a linear form, its sign and quarter turns move out.
impl Pool {
    fn trigonometric(&self, function: Function, a: Expr) -> Expr {
        let (quarters, is_negative, angle) = self.canonical_angle(a);
        let row = QUARTER_TURNS.iter().find(|row| (row.0, row.1) == (function, quarters));
        let Some(&(_, _, mut sign, function)) = row else {
            // tan(a + π/2) = −cos a / sin a
            let [s, c] = [Function::Sin, Function::Cos].map(|f| self.angle_call(f, angle));
            let quotient = self.div(c, s);
            return if is_negative { quotient } else { self.neg(quotient) };
        };
        if is_negative && function != Function::Cos {
            sign = -sign;
        }
        let call = self.angle_call(function, angle);
        if sign < 0 { self.neg(call) } else { call }
    }

    /// Writes `a` as `±angle + quarters · π/2`; whether the sign is negative. The sign is that of the
    /// angle without an eighth of a turn, which is added in both cases: −q + ¼π is −(q + ¼π) + ½π.
    fn canonical_angle(&self, a: Expr) -> (i64, bool, Expr) {
        let (quarters, angle) = self.reduce_angle(a);
        let eighth = self.scaled(Number::rational(1, 4), PI);
        let has_eighth = angle != eighth && self.chain(angle, Op::Add).contains(&eighth);
        if !has_eighth {
            let is_negative = self.looks_negative(angle);
            return (quarters, is_negative, if is_negative { self.neg(angle) } else { angle });
        }
        let rest = self.sub(angle, eighth);
        if self.looks_negative(rest) {
            ((quarters + 1).rem_euclid(4), true, self.add(self.neg(rest), eighth))
        } else {
            (quarters, false, angle)
        }
    }

    /// The call at a reduced angle, exact at 0, π/6 and π/4.
    fn angle_call(&self, function: Function, angle: Expr) -> Expr {
        let (coefficient, monic) = self.split_coefficient(angle);
        if angle == ZERO {
            return if function == Function::Cos { ONE } else { ZERO };
        }
        let is_row = |row: &&(Function, i64, (i64, i64), i64)| {
            row.0 == function && coefficient == Number::rational(1, row.1)
        };
        match SPECIAL_ANGLES.iter().find(is_row).filter(|_| monic == PI) {
            Some(&(_, _, (n, d), radicand)) => {
                self.mul(self.rational(n, d), self.sqrt(self.int(radicand)))
            }
            None => self.plain_call(function, angle),
        }
    }

    /// True if `e` is more than a number times the root of a number.
    pub(crate) fn has_call(&self, e: Expr) -> bool {
        let (_, monic) = self.split_coefficient(e);
        let node = self.node(monic);
        let is_root = node.op == Op::Call(Function::Sqrt) && self.as_number(node.left).is_some();
        monic != ONE && !is_root
    }

    /// Writes `a` as `angle + quarters · π/2` with quarters in 0..4 and the multiple of π left in
    /// `angle` within (−π/4, π/4]; scaled sums are multiplied out, so that like terms merge.
    fn reduce_angle(&self, a: Expr) -> (i64, Expr) {
        let mut terms = self.linear_form(a);
        let Some(index) = terms.iter().position(|&(monic, _)| monic == PI) else {
            return (0, self.sum_of(terms));
        };
        // −floor(1/2 − 2m) leaves 2m − quarters in (−1/2, 1/2].
        let half = Number::rational(1, 2);
        let minus_doubled = terms[index].1.times(Number::integer(-2));
        let Some(below) = minus_doubled.plus(&half).floor() else {
            return (0, self.sum_of(terms));
        };
        terms[index].1 = minus_doubled.plus(below.negated()).times(half.negated());
        // A whole turn is four quarters.
        let quarter = Number::rational(1, 4);
        let turns = below.times(&quarter).floor().unwrap_or(Number::ZERO);
        let rest = below.plus(turns.times(Number::integer(-4))).as_integer();
        let quarters = (-rest.expect("a remainder of four")).rem_euclid(4);
        (quarters, self.sum_of(terms))
    }

    /// The terms of `a`, with sums under a numeric coefficient multiplied out; like terms merged.
    fn linear_form(&self, a: Expr) -> Terms {
        let mut pending = vec![(a, Number::ONE)];
        let mut terms = Terms::new();
        while let Some((e, factor)) = pending.pop() {
            let (coefficient, monic) = self.split_coefficient(e);
            let scale = factor.times(coefficient);
            let node = self.node(monic);
            if node.op == Op::Add && node.data <= MERGE_LIMIT && terms.len() < MERGE_LIMIT as usize
            {
                pending.extend(
                    self.chain(monic, Op::Add).into_iter().map(|term| (term, scale.clone())),
                );
            } else {
                terms.push((monic, scale));
            }
        }
        terms.sort_by(|x, y| self.canonical_order(x.0, y.0));
        terms.dedup_by(|next, kept| {
            let is_like = next.0 == kept.0;
            if is_like {
                kept.1 = kept.1.plus(&next.1);
            }
            is_like
        });
        terms.retain(|&(monic, ref c)| !c.is_zero() || self.has_fact(monic, fact::POISONED));
        terms
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(left: f64, right: f64, row: &dyn std::fmt::Debug) {
        assert!((left - right).abs() < 1e-14, "{row:?}: {left} is not {right}");
    }

    #[test]
    fn rows_of_exact_values_hold() {
        for row in EXACT {
            check(row.0.value(row.1 as f64, 0.0), row.2 as f64, &row);
        }
        for row in SPECIAL_ANGLES {
            let (function, n, (p, q), radicand) = row;
            let root = Function::Sqrt.value(radicand as f64, 0.0);
            check(
                function.value(std::f64::consts::PI / n as f64, 0.0),
                p as f64 / q as f64 * root,
                &row,
            );
        }
    }

    #[test]
    fn rows_of_parity_and_quarter_turns_hold_at_every_angle() {
        for a in [-0.9, -0.3, 0.2, 0.8] {
            for function in ODD {
                check(function.value(-a, 0.0), -function.value(a, 0.0), &function);
            }
            for row in QUARTER_TURNS {
                let (function, k, sign, image) = row;
                let turned = a + k as f64 * std::f64::consts::FRAC_PI_2;
                check(function.value(turned, 0.0), f64::from(sign) * image.value(a, 0.0), &row);
            }
        }
    }
}
