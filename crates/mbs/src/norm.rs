//! The length of quaternions: the row e·e − 1 = 0 of each, and the inertia that it has.
//!
//! ```text
//! T += ½ c (e·ė)²        M += c e eᵀ,   h += c (ė·ė) e
//! ```
//!
//! A rotation is the same at every length of e, so that M would have no inertia along e. The term above
//! gives it some, c = I_x + I_y + I_z + 2 m r² of the body that turns, about its point in the tree; on
//! e·e = 1 and e·ė = 0 it is zero, and no motion changes by it.

use bksim_expr::{Expr, Pool};
use bksim_model::{Model, Vector};

use crate::inertia::central_inertia;
use crate::kinematics::{Kinematics, Turning};
use crate::sparse::SparseMatrix;
use crate::spatial;

/// e·e − 1 of a quaternion.
pub(crate) fn row(pool: &Pool, turning: &Turning) -> Expr {
    pool.sub(turning.quaternion.square(pool), pool.one())
}

/// c, kg m².
fn inertia(model: &Model, kinematics: &Kinematics, turning: &Turning) -> Expr {
    let pool = &model.pool;
    let body = &model.bodies[turning.body.0];
    let own = central_inertia(model, turning.body);
    let arm: Vector = spatial::sub(pool, &body.com, &kinematics.poses[turning.body.0].anchor_body);
    let square = spatial::dot(pool, &arm, &arm);
    let steiner = pool.product([pool.int(2), body.mass, square]);
    pool.simplify(pool.sum([own[0][0], own[1][1], own[2][2], steiner]))
}

/// No names.
pub(crate) fn unnamed(_: &Turning, e: Expr) -> Expr {
    e
}

/// The rates, or other symbols, of a quaternion's coordinates.
fn parts<T: Copy>(of: &[T], turning: &Turning) -> [T; 4] {
    std::array::from_fn(|part| of[turning.first + part])
}

/// The terms ½ c (e·ė)² of T; `named` may give each quaternion's e·ė a name.
pub(crate) fn kinetic_energy(
    model: &Model,
    kinematics: &Kinematics,
    rates: &[Expr],
    named: &dyn Fn(&Turning, Expr) -> Expr,
) -> Vec<Expr> {
    let pool = &model.pool;
    let term = |turning: &Turning| {
        let along = named(turning, turning.quaternion.dot(pool, &parts(rates, turning)));
        let c = inertia(model, kinematics, turning);
        pool.product([pool.rational(1, 2), c, pool.powi(along, 2)])
    };
    kinematics.turnings.iter().map(term).collect()
}

/// M with the entries c e eᵀ.
pub(crate) fn mass_matrix(
    model: &Model,
    kinematics: &Kinematics,
    matrix: &SparseMatrix,
) -> SparseMatrix {
    let pool = &model.pool;
    let terms = kinematics.turnings.iter().flat_map(|turning| {
        let c = inertia(model, kinematics, turning);
        let (first, e) = (turning.first, turning.quaternion.0);
        let places = (0..4).flat_map(|i| (0..4).map(move |j| (i, j)));
        places.map(move |(i, j)| (first + i, first + j, pool.product([c, e[i], e[j]])))
    });
    matrix.plus(pool, terms)
}

/// Adds c e (ė·ė + e·ë) to generalised forces that a motion needs, by coordinate; `named` may give each
/// quaternion's c (ė·ė + e·ë) a name.
pub(crate) fn add_forces(
    model: &Model,
    kinematics: &Kinematics,
    [rates, accelerations]: [&[Expr]; 2],
    forces: &mut [Expr],
    named: &dyn Fn(&Turning, Expr) -> Expr,
) {
    let pool = &model.pool;
    for turning in &kinematics.turnings {
        let rate = parts(rates, turning);
        let squares = pool.sum(rate.map(|v| pool.powi(v, 2)));
        let along = turning.quaternion.dot(pool, &parts(accelerations, turning));
        let force = pool.mul(inertia(model, kinematics, turning), pool.add(squares, along));
        let force = named(turning, force);
        for (part, &e) in turning.quaternion.0.iter().enumerate() {
            let own = &mut forces[turning.first + part];
            *own = pool.add(*own, pool.mul(force, e));
        }
    }
}
