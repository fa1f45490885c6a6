//! [`n_inverse_pairs`]: how many points of one linear space are inverse, component by component, to one of another.
//!
//! ```text
//! x ∈ V,  y ∈ W,  xₑ yₑ = λₑ for all e,  up to a factor of x and one of y;  dim V + dim W = |E| + 1
//!
//! N(E) = N(E∖ē; V/ē, W) + N(E∖ē; V, W/ē) + Σ N(E∖M; V/M, W) N(E∖N; V, W/N)
//!        over M ∪ N = E, M ∩ N = {ē}, |M|, |N| ≥ 2
//! ```
//!
//! V/M are the points of V with xₑ = 0 for e in M, without these components; elsewhere components are left out. N is 1 for one
//! element, 0 where a component vanishes on a whole space or dimensions do not fit. It is the number for λ outside of a set
//! of measure zero, and so a bound of the isolated points for every λ. Only ranks of V and W enter.
//!
//! Source: J. Capco, M. Gallet, G. Grasegger, C. Koutschan, N. Lubbes and J. Schicho, *The number of realizations of a Laman graph*,
//! SIAM J. Appl. Algebra Geom. 2 (2018) 94, theorem 4.15, where V and W belong to a graph; its argument is by valuations of x and y and uses
//! linear spaces alone.

use std::collections::BTreeMap;

/// Largest number of elements.
const MOST: usize = 14;

/// The number N for spaces on `n` elements; `rank(set)` is the rank of the components in a set of both, bit by bit.
/// None for more than 14 elements.
pub fn n_inverse_pairs(n: usize, rank: impl Fn(u32) -> u32) -> Option<u64> {
    if n == 0 || n > MOST {
        return None;
    }
    let rank = (0..1_u32 << n).map(rank).collect();
    let mut counting = Counting { rank, known: BTreeMap::new() };
    Some(counting.number((1 << n) - 1, 0, 0))
}

struct Counting {
    rank: Vec<u32>,
    known: BTreeMap<[u32; 3], u64>,
}

impl Counting {
    /// Rank of a set where the components in `zero` vanish.
    fn rank(&self, set: u32, zero: u32) -> u32 {
        self.rank[(set | zero) as usize] - self.rank[zero as usize]
    }

    /// N of elements `e`, where components in `v` of x and in `w` of y vanish.
    fn number(&mut self, e: u32, v: u32, w: u32) -> u64 {
        let n = e.count_ones();
        if n == 0 || self.rank(e, v) + self.rank(e, w) != n + 1 {
            return 0;
        }
        let vanishes = |k: u32| self.rank(1 << k, v) == 0 || self.rank(1 << k, w) == 0;
        if (0..32).filter(|k| e >> k & 1 == 1).any(vanishes) {
            return 0;
        }
        if n == 1 {
            return 1;
        }
        if let Some(&known) = self.known.get(&[e, v, w]) {
            return known;
        }
        let own = 1 << e.trailing_zeros();
        let rest = e ^ own;
        let mut sum = self.number(rest, v | own, w) + self.number(rest, v, w | own);
        // Proper parts of the rest, in turn.
        let mut part = (rest - 1) & rest;
        while part > 0 {
            let first = self.number(rest ^ part, v | part | own, w);
            if first > 0 {
                sum += first * self.number(part, v, w | (rest ^ part) | own);
            }
            part = (part - 1) & rest;
        }
        self.known.insert([e, v, w], sum);
        sum
    }
}
