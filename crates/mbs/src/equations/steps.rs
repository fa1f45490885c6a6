//! The derivation of Lagrange's equations step by step, in the form that is read.
//!
//! ```text
//! L = T − V      d/dt ∂L/∂q̇ − ∂L/∂q = Q − Σ λ_k ∂g_k/∂q
//! ```
//!
//! Source: Lê Hồng Lam and Đinh Văn Phong (2008), equation (1.3). Each derivative is taken of the line before it, with
//! the named constants of the form, so that a reader can take it, too.

use bksim_expr::{Expr, Pool, SymbolId};
use bksim_model::{BodyId, Model, Space};

use super::arrange::Kind;
use super::derivation::doubled_kinetic_energy;
use super::form::ReadingForm;
use super::levels::{Level, RowName};
use crate::coordinate::{Coordinate, CoordinateKind};
use crate::system::{Derivation, SymbolicSystem};

/// Ratio of operations up to which a sum without parentheses is preferred.
const LONGER: u64 = 2;

/// The steps from the centres of mass to Lagrange's equations; none of a mechanism whose equations are found by
/// recursion, in which T is not written out.
pub fn steps(model: &Model, system: &SymbolicSystem, form: &ReadingForm) -> Vec<Level> {
    if system.derivation == Derivation::Recursion {
        return Vec::new();
    }
    let pool = &model.pool;
    let step = |title, rows| Level { title, is_step: true, rows };
    let lagrangian = lagrangian(model, form);
    let whole = pool.sum(lagrangian.iter().copied());

    // One row for each coordinate of the motion; states have equations of their own.
    let coordinates = system.coordinates().iter().enumerate();
    let moving: Vec<(usize, &Coordinate)> =
        coordinates.filter(|(_, c)| c.kind != CoordinateKind::Integral).collect();
    let slopes = |of: fn(&Coordinate) -> SymbolId| {
        let symbols: Vec<SymbolId> = moving.iter().map(|(_, c)| of(c)).collect();
        let slopes = pool.gradient(whole, &symbols).into_iter();
        slopes.map(|slope| pool.simplify(slope)).collect::<Vec<_>>()
    };
    let momenta = slopes(|c| c.v);
    let rate = |&p: &Expr| opened(pool, system.kinematics.second_rate(model, p));
    let rates: Vec<Expr> = momenta.iter().map(rate).collect();
    let by_coordinates = slopes(|c| c.q);
    let parts = |kind: Kind, i: usize| {
        let parts = form.equations[i].iter().filter(|part| part.kind == kind);
        pool.sum(parts.flat_map(|part| part.terms(pool)).collect::<Vec<_>>())
    };
    let named = |name: fn(&Coordinate) -> RowName, values: Vec<Expr>| {
        moving.iter().map(|(_, c)| name(c)).zip(values).collect::<Vec<_>>()
    };
    let loads = moving.iter().map(|&(i, _)| pool.neg(parts(Kind::Load, i))).collect();
    let reactions = moving.iter().map(|&(i, _)| parts(Kind::Constraint, i)).collect();
    let load = |c: &Coordinate| RowName::Load(c.q);
    let [positions, velocities, energies] = of_bodies(model, system);
    vec![
        step("step 1: centres of mass", positions),
        step("step 2: velocities of the centres of mass", velocities),
        step("step 3: kinetic energies of the bodies", energies),
        step(
            "step 4: Lagrangian, the kinetic less the potential energy",
            vec![(RowName::Lagrangian, whole)],
        ),
        step("step 5: derivatives by the velocities", named(|c| RowName::ByRate(c.v), momenta)),
        step("step 6: their rates of change", named(|c| RowName::RateOf(c.v), rates)),
        step("step 7: derivatives by the coordinates", named(|c| RowName::By(c.q), by_coordinates)),
        step("step 8: generalised forces of the loads", named(load, loads)),
        step(
            "step 9: forces of the constraints",
            named(|c| RowName::OfConstraints(c.q), reactions),
        ),
    ]
}

/// A sum multiplied out, as in a book, unless that makes it much longer than its simplest form.
fn opened(pool: &Pool, e: Expr) -> Expr {
    let simple = pool.simplify(e);
    let expanded = pool.expand(simple);
    let [shortest, length] = [simple, expanded].map(|e| pool.printed_operations(&[e]).total());
    if length <= LONGER * shortest { expanded } else { simple }
}

/// The terms of T and −V; names that change with the motion are replaced by what they stand for.
fn lagrangian(model: &Model, form: &ReadingForm) -> Vec<Expr> {
    let pool = &model.pool;
    let mut images: Vec<(SymbolId, Expr)> = Vec::new();
    for group in form.groups.iter().filter(|group| !group.is_constant) {
        images.push((group.symbol, pool.substitute(group.definition(pool), &images)));
    }
    let potential = form.potential_energy.iter().map(|&term| pool.neg(term));
    let terms: Vec<Expr> = form.kinetic_energy.iter().copied().chain(potential).collect();
    pool.substitute_all(&terms, &images)
}

/// Positions and velocities of the centres of mass, and the kinetic energies, by body.
fn of_bodies(model: &Model, system: &SymbolicSystem) -> [Vec<(RowName, Expr)>; 3] {
    let pool = &model.pool;
    let n_axes = if model.space == Space::Planar { 2 } else { 3 };
    let mut found = [Vec::new(), Vec::new(), Vec::new()];
    for (idx, body) in model.bodies.iter().enumerate().skip(1) {
        let name = |before: &str, after: &str| {
            RowName::Symbol(pool.symbol(&format!("{before}_{}{after}", body.name)))
        };
        let position = system.kinematics.position(model, BodyId(idx), None);
        for (axis, &component) in ["x", "y", "z"].into_iter().zip(&position).take(n_axes) {
            let [position, velocity] =
                [component, system.kinematics.rate(model, component)].map(|e| pool.simplify(e));
            found[0].push((name(axis, ""), position));
            found[1].push((name("v", &format!("_{axis}")), velocity));
        }
        let doubled = doubled_kinetic_energy(model, system, BodyId(idx));
        let energy = opened(pool, pool.mul(pool.rational(1, 2), doubled));
        found[2].push((name("T", ""), energy));
    }
    found.map(|rows| {
        let (names, values): (Vec<RowName>, Vec<Expr>) = rows.into_iter().unzip();
        names.into_iter().zip(pool.as_written(&values)).collect()
    })
}
