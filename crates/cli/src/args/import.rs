//! The arguments of `bksim import`.

use std::path::PathBuf;

use clap::Args;

#[derive(Args, Debug)]
pub(crate) struct Import {
    /// The file (URDF, MJCF, SDF, Adams `.adm`), or a link of PMKS+ in quotes.
    pub(crate) file: PathBuf,
    /// The model file; standard output unless given.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Folder in which `package://NAME` and `model://NAME` are looked for; may be given several times.
    #[arg(long = "path", value_name = "FOLDER")]
    pub(crate) paths: Vec<PathBuf>,
    /// Let the first link of a robot in URDF move freely, in place of fixing it to the ground.
    #[arg(long)]
    pub(crate) free: bool,
    /// Overwrite an existing file.
    #[arg(long)]
    pub(crate) force: bool,
}
