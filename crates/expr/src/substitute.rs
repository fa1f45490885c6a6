//! Simultaneous substitution of symbols.

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
}
