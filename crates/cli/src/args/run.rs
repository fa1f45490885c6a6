//! The run that a command is about: a log, or a model that is solved first; and the units that it is shown in.

use std::path::{Path, PathBuf};

use clap::Args;

use super::{DrawingArgs, ModelArgs, assignment};

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
    /// Give a parameter of a model another value: a number, a quantity such as "25 mm", or an expression.
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = assignment)]
    pub set: Vec<(String, String)>,
    /// Units of what is shown, such as "mm, deg, rpm, kN"; `si` for SI, `model` for those of the model's `[units]`. Of a
    /// drawing, the length of its unit: use --in there.
    #[arg(long, value_name = "UNITS")]
    pub units: Option<String>,
    /// Units of what is shown, of drawings, too.
    #[arg(long = "in", value_name = "UNITS")]
    pub shown: Option<String>,
    /// Points of a drawing nearer than this, in its units, are one; a ten-thousandth of its size unless given.
    #[arg(long, value_name = "LENGTH", value_parser = super::tolerance)]
    pub tolerance: Option<f64>,
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
        let units = self.units.clone().filter(|_| bksim_load::is_drawn(path));
        let drawing = DrawingArgs { units, tolerance: self.tolerance };
        ModelArgs { model: path.to_owned(), set: self.set.clone(), drawing }
    }

    /// The units that results of this file are asked for in.
    pub fn shown(&self, path: &Path) -> Option<&str> {
        let units = || self.units.as_deref().filter(|_| !bksim_load::is_drawn(path));
        self.shown.as_deref().or_else(units)
    }
}
