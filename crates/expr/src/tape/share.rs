//! Common pairs of terms and of factors are computed once.
//!
//! Sums and products come as chains of operands, and which two operands are combined first is
//! free. The pair that occurs in most chains is taken out and becomes an operand itself, again and
//! again until no pair occurs twice: greedy, as M. A. Breuer, *Generation of optimal code for
//! expressions via factorization*, Commun. ACM 12 (1969). Operands that depend on parameters only
//! are combined beforehand and count as one, for they cost nothing at evaluation.

use std::collections::{BinaryHeap, HashMap};

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
    while let Some(pair) = uses.most_frequent() {
        let id = first_id + super::register::index(pairs.len());
        pairs.push(pair);
        for chain_idx in uses.take(pair) {
            replace(&mut chains[chain_idx as usize], chain_idx, pair, id, &mut uses);
        }
    }
    pairs
}

/// Replaces a pair of one chain by the operand `id`, and keeps the uses true.
fn replace(chain: &mut Vec<Operand>, chain_idx: u32, pair: Pair, id: u32, uses: &mut Uses) {
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
        uses.remove(pair_of(x, other).0, chain_idx);
        uses.remove(pair_of(y, other).0, chain_idx);
        uses.add(pair_of(shared, other).0, chain_idx);
    }
    chain.push(shared);
}

/// In which chains each pair occurs.
struct Uses {
    chains: HashMap<Pair, Vec<u32>>,
    /// Candidates with the number of uses they had when entered; stale ones are passed over.
    queue: BinaryHeap<(usize, std::cmp::Reverse<Pair>)>,
}

impl Uses {
    fn of(chains: &[Vec<Operand>]) -> Self {
        let mut uses = Self { chains: HashMap::new(), queue: BinaryHeap::new() };
        let mut n_left = MAX_PAIRS;
        for (chain_idx, chain) in (0u32..).zip(chains) {
            let n_pairs = chain.len() * chain.len().saturating_sub(1) / 2;
            if chain.len() > MAX_OPERANDS || n_pairs > n_left {
                continue;
            }
            n_left -= n_pairs;
            for (i, &x) in chain.iter().enumerate() {
                for &y in &chain[..i] {
                    uses.chains.entry(pair_of(x, y).0).or_default().push(chain_idx);
                }
            }
        }
        let frequent = uses.chains.iter().filter(|(_, chains)| chains.len() > 1);
        uses.queue = frequent.map(|(&pair, c)| (c.len(), std::cmp::Reverse(pair))).collect();
        uses
    }

    fn add(&mut self, pair: Pair, chain_idx: u32) {
        let chains = self.chains.entry(pair).or_default();
        chains.push(chain_idx);
        if chains.len() > 1 {
            self.queue.push((chains.len(), std::cmp::Reverse(pair)));
        }
    }

    fn remove(&mut self, pair: Pair, chain_idx: u32) {
        if let Some(chains) = self.chains.get_mut(&pair) {
            chains.retain(|&other| other != chain_idx);
        }
    }

    /// The pair in most chains, if any is in two.
    fn most_frequent(&mut self) -> Option<Pair> {
        while let Some((n_uses, std::cmp::Reverse(pair))) = self.queue.pop() {
            let now = self.chains.get(&pair).map_or(0, Vec::len);
            if now == n_uses {
                return Some(pair);
            }
            if now > 1 && now < n_uses {
                self.queue.push((now, std::cmp::Reverse(pair)));
            }
        }
        None
    }

    /// The chains that hold `pair`, ascending; it is not offered again.
    fn take(&mut self, pair: Pair) -> Vec<u32> {
        let mut chains = self.chains.remove(&pair).expect("the pair was found in chains");
        chains.sort_unstable();
        chains
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
