//! M by composite bodies: each link with all that it carries, as one rigid body.

use std::collections::BTreeMap;

use bksim_expr::{Expr, Pool};
use bksim_model::Vector;

use super::links::{Link, LinkBody, LinkMotion, Links};
use crate::sparse::SparseMatrix;
use crate::spatial;

/// A rigid body about the origin of a link's frame.
#[derive(Clone, Debug)]
struct Composite {
    /// kg.
    mass: Expr,
    /// m c, kg m.
    first_moment: Vector,
    /// I about the origin, kg m².
    inertia: [Vector; 3],
}

impl Composite {
    fn nothing(pool: &Pool) -> Self {
        let zero = spatial::zero(pool);
        Self { mass: pool.zero(), first_moment: zero, inertia: [zero; 3] }
    }

    fn of(pool: &Pool, body: &LinkBody) -> Self {
        let first_moment = spatial::scale(pool, body.mass, &body.com);
        // I + m (c·c 1 − c cᵀ)
        let steiner = shift(pool, &first_moment, &body.com);
        Self { mass: body.mass, first_moment, inertia: tensor_sum(pool, &body.inertia, &steiner) }
    }

    fn with(&self, pool: &Pool, other: &Self) -> Self {
        Self {
            mass: pool.add(self.mass, other.mass),
            first_moment: spatial::add(pool, &self.first_moment, &other.first_moment),
            inertia: tensor_sum(pool, &self.inertia, &other.inertia),
        }
    }

    /// The same body about the origin of the link before, in its axes.
    fn to_parent(&self, pool: &Pool, link: &Link) -> Self {
        let origin = link.origin(pool);
        let turned = link.to_parent(pool, &self.first_moment);
        let inertia = match link.turn() {
            Some(turn) => turn.tensor_to_outer(pool, &self.inertia),
            None => self.inertia,
        };
        // I + 2 h·r 1 − h rᵀ − r hᵀ + m (r·r 1 − r rᵀ) with h = R m c: both at once with 2 h + m r.
        let moved = spatial::scale(pool, self.mass, &origin);
        let doubled = spatial::add(pool, &spatial::scale(pool, pool.int(2), &turned), &moved);
        let steiner = shift(pool, &doubled, &origin);
        Self {
            mass: self.mass,
            first_moment: spatial::add(pool, &turned, &moved),
            inertia: tensor_sum(pool, &inertia, &steiner),
        }
    }

    /// Force and moment about the origin that a unit acceleration in a motion needs.
    fn wrench(&self, pool: &Pool, motion: &LinkMotion) -> Option<(Vector, Vector)> {
        match motion {
            LinkMotion::Fixed(_) => None,
            LinkMotion::Rotation { axis, .. } => {
                let force = spatial::cross(pool, axis, &self.first_moment);
                Some((force, self.inertia.map(|row| spatial::dot(pool, &row, axis))))
            }
            LinkMotion::Translation { axis, .. } => {
                let moment = spatial::cross(pool, &self.first_moment, axis);
                Some((spatial::scale(pool, self.mass, axis), moment))
            }
        }
    }
}

/// M, nq × nq, without entries that are zero.
pub(super) fn mass_matrix(pool: &Pool, links: &Links) -> SparseMatrix {
    let mut composites = vec![Composite::nothing(pool); links.links.len()];
    let mut entries: BTreeMap<(usize, usize), Expr> = BTreeMap::new();
    let mut add = |at: (usize, usize), entry: Expr| {
        let sum = entries.entry(at).or_insert(pool.zero());
        *sum = pool.add(*sum, entry);
    };
    for (link_idx, link) in links.links.iter().enumerate().rev() {
        // The link's own body joins what the links after it have handed on.
        if let Some(body) = &link.body {
            composites[link_idx] = composites[link_idx].with(pool, &Composite::of(pool, body));
        }
        let composite = composites[link_idx].clone();
        if let Some(parent) = link.parent {
            let handed_on = composite.to_parent(pool, link);
            composites[parent.0] = composites[parent.0].with(pool, &handed_on);
        }

        // A unit acceleration of the link's motion, felt by every motion before it.
        let (Some(i), Some((mut force, mut moment))) =
            (coordinate_of(&link.motion), composite.wrench(pool, &link.motion))
        else {
            continue;
        };
        let mut at = link;
        loop {
            if let (Some(j), Some(entry)) =
                (coordinate_of(&at.motion), along(pool, &at.motion, &force, &moment))
                && !pool.is_zero(entry)
            {
                add((i, j), entry);
                // The turn and the slide of a screw are links of their own with one coordinate.
                if !std::ptr::eq(at, link) {
                    add((j, i), entry);
                }
            }
            let Some(parent) = at.parent else { break };
            force = at.to_parent(pool, &force);
            let arm = spatial::cross(pool, &at.origin(pool), &force);
            moment = spatial::add(pool, &at.to_parent(pool, &moment), &arm);
            at = &links.links[parent.0];
        }
    }
    let entries = entries.into_iter().map(|((i, j), entry)| (i, j, entry));
    let entries = entries.filter(|&(.., entry)| !pool.is_zero(entry));
    SparseMatrix::new(links.n_coordinates, links.n_coordinates, entries)
}

fn coordinate_of(motion: &LinkMotion) -> Option<usize> {
    match motion {
        LinkMotion::Fixed(_) => None,
        LinkMotion::Rotation { coordinate_idx, .. }
        | LinkMotion::Translation { coordinate_idx, .. } => Some(*coordinate_idx),
    }
}

/// The part of a wrench at a link's origin that acts in its motion.
fn along(pool: &Pool, motion: &LinkMotion, force: &Vector, moment: &Vector) -> Option<Expr> {
    match motion {
        LinkMotion::Fixed(_) => None,
        LinkMotion::Rotation { axis, .. } => Some(spatial::dot(pool, axis, moment)),
        LinkMotion::Translation { axis, .. } => Some(spatial::dot(pool, axis, force)),
    }
}

/// h·r 1 − ½ (h rᵀ + r hᵀ).
fn shift(pool: &Pool, h: &Vector, r: &Vector) -> [Vector; 3] {
    let dot = spatial::dot(pool, h, r);
    let half = pool.rational(1, 2);
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let both = pool.add(pool.mul(h[i], r[j]), pool.mul(h[j], r[i]));
            let diagonal = if i == j { dot } else { pool.zero() };
            pool.sub(diagonal, pool.mul(half, both))
        })
    })
}

fn tensor_sum(pool: &Pool, a: &[Vector; 3], b: &[Vector; 3]) -> [Vector; 3] {
    std::array::from_fn(|i| spatial::add(pool, &a[i], &b[i]))
}
