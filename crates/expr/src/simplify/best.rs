//! The cheapest of the forms that were written out so far.

use super::cost::{Cost, CostModel};
use super::factor::{Preference, factored};
use super::poly::{Poly, is_trigonometric};
use crate::pool::Expr;

/// Terms up to which a polynomial is factored.
const MAX_FACTORED_TERMS: usize = 1_500;
/// Visits to each factor while a polynomial is factored, about.
const FACTORING_WORK: usize = 4;

/// The cheapest form so far.
pub(super) struct Best {
    pub(super) e: Expr,
    pub(super) cost: Cost,
}

impl Best {
    /// A form to begin with.
    pub(super) fn of(model: &CostModel, e: Expr) -> Self {
        Self { e, cost: model.cost(e) }
    }

    fn consider(&mut self, model: &CostModel, e: Expr) {
        if e != self.e || self.cost == Cost::MAX {
            self.take(Self::of(model, e));
        }
    }

    /// Replaces the form by a cheaper one.
    pub(super) fn take(&mut self, other: Self) {
        if other.cost < self.cost {
            *self = other;
        }
    }

    /// Considers a polynomial with common factors taken out in the ways that may differ.
    pub(super) fn consider_factored(&mut self, model: &CostModel, poly: &Poly) {
        if poly.len() > MAX_FACTORED_TERMS {
            return;
        }
        let n_factors: usize = poly.iter().map(|term| 1 + term.monomial.len()).sum();
        let atoms = || poly.iter().flat_map(|term| &term.monomial);
        let is_mixed = atoms().any(|f| is_trigonometric(model.pool, f.0))
            && atoms().any(|f| !is_trigonometric(model.pool, f.0));
        let preferences = [Preference::Frequent, Preference::Trigonometric, Preference::Plain];
        for &preference in &preferences[..if is_mixed { 3 } else { 1 }] {
            if model.meter.has_ended() {
                return;
            }
            model.meter.spend(FACTORING_WORK * n_factors);
            self.consider(model, factored(model.pool, poly, preference));
        }
    }
}
