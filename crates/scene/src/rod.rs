//! Rods with round ends, and balls: shapes that look the same from all around.
//!
//! Without perspective their outline is exact: all points within the radius of the line between the
//! projected ends.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::geometry::{Plane, across3, along3, circle, cross3, rounded_hull, sub3, unit3};
use crate::solid::LIGHT;
use crate::{Camera, Form, Solid};

/// The outline of a rod as the camera sees it: a ring in the plane of the picture, world, m.
pub fn silhouette(ends: [[f64; 3]; 2], radius: f64, camera: &Camera) -> Vec<[f64; 3]> {
    let [u, v, _] = camera.r_view_from_world;
    let plane = Plane { origin: ends[0], u, v };
    plane.lifted(&rounded_hull(&ends.map(|end| plane.foot(end)), radius))
}

/// Cosines of the angle to the light down to which each cap of a ball is lit alike, from the largest; of these caps
/// no part is behind the outline.
const CAPS: [f64; 4] = [0.7, 0.8, 0.9, 0.97];

/// The caps of a ball that are turned towards the light, each inside the one before: rings in the plane of the
/// picture, world, m, and how far each is turned away from the light.
pub(crate) fn lit_caps(
    centre: [f64; 3],
    radius: f64,
    camera: &Camera,
) -> Vec<(Vec<[f64; 3]>, f32)> {
    let [u, v, _] = camera.r_view_from_world;
    let plane = Plane { origin: centre, u, v };
    let [x, y, z] = LIGHT;
    let across = x.hypot(y);
    let [along, aside] = [[x / across, y / across], [-y / across, x / across]];
    let cap = |&cosine: &f64| {
        // The edge of the cap is a circle across the light, of which the camera sees an ellipse.
        let sine = (1.0 - cosine * cosine).sqrt();
        let point = |[p, q]: [f64; 2]| {
            let towards = cosine * across + sine * z * p;
            let at = |i: usize| radius * (towards * along[i] + sine * q * aside[i]);
            plane.lift([at(0), at(1)])
        };
        let ring = circle([0.0; 2], 1.0).into_iter().map(point).collect();
        (ring, single(1.0 - cosine))
    };
    CAPS.iter().map(cap).collect()
}

/// How far the part of a ball beyond its caps is turned away from the light, in the middle of it.
pub(crate) const DUSK: f32 = 0.45;

#[expect(clippy::cast_possible_truncation, reason = "a shade")]
fn single(x: f64) -> f32 {
    x as f32
}

/// A rod for renderers without a camera of ours: rings in two planes across each other that hold
/// its line, for a ball in three.
pub fn sheets([from, to]: [[f64; 3]; 2], radius: f64) -> Vec<Vec<[f64; 3]>> {
    let Some(along) = unit3(sub3(to, from)) else {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let disc = |i: usize| {
            let plane = Plane { origin: from, u: axes[i], v: axes[(i + 1) % 3] };
            plane.lifted(&circle([0.0; 2], radius))
        };
        return (0..3).map(disc).collect();
    };
    let v = across3(along, [0.0, 0.0, 1.0]);
    let sheet = |v| {
        let plane = Plane { origin: from, u: along, v };
        plane.lifted(&rounded_hull(&[from, to].map(|end| plane.foot(end)), radius))
    };
    [v, cross3(along, v)].map(sheet).to_vec()
}

/// Sides of a faceted rod about its line.
const SIDES: usize = 32;
/// Rows of facets from its sides to the end of its line.
const ROWS: usize = 8;

/// A rod or ball as a solid with plane faces, whose corners lie on it.
pub(crate) fn faceted([from, to]: [[f64; 3]; 2], radius: f64) -> Solid {
    let along = unit3(sub3(to, from));
    let axis = along.unwrap_or([0.0, 0.0, 1.0]);
    let u = across3(axis, [0.0, 0.0, 1.0]);
    let v = cross3(axis, u);
    // Circles of corners from one end to the other: the two halves of a ball have one in common.
    let latitude = |row: usize| FRAC_PI_2 * row as f64 / ROWS as f64;
    let first = (0..ROWS).rev().map(|row| (from, -latitude(row)));
    let last = (usize::from(along.is_none())..ROWS).map(|row| (to, latitude(row)));
    let mut corners = vec![along3(from, -radius, axis)];
    let mut n_circles = 0;
    for (centre, latitude) in first.chain(last) {
        let centre = along3(centre, radius * latitude.sin(), axis);
        let across = radius * latitude.cos();
        corners.extend((0..SIDES).map(|side| {
            let (sin, cos) = (TAU * side as f64 / SIDES as f64).sin_cos();
            along3(along3(centre, across * cos, u), across * sin, v)
        }));
        n_circles += 1;
    }
    corners.push(along3(to, radius, axis));

    // Triangles about both ends, four corners to each face between them.
    let corner = |circle: usize, side: usize| 1 + circle * SIDES + side % SIDES;
    let (near, far) = (0, corners.len() - 1);
    let mut faces = Vec::new();
    for side in 0..SIDES {
        faces.push(vec![near, corner(0, side + 1), corner(0, side)]);
        for circle in 1..n_circles {
            let [[a, b], [c, d]] =
                [circle - 1, circle].map(|it| [side, side + 1].map(|at| corner(it, at)));
            faces.push(vec![a, b, d, c]);
        }
        faces.push(vec![corner(n_circles - 1, side), corner(n_circles - 1, side + 1), far]);
    }
    Solid::new(corners, faces)
}

impl Form {
    /// Points whose hull encloses it, in the frame of its body, m.
    pub fn reach(&self) -> Vec<[f64; 3]> {
        match self {
            Self::Region(rings) | Self::Section { rings, .. } => rings.concat(),
            Self::Line { points, .. } => points.clone(),
            Self::Rod { ends, radius } => {
                let sides = [-1.0, 1.0].map(|sign| sign * radius);
                let box_of = |end: &[f64; 3]| {
                    let [x, y, z] = *end;
                    sides.map(|d| [[x + d, y, z], [x, y + d, z], [x, y, z + d]]).concat()
                };
                ends.iter().flat_map(box_of).collect()
            }
            Self::Solid(solid) => solid.corners.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::distance3;

    #[test]
    fn a_rod_is_as_wide_in_every_view_and_as_long_as_the_distance_of_its_ends() {
        let ends = [[0.1, -0.3, 0.2], [0.4, 0.5, 1.1]];
        for k in 0..12 {
            let camera =
                Camera::spatial([100.0, 100.0], 0.6 * f64::from(k), 0.2 * f64::from(k) - 1.2);
            let [p, q] = ends.map(|end| camera.project(end));
            let apart = (p[0] - q[0]).hypot(p[1] - q[1]);
            let seen: Vec<_> =
                silhouette(ends, 0.05, &camera).into_iter().map(|p| camera.project(p)).collect();
            let (dx, dy) = ((q[0] - p[0]) / apart, (q[1] - p[1]) / apart);
            let along = seen.iter().map(|s| dx * (s[0] - p[0]) + dy * (s[1] - p[1]));
            let across = seen.iter().map(|s| dx * (s[1] - p[1]) - dy * (s[0] - p[0]));
            let extent = |values: &mut dyn Iterator<Item = f64>| {
                let all: Vec<f64> = values.collect();
                all.iter().copied().fold(f64::NEG_INFINITY, f64::max)
                    - all.iter().copied().fold(f64::INFINITY, f64::min)
            };
            let (long, wide) = (extent(&mut along.into_iter()), extent(&mut across.into_iter()));
            assert!((wide - 0.1).abs() < 1e-3, "view {k}: {wide} m wide");
            assert!((long - apart - 0.1).abs() < 1e-3, "view {k}: {long} m long, not {apart}");
        }
    }

    #[test]
    fn sheets_have_the_size_of_the_rod() {
        let [from, to] = [[0.0, 0.0, 1.0], [0.0, 2.0, 1.0]];
        for (ends, n, size) in [([from, to], 2, 2.2), ([from, from], 3, 0.2)] {
            let sheets = sheets(ends, 0.1);
            assert_eq!(sheets.len(), n);
            for ring in sheets {
                let far = |a: &[f64; 3]| ring.iter().map(|b| distance3(*a, *b)).fold(0.0, f64::max);
                let extent = ring.iter().map(far).fold(0.0, f64::max);
                assert!((extent - size).abs() < 1e-3, "{extent}");
            }
        }
    }
}
