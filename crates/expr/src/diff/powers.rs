//! Derivatives of powers and roots, also where a base is zero.

use crate::build::MERGE_LIMIT;
use crate::op::Op;
use crate::pool::{Expr, ONE, Pool, ZERO, fact};
use crate::sweep::{Step, Sweep};

impl Pool {
    /// (aⁿ)' = n aⁿ⁻¹ a'; (aᵇ)' = b aᵇ⁻¹ a' + aᵇ ln(a) b'
    pub(super) fn power_rule(
        &self,
        power: Expr,
        (a, da): (Expr, Expr),
        (b, db): (Expr, Expr),
    ) -> Expr {
        let lowered = || self.pow(a, self.sub(b, ONE));
        let from_base = if da == ZERO { ZERO } else { self.product([b, lowered(), da]) };
        if db == ZERO {
            return from_base;
        }
        self.add(from_base, self.product([power, self.logarithm_under_power(a, b), db]))
    }

    /// ln a as a factor of aᵇ. 0ᵇ is zero for all b > 0, and so is its derivative by b, for which 1/b
    /// stands in; for b ≤ 0 neither has a value.
    pub(super) fn logarithm_under_power(&self, a: Expr, b: Expr) -> Expr {
        if a == ZERO { self.powi(b, -1) } else { self.ln(a) }
    }

    /// The factors under a root or constant power that change, with their derivatives, if others do
    /// not: √(c w)' = √(c w) w'/(2 w) is zero where c is, and w'c/(2 √(c w)) has no value there.
    pub(super) fn moving_factors(
        &self,
        sweep: &Sweep,
        step: &Step,
        tangents: &[Expr],
    ) -> Option<Vec<(Expr, Expr)>> {
        let base = self.factors_under(sweep, step)?;
        let is_moving = |&&factor: &&usize| tangents[factor] != ZERO;
        let is_still = |&&factor: &&usize| {
            !self.has_fact(sweep.steps[factor].expr, fact::CONSTANT) && tangents[factor] == ZERO
        };
        let exponent = sweep.operands(step).nth(1);
        let is_constant_power = exponent.is_none_or(|exponent| tangents[exponent] == ZERO);
        (is_constant_power && base.iter().any(|f| is_still(&f))).then(|| {
            let moving = base.iter().filter(is_moving);
            moving.map(|&factor| (sweep.steps[factor].expr, tangents[factor])).collect()
        })
    }

    /// (c w)ᵇ' = b (c w)ᵇ w'/w for the product w of the factors that change.
    pub(super) fn power_of_product_rule(&self, step: &Step, moving: &[(Expr, Expr)]) -> Expr {
        let exponent = match step.op {
            Op::Pow => self.node(step.expr).right,
            _ => self.rational(1, 2),
        };
        let inverse = moving.iter().map(|&(factor, _)| self.powi(factor, -1));
        let parts = inverse.chain([exponent, step.expr, self.product_rule(moving)]);
        self.product(parts.collect::<Vec<_>>())
    }

    /// The positions of the factors of a product under a root or a power that is no integer one;
    /// `None` where there is no product, or a long one.
    pub(super) fn factors_under(&self, sweep: &Sweep, step: &Step) -> Option<Vec<usize>> {
        let mut operands = sweep.operands(step);
        let mut base = operands.next()?;
        let is_integer = |exponent: usize| {
            let number = self.as_number(sweep.steps[exponent].expr);
            number.is_some_and(|n| n.as_integer().is_some())
        };
        if operands.next().is_some_and(is_integer) {
            return None;
        }
        // The numeric coefficient leads, and the other factors may be one product after it.
        let mut factors: Vec<usize> = Vec::new();
        while sweep.steps[base].op == Op::Mul {
            factors = sweep.operands(&sweep.steps[base]).collect();
            factors.retain(|&f| self.as_number(sweep.steps[f].expr).is_none());
            match factors[..] {
                [inner] => base = inner,
                _ => break,
            }
        }
        (2..=MERGE_LIMIT as usize).contains(&factors.len()).then_some(factors)
    }

    /// Each factor's share of a power of their product, which is zero where another factor is.
    pub(super) fn pull_back_power(
        &self,
        sweep: &Sweep,
        factors: &[usize],
        [adjoint, exponent, power]: [Expr; 3],
        give: &mut dyn FnMut(usize, Expr),
    ) {
        for &factor in factors {
            let inverse = self.powi(sweep.steps[factor].expr, -1);
            give(factor, self.product([adjoint, exponent, power, inverse]));
        }
    }
}
