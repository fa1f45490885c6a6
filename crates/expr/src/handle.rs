//! Handles of expressions and symbols, and maps by them.

use std::collections::{HashMap, HashSet};

/// Handle to one expression of a [`Pool`](crate::Pool); structurally equal expressions share one handle.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Expr(pub(crate) u32);

/// Handle to a symbol of a [`Pool`](crate::Pool), numbered in the order of first mention.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct SymbolId(pub(crate) u32);

/// A map by handles.
pub(crate) type ExprMap<V> = HashMap<Expr, V, HandleHash>;
/// A set of handles.
pub(crate) type ExprSet = HashSet<Expr, HandleHash>;
/// Hashes handles: small integers that need little mixing and no protection.
pub(crate) type HandleHash = std::hash::BuildHasherDefault<HandleHasher>;

/// See [`HandleHash`].
#[derive(Clone, Copy, Default)]
pub(crate) struct HandleHasher(u64);

impl std::hash::Hasher for HandleHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u32(u32::from(byte));
        }
    }

    fn write_u8(&mut self, byte: u8) {
        self.write_u64(u64::from(byte));
    }

    fn write_u32(&mut self, handle: u32) {
        self.write_u64(u64::from(handle));
    }

    fn write_u64(&mut self, word: u64) {
        // An odd multiplier near 2⁶⁴ over the golden ratio spreads neighbours over all bits.
        self.0 = (self.0.rotate_left(5) ^ word).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }

    fn write_usize(&mut self, word: usize) {
        self.write_u64(word as u64);
    }

    fn write_isize(&mut self, word: isize) {
        self.write_usize(word.cast_unsigned());
    }
}
