//! The region of the plane that a body sweeps over a whole motion.
//!
//! It is that of the body in one pose, and all that its edges pass: between two poses an edge passes a quadrilateral, or where
//! it crosses itself two triangles with the crossing as a corner.

use bksim_expr::Expr;
use bksim_model::{Anchor, BodyId, PointId};

use crate::centrodes::BodyRates;
use crate::curve::Curve;
use crate::double_points::cross;
use crate::path::Path;
use crate::positions::Positions;
use crate::region::{doubled_area, hull, union};
use crate::trace::Trace;

/// The region that a body sweeps.
#[derive(Clone, PartialEq, Debug)]
pub struct Swept {
    /// The body.
    pub body: String,
    /// Number of the branch, from one.
    pub branch: usize,
    /// The boundary: closed polygons, holes among them, m.
    pub rings: Vec<Vec<[f64; 2]>>,
    /// Area, m².
    pub area: f64,
}

/// The region that a body sweeps along a trace.
pub(crate) fn swept(
    (positions, rates): (&Positions, &mut BodyRates),
    curve: &Curve<Path<'_>>,
    (branch, trace): (usize, &Trace),
    body: BodyId,
) -> Swept {
    let shape = shape(positions, body);
    let edges: Vec<[[f64; 2]; 2]> = shape.iter().flat_map(|ring| edges(ring)).collect();
    let mut polygons: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut last: Vec<[[f64; 2]; 2]> = Vec::new();
    for (k, point) in trace.points.iter().enumerate() {
        let pose = rates.pose(curve, point, body);
        if k == 0 {
            polygons.extend(shape.iter().map(|ring| ring.iter().map(|p| pose(*p)).collect()));
        }
        let now: Vec<[[f64; 2]; 2]> = edges.iter().map(|ends| ends.map(&pose)).collect();
        let pairs = last.iter().zip(&now);
        polygons.extend(pairs.flat_map(|(a, b)| passed(*a, *b)));
        last = now;
    }
    polygons.retain(|polygon| polygon.len() > 2);
    let rings = union(&polygons);
    // Holes run the other way round.
    let area = rings.iter().map(|ring| 0.5 * doubled_area(ring)).sum::<f64>().abs();
    Swept { body: positions.model().bodies[body.0].name.clone(), branch, rings, area }
}

/// Polygons that an edge passes on its way from one place to another one nearby.
fn passed([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> Vec<Vec<[f64; 2]>> {
    let (u, v) = ([b[0] - a[0], b[1] - a[1]], [d[0] - c[0], d[1] - c[1]]);
    let across = u[0] * v[1] - u[1] * v[0];
    if cross([a, b], [c, d]) && across != 0.0 {
        let share = ((c[0] - a[0]) * v[1] - (c[1] - a[1]) * v[0]) / across;
        let at = [a[0] + share * u[0], a[1] + share * u[1]];
        return vec![vec![a, c, at], vec![b, d, at]];
    }
    // Ways of the two ends that cross make no ring.
    vec![if cross([a, c], [b, d]) { hull(&[a, b, c, d]) } else { vec![a, c, d, b] }]
}

/// The sides of a ring; a ring of two points has one.
fn edges(ring: &[[f64; 2]]) -> Vec<[[f64; 2]; 2]> {
    let n = if ring.len() == 2 { 1 } else { ring.len() };
    (0..n).map(|i| [ring[i], ring[(i + 1) % ring.len()]]).collect()
}

/// The outlines of a body in its frame, or else the smallest convex polygon around its joints and points.
fn shape(positions: &Positions, body: BodyId) -> Vec<Vec<[f64; 2]>> {
    let model = positions.model();
    let own = &model.bodies[body.0];
    let value = |e: Expr| positions.constant(e);
    if !own.outline.is_empty() {
        let ring = |ring: &Vec<[Expr; 2]>| ring.iter().map(|p| p.map(value)).collect();
        return own.outline.iter().map(ring).collect();
    }
    let place = |at: Anchor| {
        at.point.map_or([0.0; 2], |PointId(idx)| {
            let [x, y, _] = own.points[idx].position;
            [value(x), value(y)]
        })
    };
    let ends = model.joints.iter().flat_map(|joint| [joint.predecessor, joint.successor]);
    let joined = ends.filter(|end| end.body == body);
    let named = (0..own.points.len()).map(|idx| Anchor { body, point: Some(PointId(idx)) });
    vec![hull(&joined.chain(named).map(place).collect::<Vec<_>>())]
}
