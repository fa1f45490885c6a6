//! [`SymbolSizes`]: symbols in proportion to the mechanism's own lengths.

use super::numbers::Numbers;
use super::solids::forms;
use crate::Form;

/// Radius of a pin against the length of a link.
const PIN: f64 = 0.03;

/// Lengths that the sizes of all symbols follow from.
pub(super) struct SymbolSizes {
    /// Length of a typical link, m.
    pub(super) length: f64,
    /// Radius of a pin, m.
    pub(super) pin: f64,
}

impl SymbolSizes {
    /// The sizes for a model with `attached` points of joints and loads, by body, the ground first.
    pub(super) fn of(numbers: &Numbers, attached: &[Vec<[f64; 3]>]) -> Self {
        let length = typical_length(numbers, attached);
        // In an outline, a pin takes a part of the space around it.
        let edges = edge_distances(numbers).into_iter();
        let pin = match median(edges.filter(|&d| d > 0.2 * PIN * length)) {
            Some(edge) => (PIN * length).max((0.35 * edge).min(2.0 * PIN * length)).min(0.6 * edge),
            None => PIN * length,
        };
        Self { length, pin }
    }
}

/// True if a length is positive, and products of such lengths are finite.
fn is_length(length: f64) -> bool {
    (1e-100..1e100).contains(&length)
}

/// Median of the lengths of links; without links, of the next quantity of the model with a length.
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
    let solids = (0..bodies.len())
        .map(|body| extent(&forms(numbers, body).iter().flat_map(Form::reach).collect::<Vec<_>>()));
    let named = bodies.iter().map(|body| {
        extent(&body.points.iter().map(|p| numbers.vector(&p.position)).collect::<Vec<_>>())
    });
    let median_of = |lengths: &mut dyn Iterator<Item = f64>| {
        median(lengths.filter(|&length| is_length(length)))
    };
    median_of(&mut links.into_iter())
        .or_else(|| median_of(&mut arms.into_iter()))
        .or_else(|| median_of(&mut outlines.into_iter()))
        .or_else(|| median_of(&mut solids.into_iter()))
        .or_else(|| median_of(&mut named.into_iter()))
        .or_else(|| median_of(&mut numbers.stated_lengths()))
        .unwrap_or(1.0)
}

/// Distances of the pins in outlined bodies from their outlines.
fn edge_distances(numbers: &Numbers) -> Vec<f64> {
    let joints = numbers.model.joints.iter();
    let pinned = joints.filter(|joint| joint.kind.is_pin());
    let ends = pinned.flat_map(|joint| [joint.predecessor, joint.successor]);
    ends.filter_map(|anchor| numbers.edge_distance(numbers.attached(anchor))).collect()
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
