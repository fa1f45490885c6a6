//! Newton's and Euler's equations, outwards and inwards over the links.

use bksim_expr::{Expr, Pool};
use bksim_model::{BodyId, MotionKind, Vector};

use super::links::{Link, LinkBody, LinkMotion, Links, Screw, Spin};
use super::naming::Naming;
use crate::kinematics::Kinematics;
use crate::spatial;

/// Rates and accelerations of the coordinates, and the acceleration of the ground.
pub(super) struct TreeMotion<'a> {
    /// v, by coordinate.
    pub(super) rates: &'a [Expr],
    /// v̇, by coordinate.
    pub(super) accelerations: &'a [Expr],
    /// Acceleration of the ground, m/s².
    pub(super) base: &'a Vector,
}

/// Accelerations of a body, world axes.
#[derive(Clone, Debug)]
pub(crate) struct BodyAcceleration {
    /// Acceleration of the centre of mass, m/s².
    pub(crate) com: Vector,
    /// Rate of the angular momentum about the centre of mass, N m.
    pub(crate) angular_momentum_rate: Vector,
}

/// The motion of a link's frame, in its own axes.
#[derive(Clone, Debug)]
struct FrameMotion {
    /// ω, rad/s.
    omega: Vector,
    /// ω̇, rad/s².
    alpha: Vector,
    /// Acceleration of the origin, m/s².
    acceleration: Vector,
}

impl FrameMotion {
    /// ω̇ × r + ω × (ω × r): acceleration of a point against the origin. The products of the components
    /// of ω are those of Euler's equations, so that each is computed once.
    fn relative_acceleration(&self, pool: &Pool, r: &Vector) -> Vector {
        std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let squares = pool.add(self.product(pool, j, j), self.product(pool, k, k));
            let along_j = pool.sub(self.product(pool, i, j), self.alpha[k]);
            let along_k = pool.add(self.product(pool, i, k), self.alpha[j]);
            pool.sum([
                pool.neg(pool.mul(squares, r[i])),
                pool.mul(along_j, r[j]),
                pool.mul(along_k, r[k]),
            ])
        })
    }

    fn product(&self, pool: &Pool, i: usize, j: usize) -> Expr {
        pool.mul(self.omega[i], self.omega[j])
    }

    /// Acceleration of the centre of mass of a body, m/s².
    fn of_com(&self, pool: &Pool, body: &LinkBody) -> Vector {
        let relative = self.relative_acceleration(pool, &body.com);
        spatial::add(pool, &self.acceleration, &relative)
    }

    /// I′ ω̇ + ω × I′ ω, N m; of a diagonal tensor I_x ω̇_x + (I_z − I_y) ω_y ω_z and so on.
    fn euler_moment(&self, pool: &Pool, inertia: &[Vector; 3]) -> Vector {
        std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let squares = pool.sub(self.product(pool, j, j), self.product(pool, k, k));
            let along_j = pool.sub(self.alpha[j], self.product(pool, i, k));
            let along_k = pool.add(self.alpha[k], self.product(pool, i, j));
            pool.sum([
                pool.mul(inertia[i][i], self.alpha[i]),
                pool.mul(pool.sub(inertia[k][k], inertia[j][j]), self.product(pool, j, k)),
                pool.mul(inertia[j][k], squares),
                pool.mul(inertia[i][j], along_j),
                pool.mul(inertia[i][k], along_k),
            ])
        })
    }
}

/// The motion of every link's frame, from the ground outwards.
fn outwards(
    pool: &Pool,
    links: &Links,
    motion: &TreeMotion<'_>,
    naming: &Naming<'_>,
) -> Vec<FrameMotion> {
    let zero = spatial::zero(pool);
    let ground = FrameMotion { omega: zero, alpha: zero, acceleration: *motion.base };
    let mut frames: Vec<FrameMotion> = Vec::with_capacity(links.links.len());
    for (link_idx, link) in links.links.iter().enumerate() {
        let before = link.parent.map_or(&ground, |parent| &frames[parent.0]);
        let FrameMotion { omega, alpha, acceleration } =
            after(pool, (link_idx, link), before, motion, naming);
        frames.push(FrameMotion {
            omega: naming.vector("omega", link_idx, &omega),
            alpha: naming.vector("alpha", link_idx, &alpha),
            acceleration: naming.vector("a", link_idx, &acceleration),
        });
    }
    frames
}

/// The motion of a link's frame from that of the link before.
fn after(
    pool: &Pool,
    (link_idx, link): (usize, &Link),
    before: &FrameMotion,
    motion: &TreeMotion<'_>,
    naming: &Naming<'_>,
) -> FrameMotion {
    let relative = before.relative_acceleration(pool, &link.origin(pool));
    let mut acceleration = spatial::add(pool, &before.acceleration, &relative);
    let mut omega = link.to_link(pool, &before.omega);
    let mut alpha = link.to_link(pool, &before.alpha);
    match &link.motion {
        LinkMotion::Fixed(_) => {}
        LinkMotion::Rotation { axis, coordinate_idx, .. } => {
            let rate = spatial::scale(pool, motion.rates[*coordinate_idx], axis);
            let gain = spatial::scale(pool, motion.accelerations[*coordinate_idx], axis);
            let gyroscopic = spatial::cross(pool, &omega, &rate);
            alpha = spatial::add(pool, &spatial::add(pool, &alpha, &gain), &gyroscopic);
            omega = spatial::add(pool, &omega, &rate);
        }
        LinkMotion::Quaternion { .. } => {
            let rates = [motion.rates, motion.accelerations];
            if let Some(Spin { rate, gain }) = link.spin(pool, rates, link_idx, naming) {
                let gyroscopic = spatial::cross(pool, &omega, &rate);
                alpha = spatial::add(pool, &spatial::add(pool, &alpha, &gain), &gyroscopic);
                omega = spatial::add(pool, &omega, &rate);
            }
        }
        LinkMotion::Translation { axis, coordinate_idx, .. } => {
            // 2 ω × v (Coriolis) and the slide's own acceleration.
            let rate = spatial::scale(pool, motion.rates[*coordinate_idx], axis);
            let gain = spatial::scale(pool, motion.accelerations[*coordinate_idx], axis);
            let turning = spatial::cross(pool, &before.omega, &rate);
            let coriolis = spatial::scale(pool, pool.int(2), &turning);
            acceleration = spatial::add(pool, &spatial::add(pool, &acceleration, &coriolis), &gain);
        }
    }
    FrameMotion { omega, alpha, acceleration: link.to_link(pool, &acceleration) }
}

/// The generalised forces that a motion needs, by coordinate.
pub(super) fn generalised_forces(
    pool: &Pool,
    links: &Links,
    motion: &TreeMotion<'_>,
    naming: &Naming<'_>,
) -> Vec<Expr> {
    let frames = outwards(pool, links, motion, naming);
    let zero = spatial::zero(pool);
    // Force and moment on each link at the origin of its frame, its axes.
    let mut needed = vec![(zero, zero); links.links.len()];
    let mut generalised = vec![pool.zero(); links.n_coordinates];
    for (link_idx, link) in links.links.iter().enumerate().rev() {
        let (mut force, mut moment) = needed[link_idx];
        if let Some(body) = &link.body {
            let frame = &frames[link_idx];
            let own = spatial::scale(pool, body.mass, &frame.of_com(pool, body));
            let own = naming.vector("R", link_idx, &own);
            let turning = frame.euler_moment(pool, &body.inertia);
            let arm = spatial::cross(pool, &body.com, &own);
            force = spatial::add(pool, &force, &own);
            moment = spatial::add(pool, &spatial::add(pool, &moment, &turning), &arm);
        }
        force = naming.vector("F", link_idx, &force);
        moment = naming.vector("N", link_idx, &moment);
        for Screw { kind, axis, coordinate_idx } in link.motion.screws(pool) {
            let along = match kind {
                MotionKind::Rotation => spatial::dot(pool, &axis, &moment),
                MotionKind::Translation => spatial::dot(pool, &axis, &force),
            };
            generalised[coordinate_idx] = pool.add(generalised[coordinate_idx], along);
        }
        // Handed on to the link before, at its origin.
        if let Some(parent) = link.parent {
            let force = link.to_parent(pool, &force);
            let arm = spatial::cross(pool, &link.origin(pool), &force);
            let moment = spatial::add(pool, &link.to_parent(pool, &moment), &arm);
            let before = &mut needed[parent.0];
            before.0 = spatial::add(pool, &before.0, &force);
            before.1 = spatial::add(pool, &before.1, &moment);
        }
    }
    generalised
}

/// The accelerations of all bodies, world axes, by body.
pub(super) fn body_accelerations(
    pool: &Pool,
    links: &Links,
    motion: &TreeMotion<'_>,
    kinematics: &Kinematics,
) -> Vec<BodyAcceleration> {
    let naming = Naming::none(pool);
    let zero = spatial::zero(pool);
    let at_rest = BodyAcceleration { com: zero, angular_momentum_rate: zero };
    let mut accelerations = vec![at_rest; kinematics.poses.len()];
    for (link, frame) in links.links.iter().zip(outwards(pool, links, motion, &naming)) {
        let Some(body) = &link.body else { continue };
        let BodyId(body_idx) = body.id;
        let rotation = &kinematics.poses[body_idx].rotation;
        let world = |u: &Vector| rotation.apply(pool, u);
        accelerations[body_idx] = BodyAcceleration {
            com: world(&frame.of_com(pool, body)),
            angular_momentum_rate: world(&frame.euler_moment(pool, &body.inertia)),
        };
    }
    accelerations
}
