//! [`hatching`]: lines at equal distances over a plane area.

use crate::geometry::{Plane, Point, direction, dot, left};

/// Distance of the lines of a hatching, radii of a pin.
const SPACING: f64 = 0.7;
/// Lines over an area, fewest and most: they are closer or further apart where there would be fewer or more.
const LINES: [f64; 2] = [4.0, 60.0];

/// Direction and distance of the lines of a hatching.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hatching {
    /// Unit vector along the lines.
    along: Point,
    /// Their distance, m.
    spacing: f64,
}

impl Hatching {
    /// The hatching of a body: neighbours differ in direction or distance, as in drawings (ISO 128-3).
    pub(super) fn of_body(body: usize, pin: f64) -> Self {
        let angle = if body.is_multiple_of(2) { 45.0_f64 } else { 135.0 };
        let wide = [1.0, 1.5, 0.75][body / 2 % 3];
        Self { along: direction(angle.to_radians()), spacing: SPACING * wide * pin }
    }
}

/// The lines of a hatching inside rings of a plane, by the even–odd rule. They go through equal points of the plane
/// wherever the rings are.
pub(super) fn hatching(
    rings: &[Vec<[f64; 3]>],
    plane: &Plane,
    &Hatching { along, spacing }: &Hatching,
) -> Vec<[[f64; 3]; 2]> {
    // Points by their place along the lines and across them.
    let across = left(along);
    let flat = |&p: &[f64; 3]| {
        let foot = plane.foot(p);
        [dot(foot, along), dot(foot, across)]
    };
    let rings: Vec<Vec<Point>> = rings.iter().map(|ring| ring.iter().map(flat).collect()).collect();
    let heights = || rings.iter().flatten().map(|&[_, height]| height);
    let (low, high) = heights().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), height| {
        (low.min(height), high.max(height))
    });
    // By a power of two, so that it changes seldom while the area moves.
    let [fewest, most] = LINES.map(|lines| ((high - low) / spacing / lines).log2());
    let spacing = spacing * most.ceil().max(fewest.floor().clamp(-3.0, 0.0)).exp2();
    if !((high - low).is_finite() && spacing > 0.0 && spacing.is_finite()) {
        return Vec::new();
    }

    // Where the lines cross the rings: the number of the line, and the place along it.
    let mut crossings: Vec<(f64, f64)> = Vec::new();
    for ring in &rings {
        for (&[x, y], &[next_x, next_y]) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            let [first, end] = [y.min(next_y), y.max(next_y)].map(|y| (y / spacing).ceil());
            let mut line = first;
            while line < end {
                let part = (line * spacing - y) / (next_y - y);
                crossings.push((line, x + part * (next_x - x)));
                line += 1.0;
            }
        }
    }
    crossings.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let raised = |(line, x): (f64, f64)| {
        let y = line * spacing;
        plane.lift([x * along[0] + y * across[0], x * along[1] + y * across[1]])
    };
    crossings.chunks_exact(2).map(|pair| [raised(pair[0]), raised(pair[1])]).collect()
}
