//! The run that a command is about: a log, or a model that is solved first; and the units that it is shown in.

use std::path::{Path, PathBuf};

use clap::Args;

use super::changes::Changes;
use super::{DrawingArgs, ModelArgs};

/// A log, or a model and how it is read.
#[derive(Args, Clone, Debug)]
pub struct RunArgs {
    /// A log, or a model or drawing, which is solved first; `-` is a model from standard input.
    #[arg(value_name = "LOG|MODEL")]
    pub input: PathBuf,
    /// How the model is read, and how its results are shown.
    #[command(flatten)]
    pub reading: ReadingArgs,
}

/// How a model is read that is solved first, and the units of results.
#[derive(Args, Clone, Debug, Default)]
pub struct ReadingArgs {
    /// Values in place of the model's.
    #[command(flatten)]
    pub set: Changes,
    /// How a drawing is read, and the units of what is shown.
    #[command(flatten)]
    pub drawing: DrawingArgs,
}

impl RunArgs {
    /// A file with nothing else said.
    pub fn of(input: &Path) -> Self {
        Self { input: input.to_owned(), reading: ReadingArgs::default() }
    }

    /// The model, as other commands take it.
    pub fn model(&self) -> ModelArgs {
        self.reading.model(&self.input)
    }
}

impl ReadingArgs {
    /// A model that is read so. `--units` is about what is shown, unless a drawing is read.
    pub fn model(&self, path: &Path) -> ModelArgs {
        let units = self.drawing.units.clone().filter(|_| bksim_load::is_drawn(path));
        let drawing = DrawingArgs { units, ..self.drawing.clone() };
        ModelArgs { model: path.to_owned(), set: self.set.clone(), drawing }
    }

    /// The units that results of this file are asked for in.
    pub fn shown(&self, path: &Path) -> Option<&str> {
        self.drawing.shown(path)
    }
}
