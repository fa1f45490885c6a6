//! The symbols that the value of each step changes with, as sets of bits.
//!
//! A set holds only the words that have a bit: most parts of a large system depend on a few columns
//! out of very many.

use super::rules::is_piecewise_constant;
use crate::op::{Function, Op};
use crate::pool::SymbolId;
use crate::sweep::{Step, Sweep};

/// Columns in one word of a set.
const WORD_BITS: usize = u64::BITS as usize;
/// Words of all sets held at a time; more columns are taken in groups.
const MAX_WORDS: usize = 1 << 23;

/// For each step, the columns by which its derivative is not structurally zero.
pub(super) struct Dependence {
    pub(super) n_columns: usize,
    /// Where the words of each step start.
    starts: Vec<usize>,
    /// Words other than zero: number of the word, ascending in each step, and bits.
    words: Vec<(usize, u64)>,
    /// Symbols with their columns, in ascending order; a symbol may have several.
    columns: Vec<(SymbolId, usize)>,
}

impl Dependence {
    /// The dependence on all columns, in groups whose sets fit into memory: the number of the
    /// first column of each group, and the dependence on its columns.
    pub(super) fn in_groups(sweep: &Sweep, columns: &[SymbolId]) -> Vec<(usize, Self)> {
        let mut groups = Vec::new();
        let mut pending = vec![(0, columns)];
        while let Some((first, columns)) = pending.pop() {
            let limit = if columns.len() > WORD_BITS { MAX_WORDS } else { usize::MAX };
            if let Some(dependence) = Self::within(sweep, columns, columns.len(), limit) {
                groups.push((first, dependence));
            } else {
                let (left, right) = columns.split_at(columns.len() / 2);
                pending.extend([(first + left.len(), right), (first, left)]);
            }
        }
        groups
    }

    /// The dependence on any of the columns, however many: all are one bit.
    pub(super) fn on_any(sweep: &Sweep, columns: &[SymbolId]) -> Self {
        Self::within(sweep, columns, 1, usize::MAX).expect("there is no limit")
    }

    /// The sets, columns counted modulo `n_bits`; `None` when they have more words than `limit`.
    fn within(sweep: &Sweep, columns: &[SymbolId], n_bits: usize, limit: usize) -> Option<Self> {
        let mut sorted: Vec<_> = columns.iter().copied().zip(0..).collect();
        sorted.sort_unstable();
        let mut dependence = Self {
            n_columns: columns.len(),
            starts: Vec::with_capacity(sweep.steps.len() + 1),
            words: Vec::new(),
            columns: sorted,
        };
        dependence.starts.push(0);
        let mut found: Vec<(usize, u64)> = Vec::new();
        for step in &sweep.steps {
            found.clear();
            if let Some(symbol) = step.symbol() {
                let bits = dependence.columns_of(symbol).iter().map(|&(_, column)| column % n_bits);
                found.extend(bits.map(|bit| (bit / WORD_BITS, 1 << (bit % WORD_BITS))));
            } else {
                for operand in changing_operands(sweep, step) {
                    found.extend(dependence.words(operand));
                }
            }
            found.sort_unstable_by_key(|&(index, _)| index);
            found.dedup_by(|next, kept| {
                let is_same = next.0 == kept.0;
                if is_same {
                    kept.1 |= next.1;
                }
                is_same
            });
            dependence.words.extend(&found);
            if dependence.words.len() > limit {
                return None;
            }
            dependence.starts.push(dependence.words.len());
        }
        Some(dependence)
    }

    fn words(&self, position: usize) -> &[(usize, u64)] {
        &self.words[self.starts[position]..self.starts[position + 1]]
    }

    /// Number of columns a step depends on.
    pub(super) fn count(&self, position: usize) -> usize {
        self.words(position).iter().map(|(_, word)| word.count_ones() as usize).sum()
    }

    pub(super) fn is_empty(&self, position: usize) -> bool {
        self.words(position).is_empty()
    }

    /// The columns a step depends on, ascending.
    pub(super) fn columns(&self, position: usize) -> impl Iterator<Item = usize> {
        self.words(position).iter().flat_map(|&(index, word)| {
            let mut left = word;
            std::iter::from_fn(move || {
                let bit = (left != 0).then(|| left.trailing_zeros() as usize)?;
                left &= left - 1;
                Some(index * WORD_BITS + bit)
            })
        })
    }

    /// The columns of a symbol.
    pub(super) fn columns_of(&self, symbol: SymbolId) -> &[(SymbolId, usize)] {
        let start = self.columns.partition_point(|entry| entry.0 < symbol);
        let end = self.columns.partition_point(|entry| entry.0 <= symbol);
        &self.columns[start..end]
    }

    /// The positions at or below `roots` that depend on any column, users before operands.
    pub(super) fn reach(&self, sweep: &Sweep, roots: &[usize]) -> Vec<usize> {
        let mut is_found = std::collections::HashSet::new();
        let mut found = Vec::new();
        let mut visit = |position: usize, found: &mut Vec<usize>| {
            if !self.is_empty(position) && is_found.insert(position) {
                found.push(position);
            }
        };
        for &root in roots {
            visit(root, &mut found);
        }
        let mut next = 0;
        while next < found.len() {
            let step = &sweep.steps[found[next]];
            changing_operands(sweep, step).for_each(|operand| visit(operand, &mut found));
            next += 1;
        }
        found.sort_unstable_by(|a, b| b.cmp(a));
        found
    }
}

/// The operands a derivative flows through: none of a piecewise constant function, and not the
/// condition of an `if`.
fn changing_operands<'s>(sweep: &'s Sweep, step: &'s Step) -> impl Iterator<Item = usize> + 's {
    let n_left_out = match step.op {
        Op::Call(Function::If) => 1,
        Op::Call(function) if is_piecewise_constant(function) => usize::MAX,
        _ => 0,
    };
    sweep.operands(step).skip(n_left_out)
}
