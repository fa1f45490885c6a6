//! Simultaneous substitution of symbols, and replacement of parts and of function calls.

use crate::op::{Function, Op};
use crate::pool::{Expr, Pool, SymbolId};
use std::collections::HashMap;

impl Pool {
    /// Replaces symbols by expressions, all at once: replacements are not searched again.
    pub fn substitute(&self, e: Expr, map: &[(SymbolId, Expr)]) -> Expr {
        self.substitute_all(&[e], map)[0]
    }

    /// Replaces symbols in several expressions; shared parts are rebuilt once.
    pub fn substitute_all(&self, roots: &[Expr], map: &[(SymbolId, Expr)]) -> Vec<Expr> {
        if map.is_empty() {
            return roots.to_vec();
        }
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

    /// Rewrites function calls, operands before users: `image` gets each call with its operands
    /// already rewritten, and may return another expression for it.
    ///
    /// ```
    /// use bksim_expr::{Function, Pool};
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let pool = Pool::new();
    /// let kinked = pool.parse("k*abs(x + y) + sin(x)")?;
    /// let [smooth] = pool.map_calls(&[kinked], |function, operands| match (function, operands) {
    ///     (Function::Abs, &[a]) => Some(pool.mul(pool.symbol("s"), a)),
    ///     _ => None,
    /// })[..] else { unreachable!("one expression in, one out") };
    /// assert_eq!(smooth, pool.parse("k*s*(x + y) + sin(x)")?);
    /// # Ok(())
    /// # }
    /// ```
    pub fn map_calls(
        &self,
        roots: &[Expr],
        mut image: impl FnMut(Function, &[Expr]) -> Option<Expr>,
    ) -> Vec<Expr> {
        let sweep = self.sweep(roots);
        let mut images: Vec<Expr> = Vec::with_capacity(sweep.steps.len());
        for step in &sweep.steps {
            let mut operands: Vec<Expr> = sweep.operands(step).map(|o| images[o]).collect();
            let unchanged = sweep.operands(step).all(|o| images[o] == sweep.steps[o].expr);
            let rebuilt = if unchanged { step.expr } else { self.rebuild(step, &operands) };
            let called = match step.op {
                Op::Call(Function::If) => {
                    let branches = self.node(operands[1]);
                    operands.truncate(1);
                    operands.extend([branches.left, branches.right]);
                    image(Function::If, &operands)
                }
                Op::Call(function) => image(function, &operands),
                _ => None,
            };
            images.push(called.unwrap_or(rebuilt));
        }
        sweep.roots.iter().map(|&root| images[root]).collect()
    }
}
