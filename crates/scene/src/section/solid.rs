//! [`cut`]: a solid cut by a plane, and the face that closes the cut.

use std::ops::Range;

use super::HalfSpace;
use super::area::Cutter;
use crate::solid::normal;
use crate::{Edge, Solid};

/// The part of a solid that is left.
pub(super) enum Cut {
    /// All of it.
    Whole,
    /// Nothing.
    Gone,
    /// A part.
    Part {
        /// The part, open at the plane.
        solid: Solid,
        /// The rings about the cut face, which is filled by the even–odd rule.
        rings: Vec<Vec<[f64; 3]>>,
    },
}

/// The part of a solid in a half of space.
pub(super) fn cut(solid: &Solid, half: &HalfSpace) -> Cut {
    let mut cutter = Cutter::new(half, solid.corners.clone());
    match cutter.sides(2.0 * half.slack) {
        [false, _] => return Cut::Whole,
        [true, false] => return Cut::Gone,
        [true, true] => (),
    }

    // Faces; of each its pieces, which are more than one where it is concave.
    let mut faces: Vec<Vec<usize>> = Vec::new();
    let mut pieces: Vec<Range<usize>> = Vec::with_capacity(solid.faces.len());
    let mut cuts = Vec::new();
    for face in &solid.faces {
        let first = faces.len();
        if face.iter().all(|&corner| cutter.is_kept(corner)) {
            faces.push(face.clone());
        } else if face.iter().any(|&corner| cutter.is_kept(corner)) {
            let normal = normal(face.iter().map(|&corner| solid.corners[corner]));
            let area = cutter.area(std::slice::from_ref(face), normal);
            faces.extend(area.rings);
            cuts.extend(area.cuts.into_iter().map(|(cut, ring)| (cut, first + ring)));
        }
        pieces.push(first..faces.len());
    }

    // Edges, up to the plane.
    let mut edges = Vec::new();
    for edge in &solid.edges {
        let [a, b] = edge.corners;
        let corners = match edge.corners.map(|corner| cutter.is_kept(corner)) {
            [true, true] => [a, b],
            [true, false] => [a, cutter.crossing(a, b)],
            [false, true] => [b, cutter.crossing(a, b)],
            [false, false] => continue,
        };
        let piece = |face: usize| {
            let mut pieces = pieces[face].clone();
            pieces.find(|&piece| faces[piece].contains(&corners[0]))
        };
        if let [Some(one), Some(other)] = edge.faces.map(piece) {
            edges.push(Edge { corners, faces: [one, other], is_sharp: edge.is_sharp });
        }
    }
    // The edges of the cut go with the one face that they have, and are drawn whenever it is seen.
    let rim =
        |&(corners, face): &([usize; 2], usize)| Edge { corners, faces: [face; 2], is_sharp: true };
    edges.extend(cuts.iter().map(rim));

    let segments: Vec<[usize; 2]> = cuts.iter().map(|&(cut, _)| cut).collect();
    let rings = rings_of(&segments, cutter.corners.len());
    let at = |ring: Vec<usize>| {
        let mut points: Vec<[f64; 3]> = ring.iter().map(|&corner| cutter.corners[corner]).collect();
        points.dedup();
        points
    };
    let rings = rings.into_iter().map(at).filter(|ring| ring.len() > 2).collect();
    Cut::Part { solid: compact(&cutter, solid.corners.len(), faces, edges), rings }
}

/// A solid of faces and edges without the corners that are left out.
fn compact(
    cutter: &Cutter,
    n_given: usize,
    mut faces: Vec<Vec<usize>>,
    mut edges: Vec<Edge>,
) -> Solid {
    let mut corners = Vec::new();
    let mut number = vec![0; cutter.corners.len()];
    for (corner, &p) in cutter.corners.iter().enumerate() {
        if corner >= n_given || cutter.is_kept(corner) {
            number[corner] = corners.len();
            corners.push(p);
        }
    }
    let all = faces.iter_mut().flatten().chain(edges.iter_mut().flat_map(|edge| &mut edge.corners));
    for corner in all {
        *corner = number[*corner];
    }
    Solid { corners, faces, edges }
}

/// Segments between corners joined to rings. What does not close, of a solid that has gaps, is left out.
fn rings_of(segments: &[[usize; 2]], n_corners: usize) -> Vec<Vec<usize>> {
    let mut at = vec![Vec::new(); n_corners];
    for (idx, segment) in segments.iter().enumerate() {
        for &corner in segment {
            at[corner].push(idx);
        }
    }
    let mut is_used = vec![false; segments.len()];
    let mut rings = Vec::new();
    for (idx, &[first, second]) in segments.iter().enumerate() {
        if std::mem::replace(&mut is_used[idx], true) {
            continue;
        }
        let (mut ring, mut corner) = (vec![first], second);
        while corner != first {
            ring.push(corner);
            let Some(&next) = at[corner].iter().find(|&&segment| !is_used[segment]) else {
                ring.clear();
                break;
            };
            is_used[next] = true;
            let [a, b] = segments[next];
            corner = if a == corner { b } else { a };
        }
        if ring.len() > 2 {
            rings.push(ring);
        }
    }
    rings
}
