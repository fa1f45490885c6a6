//! The arguments of `bksim completions` and `bksim man`.

use std::path::PathBuf;

use clap::Args;
use clap_complete::Shell;

use super::text::TextFile;

/// Completions of commands, options and files for a shell.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Completions {
    /// The shell.
    #[arg(value_enum)]
    pub(crate) shell: Shell,
    #[command(flatten)]
    pub(crate) file: TextFile,
}

const EXAMPLES: &str = "\
Examples:
  bksim completions bash > ~/.local/share/bash-completion/completions/bksim
  bksim completions zsh > ~/.zfunc/_bksim
  bksim completions fish > ~/.config/fish/completions/bksim.fish";

/// Manual pages.
#[derive(Args, Debug)]
pub(crate) struct Man {
    /// The command, such as `solve` or `cad list`; the page of bksim itself if none.
    pub(crate) command: Vec<String>,
    /// Write the pages of all commands into this folder: `bksim.1`, `bksim-solve.1`, …
    #[arg(short, long, value_name = "FOLDER", conflicts_with = "command")]
    pub(crate) output: Option<PathBuf>,
}
