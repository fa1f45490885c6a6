//! What can be written after `bksim page`.

use std::path::PathBuf;

use clap::Args;

#[derive(Args, Debug)]
pub(crate) struct Page {
    /// The log.
    pub(crate) log: PathBuf,
    /// The page; LOG's name with the ending .html, in the working directory, unless given.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Heading of the page; the model's name unless given.
    #[arg(long, value_name = "TEXT")]
    pub(crate) title: Option<String>,
    /// Overwrite an existing file.
    #[arg(long)]
    pub(crate) force: bool,
}
