//! The order of instructions: those that the outputs need, operands first, angles gathered.
//!
//! A sine or cosine whose angle holds no other sine or cosine has level 1, one of an angle that
//! holds level n has level n + 1. All angles of one level are known at the same time, so they make
//! one turn:
//!
//! ```text
//! operands of level 1 | turn 1 | further operands of level 2 | turn 2 | … | all others
//! ```
//!
//! Within each part, operands come right before their first user: few values are alive at a time.

use super::register::{Key, Register, index};
use super::{Action, Instruction};
use crate::op::Function;
use std::collections::HashMap;

/// Prologue or body: its instructions in order.
pub(super) struct Section<'k> {
    keys: &'k [Key],
    is_needed: Vec<bool>,
    order: Vec<Entry>,
}

/// One instruction of the final order.
enum Entry {
    /// The key at this position.
    Single(usize),
    /// Sines and cosines of these angles.
    Turn(Turn),
}

/// The sines and cosines of one level.
#[derive(Default)]
struct Turn {
    angles: Vec<Register>,
    /// Positions of keys, with the position of their result among those of the turn; that of a
    /// cosine is counted after the sines.
    sines: Vec<(usize, usize)>,
    cosines: Vec<(usize, usize)>,
}

fn is_turned((action, ..): &Key) -> bool {
    matches!(action, Action::Call(Function::Sin | Function::Cos))
}

impl<'k> Section<'k> {
    /// Orders the `keys` that `roots` need; `own` gives the position of a register of this section.
    pub(super) fn new(
        keys: &'k [Key],
        own: impl Fn(Register) -> Option<usize>,
        roots: &[Register],
    ) -> Self {
        // The keys that the roots need, users before operands.
        let operands = |&(_, a, b, c): &Key| [a, b, c].map(&own).into_iter().flatten();
        let mut is_needed = vec![false; keys.len()];
        roots.iter().copied().filter_map(&own).for_each(|root| is_needed[root] = true);
        for position in (0..keys.len()).rev() {
            if is_needed[position] {
                for operand in operands(&keys[position]) {
                    is_needed[operand] = true;
                }
            }
        }

        // Orders a key after its operands: depth first without recursion, a position is left once
        // its operands are ordered.
        let mut order = Vec::new();
        let mut is_ordered = vec![false; keys.len()];
        let mut demand = |root: Register, order: &mut Vec<Entry>| {
            let mut path: Vec<usize> = own(root).into_iter().collect();
            while let Some(&position) = path.last() {
                let missing = operands(&keys[position]).find(|&o| !is_ordered[o]);
                if let Some(operand) = missing.filter(|_| !is_ordered[position]) {
                    path.push(operand);
                    continue;
                }
                path.pop();
                if !is_ordered[position] {
                    is_ordered[position] = true;
                    // Turned keys are ordered through their turn.
                    if !is_turned(&keys[position]) {
                        order.push(Entry::Single(position));
                    }
                }
            }
        };
        // Level by level, then the roots.
        for turn in turns(keys, &is_needed, &operands) {
            for &angle in &turn.angles {
                demand(angle, &mut order);
            }
            order.push(Entry::Turn(turn));
        }
        for &root in roots {
            demand(root, &mut order);
        }
        Self { keys, is_needed, order }
    }

    /// All registers that the section reads.
    pub(super) fn operands(&self) -> Vec<Register> {
        let needed = self.keys.iter().zip(&self.is_needed).filter(|(_, needed)| **needed);
        needed.flat_map(|(&(_, a, b, c), _)| [a, b, c]).collect()
    }

    /// Number of keys that are computed.
    pub(super) fn n_operations(&self) -> usize {
        self.is_needed.iter().filter(|&&needed| needed).count()
    }

    /// Number of registers written.
    pub(super) fn n_results(&self) -> usize {
        self.order.iter().map(Entry::n_results).sum()
    }

    /// The final number of every key's register, counted from `first`.
    pub(super) fn numbers(&self, first: usize) -> Vec<u32> {
        let mut numbers = vec![0; self.keys.len()];
        let mut next = first;
        for entry in &self.order {
            match entry {
                Entry::Single(position) => numbers[*position] = index(next),
                Entry::Turn(turn) => {
                    let n = turn.angles.len();
                    let cosines = turn.cosines.iter().map(|&(key, j)| (key, n + j));
                    for (key, j) in turn.sines.iter().copied().chain(cosines) {
                        numbers[key] = index(next + j);
                    }
                }
            }
            next += entry.n_results();
        }
        numbers
    }

    /// The instructions on numbered registers; those of turned angles are added to `angles`.
    pub(super) fn instructions(
        &self,
        number: &impl Fn(Register) -> u32,
        angles: &mut Vec<u32>,
    ) -> Vec<Instruction> {
        let instruction = |entry: &Entry| match entry {
            Entry::Single(position) => {
                let (action, a, b, c) = self.keys[*position];
                Instruction { action, a: number(a), b: number(b), c: number(c) }
            }
            Entry::Turn(turn) => {
                let (a, b) = (index(angles.len()), index(turn.angles.len()));
                angles.extend(turn.angles.iter().map(|&angle| number(angle)));
                Instruction { action: Action::Turn, a, b, c: a }
            }
        };
        self.order.iter().map(instruction).collect()
    }
}

impl Entry {
    fn n_results(&self) -> usize {
        match self {
            Self::Single(_) => 1,
            Self::Turn(turn) => 2 * turn.angles.len(),
        }
    }
}

/// Gathers the needed sines and cosines by level.
fn turns<I: Iterator<Item = usize>>(
    keys: &[Key],
    is_needed: &[bool],
    operands: &impl Fn(&Key) -> I,
) -> Vec<Turn> {
    let mut levels = vec![0; keys.len()];
    let mut turns: Vec<Turn> = Vec::new();
    let mut positions: HashMap<Register, usize> = HashMap::new();
    for (position, key) in keys.iter().enumerate().filter(|&(position, _)| is_needed[position]) {
        let level = operands(key).map(|operand| levels[operand]).max().unwrap_or(0);
        levels[position] = level;
        if !is_turned(key) {
            continue;
        }
        levels[position] = level + 1;
        if turns.len() == level {
            turns.push(Turn::default());
        }
        let turn = &mut turns[level];
        let &(action, angle, ..) = key;
        let angle_idx = *positions.entry(angle).or_insert_with(|| {
            turn.angles.push(angle);
            turn.angles.len() - 1
        });
        let is_sine = action == Action::Call(Function::Sin);
        let results = if is_sine { &mut turn.sines } else { &mut turn.cosines };
        results.push((position, angle_idx));
    }
    turns
}
