//! The arena of interned nodes behind every expression.
//!
//! A node is sixteen bytes: an operation, two operands and a payload; numbers and symbol names
//! live in side tables. A node is interned after its operands, so operands always carry smaller
//! handles and one forward sweep reaches every operand before its user. Nothing points backwards,
//! so dropping a pool drops a few vectors.
//!
//! Every node has a structural hash made of names and values, never of handles. Canonical operand
//! order follows it, which makes an expression independent of the order it was built in.

use crate::arena::{Arena, mix};
use crate::handle::ExprMap;
use crate::named_row::{FunctionId, NamedRow};
use crate::number::Number;
use crate::op::Op;
use std::cell::{Ref, RefCell};
use std::cmp::Ordering;

pub(crate) use crate::arena::{MINUS_ONE, Node, ONE, PI, ZERO, fact, unit_random};
pub use crate::handle::{Expr, SymbolId};

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
        // The table of handles, the simplified and the scratch space of sweeps are made again where they are needed.
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
                simplified: ExprMap::default(),
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

    /// True if the pool holds nothing but its constants.
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

    /// True if any function with a name was defined.
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

    /// True where `e` is a number below zero.
    pub(crate) fn is_negative_number(&self, e: Expr) -> bool {
        let arena = self.arena.borrow();
        let node = arena.nodes[e.0 as usize];
        node.op == Op::Number && arena.numbers[node.data as usize].is_negative()
    }

    /// The number of a node that is one.
    pub(crate) fn number_of(&self, e: Expr) -> Number {
        self.as_number(e).expect("the node is a number")
    }

    /// The simplified form of `e`: the known one, or that of `find`.
    pub(crate) fn simplified(&self, e: Expr, find: impl FnOnce() -> Expr) -> Expr {
        let known = self.arena.borrow().simplified.get(&e).copied();
        known.unwrap_or_else(|| {
            let form = find();
            self.arena.borrow_mut().simplified.insert(e, form);
            form
        })
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
