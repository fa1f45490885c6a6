//! Equations: identities, recursions, and the letters of the comments.

mod identities;
mod notation;
mod recursion;
