//! The arguments of the commands of `bksim cad` that write drawings.

use std::path::PathBuf;

use bksim::cad::write::Release;
use clap::Args;

use super::time::time;
use super::{DrawingArgs, assignment};

#[derive(Args, Debug)]
pub(crate) struct Destination {
    /// The drawing to write (DXF).
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Overwrite an existing file.
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Args, Debug)]
pub(crate) struct Style {
    /// Release of the format: R12, R2000, R2004, R2007, R2010, R2013 or R2018.
    #[arg(long, value_name = "RELEASE", default_value = "R2010", value_parser = release)]
    pub(crate) dxf_version: Release,
    /// Length of one unit of the drawing: mm, cm, m, inch or ft.
    #[arg(long, value_name = "UNIT", default_value = "mm",
          value_parser = ["mm", "cm", "m", "inch", "ft"])]
    pub(crate) units: String,
}

/// A drawing with the blocks ready to insert, and layers to draw on.
#[derive(Args, Debug)]
pub(crate) struct Template {
    #[command(flatten)]
    pub(crate) written: Destination,
    #[command(flatten)]
    pub(crate) style: Style,
    /// Size of the symbols, in drawing units; 10 mm or a round size near it unless given.
    #[arg(long, value_name = "SIZE", value_parser = size)]
    pub(crate) size: Option<f64>,
}

#[derive(Args, Debug)]
pub(crate) struct FromToml {
    /// The model file.
    pub(crate) model: PathBuf,
    /// Give a parameter another value: a number, a quantity such as "25 mm", or an expression.
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = assignment)]
    pub(crate) set: Vec<(String, String)>,
    #[command(flatten)]
    pub(crate) written: Destination,
    #[command(flatten)]
    pub(crate) style: Style,
}

/// With none of the choices, all of them are drawn.
#[derive(Args, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is an option that is given or not")]
pub(crate) struct Trace {
    /// The log of the run.
    pub(crate) log: PathBuf,
    /// The drawing (DXF).
    pub(crate) drawing: PathBuf,
    #[command(flatten)]
    pub(crate) reading: DrawingArgs,
    #[command(flatten)]
    pub(crate) written: Destination,
    /// Points to follow, such as rod.B; a body alone is its centre of mass. All named points that
    /// move unless given.
    #[arg(long, value_name = "BODY.POINT", value_delimiter = ',')]
    pub(crate) points: Vec<String>,
    /// Times of the reactions, s; four even ones unless given.
    #[arg(long, value_name = "S", value_delimiter = ',', allow_negative_numbers = true,
          value_parser = time)]
    pub(crate) at: Vec<f64>,
    /// Draw a curve of the whole motion: the way of a point (`coupler.P`), `centrode:coupler`, `swept:rocker`,
    /// `workspace:arm.P`; may be repeated.
    #[arg(long, value_name = "CURVE")]
    pub(crate) curve: Vec<String>,
    /// Draw the curves of the points.
    #[arg(long)]
    pub(crate) paths: bool,
    /// Draw what each body sweeps.
    #[arg(long)]
    pub(crate) envelope: bool,
    /// Draw the velocities of the points as curves.
    #[arg(long)]
    pub(crate) hodograph: bool,
    /// Draw the forces in the joints.
    #[arg(long)]
    pub(crate) reactions: bool,
    /// Draw the bodies at so many even times; six unless given.
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "6",
          value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub(crate) ghosts: Option<u16>,
}

fn release(text: &str) -> Result<Release, String> {
    Release::by_name(text)
        .ok_or_else(|| "expected R12, R2000, R2004, R2007, R2010, R2013 or R2018".to_owned())
}

fn size(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(size) if size.is_finite() && size > 0.0 => Ok(size),
        _ => Err("expected a number greater than zero".to_owned()),
    }
}
