//! Algebra: passes over the graph, folding and simplification, cancellation, series and equations.

mod budget;
mod cancel;
mod certificate;
mod chains;
mod construction;
mod determinism;
mod folding;
mod functions;
mod graph;
mod identities;
mod series;
mod simplify;
mod solve;
mod values;
