//! Linear algebra behind one door: dense for small mechanisms, by sparse elimination for large ones.
//!
//! | file | holds |
//! | --- | --- |
//! | `shape` | the entries that M and G have |
//! | `dense` | smallest solutions and rank of dense rows |
//! | `rows` | sparse rows, their smallest solutions |
//! | `rank` | rows that depend on others, and how near others are to it |
//! | `elimination` | the multiplier system by recorded elimination |
//! | `augmented` | the same with massless coordinates |
//! | `unrolled` | the same as straight-line code of small mechanisms |

pub(crate) mod augmented;
pub(crate) mod dense;
pub(crate) mod elimination;
pub(crate) mod rank;
pub(crate) mod rows;
pub(crate) mod shape;
pub(crate) mod unrolled;
