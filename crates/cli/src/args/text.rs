//! The arguments of commands whose answer is a text, which is printed or written to a file.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::{Command, ModelArgs, Switch};

/// The file that a printed answer goes to.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct TextFile {
    /// Write the answer to this file in place of standard output.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Overwrite an existing file.
    #[arg(long, requires = "output")]
    pub(crate) force: bool,
}

/// A model that is asked about.
#[derive(Args, Debug)]
pub(crate) struct ModelText {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    #[command(flatten)]
    pub(crate) file: TextFile,
}

impl Command {
    /// The file that the text of the command goes to, with the command's name and whether a file may be replaced.
    pub(crate) fn text_file(&self) -> Option<(&'static str, &Path, bool)> {
        let (name, file) = match self {
            Self::Check(args) => ("check", &args.file),
            Self::Assemble(args) => ("assemble", &args.file),
            Self::Expand(args) => ("expand", &args.file),
            Self::Parts(args) => ("parts", &args.file),
            Self::Equations(args) => ("equations", &args.file),
            Self::Expr(args) => ("expr", &args.file),
            Self::Info(args) => ("info", &args.file),
            Self::Explain(args) => ("explain", &args.file),
            Self::Schema(file) => ("schema", file),
            Self::Completions(args) => ("completions", &args.file),
            _ => return None,
        };
        Some((name, file.output.as_deref()?, file.force))
    }
}

#[derive(Args, Debug)]
pub(crate) struct Parts {
    /// Name of a part, to print its model.
    pub(crate) name: Option<String>,
    #[command(flatten)]
    pub(crate) file: TextFile,
}

#[derive(Args, Debug)]
pub(crate) struct Expand {
    /// The model file, or a drawing (DXF, DWG) with one next to it.
    pub(crate) model: PathBuf,
    #[command(flatten)]
    pub(crate) file: TextFile,
}

#[derive(Args, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is an option that is given or not")]
pub(crate) struct Equations {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// How formulas are written; as text, unless the name of the file says otherwise: a document in .tex, .typ or .html,
    /// or .json.
    #[arg(long, value_enum)]
    pub(crate) format: Option<Format>,
    /// Write a complete document that typesets as it is: an article, a Typst file, an HTML page.
    #[arg(long)]
    pub(crate) document: bool,
    /// The angles that equations are in: those of the joints, in which the model is solved, or in the plane those of the
    /// bodies against the ground.
    #[arg(long, value_enum, default_value_t = Angles::Relative, value_name = "KIND")]
    pub(crate) angles: Angles,
    /// Add the derivation step by step: centres of mass, kinetic energies, the Lagrangian, its derivatives, and the forces
    /// of loads and constraints.
    #[arg(long)]
    pub(crate) steps: bool,
    /// Add the velocity and acceleration equations of the constraints, in letters and with the numbers of the start.
    #[arg(long)]
    pub(crate) levels: bool,
    /// Add the balances of forces and moments of each body that is cut free, by Newton and Euler, with the reactions of
    /// its joints.
    #[arg(long)]
    pub(crate) free_bodies: bool,
    /// Add the effort of the only drive in explicit form: the velocities of all coordinates by that of the drive, and the
    /// effort by them.
    #[arg(long)]
    pub(crate) effort: bool,
    /// Whether constants that take more than one operation get names of their own.
    #[arg(long, value_enum, default_value_t = Switch::On, value_name = "SWITCH")]
    pub(crate) groups: Switch,
    /// With `--format aligned`: Greek letters, dots and indices instead of identifiers.
    #[arg(long)]
    pub(crate) unicode: bool,
    /// With `--format aligned`: characters of a line; the terminal's unless given, or 100.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(20..))]
    pub(crate) width: Option<u16>,
    #[command(flatten)]
    pub(crate) file: TextFile,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub(crate) enum Angles {
    /// Of a joint's second body against its first.
    Relative,
    /// Of a body against the ground.
    Absolute,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub(crate) enum Format {
    /// Infix text, one line for each formula; reads back.
    Text,
    /// Text in columns, in lines that fit the terminal.
    Aligned,
    /// LaTeX, one aligned block per group.
    Latex,
    /// Typst, one aligned block per group.
    Typst,
    /// MathML, one element per group; the document is an HTML page.
    Mathml,
    /// Short form of --format json.
    Json,
}

#[derive(Args, Debug)]
pub(crate) struct Explain {
    /// The code, such as M012; without one, all codes are listed.
    pub(crate) code: Option<String>,
    #[command(flatten)]
    pub(crate) file: TextFile,
}
