//! How large symbols are: a share of the mechanism's own lengths.

use super::attachments;
use super::numbers::Numbers;
use crate::geometry::{Point, distance_from_edges};

/// Radius of a pin against the length of a link.
const PIN: f64 = 0.03;

/// Measures of all symbols.
pub(super) struct Sizes {
    /// Length of a typical link, m.
    pub(super) length: f64,
    /// Radius of a pin, m.
    pub(super) pin: f64,
}

impl Sizes {
    /// From the points that something is attached to, by body, the ground first.
    pub(super) fn of(numbers: &Numbers, attached: &[Vec<[f64; 3]>]) -> Self {
        let length = typical_length(numbers, attached);
        // A pin leaves something of the outline around it.
        let room = median(edge_distances(numbers).into_iter().filter(|&d| is_length(&d)));
        let pin = (PIN * length).min(room.map_or(f64::INFINITY, |room| 0.6 * room));
        Self { length, pin }
    }
}

fn is_length(length: &f64) -> bool {
    // So that products of lengths are numbers.
    (1e-100..1e100).contains(length)
}

/// Median of the lengths of links; without links, of whatever has a length.
fn typical_length(numbers: &Numbers, attached: &[Vec<[f64; 3]>]) -> f64 {
    let bodies = &numbers.model.bodies;
    let links = attached.iter().skip(1).map(|points| extent(points));
    let arms = attached.iter().zip(bodies).skip(1).flat_map(|(points, body)| {
        let com = numbers.vector(&body.com);
        points.iter().map(move |&p| extent(&[p, com])).collect::<Vec<_>>()
    });
    let outlines = bodies.iter().map(|body| {
        let points = body.outline.iter().flatten();
        extent(&points.map(|p| [numbers.value(p[0]), numbers.value(p[1]), 0.0]).collect::<Vec<_>>())
    });
    let named = bodies.iter().map(|body| {
        extent(&body.points.iter().map(|p| numbers.vector(&p.position)).collect::<Vec<_>>())
    });
    let median_of = |lengths: &mut dyn Iterator<Item = f64>| median(lengths.filter(is_length));
    median_of(&mut links.into_iter())
        .or_else(|| median_of(&mut arms.into_iter()))
        .or_else(|| median_of(&mut outlines.into_iter()))
        .or_else(|| median_of(&mut named.into_iter()))
        .or_else(|| median_of(&mut numbers.stated_lengths()))
        .unwrap_or(1.0)
}

/// Distances of the joints in outlined bodies from their outlines.
fn edge_distances(numbers: &Numbers) -> Vec<f64> {
    let mut distances = Vec::new();
    for at in attachments(numbers) {
        let rings = numbers.outline(at.body);
        let p = [at.position[0], at.position[1]];
        let nearest = rings.iter().map(|ring: &Vec<Point>| distance_from_edges(p, ring));
        distances.extend(nearest.reduce(f64::min));
    }
    distances
}

/// The diagonal of the box around some points.
fn extent(points: &[[f64; 3]]) -> f64 {
    let side = |i: usize| {
        let values = points.iter().map(|p| p[i]);
        super::numbers::range(values).map_or(0.0, |[low, high]| high - low)
    };
    side(0).hypot(side(1)).hypot(side(2))
}

/// The middle value, or the mean of the two in the middle.
fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    let [low, high] = [n.checked_sub(1)? / 2, n / 2].map(|i| sorted[i]);
    Some(0.5 * low + 0.5 * high)
}
