//! [`Cutter`]: plane areas cut by a plane.

use std::collections::HashMap;

use super::HalfSpace;
use crate::geometry::{along3, cross3, dot3, sub3};

/// Corners within this part of the largest height count as on the plane.
const ON_PLANE: f64 = 1e-9;

/// Corners of areas, those on the plane after those that were given.
pub(super) struct Cutter {
    normal: [f64; 3],
    /// All corners, m.
    pub(super) corners: Vec<[f64; 3]>,
    /// Heights above the plane of the corners that were given, m.
    heights: Vec<f64>,
    /// The corner on the plane between two others, the smaller index first.
    crossings: HashMap<[usize; 2], usize>,
}

/// The part of an area that is kept.
#[derive(Debug, Default)]
pub(super) struct Area {
    /// Rings of the area, by corners.
    pub(super) rings: Vec<Vec<usize>>,
    /// Edges on the plane, each with the index of its ring.
    pub(super) cuts: Vec<([usize; 2], usize)>,
}

/// An end of a kept chain of corners.
#[derive(Clone, Copy)]
struct End {
    chain: usize,
    is_tail: bool,
}

impl Cutter {
    pub(super) fn new(half: &HalfSpace, corners: Vec<[f64; 3]>) -> Self {
        let mut heights: Vec<f64> = corners.iter().map(|&p| half.height(p)).collect();
        let largest = heights.iter().fold(0.0, |most: f64, height| most.max(height.abs()));
        for height in heights.iter_mut().filter(|height| height.abs() <= ON_PLANE * largest) {
            *height = 0.0;
        }
        Self { normal: half.normal, corners, heights, crossings: HashMap::new() }
    }

    /// True where corners are left out; and where some are further below the plane than `slack`, m.
    pub(super) fn sides(&self, slack: f64) -> [bool; 2] {
        let is_any = |is: &dyn Fn(f64) -> bool| self.heights.iter().any(|&height| is(height));
        [is_any(&|height| height > 0.0 || height.is_nan()), is_any(&|height| height < -slack)]
    }

    /// True of a corner that was given and is kept.
    pub(super) fn is_kept(&self, corner: usize) -> bool {
        self.heights[corner] <= 0.0
    }

    /// The corner on the plane between two corners on different sides of it: the same one each time.
    pub(super) fn crossing(&mut self, a: usize, b: usize) -> usize {
        let [a, b] = [a.min(b), a.max(b)];
        *self.crossings.entry([a, b]).or_insert_with(|| {
            let part = self.heights[a] / (self.heights[a] - self.heights[b]);
            let between = sub3(self.corners[b], self.corners[a]);
            self.corners.push(along3(self.corners[a], part, between));
            self.corners.len() - 1
        })
    }

    /// The part of an area with this normal that is kept. The area is bounded by rings of corners: it is where a
    /// line to the outside crosses an odd number of them. So along the plane it lies between the first and the
    /// second place where rings pass the plane, between the third and the fourth, and so on.
    pub(super) fn area(&mut self, rings: &[Vec<usize>], normal: [f64; 3]) -> Area {
        let mut kept = Area::default();
        let mut chains: Vec<Vec<usize>> = Vec::new();
        for ring in rings {
            if ring.iter().all(|&corner| self.is_kept(corner)) {
                kept.rings.push(ring.clone());
            } else {
                self.add_chains(ring, &mut chains);
            }
        }

        // The ends of chains in their order along the plane; neighbours are joined.
        let along = cross3(normal, self.normal);
        let ends =
            (0..chains.len()).flat_map(|chain| [false, true].map(|is_tail| End { chain, is_tail }));
        let place = |end: &End| dot3(along, self.corners[corner_at(&chains, *end)]);
        let mut ends: Vec<(f64, End)> = ends.map(|end| (place(&end), end)).collect();
        ends.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let mut joined = vec![[End { chain: 0, is_tail: false }; 2]; chains.len()];
        for pair in ends.chunks_exact(2) {
            let [one, other] = [pair[0].1, pair[1].1];
            joined[one.chain][usize::from(one.is_tail)] = other;
            joined[other.chain][usize::from(other.is_tail)] = one;
        }

        // Chains and joints between them close to rings.
        let mut is_used = vec![false; chains.len()];
        for first in 0..chains.len() {
            let mut ring = Vec::new();
            let (mut chain, mut is_backwards) = (first, false);
            while !is_used[chain] {
                is_used[chain] = true;
                let corners = chains[chain].iter().copied();
                if is_backwards {
                    ring.extend(corners.rev());
                } else {
                    ring.extend(corners);
                }
                let end = End { chain, is_tail: !is_backwards };
                let next = joined[chain][usize::from(end.is_tail)];
                let cut = [end, next].map(|end| corner_at(&chains, end));
                kept.cuts.push((cut, kept.rings.len()));
                (chain, is_backwards) = (next.chain, next.is_tail);
            }
            if !ring.is_empty() {
                kept.rings.push(ring);
            }
        }
        kept
    }

    /// Adds the chains of a ring that are kept, each from the plane to the plane.
    fn add_chains(&mut self, ring: &[usize], chains: &mut Vec<Vec<usize>>) {
        // The ring begins after a corner that is left out.
        let n = ring.len();
        let Some(out) = ring.iter().position(|&corner| !self.is_kept(corner)) else { return };
        let corner = |i: usize| ring[(out + i) % n];
        let mut chain = Vec::new();
        for i in 1..=n {
            let [before, now] = [corner(i - 1), corner(i)];
            match [before, now].map(|corner| self.is_kept(corner)) {
                [false, true] => chain = vec![self.crossing(before, now), now],
                [true, true] => chain.push(now),
                [true, false] => {
                    chain.push(self.crossing(before, now));
                    chains.push(std::mem::take(&mut chain));
                }
                [false, false] => (),
            }
        }
    }
}

/// The corner at an end of a chain.
fn corner_at(chains: &[Vec<usize>], End { chain, is_tail }: End) -> usize {
    let chain = &chains[chain];
    if is_tail { chain[chain.len() - 1] } else { chain[0] }
}
