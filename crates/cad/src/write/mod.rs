//! Drawings that are written: blocks to insert, whole drawings of models, and traces of runs.
//!
//! New drawings are built on a [`Canvas`] and written by `acadrust`; additions to a drawing that
//! exists are spliced into its bytes, so that everything else stays as it was.

mod blocks;
mod canvas;
pub mod from_model;
pub mod graft;
pub mod profile;
mod prompt;
mod symbol;
pub mod template;
pub mod trace;

pub(crate) use canvas::Mark;
pub use canvas::{Canvas, Release, WriteError};

pub use crate::attach::LEGEND_LAYER;

/// Name, code of `$INSUNITS`, metres, and the usual size of a symbol, in units.
pub(crate) const UNITS: &[(&str, i16, f64, f64)] = &[
    ("mm", 4, 1e-3, 10.0),
    ("cm", 5, 1e-2, 2.0),
    ("m", 6, 1.0, 0.1),
    ("inch", 1, 0.0254, 0.5),
    ("ft", 2, 0.3048, 0.25),
];
