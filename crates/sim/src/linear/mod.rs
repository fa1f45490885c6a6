//! Linear algebra of mechanisms: dense for small ones, by sparse elimination for large ones.
//!
//! Everything here serves one matrix, that of the multiplier system, or its lower rows:
//!
//! ```text
//! [ M  Gᵀ ]     M   nq × nq, symmetric: positive definite where every coordinate has inertia
//! [ G  0  ]     G   nc × nq: its *active* rows take part; rows that depend on others, and rows of
//!                   open contacts, are *inactive*
//! ```
//!
//! | module | question | answer |
//! | --- | --- | --- |
//! | [`shape`] | which entries do M and G have? | `Shape` |
//! | [`rows`] | which x nearest to G x = r is the shortest? | `SparseRows`, `shortest_solution`, `Inverse` |
//! | [`lq`] | the same where the rows are far from depending on each other | `shortest_solution` |
//! | [`dense`] | the same, and the rank, of small matrices | `least_squares`, `dependent_rows` |
//! | [`svd`] | which singular values has a small matrix? | `Svd` |
//! | [`matrix`] | dense or sparse, as the size of the mechanism asks for? | `Matrix` |
//! | [`rank`] | which rows of G depend on rows before them? | `dependent_rows` |
//! | [`elimination`] | x and λ, M positive definite; how far is G from a loss of rank? | `Elimination` |
//! | [`plan`] | the same, its order chosen once | `EliminationPlan` |
//! | [`augmented`] | the same with coordinates that have no inertia of their own | `Augmented` |
//! | [`unrolled`] | the same as straight-line code, for small mechanisms | `UnrolledSolve` |
//! | [`written`] | projections, and refined solutions, as straight-line code? | `WrittenSystem` |
//!
//! Matrices with more than [`rows::LARGEST_DENSE`] columns are never decomposed as dense ones.

pub(crate) mod augmented;
pub(crate) mod dense;
pub(crate) mod elimination;
pub(crate) mod lq;
pub(crate) mod matrix;
pub(crate) mod plan;
pub(crate) mod rank;
pub(crate) mod rows;
pub(crate) mod shape;
pub(crate) mod svd;
pub(crate) mod unrolled;
pub(crate) mod written;
