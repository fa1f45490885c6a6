//! How much of the running form is folded.
//!
//! Folding multiplies out and looks for the shortest of several forms. It pays where a person could read the result; of
//! what is long, factors that are shared take fewer operations than any sum of products, and no time to find. The
//! limits are terms multiplied out, see [`bksim_expr::Pool::multiplied_out`]: they depend on the expression alone.

/// Terms of a generalised force: no force of the examples has more, and all of them are read.
pub(crate) const MAX_TERMS_OF_FORCE: u64 = 40;
/// Terms of an entry of G, which comes from a row that is folded: above eight it gains little, and rows that share their
/// sums lose by it.
pub(crate) const MAX_TERMS_OF_SLOPE: u64 = 15;
/// Terms of the square of a distance: of some eight vectors in the plane.
pub(crate) const MAX_TERMS_OF_SQUARE: u64 = 150;
