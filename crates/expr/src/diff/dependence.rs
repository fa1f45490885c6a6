//! Which symbols the value of each step changes with, as sets of bits.

use crate::op::{Function, Op};
use crate::pool::SymbolId;
use crate::sweep::{Step, Sweep};

/// Columns in one word of a set.
pub(super) const WORD_BITS: usize = u64::BITS as usize;

/// For each step, the columns by which its derivative is not structurally zero.
pub(super) struct Dependence {
    pub(super) n_columns: usize,
    n_words: usize,
    bits: Vec<u64>,
    /// Symbols with their columns, in ascending order; a symbol may have several.
    columns: Vec<(SymbolId, usize)>,
}

impl Dependence {
    pub(super) fn new(sweep: &Sweep, columns: &[SymbolId]) -> Self {
        Self::in_words(sweep, columns, columns.len().div_ceil(WORD_BITS))
    }

    /// Tells only whether a step depends on any column, however many: all are one bit.
    pub(super) fn on_any(sweep: &Sweep, columns: &[SymbolId]) -> Self {
        Self::in_words(sweep, columns, 1)
    }

    fn in_words(sweep: &Sweep, columns: &[SymbolId], n_words: usize) -> Self {
        let mut sorted: Vec<_> = columns.iter().copied().zip(0..).collect();
        sorted.sort_unstable();
        let mut dependence = Self {
            n_columns: columns.len(),
            n_words,
            bits: vec![0; n_words * sweep.steps.len()],
            columns: sorted,
        };
        for (position, step) in sweep.steps.iter().enumerate() {
            if let Some(symbol) = step.symbol() {
                for &(_, column) in &dependence.columns_of(symbol).to_vec() {
                    let bit = column % (n_words * WORD_BITS);
                    dependence.bits[position * n_words + bit / WORD_BITS] |= 1 << (bit % WORD_BITS);
                }
                continue;
            }
            let (below, own) = dependence.bits.split_at_mut(position * n_words);
            for operand in changing_operands(sweep, step) {
                let set = &below[operand * n_words..(operand + 1) * n_words];
                own.iter_mut().zip(set).for_each(|(word, other)| *word |= other);
            }
        }
        dependence
    }

    fn words(&self, position: usize) -> &[u64] {
        &self.bits[position * self.n_words..(position + 1) * self.n_words]
    }

    /// Number of columns a step depends on.
    pub(super) fn count(&self, position: usize) -> usize {
        self.words(position).iter().map(|word| word.count_ones() as usize).sum()
    }

    pub(super) fn is_empty(&self, position: usize) -> bool {
        self.words(position).iter().all(|&word| word == 0)
    }

    /// The columns a step depends on, ascending.
    pub(super) fn columns(&self, position: usize) -> impl Iterator<Item = usize> {
        self.words(position).iter().enumerate().flat_map(|(index, &word)| {
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
        Op::Call(function) if function.is_piecewise_constant() => usize::MAX,
        _ => 0,
    };
    sweep.operands(step).skip(n_left_out)
}
