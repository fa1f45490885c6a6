//! Sines and cosines of sums by those of the terms: more operations in one expression, fewer in
//! many that share them.
//!
//! ```text
//! Σ_l c_l sin(a − b_l) = sin a (Σ_l c_l cos b_l) − cos a (Σ_l c_l sin b_l)
//! ```
//!
//! In the forces of a chain of N bodies, the left side takes N² sines in all, the right side 2 N
//! sines and cosines and sums that neighbouring bodies have in common.

use super::budget::FORM_BUDGET;
use super::factor::{Preference, factored};
use super::poly::{Algebra, Reading};
use crate::op::{Function, Op};
use crate::pool::{Expr, ONE, Pool, ZERO};

impl Pool {
    /// Writes sines and cosines of sums by those of the terms, and takes common sines and cosines
    /// out; the expression itself if that is too much.
    pub fn unfold_angles(&self, e: Expr) -> Expr {
        let sweep = self.sweep(&[e]);
        let unfolded = self.map_sweep(&sweep, |step| {
            let is_sine = match step.op {
                Op::Call(Function::Sin) => true,
                Op::Call(Function::Cos) => false,
                _ => return None,
            };
            let angle = self.node(step.expr).left;
            (self.node(angle).op == Op::Add).then(|| {
                let [sine, cosine] = self.unfolded(angle);
                if is_sine { sine } else { cosine }
            })
        });
        let products =
            Reading { is_fourier: false, keeps_plain_sums: true, splits_tangents: false };
        let unfolded = unfolded[sweep.roots[0]];
        let poly = Algebra::new(self, FORM_BUDGET).read(unfolded, products);
        poly.map_or(e, |poly| factored(self, &poly, Preference::Trigonometric))
    }

    /// Sine and cosine of a sum, by the addition theorems.
    fn unfolded(&self, angle: Expr) -> [Expr; 2] {
        self.operands_of(angle).into_iter().fold([ZERO, ONE], |[s, c], term| {
            let (sine, cosine) = (self.sin(term), self.cos(term));
            [
                self.add(self.mul(s, cosine), self.mul(c, sine)),
                self.sub(self.mul(c, cosine), self.mul(s, sine)),
            ]
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::pool::Pool;

    #[test]
    fn common_sines_and_cosines_are_taken_out() {
        let pool = Pool::new();
        let e = pool.parse("k*sin(a - b) + m*sin(a - c)").expect("valid");
        let unfolded = pool.unfold_angles(e);
        assert!(pool.certificate(e, unfolded).is_equal());
        let text = pool.to_text(unfolded);
        assert_eq!(text.matches("(a)").count(), 2, "one sine and one cosine of a: {text}");
    }
}
