//! M by composite bodies: each link with all that it carries, as one rigid body.

use std::collections::BTreeMap;

use bksim_expr::{Expr, Pool};
use bksim_model::{MotionKind, Vector};

use super::ground_axes::{self, GroundFrame, GroundScrew};
use super::links::{Link, LinkBody, Links, Screw};
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

    /// Composite body about the origin of the link before, in its axes.
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

    /// Force and moment about the origin that a unit acceleration along a screw needs.
    fn wrench(&self, pool: &Pool, Screw { kind, axis, .. }: &Screw) -> (Vector, Vector) {
        match kind {
            MotionKind::Rotation => {
                let force = spatial::cross(pool, axis, &self.first_moment);
                (force, self.inertia.map(|row| spatial::dot(pool, &row, axis)))
            }
            MotionKind::Translation => {
                let moment = spatial::cross(pool, &self.first_moment, axis);
                (spatial::scale(pool, self.mass, axis), moment)
            }
        }
    }
}

/// Entries of M by row and column.
#[derive(Default)]
struct Entries(BTreeMap<(usize, usize), Expr>);

impl Entries {
    /// Adds an entry of one link; off the diagonal its mirror image, too.
    fn add(&mut self, pool: &Pool, [i, j]: [usize; 2], entry: Expr) {
        self.add_one(pool, (i, j), entry);
        if i != j {
            self.add_one(pool, (j, i), entry);
        }
    }

    /// Adds an entry between two links and its mirror image: the turn and the slide of a screw joint have one
    /// coordinate, so that both are on its diagonal.
    fn add_both(&mut self, pool: &Pool, [i, j]: [usize; 2], entry: Expr) {
        self.add_one(pool, (i, j), entry);
        self.add_one(pool, (j, i), entry);
    }

    fn add_one(&mut self, pool: &Pool, at: (usize, usize), entry: Expr) {
        let sum = self.0.entry(at).or_insert(pool.zero());
        *sum = pool.add(*sum, entry);
    }
}

/// M, nq × nq, without entries that are zero.
pub(super) fn mass_matrix(pool: &Pool, links: &Links) -> SparseMatrix {
    let composites = composites(pool, links);
    let entries = if ground_axes::is_shorter(links) {
        entries_in_ground_axes(pool, links, &composites)
    } else {
        entries_by_handing_on(pool, links, &composites)
    };
    let entries = entries.0.into_iter().map(|((i, j), entry)| (i, j, entry));
    let entries = entries.filter(|&(.., entry)| !pool.is_zero(entry));
    SparseMatrix::new(links.n_coordinates, links.n_coordinates, entries)
}

/// Each link with all that it carries.
fn composites(pool: &Pool, links: &Links) -> Vec<Composite> {
    let mut composites = vec![Composite::nothing(pool); links.links.len()];
    for (link_idx, link) in links.links.iter().enumerate().rev() {
        // The link's own body joins what the links after it have handed on.
        if let Some(body) = &link.body {
            composites[link_idx] = composites[link_idx].with(pool, &Composite::of(pool, body));
        }
        if let Some(parent) = link.parent {
            let handed_on = composites[link_idx].to_parent(pool, link);
            composites[parent.0] = composites[parent.0].with(pool, &handed_on);
        }
    }
    composites
}

/// A unit acceleration of each coordinate, felt by all before it as its wrench goes from frame to frame.
fn entries_by_handing_on(pool: &Pool, links: &Links, composites: &[Composite]) -> Entries {
    let mut entries = Entries::default();
    for (link, composite) in links.links.iter().zip(composites) {
        let own = link.motion.screws(pool);
        for (own_idx, screw) in own.iter().enumerate() {
            let i = screw.coordinate_idx;
            let (mut force, mut moment) = composite.wrench(pool, screw);
            for other in &own[..=own_idx] {
                let entry = along(pool, other, &force, &moment);
                entries.add(pool, [i, other.coordinate_idx], entry);
            }
            let mut at = link;
            while let Some(parent) = at.parent {
                force = at.to_parent(pool, &force);
                let arm = spatial::cross(pool, &at.origin(pool), &force);
                moment = spatial::add(pool, &at.to_parent(pool, &moment), &arm);
                at = &links.links[parent.0];
                for other in at.motion.screws(pool) {
                    let entry = along(pool, &other, &force, &moment);
                    entries.add_both(pool, [i, other.coordinate_idx], entry);
                }
            }
        }
    }
    entries
}

/// Entries of the mass matrix with all wrenches and motions in the axes of the ground.
fn entries_in_ground_axes(pool: &Pool, links: &Links, composites: &[Composite]) -> Entries {
    let frames = GroundFrame::all(pool, links);
    let screws: Vec<Vec<Screw>> = links.links.iter().map(|link| link.motion.screws(pool)).collect();
    let in_ground = |(frame, own): (&GroundFrame, &Vec<Screw>)| -> Vec<GroundScrew> {
        own.iter().map(|screw| frame.screw(pool, screw)).collect()
    };
    let turned: Vec<Vec<GroundScrew>> = frames.iter().zip(&screws).map(in_ground).collect();
    let mut entries = Entries::default();
    for (link_idx, link) in links.links.iter().enumerate() {
        for (own_idx, screw) in screws[link_idx].iter().enumerate() {
            let i = screw.coordinate_idx;
            // On its own axes a link needs no turn.
            let wrench = composites[link_idx].wrench(pool, screw);
            for other in &screws[link_idx][..=own_idx] {
                let entry = along(pool, other, &wrench.0, &wrench.1);
                entries.add(pool, [i, other.coordinate_idx], entry);
            }
            let wrench = frames[link_idx].wrench(pool, &wrench);
            let mut before = link.parent;
            while let Some(parent) = before {
                for other in &turned[parent.0] {
                    entries.add_both(pool, [i, other.coordinate_idx], other.along(pool, &wrench));
                }
                before = links.links[parent.0].parent;
            }
        }
    }
    entries
}

/// The part of a wrench at a link's origin that acts along a screw.
fn along(pool: &Pool, Screw { kind, axis, .. }: &Screw, force: &Vector, moment: &Vector) -> Expr {
    match kind {
        MotionKind::Rotation => spatial::dot(pool, axis, moment),
        MotionKind::Translation => spatial::dot(pool, axis, force),
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
