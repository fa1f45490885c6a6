//! How much of the running form is folded.
//!
//! Folding multiplies out and looks for the shortest of several forms. It pays where a person could read the result; of
//! what is long, factors that are shared take fewer operations than any sum of products, and no time to find. The
//! limits are terms multiplied out, see [`bksim_expr::Pool::multiplied_out`]: they depend on the expression alone.
//! Equations that are read are folded when they are read.

use std::hash::{DefaultHasher, Hash, Hasher};

use bksim_expr::{Expr, Pool, SymbolId};

/// Terms of a generalised force: no force of the examples has more, and all of them are read.
pub(crate) const MAX_TERMS_OF_FORCE: u64 = 40;
/// Terms of an entry of G, which comes from a row that is folded: above eight it gains little, and rows that share their
/// sums lose by it.
pub(crate) const MAX_TERMS_OF_SLOPE: u64 = 15;
/// Terms of whatever else is measured: of the square of a distance some eight vectors in the plane.
pub(crate) const MAX_TERMS: u64 = 150;

/// The shortest form of a row, of a measure or of a part of a reaction; a long one as it comes.
pub(crate) fn short(pool: &Pool, e: Expr) -> Expr {
    pool.simplify_up_to(e, MAX_TERMS)
}

/// An entry of a row of G.
pub(crate) fn folded_slope(pool: &Pool, slope: Expr) -> Expr {
    pool.simplify_up_to(slope, MAX_TERMS_OF_SLOPE)
}

/// True where `e` is zero throughout. Most of what is not shows it at the first position that is tried.
pub(crate) fn is_nothing(pool: &Pool, e: Expr) -> bool {
    /// Above all rounding.
    const SURE: f64 = 1e-9;
    // Anywhere between 0 and 1.
    let value = |symbol: SymbolId| {
        let mut hash = DefaultHasher::new();
        symbol.hash(&mut hash);
        let digits = u32::try_from(hash.finish() >> 32).ok()?;
        Some(f64::from(digits) / f64::from(u32::MAX))
    };
    let differs = pool.evaluate(e, &value).is_ok_and(|value| value.abs() > SURE);
    !differs && pool.is_zero(short(pool, e))
}
