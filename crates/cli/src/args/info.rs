//! The arguments of `bksim info`.

use clap::Args;

use super::run::RunArgs;
use super::text::TextFile;

/// Contents of a log: its model, options and channels, and how its run ended. Any MCAP file will do; a model is solved
/// first.
#[derive(Args, Debug)]
pub(crate) struct Info {
    #[command(flatten)]
    pub(crate) run: RunArgs,
    #[command(flatten)]
    pub(crate) file: TextFile,
}
