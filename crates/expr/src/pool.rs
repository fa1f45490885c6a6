//! The arena of interned nodes behind every expression.
//!
//! A node is sixteen bytes: an operation, two operands and a payload; numbers and symbol names
//! live in side tables. A node is interned after its operands, so operands always carry smaller
//! handles and one forward sweep reaches every operand before its user. Nothing points backwards,
//! so dropping a pool drops a few vectors.
//!
//! Every node has a structural hash made of names and values, never of handles. Canonical operand
//! order follows it, which makes an expression independent of the order it was built in.

use crate::handle::ExprMap;
use crate::named_row::{FunctionId, NamedRow};
use crate::number::Number;
use crate::op::{Function, Op};
use std::cell::{Ref, RefCell};
use std::cmp::Ordering;
use std::collections::HashMap;

pub use crate::handle::{Expr, SymbolId};

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

/// An arena of expressions.
///
/// All methods take `&self`, so constructor calls nest: `pool.mul(m, pool.add(x, y))`.
pub struct Pool {
    arena: RefCell<Arena>,
}

/// The expressions of a [`Pool`] at one moment, to be shared between threads: every handle of that pool
/// means the same in a pool that is made from them.
#[derive(Clone)]
pub struct PoolSnapshot {
    arena: Arena,
}

impl std::fmt::Debug for PoolSnapshot {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PoolSnapshot").field("len", &self.arena.nodes.len()).finish_non_exhaustive()
    }
}

impl PoolSnapshot {
    /// A pool of its own with these expressions.
    pub fn to_pool(&self) -> Pool {
        let mut arena = self.arena.clone();
        arena.reindex();
        Pool { arena: RefCell::new(arena) }
    }
}

impl Default for Pool {
    fn default() -> Self {
        Self::new()
    }
}

impl std::fmt::Debug for Pool {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Pool").field("len", &self.len()).finish_non_exhaustive()
    }
}

#[derive(Clone, Default)]
struct Arena {
    nodes: Vec<Node>,
    hashes: Vec<u64>,
    facts: Vec<u8>,
    numbers: Vec<Number>,
    number_index: HashMap<Number, u32>,
    /// Values of the constants that are no numbers, such as √2.
    constants: ExprMap<f64>,
    symbols: Vec<(String, Expr)>,
    symbol_index: HashMap<String, u32>,
    /// Functions with names, and their derivatives.
    named: Vec<NamedRow>,
    /// Open addressing table of node handles by structural hash; its length is a power of two.
    slots: Vec<u32>,
    /// Handle to position, valid where `stamp` equals `epoch`: scratch space of sweeps.
    pub(crate) position: Vec<(u32, u32)>,
    epoch: u32,
}

const EMPTY: u32 = u32::MAX;

/// The order of operands: the same in every pool, whatever was built before.
pub(crate) struct CanonicalOrder<'p> {
    arena: Ref<'p, Arena>,
}

impl CanonicalOrder<'_> {
    pub(crate) fn compare(&self, a: Expr, b: Expr) -> Ordering {
        if a == b {
            return Ordering::Equal;
        }
        let key = |e: Expr| (self.arena.hashes[e.0 as usize], e.0);
        key(a).cmp(&key(b))
    }
}

/// Mixes two words into one (the finaliser of SplitMix64 after an odd multiply).
fn mix(a: u64, b: u64) -> u64 {
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
    fn intern(&mut self, node: Node, hash: u64) -> Expr {
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

    fn grow(&mut self) {
        self.rehash((self.slots.len() * 2).max(1024));
    }

    /// Makes the table of handles for as many nodes as there are.
    fn reindex(&mut self) {
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

    fn hash_of(&self, node: Node) -> u64 {
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
    fn constant_value(&self, node: Node) -> f64 {
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
    fn facts_of(&mut self, node: Node, index: u32) -> u8 {
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

impl Pool {
    /// An empty pool; it knows only the constants 0, 1, −1 and π.
    pub fn new() -> Self {
        let pool = Self { arena: RefCell::default() };
        for number in [Number::ZERO, Number::ONE, Number::MINUS_ONE] {
            pool.number(number);
        }
        pool.intern(Op::Pi, ZERO, ZERO, 0);
        pool
    }

    /// The expressions of this pool as they are now; what is added later is not among them.
    pub fn snapshot(&self) -> PoolSnapshot {
        let arena = &*self.arena.borrow();
        // The table of handles and the scratch space of sweeps are made anew where they are needed.
        PoolSnapshot {
            arena: Arena {
                nodes: arena.nodes.clone(),
                hashes: arena.hashes.clone(),
                facts: arena.facts.clone(),
                numbers: arena.numbers.clone(),
                number_index: arena.number_index.clone(),
                constants: arena.constants.clone(),
                symbols: arena.symbols.clone(),
                symbol_index: arena.symbol_index.clone(),
                named: arena.named.clone(),
                slots: Vec::new(),
                position: Vec::new(),
                epoch: 0,
            },
        }
    }

    /// Number of nodes ever interned.
    pub fn len(&self) -> usize {
        self.arena.borrow().nodes.len()
    }

    /// Whether the pool holds nothing but its constants.
    pub fn is_empty(&self) -> bool {
        self.len() <= 4
    }

    /// Returns the handle of a node, storing the node only when it is new.
    pub(crate) fn intern(&self, op: Op, left: Expr, right: Expr, data: u32) -> Expr {
        let arena = &mut *self.arena.borrow_mut();
        let node = Node { op, left, right, data };
        let hash = arena.hash_of(node);
        arena.intern(node, hash)
    }

    pub(crate) fn node(&self, e: Expr) -> Node {
        self.arena.borrow().nodes[e.0 as usize]
    }

    pub(crate) fn has_fact(&self, e: Expr, fact: u8) -> bool {
        self.arena.borrow().facts[e.0 as usize] & fact != 0
    }

    /// Canonical order: by structural hash; the handle decides between colliding hashes.
    pub(crate) fn canonical_order(&self, a: Expr, b: Expr) -> Ordering {
        self.ordering().compare(a, b)
    }

    /// The canonical order, for many comparisons; no node can be interned while it is held.
    pub(crate) fn ordering(&self) -> CanonicalOrder<'_> {
        CanonicalOrder { arena: self.arena.borrow() }
    }

    /// The symbol called `name`, new or known.
    ///
    /// # Panics
    /// When the pool is full, at 2³² nodes.
    pub fn symbol(&self, name: &str) -> Expr {
        let arena = &mut *self.arena.borrow_mut();
        if let Some(&known) = arena.symbol_index.get(name) {
            return arena.symbols[known as usize].1;
        }
        let id = u32::try_from(arena.symbols.len()).expect("a pool holds fewer than 2^32 symbols");
        arena.symbols.push((name.to_owned(), ZERO));
        arena.symbol_index.insert(name.to_owned(), id);
        let node = Node { op: Op::Symbol, left: ZERO, right: ZERO, data: id };
        let hash = arena.hash_of(node);
        let e = arena.intern(node, hash);
        arena.symbols[id as usize].1 = e;
        e
    }

    /// The symbol that `e` is, if it is one.
    pub fn symbol_id(&self, e: Expr) -> Option<SymbolId> {
        let node = self.node(e);
        (node.op == Op::Symbol).then_some(SymbolId(node.data))
    }

    /// The symbol called `name`, if the pool knows it.
    pub fn find_symbol(&self, name: &str) -> Option<SymbolId> {
        self.arena.borrow().symbol_index.get(name).copied().map(SymbolId)
    }

    /// The expression that is the symbol alone.
    pub fn symbol_expr(&self, id: SymbolId) -> Expr {
        self.arena.borrow().symbols[id.0 as usize].1
    }

    /// The name of a symbol.
    pub fn symbol_name(&self, id: SymbolId) -> String {
        self.arena.borrow().symbols[id.0 as usize].0.clone()
    }

    /// Whether any function with a name was defined.
    pub(crate) fn has_named(&self) -> bool {
        !self.arena.borrow().named.is_empty()
    }

    /// A fact about a function with a name.
    pub(crate) fn named<T>(&self, function: FunctionId, of: impl Fn(&NamedRow) -> T) -> T {
        of(&self.arena.borrow().named[function.0 as usize])
    }

    /// The first function with a name of which a condition holds.
    pub(crate) fn find_named(&self, is_it: impl Fn(&NamedRow) -> bool) -> Option<FunctionId> {
        let index = self.arena.borrow().named.iter().position(is_it)?;
        Some(FunctionId(u32::try_from(index).expect("fewer than 2^32 functions")))
    }

    /// Adds a function with a name, without a `base` a function of its own.
    pub(crate) fn add_named(&self, row: NamedRow) -> FunctionId {
        let arena = &mut *self.arena.borrow_mut();
        let id = u32::try_from(arena.named.len()).expect("fewer than 2^32 functions");
        let text = row.name.bytes().fold(0, |hash, byte| mix(hash, u64::from(byte)));
        let orders = row.orders.iter().fold(text, |hash, &n| mix(hash, u64::from(n)));
        let hash = mix(orders, arena.hashes[row.body.0 as usize]);
        arena.named.push(NamedRow { hash, ..row });
        FunctionId(id)
    }

    /// Takes note of the derivative of a function by a parameter.
    pub(crate) fn note_derivative(&self, of: FunctionId, parameter: usize, is: FunctionId) {
        self.arena.borrow_mut().named[of.0 as usize].derivatives[parameter] = Some(is);
    }

    /// A number.
    ///
    /// # Panics
    /// When the pool is full, at 2³² nodes.
    pub fn number(&self, n: Number) -> Expr {
        let data = {
            let arena = &mut *self.arena.borrow_mut();
            let next = u32::try_from(arena.numbers.len()).expect("fewer than 2^32 numbers");
            if let Some(&known) = arena.number_index.get(&n) {
                known
            } else {
                arena.number_index.insert(n.clone(), next);
                arena.numbers.push(n);
                next
            }
        };
        self.intern(Op::Number, ZERO, ZERO, data)
    }

    /// The number that `e` is, if it is one (π is none).
    pub fn as_number(&self, e: Expr) -> Option<Number> {
        let arena = self.arena.borrow();
        let node = arena.nodes[e.0 as usize];
        (node.op == Op::Number).then(|| arena.numbers[node.data as usize].clone())
    }

    /// The number of a node that is one.
    pub(crate) fn number_of(&self, e: Expr) -> Number {
        self.as_number(e).expect("the node is a number")
    }

    /// Starts a sweep over handles: afterwards no handle has a position.
    pub(crate) fn clear_positions(&self) {
        let arena = &mut *self.arena.borrow_mut();
        arena.position.resize(arena.nodes.len(), (0, 0));
        arena.epoch = arena.epoch.wrapping_add(1);
        if arena.epoch == 0 {
            arena.position.fill((0, 0));
            arena.epoch = 1;
        }
    }

    /// Gives `e` position 0 if it has none; whether it had none.
    pub(crate) fn visit(&self, e: Expr) -> bool {
        let arena = &mut *self.arena.borrow_mut();
        let entry = &mut arena.position[e.0 as usize];
        let is_new = entry.0 != arena.epoch;
        if is_new {
            *entry = (arena.epoch, 0);
        }
        is_new
    }

    /// Gives `e` a position.
    pub(crate) fn set_position(&self, e: Expr, position: u32) {
        let arena = &mut *self.arena.borrow_mut();
        arena.position[e.0 as usize] = (arena.epoch, position);
    }

    /// The position last given to `e` in this sweep.
    pub(crate) fn position(&self, e: Expr) -> u32 {
        self.arena.borrow().position[e.0 as usize].1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn handles_mean_the_same_in_a_pool_from_a_snapshot() {
        let pool = Pool::new();
        let e = pool.parse("sin(a)^2 + 3*b/7 - sqrt(2)").expect("an expression");
        let snapshot = pool.snapshot();
        // What comes later is not among them.
        pool.symbol("later");
        let thawed = std::thread::spawn(move || snapshot.to_pool()).join().expect("a thread");
        assert_eq!(thawed.to_text(e), pool.to_text(e));
        assert_eq!(thawed.find_symbol("later"), None);
        let again = thawed.parse("sin(a)^2 + 3*b/7 - sqrt(2)").expect("an expression");
        assert_eq!(again, e, "known nodes are found again");
    }
}
