//! Object coordinates: entities of the plane carry a normal, and their numbers are in axes that follow
//! from it.
//!
//! The arbitrary axis algorithm of the DXF reference: x is W × n, with W the world's y axis where n is
//! within 1/64 of the world's z axis, else its z axis; y is n × x. For n = −z, as mirroring leaves it,
//! x points along −x and y along y.

use acadrust::Vector3;

use crate::geometry::Affine;

/// How far a normal may be from ±z for its entity to lie in the plane.
const TILT: f64 = 1e-9;

/// From object to world coordinates; `None` where the entity does not lie in the plane.
pub(super) fn planar(normal: Vector3) -> Option<Affine> {
    let length = (normal.x * normal.x + normal.y * normal.y + normal.z * normal.z).sqrt();
    let is_flat = normal.x.hypot(normal.y) <= TILT * length;
    if !is_flat || length == 0.0 || !length.is_finite() {
        return None;
    }
    let sign = normal.z.signum();
    Some(Affine { x: [sign, 0.0], y: [0.0, 1.0], origin: [0.0, 0.0] })
}
