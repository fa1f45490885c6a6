//! Loops that gaps leave open: outlines that would close under a larger tolerance.

use super::outlines::WIDEST_GAP;
use crate::geometry::signed_area;
use crate::geometry::vector::distance;
use crate::geometry::{Bounds, Point};
use crate::outline::{Chain, Snap, Stroke, chain_apart};

/// Gaps that are tried; what has more open ends than twice this is no drawing with a slip.
const MOST_GAPS: usize = 200;

/// A loop with the gaps that leave it open.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct NearLoop {
    /// Closed, with lines over the gaps; its entities are those of the drawing.
    pub(super) chain: Chain,
    /// The gaps.
    pub(super) gaps: Vec<Snap>,
}

/// The loops that open chains make where gaps are closed, the smallest first.
pub(super) fn loops(open: &[Chain], tolerance: f64) -> Vec<NearLoop> {
    let strokes: Vec<Stroke> = open
        .iter()
        .enumerate()
        .map(|(idx, chain)| Stroke { path: chain.path.clone(), entity: idx })
        .collect();
    let mut found: Vec<NearLoop> = Vec::new();
    for width in widths(&strokes, tolerance) {
        let chains = chain_apart(&strokes, width * (1.0 + 1e-9)).chains;
        for chain in chains.closed {
            let is_known = |near: &NearLoop| near.chain.entities == chain.entities;
            if found.iter().any(is_known) {
                continue;
            }
            let is_own = |gap: &&Snap| gap.entities.iter().all(|idx| chain.entities.contains(idx));
            let gaps: Vec<Snap> = chains.snaps.iter().filter(is_own).copied().collect();
            let widest = gaps.iter().map(|gap| gap.distance).fold(0.0, f64::max);
            if widest > tolerance && widest <= WIDEST_GAP * chain.path.bounds().diagonal() {
                found.push(NearLoop { chain, gaps });
            }
        }
    }
    // From the numbers of the chains to the entities at their ends.
    let entity = |idx: usize, at: Point| {
        let [start, end] = [open[idx].path.start_point(), open[idx].path.end_point()]
            .map(|end| end.map_or(f64::INFINITY, |end| distance(end, at)));
        let entities = &open[idx].entities;
        *if start < end { entities.first() } else { entities.last() }.expect("a chain has entities")
    };
    for near in &mut found {
        for gap in &mut near.gaps {
            gap.entities = [entity(gap.entities[0], gap.from), entity(gap.entities[1], gap.to)];
        }
        let entities =
            near.chain.entities.iter().flat_map(|&idx| open[idx].entities.iter().copied());
        near.chain.entities = entities.collect();
    }
    found.sort_by(|a, b| {
        signed_area(&a.chain.path).abs().total_cmp(&signed_area(&b.chain.path).abs())
    });
    found
}

/// The distances of each open end to its nearest other one, in ascending order.
fn widths(strokes: &[Stroke], tolerance: f64) -> Vec<f64> {
    let ends = |stroke: &Stroke| [stroke.path.start_point(), stroke.path.end_point()];
    let ends: Vec<Point> = strokes.iter().flat_map(ends).flatten().collect();
    if ends.len() > 2 * MOST_GAPS {
        return Vec::new();
    }
    let nearest = |(idx, at): (usize, &Point)| {
        let others = ends.iter().enumerate().filter(|(other, _)| *other != idx);
        others.map(|(_, other)| distance(*other, *at)).fold(f64::INFINITY, f64::min)
    };
    // No loop is wider than all of the strokes, and no gap wider than its part of that.
    let all = strokes.iter().map(|stroke| stroke.path.bounds()).fold(Bounds::EMPTY, Bounds::union);
    let widest = WIDEST_GAP * (all.diagonal() + 2.0 * tolerance);
    let mut widths: Vec<f64> = ends.iter().enumerate().map(nearest).collect();
    widths.retain(|width| *width > tolerance && *width <= widest);
    widths.sort_by(f64::total_cmp);
    widths.dedup();
    widths
}
