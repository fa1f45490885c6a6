//! The arguments of `bksim page`.

use std::path::PathBuf;

use clap::Args;

/// A run as one page of HTML.
#[derive(Args, Debug)]
pub struct Page {
    /// The log.
    pub log: PathBuf,
    /// The page; LOG's name with the ending .html, in the working directory, unless given.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Heading of the page; the model's name unless given.
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
    /// Overwrite an existing file.
    #[arg(long)]
    pub force: bool,
}
