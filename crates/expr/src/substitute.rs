//! Simultaneous substitution of symbols, and replacement of parts.

use crate::pool::{Expr, Pool, SymbolId};
use std::collections::HashMap;

impl Pool {
    /// Replaces symbols by expressions, all at once: replacements are not searched again.
    pub fn substitute(&self, e: Expr, map: &[(SymbolId, Expr)]) -> Expr {
        self.substitute_all(&[e], map)[0]
    }

    /// Replaces symbols in several expressions; shared parts are rebuilt once.
    pub fn substitute_all(&self, roots: &[Expr], map: &[(SymbolId, Expr)]) -> Vec<Expr> {
        let replacement: HashMap<SymbolId, Expr> = map.iter().copied().collect();
        let sweep = self.sweep(roots);
        let images = self.map_sweep(&sweep, |step| replacement.get(&step.symbol()?).copied());
        sweep.roots.iter().map(|&root| images[root]).collect()
    }

    /// Replaces whole parts by other expressions, all at once. A part of a longer sum or product
    /// is not found: only the sum or product as a whole is a part.
    pub fn replace_all(&self, roots: &[Expr], map: &[(Expr, Expr)]) -> Vec<Expr> {
        let replacement: HashMap<Expr, Expr> = map.iter().copied().collect();
        let sweep = self.sweep(roots);
        let images = self.map_sweep(&sweep, |step| replacement.get(&step.expr).copied());
        sweep.roots.iter().map(|&root| images[root]).collect()
    }
}
