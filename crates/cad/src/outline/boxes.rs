//! [`BoxTree`]: which of many boxes meet a given one, without asking each.
//!
//! A complete binary tree stored level by level: the children of node i are 2i and 2i + 1, the
//! leaves are the boxes in an order in which neighbours are near each other.

use crate::geometry::{Bounds, Point};

/// Boxes under a tree of boxes.
#[derive(Clone, Debug)]
pub(super) struct BoxTree {
    /// Node 1 is the root, node 0 unused; the second half are the leaves.
    nodes: Vec<Bounds>,
    /// The index of the box of each leaf.
    order: Vec<usize>,
}

impl BoxTree {
    /// Over boxes that already follow one another, as those of a path do.
    pub(super) fn in_order(boxes: &[Bounds]) -> Self {
        Self::ordered(boxes, (0..boxes.len()).collect())
    }

    /// Over boxes that lie anywhere: sorted along a curve that fills the plane (Morton 1966).
    pub(super) fn anywhere(boxes: &[Bounds]) -> Self {
        let all = boxes.iter().copied().fold(Bounds::EMPTY, Bounds::union);
        let key = |i: &usize| morton(boxes[*i].centre(), &all);
        let mut order: Vec<usize> = (0..boxes.len()).collect();
        order.sort_by_cached_key(key);
        Self::ordered(boxes, order)
    }

    fn ordered(boxes: &[Bounds], order: Vec<usize>) -> Self {
        let n = boxes.len().next_power_of_two();
        let mut nodes = vec![Bounds::EMPTY; 2 * n];
        for (leaf, &i) in order.iter().enumerate() {
            nodes[n + leaf] = boxes[i];
        }
        for node in (1..n).rev() {
            nodes[node] = nodes[2 * node].union(nodes[2 * node + 1]);
        }
        Self { nodes, order }
    }

    /// Calls `visit` with the index of every box that meets `query`.
    pub(super) fn meeting(&self, query: &Bounds, mut visit: impl FnMut(usize)) {
        self.descend(
            |bounds| bounds.meets(query),
            |part| {
                if let Part::Leaf(i) = part {
                    visit(i);
                }
            },
        );
    }

    /// Calls `visit` with the index of every box that, grown by `margin`, covers `query`.
    pub(super) fn covering(&self, query: &Bounds, margin: f64, mut visit: impl FnMut(usize)) {
        self.descend(
            |bounds| {
                let grown = bounds.grown(margin);
                grown.contains(query.min) && grown.contains(query.max)
            },
            |part| {
                if let Part::Leaf(i) = part {
                    visit(i);
                }
            },
        );
    }

    /// Meets the boxes in order; where `enter` refuses a box, all in it are passed over at once.
    pub(super) fn descend(&self, enter: impl Fn(&Bounds) -> bool, mut visit: impl FnMut(Part)) {
        let n = self.nodes.len() / 2;
        let mut rest = vec![1];
        while let Some(node) = rest.pop() {
            if self.nodes[node].is_empty() {
                continue;
            }
            if !enter(&self.nodes[node]) {
                // The leaves below: shift the path to the node by the levels that are missing.
                let levels = n.ilog2() - node.ilog2();
                let first = (node << levels) - n;
                let last = (first + (1 << levels)).min(self.order.len()) - 1;
                visit(Part::Passed { first: self.order[first], last: self.order[last] });
            } else if node < n {
                rest.extend([2 * node + 1, 2 * node]);
            } else {
                visit(Part::Leaf(self.order[node - n]));
            }
        }
    }

    /// The least value of `distance` over the boxes, which no box's own distance may exceed.
    pub(super) fn nearest(&self, point: Point, distance: impl Fn(usize) -> f64) -> f64 {
        let n = self.nodes.len() / 2;
        let mut least = f64::INFINITY;
        let mut rest = vec![1];
        while let Some(node) = rest.pop() {
            let bounds = &self.nodes[node];
            if bounds.is_empty() || bounds.distance(point) >= least {
                continue;
            }
            if node >= n {
                least = least.min(distance(self.order[node - n]));
                continue;
            }
            // The nearer child first: it may rule the other one out.
            let mut children = [2 * node, 2 * node + 1];
            let away = children.map(|child| self.nodes[child].distance(point));
            if away[0] < away[1] {
                children.reverse();
            }
            rest.extend(children);
        }
        least
    }
}

/// A box, or a row of boxes, that [`BoxTree::descend`] meets.
pub(super) enum Part {
    /// A box that was entered.
    Leaf(usize),
    /// Boxes that were not, from the first to the last in order.
    Passed {
        /// The first of them.
        first: usize,
        /// The last of them.
        last: usize,
    },
}

/// The bits of both coordinates, 32 of each, one by one in turn.
fn morton(point: Point, all: &Bounds) -> u64 {
    let [x, y] = [0, 1].map(|k| {
        let share = (point[k] - all.min[k]) / (all.max[k] - all.min[k]);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let cell = (share * f64::from(u32::MAX)) as u32;
        spread(u64::from(cell))
    });
    x | (y << 1)
}

/// Puts a zero between any two of the lower 32 bits.
fn spread(mut bits: u64) -> u64 {
    for (shift, mask) in [
        (16, 0x0000_ffff_0000_ffff),
        (8, 0x00ff_00ff_00ff_00ff),
        (4, 0x0f0f_0f0f_0f0f_0f0f),
        (2, 0x3333_3333_3333_3333),
        (1, 0x5555_5555_5555_5555),
    ] {
        bits = (bits | (bits << shift)) & mask;
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::{BoxTree, spread};
    use crate::geometry::Bounds;

    /// Boxes of a fixed pseudo-random cloud.
    fn cloud(n: usize) -> Vec<Bounds> {
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f64 / f64::from(1 << 24)
        };
        let boxes = (0..n).map(|_| {
            let corner = [next(), next()];
            Bounds::of([corner, [corner[0] + 0.1 * next(), corner[1] + 0.1 * next()]])
        });
        boxes.collect()
    }

    #[test]
    fn the_tree_finds_what_asking_each_finds() {
        for n in [0, 1, 2, 3, 100] {
            let boxes = cloud(n);
            let trees = [BoxTree::in_order(&boxes), BoxTree::anywhere(&boxes)];
            for (tree, query) in trees.iter().flat_map(|t| boxes.iter().map(move |q| (t, q))) {
                let mut found = Vec::new();
                tree.meeting(query, |i| found.push(i));
                found.sort_unstable();
                let asked: Vec<usize> = (0..n).filter(|&i| boxes[i].meets(query)).collect();
                assert_eq!(found, asked);

                let point = query.max;
                let distance = |i: usize| boxes[i].distance(point);
                let least = (0..n).map(distance).fold(f64::INFINITY, f64::min);
                assert_eq!(tree.nearest(point, distance), least);
            }
        }
    }

    #[test]
    fn bits_are_spread() {
        assert_eq!(spread(0b1011), 0b100_0101);
        assert_eq!(spread(u64::from(u32::MAX)), 0x5555_5555_5555_5555);
    }
}
