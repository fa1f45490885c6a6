//! [`Solid`]: a body with plane faces, and what a camera sees of it.

use std::collections::HashMap;

use serde::Serialize;

use crate::Camera;
use crate::geometry::{Plane, Point, along3, cross3, dot3, sub3, unit3};

/// The direction to the light in the view: right, up, towards the eye.
pub const LIGHT: [f64; 3] = [-0.35, 0.55, 0.758];
/// Faces whose normals are further apart than this (cosine) meet in an edge that is drawn from all sides.
const SHARP: f64 = 0.9;

/// A solid bounded by plane faces, in the frame of its body.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Solid {
    /// Corners, m.
    pub corners: Vec<[f64; 3]>,
    /// Faces by their corners, counter-clockwise as seen from outside.
    pub faces: Vec<Vec<usize>>,
    /// Where two faces meet.
    pub edges: Vec<Edge>,
}

/// A line in which two faces meet.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
pub struct Edge {
    /// Two corners of the edge.
    pub corners: [usize; 2],
    /// The faces on either side.
    pub faces: [usize; 2],
    /// True if it is drawn from all sides: edges of round parts are drawn as outlines alone.
    pub is_sharp: bool,
}

/// A face towards the eye, in the world.
#[derive(Clone, PartialEq, Debug)]
pub struct SeenFace {
    /// Corners of the face, m.
    pub ring: Vec<[f64; 3]>,
    /// How far it is turned away from the light: 0 towards it, 1 across and beyond.
    pub shade: f32,
    /// Edges that are painted after it.
    pub edges: Vec<[[f64; 3]; 2]>,
}

impl Solid {
    /// A solid with these faces, counter-clockwise as seen from outside.
    pub fn new(corners: Vec<[f64; 3]>, faces: Vec<Vec<usize>>) -> Self {
        let normals: Vec<Option<[f64; 3]>> = faces
            .iter()
            .map(|face| unit3(normal(face.iter().map(|&corner| corners[corner]))))
            .collect();
        // Each edge is met twice, in opposite directions.
        let mut open: HashMap<[usize; 2], usize> = HashMap::new();
        let mut edges = Vec::new();
        for (face, ring) in faces.iter().enumerate() {
            for (&from, &to) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                let Some(other) = open.remove(&[to, from]) else {
                    open.insert([from, to], face);
                    continue;
                };
                let is_sharp = match (normals[face], normals[other]) {
                    (Some(one), Some(other)) => dot3(one, other) < SHARP,
                    _ => false,
                };
                edges.push(Edge { corners: [from, to], faces: [other, face], is_sharp });
            }
        }
        Self { corners, faces, edges }
    }

    /// The prism between z = `low` and z = `high` over a ring in the plane, counter-clockwise, with its
    /// points moved by `place`.
    pub(crate) fn prism(
        ring: &[Point],
        [low, high]: [f64; 2],
        place: impl Fn([f64; 3]) -> [f64; 3],
    ) -> Self {
        let n = ring.len();
        let level = |z: f64| ring.iter().map(move |&[x, y]| [x, y, z]);
        let corners = level(low).chain(level(high)).map(place).collect();
        let bottom = (0..n).rev().collect();
        let top = (n..2 * n).collect();
        let side = |i: usize| {
            let next = (i + 1) % n;
            vec![i, next, n + next, n + i]
        };
        Self::new(corners, [bottom, top].into_iter().chain((0..n).map(side)).collect())
    }

    /// The block between these distances along u, v and u × v from the origin of a plane.
    pub(crate) fn block(plane: &Plane, [[a, b], [c, d], heights]: [[f64; 2]; 3]) -> Self {
        let normal = cross3(plane.u, plane.v);
        let place = |[x, y, z]: [f64; 3]| along3(plane.lift([x, y]), z, normal);
        Self::prism(&[[a, c], [b, c], [b, d], [a, d]], heights, place)
    }

    /// The faces that a camera sees of the solid placed in the world, the farthest first.
    pub fn seen(&self, place: impl Fn([f64; 3]) -> [f64; 3], camera: &Camera) -> Vec<SeenFace> {
        let corners: Vec<[f64; 3]> = self.corners.iter().map(|&corner| place(corner)).collect();
        let [right, up, eye] = camera.r_view_from_world;
        // The shade of each face that looks towards the eye.
        let shade = |face: &Vec<usize>| {
            let n = unit3(normal(face.iter().map(|&corner| corners[corner])))?;
            let lit = dot3([right, up, eye].map(|axis| dot3(axis, n)), LIGHT);
            (dot3(eye, n) > 1e-9).then(|| 1.0 - lit.clamp(0.0, 1.0))
        };
        let shades: Vec<Option<f64>> = self.faces.iter().map(shade).collect();
        let depth = |face: usize| {
            let ring = &self.faces[face];
            ring.iter().map(|&corner| dot3(eye, corners[corner])).sum::<f64>() / ring.len() as f64
        };
        let mut order: Vec<(f64, usize)> = (0..self.faces.len())
            .filter(|&face| shades[face].is_some())
            .map(|face| (depth(face), face))
            .collect();
        order.sort_by(|(a, _), (b, _)| a.total_cmp(b));

        // Sharp edges and the outline go with the nearer of their faces.
        let mut place_of = vec![None; self.faces.len()];
        for (at, &(_, face)) in order.iter().enumerate() {
            place_of[face] = Some(at);
        }
        let mut edges = vec![Vec::new(); order.len()];
        for edge in &self.edges {
            let [one, other] = edge.faces.map(|face| place_of[face]);
            let is_drawn = edge.is_sharp || one.is_some() != other.is_some();
            if let Some(at) = one.max(other).filter(|_| is_drawn) {
                edges[at].push(edge.corners.map(|corner| corners[corner]));
            }
        }
        let face = |((_, face), edges): ((f64, usize), Vec<[[f64; 3]; 2]>)| SeenFace {
            ring: self.faces[face].iter().map(|&corner| corners[corner]).collect(),
            shade: single(shades[face].unwrap_or(1.0)),
            edges,
        };
        order.into_iter().zip(edges).map(face).collect()
    }

    /// Unit normals of its faces, outwards.
    pub fn normals(&self) -> impl Iterator<Item = [f64; 3]> {
        let corner = |&corner: &usize| self.corners[corner];
        self.faces.iter().filter_map(move |face| unit3(normal(face.iter().map(corner))))
    }

    /// The middle of its corners.
    pub fn middle(&self) -> [f64; 3] {
        let n = self.corners.len().max(1) as f64;
        std::array::from_fn(|i| self.corners.iter().map(|corner| corner[i]).sum::<f64>() / n)
    }
}

/// Twice the area of a plane ring as a vector.
pub(crate) fn normal(ring: impl Iterator<Item = [f64; 3]>) -> [f64; 3] {
    let ring: Vec<[f64; 3]> = ring.collect();
    let Some((&origin, rest)) = ring.split_first() else { return [0.0; 3] };
    let fans = rest.windows(2).map(|p| cross3(sub3(p[0], origin), sub3(p[1], origin)));
    fans.fold([0.0; 3], |sum, part| std::array::from_fn(|i| sum[i] + part[i]))
}

#[expect(clippy::cast_possible_truncation, reason = "a shade")]
fn single(x: f64) -> f32 {
    x as f32
}
