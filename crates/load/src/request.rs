//! A request to [`load`](crate::load()) a model.

use std::path::Path;

use bksim::model::file::Limits;

/// A model to load, and how.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// A model file or a drawing.
    pub path: &'a Path,
    /// Definitions in place of those of parameters.
    pub overrides: &'a [(String, String)],
    /// The unit of a drawing that states none, `mm`.
    pub unit: Option<&'a str>,
    /// How far apart points of a drawing may be that are one, in units of the drawing.
    pub tolerance: Option<f64>,
    /// Limits on the text of a model.
    pub limits: Limits,
    /// True if positions alone are asked for: bodies need no masses then.
    pub is_geometry: bool,
}

impl<'a> Request<'a> {
    /// The file as it is.
    pub fn new(path: &'a Path) -> Self {
        Self {
            path,
            overrides: &[],
            unit: None,
            tolerance: None,
            limits: Limits::default(),
            is_geometry: false,
        }
    }
}
