//! Axes of motions and wrenches of composite bodies in the axes of the ground: the entries of M of long chains.
//!
//! ```text
//! M_ij = a_j · N_i + b_j · F_i,      b_j = p_j × a_j
//! ```
//!
//! with the axis a_j and the point p_j of a turn j, and the wrench F_i, N_i that a unit acceleration of i takes; all
//! about one point, that at which the first link turns that both hang on. An entry is two scalar products, where a wrench
//! that is handed on from frame to frame takes two turns for each. Only composites that turn stay in the frames of their
//! links, so that no inertia is moved far and back. Source: R. Featherstone, *Rigid Body Dynamics Algorithms* (2008),
//! §6.2, and §6.6 on the costs.

use bksim_expr::{Expr, Pool};
use bksim_model::{MotionKind, Vector};

use super::links::{Link, LinkMotion, Links, Screw};
use super::turn::{LinkTurn, TurnAxis};
use crate::spatial;

/// The frame of a link, against that of the ground.
#[derive(Clone, Debug)]
pub(super) struct GroundFrame {
    /// Rows of R: the axes of the ground in those of the link.
    rows: [Vector; 3],
    /// The link's origin from the first turn before it, axes of the ground, m; `None` before any turn.
    origin: Option<Vector>,
}

/// A motion of one coordinate in the axes of the ground.
#[derive(Clone, Debug)]
pub(super) struct GroundScrew {
    pub(super) coordinate_idx: usize,
    kind: MotionKind,
    /// a.
    axis: Vector,
    /// p × a of a turn.
    lever: Vector,
}

/// Force and moment in the axes of the ground.
#[derive(Clone, Debug)]
pub(super) struct GroundWrench {
    force: Vector,
    moment: Vector,
}

/// True if M takes fewer operations with wrenches in the axes of the ground.
pub(super) fn is_shorter(links: &Links) -> bool {
    /// Operations of an entry: two scalar products.
    const ENTRY: usize = 11;
    /// Of a frame's origin, an axis with its lever, and a wrench with its own.
    const FRAME: usize = 90;
    let mut handed_on = vec![0; links.links.len()];
    let mut n_before = vec![0; links.links.len()];
    let (mut own, mut ground) = (0, 0);
    for (link_idx, link) in links.links.iter().enumerate() {
        let turn = link.turn().map_or(0, cost);
        let n_screws = n_screws(link);
        if let Some(parent) = link.parent {
            // Force and moment turned, the arm of the force, and one scalar product for each motion there.
            let before = n_screws_of(links, parent.0);
            handed_on[link_idx] = handed_on[parent.0] + 2 * turn + 12 + 5 * before;
            n_before[link_idx] = n_before[parent.0] + before;
        }
        own += n_screws * handed_on[link_idx];
        ground += 3 * turn + n_screws * (FRAME + ENTRY * n_before[link_idx]);
    }
    ground < own
}

fn n_screws_of(links: &Links, link_idx: usize) -> usize {
    n_screws(&links.links[link_idx])
}

fn n_screws(link: &Link) -> usize {
    match link.motion {
        LinkMotion::Fixed(_) => 0,
        LinkMotion::Rotation { .. } | LinkMotion::Translation { .. } => 1,
        LinkMotion::Quaternion { .. } => 4,
    }
}

/// Operations of a turn of one vector.
fn cost(turn: &LinkTurn) -> usize {
    match turn {
        LinkTurn::About { axis: TurnAxis::Coordinate(_), .. } => 6,
        LinkTurn::Matrix(_) => 15,
        LinkTurn::About { axis: TurnAxis::Other(_), .. } => 30,
    }
}

impl GroundFrame {
    /// The frames of all links.
    pub(super) fn all(pool: &Pool, links: &Links) -> Vec<Self> {
        let mut frames: Vec<Self> = Vec::with_capacity(links.links.len());
        for link in &links.links {
            let before = link.parent.map(|parent| &frames[parent.0]);
            let rows = before.map_or_else(|| spatial::axes(pool), |before| before.rows);
            let origin = match before.and_then(|before| before.origin) {
                Some(origin) => {
                    let way = link.origin(pool);
                    let way = rows.map(|row| spatial::dot(pool, &row, &way));
                    Some(spatial::add(pool, &origin, &way))
                }
                // The first turn is about the point that all else is about.
                None => (!matches!(link.motion, LinkMotion::Translation { .. }))
                    .then(|| spatial::zero(pool)),
            };
            let rows = match link.turn() {
                Some(turn) => rows.map(|row| turn.to_inner(pool, &row)),
                None => rows,
            };
            frames.push(Self { rows, origin });
        }
        frames
    }

    fn to_ground(&self, pool: &Pool, u: &Vector) -> Vector {
        self.rows.map(|row| spatial::dot(pool, &row, u))
    }

    pub(super) fn screw(&self, pool: &Pool, screw: &Screw) -> GroundScrew {
        let axis = self.to_ground(pool, &screw.axis);
        let lever = match (screw.kind, &self.origin) {
            (MotionKind::Rotation, Some(origin)) => spatial::cross(pool, origin, &axis),
            _ => spatial::zero(pool),
        };
        GroundScrew { coordinate_idx: screw.coordinate_idx, kind: screw.kind, axis, lever }
    }

    /// A wrench at the link's origin.
    pub(super) fn wrench(&self, pool: &Pool, (force, moment): &(Vector, Vector)) -> GroundWrench {
        let force = self.to_ground(pool, force);
        let moment = match &self.origin {
            Some(origin) => {
                let arm = spatial::cross(pool, origin, &force);
                spatial::add(pool, &self.to_ground(pool, moment), &arm)
            }
            None => spatial::zero(pool),
        };
        GroundWrench { force, moment }
    }
}

impl GroundScrew {
    /// The part of a wrench that acts along it.
    pub(super) fn along(&self, pool: &Pool, GroundWrench { force, moment }: &GroundWrench) -> Expr {
        match self.kind {
            MotionKind::Translation => spatial::dot(pool, &self.axis, force),
            MotionKind::Rotation => pool.add(
                spatial::dot(pool, &self.axis, moment),
                spatial::dot(pool, &self.lever, force),
            ),
        }
    }
}
