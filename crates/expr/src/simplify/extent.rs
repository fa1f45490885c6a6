//! How far an expression would spread multiplied out, counted before anything is.
//!
//! A force in a long mechanism is a product of sums that hardly share anything: its factors have tens of terms, their
//! product thousands, and none of its normal forms is shorter than the factors. To find that out by multiplying takes
//! seconds; counting takes one sweep and depends on the expression alone.

use crate::op::Op;
use crate::pool::{Expr, Pool};

impl Pool {
    /// Number of terms of `e` with products and powers of sums multiplied out, before equal ones meet.
    ///
    /// ```
    /// let pool = bksim_expr::Pool::new();
    /// let terms = |text: &str| pool.multiplied_out(pool.parse(text).expect("valid"));
    /// assert_eq!(terms("(a + b)*(c + d + 1) + sin(a + b)"), 7);
    /// assert_eq!(terms("(a + b)^3/(c + d)"), 8);
    /// ```
    pub fn multiplied_out(&self, e: Expr) -> u64 {
        self.terms_of_parts(e).pop().unwrap_or(0)
    }

    /// Terms of every part of `e` multiplied out, those of `e` last.
    fn terms_of_parts(&self, e: Expr) -> Vec<u64> {
        let sweep = self.sweep(&[e]);
        let mut terms: Vec<u64> = Vec::with_capacity(sweep.steps.len());
        for step in &sweep.steps {
            let operands = sweep.operands(step).map(|o| terms[o]);
            terms.push(match step.op {
                Op::Add => operands.fold(0, u64::saturating_add),
                Op::Mul => operands.fold(1, u64::saturating_mul),
                Op::Pow => self.terms_of_power(step.expr, operands.max().unwrap_or(1)),
                _ => 1,
            });
        }
        terms
    }

    /// Terms of a power whose base has `n_base` terms; one that is no power of a natural number stays a factor.
    fn terms_of_power(&self, power: Expr, n_base: u64) -> u64 {
        let (base, exponent) = self.split_power(power);
        match u32::try_from(exponent) {
            Ok(exponent) if base != power => n_base.saturating_pow(exponent),
            _ => 1,
        }
    }

    /// The cheapest form of `e` as by [`Pool::simplify`], if it has at most `max_terms` terms multiplied out, and so has
    /// every divisor and argument in it; else `e`.
    #[must_use]
    pub fn simplify_up_to(&self, e: Expr, max_terms: u64) -> Expr {
        let is_short = self.terms_of_parts(e).iter().all(|&n| n <= max_terms);
        if is_short { self.simplify(e) } else { e }
    }
}

#[cfg(test)]
mod tests {
    use crate::pool::Pool;

    #[test]
    fn long_divisors_and_arguments_keep_an_expression_as_it_is() {
        let pool = Pool::new();
        let parsed = |text: &str| pool.parse(text).expect(text);
        let [short, long] = ["sin(q)^2 + cos(q)^2", "(sin(q)^2 + cos(q)^2)/sqrt((a + b)*(c + d))"];
        assert_eq!(pool.simplify_up_to(parsed(short), 3), pool.one());
        assert_eq!(pool.simplify_up_to(parsed(long), 3), parsed(long));
        assert_ne!(pool.simplify_up_to(parsed(long), 4), parsed(long));
    }
}
