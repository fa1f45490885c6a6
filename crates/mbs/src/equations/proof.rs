//! [`proof`]: evidence that the equations say what mechanics says, and what the forms cost.
//!
//! All equations of a form are compared at once: each is multiplied by a weight, and the sums are
//! evaluated at random points with random weights, in two precisions. Sums that agree for random
//! weights have terms that agree.

use bksim_expr::{Certificate, Expr, Operations, Pool, SymbolId};

use super::arrange::to_be_read;
use super::derivation::{UnsimplifiedEquations, derive};
use super::form::ReadingForm;
use crate::system::SymbolicSystem;
use bksim_model::Model;

/// The comparisons of the forms, and their costs.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Proof {
    /// The simplified equations against a derivation of their own, unsimplified.
    pub derivation: Certificate,
    /// The form that is shown, its names replaced by their definitions, against the simplified
    /// equations.
    pub grouping: Certificate,
    /// Operations of all equations and constraints.
    pub work: Work,
}

/// Operations of the Lagrange equations and constraints in three forms.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Work {
    /// Operations as derived, unsimplified.
    pub derived: Counts,
    /// Simplified.
    pub simplified: Counts,
    /// Operations as shown, definitions of constants aside.
    pub shown: Counts,
}

/// Operations of one form.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Counts {
    /// Shared parts once.
    pub shared: Operations,
    /// Everything written out.
    pub printed: Operations,
}

impl Counts {
    fn of(pool: &Pool, roots: &[Expr]) -> Self {
        Self {
            shared: pool.operation_count(roots).operations(),
            printed: pool.printed_operations(roots),
        }
    }
}

/// Compares and counts the equations of `system`, shown in the given form.
pub fn proof(model: &Model, system: &SymbolicSystem, shown: &ReadingForm) -> Proof {
    let pool = &model.pool;
    let plain = ReadingForm::solved(model, &to_be_read(model, system));
    let UnsimplifiedEquations { kinetic_energy, potential_energy, left_sides, constraints } =
        derive(model, system);
    let derived: Vec<Expr> = left_sides.into_iter().chain(constraints).collect();
    let energies = |form: &ReadingForm| {
        [&form.kinetic_energy, &form.potential_energy].map(|terms| pool.sum(terms.iter().copied()))
    };
    let rows = |form: &ReadingForm| {
        let sum = |terms: &Vec<Expr>| pool.sum(terms.iter().copied());
        let constraints = form.constraints.iter().map(sum);
        form.left_sides(pool).into_iter().chain(constraints).collect::<Vec<_>>()
    };
    let everything = |rows: &[Expr], energies: [Expr; 2]| -> Vec<Expr> {
        rows.iter().copied().chain(energies).collect()
    };
    // Constants and named roots are computed apart from the equations; roots change with the motion.
    let mut shown_rows = rows(shown);
    let motion = shown.groups.iter().filter(|group| !group.is_constant);
    shown_rows.extend(motion.map(|group| group.definition(pool)));
    Proof {
        derivation: weighted(
            pool,
            &everything(&derived, [kinetic_energy, potential_energy]),
            &everything(&rows(&plain), energies(&plain)),
        ),
        grouping: same(model, &plain, shown),
        work: Work {
            derived: Counts::of(pool, &derived),
            simplified: Counts::of(pool, &rows(&plain)),
            shown: Counts::of(pool, &shown_rows),
        },
    }
}

/// Whether two forms say the same when all names are replaced by their definitions.
pub(super) fn same(model: &Model, a: &ReadingForm, b: &ReadingForm) -> Certificate {
    let pool = &model.pool;
    let all = |form: &ReadingForm| {
        let form = spelled_out(pool, form);
        let sum = |terms: &Vec<Expr>| pool.sum(terms.iter().copied());
        let mut all = form.left_sides(pool);
        all.extend(form.constraints.iter().map(sum));
        all.extend([sum(&form.kinetic_energy), sum(&form.potential_energy)]);
        all
    };
    weighted(pool, &all(a), &all(b))
}

/// The form with every name replaced by what it stands for.
fn spelled_out(pool: &Pool, form: &ReadingForm) -> ReadingForm {
    let mut images: Vec<(SymbolId, Expr)> = Vec::new();
    for group in &form.groups {
        // A definition uses earlier names only.
        let definition = pool.substitute(group.definition(pool), &images);
        images.push((group.symbol, definition));
    }
    form.map(&|exprs| pool.substitute_all(exprs, &images))
}

/// Compares two lists of expressions of equal length.
fn weighted(pool: &Pool, a: &[Expr], b: &[Expr]) -> Certificate {
    // No identifier contains the sign.
    let weight = |i: usize| pool.symbol(&format!("§weight{i}"));
    let sum = |list: &[Expr]| {
        let products = list.iter().enumerate().map(|(i, &e)| pool.mul(weight(i), e));
        pool.sum(products.collect::<Vec<_>>())
    };
    let (a, b) = (sum(a), sum(b));
    let mut found = pool.certificate(a, b);
    found.is_rounded |= pool.has_computed_numbers(&[a, b]);
    found
}
