//! The arguments of `bksim page`.

use std::path::PathBuf;

use clap::Args;

use super::mode::ModeArgs;
use super::run::RunArgs;

/// A run as one page of HTML.
#[derive(Args, Debug)]
pub struct Page {
    /// The run.
    #[command(flatten)]
    pub run: RunArgs,
    /// The page; the name of the log or model with the ending .html, in the working directory, unless given.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Heading of the page; the model's name unless given.
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
    /// Lay a curve of the whole motion over the mechanism: the way of a point (`coupler.P`),
    /// `centrode:coupler`, `swept:rocker`, `workspace:arm.P`; may be repeated.
    #[arg(long, value_name = "CURVE")]
    pub curve: Vec<String>,
    /// Lay the path of this point, `coupler.P`, over the mechanism: the same as --curve; may be repeated.
    #[arg(long, value_name = "POINT")]
    pub path: Vec<String>,
    /// Show all ways in which the start closes as small pictures next to each other.
    #[arg(long)]
    pub assemblies: bool,
    /// Write a live page: the mechanism can be dragged, drawn, changed and solved in it, and its text downloaded.
    #[arg(long, conflicts_with_all = ["curve", "path", "assemblies"])]
    pub live: bool,
    /// Show the lines of this drawing (DXF, DWG) under the mechanism of a live page, to draw over; `--units` states its unit.
    #[arg(long, value_name = "DRAWING", requires = "live")]
    pub under: Option<PathBuf>,
    /// A mode in place of the run.
    #[command(flatten)]
    pub mode: ModeArgs,
    /// Overwrite an existing file.
    #[arg(long)]
    pub force: bool,
}
