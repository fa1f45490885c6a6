//! Common pairs of terms and of factors are computed once.
//!
//! Sums and products come as chains of operands, and which two operands are combined first is
//! free. The pair that occurs in most chains is taken out and becomes an operand itself, again and
//! again until no pair occurs twice: greedy, as M. A. Breuer, *Generation of optimal code for
//! expressions via factorization*, Commun. ACM 12 (1969). Operands that depend on parameters only
//! are combined beforehand and count as one, for they cost nothing at evaluation.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use crate::handle::HandleHash;

/// One operand of a chain. In a sum, a negated one is subtracted.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(super) struct Operand {
    pub(super) id: u32,
    pub(super) is_negated: bool,
}

/// `a + b`, `a − b` or `a · b`.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(super) struct Pair {
    pub(super) a: u32,
    pub(super) b: u32,
    pub(super) is_difference: bool,
}

/// Operands above which a chain stays as it is: the number of its pairs grows with the square.
const MAX_OPERANDS: usize = 64;
/// Pairs that are looked at; chains beyond them stay as they are.
const MAX_PAIRS: usize = 1 << 20;

/// The pair of two operands, and whether the chain holds it negated.
fn pair_of(x: Operand, y: Operand) -> (Pair, bool) {
    let (first, second) = if x.id <= y.id { (x, y) } else { (y, x) };
    let is_difference = first.is_negated != second.is_negated;
    (Pair { a: first.id, b: second.id, is_difference }, first.is_negated)
}

/// Takes common pairs out of `chains`; the ids of new operands count up from `first_id`, one for
/// each pair returned.
pub(super) fn share(chains: &mut [Vec<Operand>], first_id: u32) -> Vec<Pair> {
    let mut uses = Uses::of(chains);
    let mut pairs = Vec::new();
    let mut new = Vec::new();
    while let Some((pair, holders)) = uses.take_most_frequent() {
        let id = first_id + super::register::index(pairs.len());
        pairs.push(pair);
        for chain_idx in holders {
            replace(&mut chains[chain_idx as usize], chain_idx, (pair, id), &mut uses, &mut new);
        }
        uses.enter(&mut new);
    }
    pairs
}

/// Replaces a pair of one chain by the operand `id`: its other pairs lose a use, those with `id` join `new`.
fn replace(
    chain: &mut Vec<Operand>,
    chain_idx: u32,
    (pair, id): (Pair, u32),
    uses: &mut Uses,
    new: &mut Vec<(Pair, u32)>,
) {
    let position = |chain: &[Operand], id| chain.iter().position(|operand| operand.id == id);
    let (Some(a), Some(b)) = (position(chain, pair.a), position(chain, pair.b)) else { return };
    let (x, y) = (chain[a], chain[b]);
    let (found, is_negated) = pair_of(x, y);
    if a == b || found != pair {
        return;
    }
    chain.retain(|&operand| operand != x && operand != y);
    let shared = Operand { id, is_negated };
    for &other in chain.iter() {
        uses.remove(pair_of(x, other).0);
        uses.remove(pair_of(y, other).0);
        new.push((pair_of(shared, other).0, chain_idx));
    }
    chain.push(shared);
}

/// The chains that hold a pair.
struct Holders {
    /// Number of chains that hold it now.
    n_uses: usize,
    /// The chains that held it when it was entered, ascending.
    chains: Vec<u32>,
}

/// In which chains each pair occurs that is in more than one. Pairs are entered when all their chains are known:
/// those of old operands only ever lose uses, so that one which is in a single chain need not be kept.
struct Uses {
    pairs: HashMap<Pair, Holders, HandleHash>,
    /// Candidates with the number of uses they had when entered; stale ones are passed over.
    queue: BinaryHeap<(usize, Reverse<Pair>)>,
}

impl Uses {
    fn of(chains: &[Vec<Operand>]) -> Self {
        let mut n_left = MAX_PAIRS;
        let mut found = Vec::new();
        for (chain_idx, chain) in (0u32..).zip(chains) {
            let n_pairs = chain.len() * chain.len().saturating_sub(1) / 2;
            if chain.len() > MAX_OPERANDS || n_pairs > n_left {
                continue;
            }
            n_left -= n_pairs;
            for (i, &x) in chain.iter().enumerate() {
                found.extend(chain[..i].iter().map(|&y| (pair_of(x, y).0, chain_idx)));
            }
        }
        let mut uses = Self { pairs: HashMap::default(), queue: BinaryHeap::new() };
        uses.enter(&mut found);
        uses
    }

    /// Enters new pairs with the chains that hold them, and empties the list.
    fn enter(&mut self, found: &mut Vec<(Pair, u32)>) {
        found.sort_unstable();
        for same in found.chunk_by(|a, b| a.0 == b.0) {
            if let [(pair, _), _, ..] = *same {
                let chains: Vec<u32> = same.iter().map(|&(_, chain_idx)| chain_idx).collect();
                self.queue.push((chains.len(), Reverse(pair)));
                self.pairs.insert(pair, Holders { n_uses: chains.len(), chains });
            }
        }
        found.clear();
    }

    /// Takes note that a chain no longer holds `pair`.
    fn remove(&mut self, pair: Pair) {
        if let Some(holders) = self.pairs.get_mut(&pair) {
            holders.n_uses = holders.n_uses.saturating_sub(1);
        }
    }

    /// The pair in most chains, if any is in two, with all that held it; it is not offered again.
    fn take_most_frequent(&mut self) -> Option<(Pair, Vec<u32>)> {
        while let Some((n_uses, Reverse(pair))) = self.queue.pop() {
            let now = self.pairs.get(&pair).map_or(0, |holders| holders.n_uses);
            if now == n_uses {
                return self.pairs.remove(&pair).map(|holders| (pair, holders.chains));
            }
            if now > 1 {
                self.queue.push((now, Reverse(pair)));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(ids: &[i32]) -> Vec<Operand> {
        ids.iter().map(|&i| Operand { id: i.unsigned_abs(), is_negated: i < 0 }).collect()
    }

    #[test]
    fn the_pair_in_most_chains_goes_first() {
        // 1 + 2 + 3, 1 + 2 + 4, −1 − 2 + 3, 1 − 2
        let mut chains = [&[1, 2, 3][..], &[1, 2, 4], &[-1, -2, 3], &[1, -2]].map(chain);
        let pairs = share(&mut chains, 10);
        assert_eq!(pairs, [Pair { a: 1, b: 2, is_difference: false }]);
        assert_eq!(chains, [&[3, 10][..], &[4, 10], &[3, -10], &[1, -2]].map(chain));
    }

    #[test]
    fn shared_pairs_are_shared_again() {
        let mut chains = [&[1, 2, 3, 4][..], &[1, 2, 3, 5], &[1, 2, 3, 6]].map(chain);
        let pairs = share(&mut chains, 10);
        assert_eq!(pairs.len(), 2, "three common terms are two pairs: {pairs:?}");
        assert!(chains.iter().all(|chain| chain.len() == 2), "{chains:?}");
    }
}
