//! The arguments of `bksim info`.

use std::path::PathBuf;

use clap::Args;

/// Contents of a log: its model, options and channels, and how its run ended.
#[derive(Args, Debug)]
pub(crate) struct Info {
    /// The log; any MCAP file will do.
    pub(crate) log: PathBuf,
}
