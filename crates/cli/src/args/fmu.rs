//! `bksim fmu`: a model as a functional mock-up unit.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::ModelArgs;

#[derive(Args, Debug)]
pub(crate) struct Fmu {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// The version of the standard.
    #[arg(long, value_enum, default_value_t = Fmi::Three)]
    pub(crate) fmi: Fmi,
    /// A parameter that loads depend on, as an input; may be repeated. Without it the inputs of `[io]`.
    #[arg(long, value_name = "NAME")]
    pub(crate) input: Vec<String>,
    /// An output: a measure, a signal, a reaction; may be repeated. Without it those of `[io]`, or all positions and
    /// rates.
    #[arg(long = "of", value_name = "NAME")]
    pub(crate) of: Vec<String>,
    /// Leave out the program for this machine: importers compile the source.
    #[arg(long)]
    pub(crate) sources: bool,
    /// The compiler of C.
    #[arg(long, value_name = "PROGRAM", default_value = "cc")]
    pub(crate) compiler: PathBuf,
    /// The unit, a file that ends with `.fmu`.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Overwrite an existing file.
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub(crate) enum Fmi {
    /// FMI 2.0.
    #[value(name = "2")]
    Two,
    /// FMI 3.0.
    #[value(name = "3")]
    Three,
}
