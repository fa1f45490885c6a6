//! [`View`]: the way in which a page sees the mechanism.

use serde::Deserialize;

/// A camera with the colours of a page.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct View {
    /// In the middle of the picture, m.
    pub(crate) centre: [f64; 3],
    /// Pixels for each metre.
    pub(crate) scale: f64,
    /// To the right, up, and towards the eye.
    pub(crate) rows: [[f64; 3]; 3],
    /// Width and height, pixels.
    pub(crate) size: [f64; 2],
    pub(crate) is_dark: bool,
    pub(crate) has_names: bool,
}
