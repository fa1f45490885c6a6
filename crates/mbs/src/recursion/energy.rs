//! Kinetic energy, and the potential of a uniform field, from velocities and heights of the links.

use bksim_expr::{Expr, Pool};
use bksim_model::Vector;

use super::links::{LinkMotion, Links};
use super::naming::Naming;
use crate::spatial;

/// The terms of T = Σ ½ m v_c · v_c + ½ ω · I′ ω, J, in body frames.
pub(super) fn kinetic(
    pool: &Pool,
    links: &Links,
    rates: &[Expr],
    naming: &Naming<'_>,
) -> Vec<Expr> {
    let half = pool.rational(1, 2);
    let zero = spatial::zero(pool);
    // ω and the velocity of the origin, link's axes.
    let mut motions: Vec<(Vector, Vector)> = Vec::with_capacity(links.links.len());
    let mut terms = Vec::new();
    for (link_idx, link) in links.links.iter().enumerate() {
        let (omega, velocity) = link.parent.map_or((zero, zero), |parent| motions[parent.0]);
        let swing = spatial::cross(pool, &omega, &link.origin(pool));
        let mut velocity = spatial::add(pool, &velocity, &swing);
        let mut turning = link.to_link(pool, &omega);
        match &link.motion {
            LinkMotion::Fixed(_) => {}
            LinkMotion::Rotation { axis, coordinate_idx, .. } => {
                let rate = spatial::scale(pool, rates[*coordinate_idx], axis);
                turning = spatial::add(pool, &turning, &rate);
            }
            LinkMotion::Quaternion { .. } => {
                if let Some(spin) = link.spin(pool, [rates, rates], link_idx, naming) {
                    turning = spatial::add(pool, &turning, &spin.rate);
                }
            }
            LinkMotion::Translation { axis, coordinate_idx, .. } => {
                let rate = spatial::scale(pool, rates[*coordinate_idx], axis);
                velocity = spatial::add(pool, &velocity, &rate);
            }
        }
        let velocity = naming.vector("v", link_idx, &link.to_link(pool, &velocity));
        let turning = naming.vector("omega", link_idx, &turning);
        if let Some(body) = &link.body {
            let swing = spatial::cross(pool, &turning, &body.com);
            let of_com = spatial::add(pool, &velocity, &swing);
            let momentum = body.inertia.map(|row| spatial::dot(pool, &row, &turning));
            let of_com = naming.vector("c", link_idx, &of_com);
            let square = spatial::dot(pool, &of_com, &of_com);
            terms.push(pool.product([half, body.mass, square]));
            terms.push(pool.mul(half, spatial::dot(pool, &turning, &momentum)));
        }
        motions.push((turning, velocity));
    }
    terms.retain(|&term| !pool.is_zero(term));
    terms
}

/// The terms of V = −Σ m a · r_c, J, in a field of the acceleration a, which is turned into each frame.
pub(super) fn potential(
    pool: &Pool,
    links: &Links,
    field: &Vector,
    naming: &Naming<'_>,
) -> Vec<Expr> {
    // a in the link's axes, and a · r of its origin.
    let mut frames: Vec<(Vector, Expr)> = Vec::with_capacity(links.links.len());
    let mut terms = Vec::new();
    for (link_idx, link) in links.links.iter().enumerate() {
        let (field, work) = link.parent.map_or((*field, pool.zero()), |parent| frames[parent.0]);
        let work = pool.add(work, spatial::dot(pool, &field, &link.origin(pool)));
        let work = naming.scalar("u", link_idx, work);
        let field = naming.vector("g", link_idx, &link.to_link(pool, &field));
        if let Some(body) = &link.body {
            let of_com = pool.add(work, spatial::dot(pool, &field, &body.com));
            terms.push(pool.neg(pool.mul(body.mass, of_com)));
        }
        frames.push((field, work));
    }
    terms.retain(|&term| !pool.is_zero(term));
    terms
}
