//! Expressions as a person writes them: short numbers, and no number before a sum that goes better into it.

use crate::number::Number;
use crate::op::Op;
use crate::pool::{Expr, Pool};
use std::cmp::Ordering;

/// Characters that a change has to save where it saves no number.
const WORTH_THE_CHANGE: usize = 3;

impl Pool {
    /// The expressions with numbers as a person writes them.
    ///
    /// A number of many digits becomes the short decimal or the small fraction that it is within rounding,
    /// and a number before a sum is multiplied in where fewer digits remain: `0.5*(2*a + b)` is `a + 0.5*b`.
    ///
    /// ```
    /// let pool = bksim_expr::Pool::new();
    /// let e = pool.parse("0.013333333333333334*x^2 + 0.5*(2*a*sin(x) + b)*y").expect("valid");
    /// assert_eq!(pool.to_text(pool.as_written(&[e])[0]), "1/75*x^2 + y*(a*sin(x) + 0.5*b)");
    /// ```
    #[must_use]
    pub fn as_written(&self, roots: &[Expr]) -> Vec<Expr> {
        let sweep = self.sweep(roots);
        let mut images: Vec<Expr> = Vec::with_capacity(sweep.steps.len());
        for step in &sweep.steps {
            let operands: Vec<Expr> = sweep.operands(step).map(|o| images[o]).collect();
            let unchanged = sweep.operands(step).all(|o| images[o] == sweep.steps[o].expr);
            let rebuilt = if unchanged { step.expr } else { self.rebuild(step, &operands) };
            let written = match self.as_number(rebuilt) {
                Some(number) => number.as_written().map(|number| self.number(number)),
                None => self.multiplied_in(rebuilt),
            };
            images.push(written.unwrap_or(rebuilt));
        }
        sweep.roots.iter().map(|&root| images[root]).collect()
    }

    /// True if a number has so many digits that [`Pool::as_written`] writes another one.
    pub fn has_computed_numbers(&self, roots: &[Expr]) -> bool {
        let steps = self.sweep(roots).steps;
        steps.iter().filter_map(|step| self.as_number(step.expr)).any(|n| n.as_written().is_some())
    }

    /// A product of a number and one sum, among other factors, with the number in the sum; `None` where
    /// that takes as many digits.
    fn multiplied_in(&self, e: Expr) -> Option<Expr> {
        let (number, monic) = self.split_coefficient(e);
        if number.magnitude().is_one() {
            return None;
        }
        let mut factors = self.chain(monic, Op::Mul);
        let mut sums = (0..factors.len()).filter(|&i| self.node(factors[i]).op == Op::Add);
        let (Some(at), None) = (sums.next(), sums.next()) else { return None };
        let terms: Vec<_> = self.chain(factors[at], Op::Add);
        let terms: Vec<_> = terms.into_iter().map(|term| self.split_coefficient(term)).collect();
        let multiplied: Vec<_> =
            terms.iter().map(|(c, monic)| (c.times(&number), *monic)).collect();
        let [before, after] = [&terms, &multiplied].map(|terms| digits(terms.iter().map(|t| &t.0)));
        let [n, n_digits] = digits([&number].into_iter());
        // Numbers as many as before are worth a longer sum only where they are much shorter.
        let saved = (before[1] + n_digits).saturating_sub(after[1]);
        let least = match after[0].cmp(&(before[0] + n)) {
            Ordering::Less => 1,
            Ordering::Equal => WORTH_THE_CHANGE,
            Ordering::Greater => return None,
        };
        if saved < least {
            return None;
        }
        let multiplied = multiplied.into_iter().map(|(c, monic)| self.mul(self.number(c), monic));
        factors[at] = self.sum(multiplied.collect::<Vec<_>>());
        Some(self.product(factors))
    }
}

/// How many numbers are written, and of how many characters; one is not.
fn digits<'n>(numbers: impl Iterator<Item = &'n Number>) -> [usize; 2] {
    let lengths = numbers.map(Number::magnitude).filter(|n| !n.is_one());
    lengths.fold([0, 0], |[n, length], number| [n + 1, length + number.to_string().len()])
}
