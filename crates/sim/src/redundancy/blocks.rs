//! Blocks of the joint graph: joints whose loops share joints.

use std::collections::VecDeque;

/// A body, its joint to its parent, and how deep it lies; ground and other roots have none.
#[derive(Clone, Copy, Default)]
struct Place {
    up: Option<(usize, usize)>,
    depth: usize,
}

/// The block of each joint, by the smallest joint in it. `ends` are the two bodies of each joint.
///
/// Each joint outside a spanning forest is united with those of the loop that it closes.
pub(super) fn blocks(n_bodies: usize, ends: &[[usize; 2]]) -> Vec<usize> {
    let mut incident = vec![Vec::new(); n_bodies];
    for (joint, &[a, b]) in ends.iter().enumerate() {
        incident[a].push(joint);
        incident[b].push(joint);
    }

    // A spanning forest, breadth first.
    let mut places = vec![Place::default(); n_bodies];
    let mut is_reached = vec![false; n_bodies];
    let mut is_in_forest = vec![false; ends.len()];
    let mut frontier = VecDeque::new();
    for root in 0..n_bodies {
        if is_reached[root] {
            continue;
        }
        is_reached[root] = true;
        frontier.push_back(root);
        while let Some(body) = frontier.pop_front() {
            for &joint in &incident[body] {
                let [a, b] = ends[joint];
                let far = if a == body { b } else { a };
                if !is_reached[far] {
                    is_reached[far] = true;
                    is_in_forest[joint] = true;
                    places[far] = Place { up: Some((joint, body)), depth: places[body].depth + 1 };
                    frontier.push_back(far);
                }
            }
        }
    }

    // Every other joint closes a loop: up from both ends to where they meet.
    let mut united = Union((0..ends.len()).collect());
    for (joint, &[mut a, mut b]) in ends.iter().enumerate().filter(|(j, _)| !is_in_forest[*j]) {
        while a != b {
            let deeper = if places[a].depth >= places[b].depth { &mut a } else { &mut b };
            let Some((passed, parent)) = places[*deeper].up else { break };
            united.unite(joint, passed);
            *deeper = parent;
        }
    }
    (0..ends.len()).map(|joint| united.find(joint)).collect()
}

/// Disjoint sets of joints; each is named by its smallest joint.
struct Union(Vec<usize>);

impl Union {
    fn find(&mut self, mut joint: usize) -> usize {
        while self.0[joint] != joint {
            // Halving the path keeps later ones short.
            self.0[joint] = self.0[self.0[joint]];
            joint = self.0[joint];
        }
        joint
    }

    fn unite(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b)] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_that_share_a_body_alone_are_blocks_of_their_own() {
        // Two triangles that meet in body 2, a bar between two bodies twice, and a tail.
        let ends = [[0, 1], [1, 2], [2, 0], [2, 3], [3, 4], [4, 2], [4, 5], [5, 4], [5, 6], [7, 8]];
        assert_eq!(blocks(9, &ends), [0, 0, 0, 3, 3, 3, 6, 6, 8, 9]);
    }

    #[test]
    fn loops_that_share_a_joint_are_one_block() {
        // A ladder of three rungs.
        let ends = [[0, 1], [2, 3], [0, 2], [1, 3], [2, 4], [3, 5], [4, 5]];
        assert_eq!(blocks(6, &ends), [0; 7]);
    }
}
