//! [`Blocks`]: names for the parts of equations in letters that would be long written out.
//!
//! ```text
//! G Z = 0              slopes of the rows, then Z in terms of them
//! Zᵀ M Z, Zᵀ K Z, …    in terms of Z
//! ```
//!
//! A solution of linear equations multiplies its coefficients with each other. Where these are sums, the products spread
//! over thousands of terms that nobody reads; with a name for each coefficient it keeps the length of the book's.

use std::cell::RefCell;

use bksim_expr::{Expr, Pool};

/// Terms, multiplied out, up to which a part is written where it is used.
pub(super) const MAX_TERMS: u64 = 200;

/// Bound on the terms of a determinant up to which the rows are solved written out: those of one loop are.
pub(super) const MAX_DETERMINANT: u64 = 60;

/// The names and what they stand for.
pub(super) struct Blocks<'a> {
    pool: &'a Pool,
    /// Symbols with their definitions, each by symbols before it.
    found: RefCell<Vec<(Expr, Expr)>>,
}

impl<'a> Blocks<'a> {
    pub(super) fn new(pool: &'a Pool) -> Self {
        Self { pool, found: RefCell::default() }
    }

    /// True where nothing has a name.
    pub(super) fn is_empty(&self) -> bool {
        self.found.borrow().is_empty()
    }

    /// A name for the expression, the one that it has already or a new one; a number or a symbol needs none.
    pub(super) fn named(&self, e: Expr, name: impl FnOnce() -> String) -> Expr {
        let pool = self.pool;
        let e = pool.simplify_up_to(e, MAX_TERMS);
        if pool.as_number(e).is_some() || pool.symbol_id(e).is_some() {
            return e;
        }
        let mut found = self.found.borrow_mut();
        if let Some(&(symbol, _)) = found.iter().find(|&&(_, definition)| definition == e) {
            return symbol;
        }
        // No name of the model, which may have any.
        let mut name = name();
        while pool.find_symbol(&name).is_some() {
            name.push('_');
        }
        let symbol = pool.symbol(&name);
        found.push((symbol, e));
        symbol
    }

    /// The expressions with definitions in the place of all names.
    pub(super) fn written_out(&self, roots: &[Expr]) -> Vec<Expr> {
        let pool = self.pool;
        let mut images = Vec::new();
        for &(symbol, definition) in self.found.borrow().iter() {
            let image = pool.substitute(definition, &images);
            images.extend(pool.symbol_id(symbol).map(|symbol| (symbol, image)));
        }
        pool.substitute_all(roots, &images)
    }

    /// The names that some expressions need, and their definitions, each by names before it.
    pub(super) fn needed(&self, roots: &[Expr]) -> Vec<(String, Expr)> {
        let pool = self.pool;
        let mut readers = roots.to_vec();
        let mut needed = Vec::new();
        for &(symbol, definition) in self.found.borrow().iter().rev() {
            let Some(id) = pool.symbol_id(symbol) else { continue };
            if readers.iter().any(|&reader| pool.depends_on(reader, id)) {
                readers.push(definition);
                needed.push((pool.symbol_name(id), definition));
            }
        }
        needed.reverse();
        needed
    }
}
