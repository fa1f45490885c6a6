//! Recursion over the links of the tree in body frames: the equations of motion of mechanisms in space.
//!
//! ```text
//! outwards:  ω, ω̇ and the acceleration a of each frame from those of the frame before
//! inwards:   f = Σ (m a + ω̇ × m c + ω × (ω × m c)),  n = Σ (I ω̇ + ω × I ω + c × f),  τ_i = S_i · (n, f)
//! ```
//!
//! Written in the frame of each link, where inertia is constant, the equations of a tree grow with the
//! number of its links, and M with that of its pairs; expanded into sums over products of sines and
//! cosines they would grow exponentially. Nothing here is expanded: an expression of one link is an
//! operand of the next one's.
//!
//! Sources: J. Y. S. Luh, M. W. Walker, R. P. C. Paul, *On-Line Computational Scheme for Mechanical
//! Manipulators*, J. Dyn. Sys. Meas. Control 102 (1980), equations (1) to (15), for τ; R. Featherstone,
//! *Rigid Body Dynamics Algorithms* (2008), §6.2, for M by composite bodies.

mod composite;
mod energy;
mod links;
mod newton_euler;
mod turn;

use bksim_expr::Expr;
use bksim_model::{Model, Vector};

use crate::kinematics::Kinematics;
use crate::lagrange::LeftSide;
use crate::spatial;
use crate::tree::Tree;

use links::Links;
use newton_euler::{Motion, generalised_forces};

pub(crate) use newton_euler::BodyAcceleration;

/// Number of turns about different axes in a row from which on the recursion is shorter than
/// Lagrange's equations written out.
const MIN_TURNS: usize = 4;

/// Whether the equations of the bodies at `kinematics` are derived by recursion.
pub(crate) fn is_shorter(kinematics: &Kinematics) -> bool {
    kinematics.poses.iter().any(|pose| pose.rotation.turns().len() >= MIN_TURNS)
}

/// Derives the left side for the bodies of `model` in a uniform field of acceleration `field` and the
/// potential `rest` of everything else.
pub(crate) fn left_side(
    model: &Model,
    tree: &Tree,
    kinematics: &Kinematics,
    field: &Vector,
    rest: Expr,
) -> LeftSide {
    let pool = &model.pool;
    let links = Links::of(model, tree, kinematics);
    let symbols: Vec<_> = kinematics.coordinates.iter().map(|c| c.q).collect();
    let velocities: Vec<Expr> =
        kinematics.coordinates.iter().map(|c| pool.symbol_expr(c.v)).collect();
    let accelerations: Vec<Expr> =
        kinematics.coordinates.iter().map(|c| pool.symbol_expr(c.a)).collect();
    let at_rest = vec![pool.zero(); velocities.len()];

    // A field is what a frame that falls the other way feels.
    let lifted = spatial::neg(pool, field);
    let forces = |rates: &[Expr], accelerations: &[Expr], base: &Vector| {
        generalised_forces(pool, &links, &Motion { rates, accelerations, base })
    };
    let slopes = pool.gradient(rest, &symbols);
    let with_slope = |forces: Vec<Expr>| -> Vec<Expr> {
        forces.into_iter().zip(&slopes).map(|(force, &slope)| pool.add(force, slope)).collect()
    };
    LeftSide {
        kinetic_energy: energy::kinetic(pool, &links, &velocities),
        potential_energy: pool.add(energy::potential(pool, &links, field), rest),
        mass_matrix: composite::mass_matrix(pool, &links),
        bias: forces(&velocities, &at_rest, &spatial::zero(pool)),
        potential_gradient: with_slope(forces(&at_rest, &at_rest, &lifted)),
        resistance: with_slope(forces(&velocities, &at_rest, &lifted)),
        inverse_dynamics: Some(with_slope(forces(&velocities, &accelerations, &lifted))),
    }
}

/// The accelerations of all bodies, world axes.
pub(crate) fn body_accelerations(
    model: &Model,
    tree: &Tree,
    kinematics: &Kinematics,
) -> Vec<BodyAcceleration> {
    let pool = &model.pool;
    let coordinates = &kinematics.coordinates;
    let rates: Vec<Expr> = coordinates.iter().map(|c| pool.symbol_expr(c.v)).collect();
    let accelerations: Vec<Expr> = coordinates.iter().map(|c| pool.symbol_expr(c.a)).collect();
    let base = spatial::zero(pool);
    let motion = Motion { rates: &rates, accelerations: &accelerations, base: &base };
    let links = Links::of(model, tree, kinematics);
    newton_euler::body_accelerations(pool, &links, &motion, kinematics)
}
