//! Nodes in the order in which they were interned, each once: their table by structural hash, and facts about them.

use crate::handle::{Expr, ExprMap};
use crate::named_row::NamedRow;
use crate::number::Number;
use crate::op::{Function, Op};
use std::collections::HashMap;

/// One operation on up to two operands.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Node {
    pub(crate) op: Op,
    pub(crate) left: Expr,
    pub(crate) right: Expr,
    /// Index of the number or symbol; number of terms or factors of a chain.
    pub(crate) data: u32,
}

/// Facts about a node's value, found when it is interned.
pub(crate) mod fact {
    /// The value is never below zero (it may be NaN).
    pub(crate) const NOT_NEGATIVE: u8 = 1;
    /// Some constant part has no finite value, such as `1/0` or `ln(-2)`; zero must not swallow it.
    pub(crate) const POISONED: u8 = 2;
    /// No symbol occurs.
    pub(crate) const CONSTANT: u8 = 4;
    /// A sine or cosine of something that is no constant occurs.
    pub(crate) const TRIGONOMETRIC: u8 = 8;
    /// A tangent of something that is no constant occurs.
    pub(crate) const TANGENT: u8 = 16;
    /// An exponential or hyperbolic function of something that is no constant occurs.
    pub(crate) const EXPONENTIAL: u8 = 32;
}

/// The handle of the number 0, fixed in every pool.
pub(crate) const ZERO: Expr = Expr(0);
/// The handle of the number 1, fixed in every pool.
pub(crate) const ONE: Expr = Expr(1);
/// The handle of the number −1, fixed in every pool.
pub(crate) const MINUS_ONE: Expr = Expr(2);
/// The handle of π, fixed in every pool.
pub(crate) const PI: Expr = Expr(3);

/// The nodes of a pool.
#[derive(Clone, Default)]
pub(crate) struct Arena {
    pub(crate) nodes: Vec<Node>,
    pub(crate) hashes: Vec<u64>,
    pub(crate) facts: Vec<u8>,
    pub(crate) numbers: Vec<Number>,
    pub(crate) number_index: HashMap<Number, u32>,
    /// Values of the constants that are no numbers, such as √2.
    pub(crate) constants: ExprMap<f64>,
    pub(crate) symbols: Vec<(String, Expr)>,
    pub(crate) symbol_index: HashMap<String, u32>,
    /// Functions with names, and their derivatives.
    pub(crate) named: Vec<NamedRow>,
    /// Expressions that were simplified, with what they became.
    pub(crate) simplified: ExprMap<Expr>,
    /// Open addressing table of node handles by structural hash; its length is a power of two.
    pub(crate) slots: Vec<u32>,
    /// Handle to position, valid where `stamp` equals `epoch`: scratch space of sweeps.
    pub(crate) position: Vec<(u32, u32)>,
    pub(crate) epoch: u32,
}

/// A slot without a node.
const EMPTY: u32 = u32::MAX;

/// Mixes two words into one (the finaliser of SplitMix64 after an odd multiply).
pub(crate) fn mix(a: u64, b: u64) -> u64 {
    let mut z = a.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ b.wrapping_add(0xD1B5_4A32_D192_ED03);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// The next of a fixed sequence of pseudo-random numbers in [0, 1).
pub(crate) fn unit_random(state: &mut u64) -> f64 {
    *state = state.wrapping_add(1);
    (mix(*state, 0) >> 11) as f64 / 2f64.powi(53)
}

/// A number for each operation, part of its nodes' hash.
fn op_code(op: Op) -> u64 {
    match op {
        Op::Number => 1,
        Op::Symbol => 2,
        Op::Pi => 3,
        Op::Add => 4,
        Op::Mul => 5,
        Op::Pow => 6,
        Op::Pair => 7,
        Op::Named => 8,
        Op::Call(function) => 16 + function as u64,
    }
}

impl Arena {
    pub(crate) fn intern(&mut self, node: Node, hash: u64) -> Expr {
        if (self.nodes.len() + 1) * 2 > self.slots.len() {
            self.grow();
        }
        let mask = self.slots.len() - 1;
        #[expect(clippy::cast_possible_truncation, reason = "only the low bits are used")]
        let mut slot = hash as usize & mask;
        while self.slots[slot] != EMPTY {
            let known = self.slots[slot] as usize;
            if self.hashes[known] == hash && self.nodes[known] == node {
                return Expr(self.slots[slot]);
            }
            slot = (slot + 1) & mask;
        }
        let index = u32::try_from(self.nodes.len()).ok().filter(|&index| index != EMPTY);
        let index = index.expect("a pool holds fewer than 2^32 nodes");
        self.slots[slot] = index;
        let facts = self.facts_of(node, index);
        self.nodes.push(node);
        self.hashes.push(hash);
        self.facts.push(facts);
        Expr(index)
    }

    pub(crate) fn grow(&mut self) {
        self.rehash((self.slots.len() * 2).max(1024));
    }

    /// Makes the table of handles for as many nodes as there are.
    pub(crate) fn reindex(&mut self) {
        self.rehash((2 * (self.nodes.len() + 1)).next_power_of_two().max(1024));
    }

    fn rehash(&mut self, n_slots: usize) {
        let mask = n_slots - 1;
        self.slots = vec![EMPTY; mask + 1];
        for (index, &hash) in (0u32..).zip(&self.hashes) {
            #[expect(clippy::cast_possible_truncation, reason = "only the low bits are used")]
            let mut slot = hash as usize & mask;
            while self.slots[slot] != EMPTY {
                slot = (slot + 1) & mask;
            }
            self.slots[slot] = index;
        }
    }

    pub(crate) fn hash_of(&self, node: Node) -> u64 {
        let code = op_code(node.op);
        match node.op {
            Op::Number => mix(code, self.numbers[node.data as usize].mixed(&mix)),
            Op::Symbol => {
                let name = &self.symbols[node.data as usize].0;
                name.bytes().fold(mix(code, 0), |hash, byte| mix(hash, u64::from(byte)))
            }
            Op::Pi => mix(code, 0),
            Op::Named => {
                let hash = |e: Expr| self.hashes[e.0 as usize];
                let of_function = mix(code, self.named[node.data as usize].hash);
                mix(mix(of_function, hash(node.left)), hash(node.right))
            }
            _ => {
                let hash = |e: Expr| self.hashes[e.0 as usize];
                mix(mix(code, hash(node.left)), mix(hash(node.right), u64::from(node.data)))
            }
        }
    }

    /// The value of a constant node, from those of its operands, which are constants too.
    pub(crate) fn constant_value(&self, node: Node) -> f64 {
        let value = |e: Expr| {
            let node = self.nodes[e.0 as usize];
            match node.op {
                Op::Number => self.numbers[node.data as usize].to_f64(),
                Op::Pi => std::f64::consts::PI,
                _ => self.constants[&e],
            }
        };
        let (left, right) = (value(node.left), value(node.right));
        match node.op {
            Op::Add => left + right,
            Op::Mul => left * right,
            Op::Pow => crate::op::power(left, right),
            Op::Call(Function::If) => {
                let branches = self.nodes[node.right.0 as usize];
                crate::op::select(left, value(branches.left), value(branches.right))
            }
            Op::Call(function) => function.value(left, right),
            // The branches are read by their `if`; functions with names are expanded at constants.
            Op::Number | Op::Symbol | Op::Pi | Op::Pair | Op::Named => 0.0,
        }
    }

    /// The facts of a node, from those of its operands.
    pub(crate) fn facts_of(&mut self, node: Node, index: u32) -> u8 {
        use fact::{CONSTANT, EXPONENTIAL, NOT_NEGATIVE, POISONED, TANGENT, TRIGONOMETRIC};
        if node.op == Op::Number {
            let number = &self.numbers[node.data as usize];
            let sign = if number.is_negative() { 0 } else { NOT_NEGATIVE };
            let poison = if number.is_finite() { 0 } else { POISONED };
            return CONSTANT | sign | poison;
        }
        if node.op == Op::Symbol {
            return 0;
        }
        if node.op == Op::Pi {
            return CONSTANT | NOT_NEGATIVE;
        }
        let (left, right) = (self.facts[node.left.0 as usize], self.facts[node.right.0 as usize]);
        let both = left & right;
        let is_even_power = || {
            let exponent = self.nodes[node.right.0 as usize];
            exponent.op == Op::Number
                && self.numbers[exponent.data as usize].as_integer().is_some_and(|n| n % 2 == 0)
        };
        let is_never_negative = match node.op {
            Op::Add | Op::Mul | Op::Pair | Op::Call(Function::Min) => both & NOT_NEGATIVE != 0,
            Op::Pow => left & NOT_NEGATIVE != 0 || is_even_power(),
            Op::Call(Function::Exp | Function::Sqrt | Function::Abs | Function::Cosh) => true,
            Op::Call(Function::Max) => (left | right) & NOT_NEGATIVE != 0,
            Op::Call(Function::If) => right & NOT_NEGATIVE != 0,
            _ => false,
        };
        let is_constant = both & CONSTANT != 0 && node.op != Op::Named;
        let is_poisoned = is_constant && {
            let value = self.constant_value(node);
            self.constants.insert(Expr(index), value);
            !value.is_finite()
        };
        let has_angle = matches!(node.op, Op::Call(Function::Sin | Function::Cos));
        let is_exponential = matches!(
            node.op,
            Op::Call(Function::Exp | Function::Sinh | Function::Cosh | Function::Tanh)
        );
        let mut facts = (left | right) & (POISONED | TRIGONOMETRIC | TANGENT | EXPONENTIAL);
        for (holds, fact) in [
            (is_never_negative, NOT_NEGATIVE),
            (is_constant, CONSTANT),
            (is_poisoned, POISONED),
            (has_angle && !is_constant, TRIGONOMETRIC),
            (node.op == Op::Call(Function::Tan) && !is_constant, TANGENT),
            (is_exponential && !is_constant, EXPONENTIAL),
        ] {
            facts |= if holds { fact } else { 0 };
        }
        facts
    }
}
