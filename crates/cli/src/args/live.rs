//! The arguments of `bksim edit`.

use std::path::PathBuf;

use clap::Args;

/// A model under the hand.
#[derive(Args, Debug)]
pub struct Edit {
    /// The model file, which is written when the page says so.
    #[arg(value_name = "MODEL")]
    pub model: PathBuf,
    /// Port of the page on this computer; a free one unless given.
    #[arg(long, value_name = "PORT", default_value_t = 0, conflicts_with = "apply")]
    pub port: u16,
    /// Show the lines of this drawing (DXF, DWG) under the mechanism, to draw over.
    #[arg(long, value_name = "DRAWING", conflicts_with = "apply")]
    pub under: Option<PathBuf>,
    /// Unit of the drawing underneath, if it does not say it: `mm`, `inch`.
    #[arg(long, value_name = "UNIT", requires = "under")]
    pub units: Option<String>,
    /// Make this edit, written as JSON, and write the file, without a page: `{"edit": "rename", "name": "rod", "to":
    /// "coupler"}`; may be repeated.
    #[arg(long, value_name = "EDIT")]
    pub apply: Vec<String>,
}
