//! Moments of inertia about the centre of mass.

use bksim_model::{BodyId, Model, Vector};

use crate::pose::Pose;
use crate::spatial;

/// I′ about the centre of mass: by Steiner, I_c = I_P − m (d·d 1 − d dᵀ), d from P to the centre.
pub fn central_inertia(model: &Model, body: BodyId) -> [Vector; 3] {
    let pool = &model.pool;
    let body = &model.bodies[body.0];
    let [ixx, iyy, izz] = body.inertia.moments;
    let [ixy, iyz, izx] = body.inertia.products;
    let stated = [[ixx, ixy, izx], [ixy, iyy, iyz], [izx, iyz, izz]];
    let Some(about) = body.inertia.about else {
        return stated;
    };
    let d = spatial::sub(pool, &body.com, &body.points[about.0].position);
    let d_squared = spatial::dot(pool, &d, &d);
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let diagonal = if i == j { d_squared } else { pool.zero() };
            let shift = pool.sub(diagonal, pool.mul(d[i], d[j]));
            pool.sub(stated[i][j], pool.mul(body.mass, shift))
        })
    })
}

/// A I′ Aᵀ ω of a body about its centre of mass, world axes.
pub(crate) fn angular_momentum(model: &Model, pose: &Pose, body: BodyId) -> Vector {
    let pool = &model.pool;
    let omega = pose.rotation.apply_inverse(pool, &pose.omega);
    let in_body = central_inertia(model, body).map(|row| spatial::dot(pool, &row, &omega));
    pose.rotation.apply(pool, &in_body)
}
