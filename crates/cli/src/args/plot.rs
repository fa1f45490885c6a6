//! The arguments of `bksim plot`.

use std::path::{Path, PathBuf};

use bksim_load::is_log;
use clap::{Args, ValueEnum};

use super::run::ReadingArgs;
use super::time::time;
use super::view::seconds;

/// Curves of runs. Names of logs, models and channels may stand in any order, the first log or model first.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Plot {
    /// Logs or models, which are solved first, and channels of them: `state.A_angle`, a whole topic `energy`, a
    /// pattern `reactions.*.fx`, or what the model can name, as `rod.B.x`; with a unit as `A.angle:deg`. An overview if
    /// there are no channels. Tables of measured values (CSV) are drawn as points next to them. Or the table of a sweep and outputs of it: curves, contours or points by what varies.
    #[arg(required = true, value_name = "LOG|MODEL|CHANNEL")]
    pub what: Vec<String>,
    /// How models are read, and in which units curves are drawn.
    #[command(flatten)]
    pub reading: ReadingArgs,
    /// Draw the path of this point, `coupler.P`: its y over its x, to one scale; may be repeated.
    #[arg(long, value_name = "POINT", conflicts_with = "x")]
    pub path: Vec<String>,
    /// Draw over this channel in place of the time.
    #[arg(long, value_name = "CHANNEL")]
    pub x: Option<String>,
    /// Draw from this time on, s.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = time)]
    pub from: Option<f64>,
    /// Draw up to this time, s.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = time)]
    pub to: Option<f64>,
    /// The picture; its ending chooses the format (.svg, .png, .pdf). Text on standard output if
    /// none.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Open a window to zoom into the curves and to read values.
    #[arg(long, conflicts_with = "output")]
    pub window: bool,
    /// Write a picture of the window as PNG, and close it.
    #[arg(long, value_name = "FILE", requires = "window")]
    pub screenshot: Option<PathBuf>,
    /// Take the picture so many seconds after the first frame.
    #[arg(long, value_name = "S", default_value_t = 0.5, requires = "screenshot",
          value_parser = seconds)]
    pub after: f64,
    /// Width and height: pixels of a PNG or a window, of 1/96 inch otherwise.
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(f64, f64)>,
    /// Colours; light ones for a picture and as the system wishes for a window unless given.
    #[arg(long, value_enum)]
    pub theme: Option<PlotTheme>,
    /// Title of the picture; the model's name unless given.
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
    /// Logarithms of the ordinates; what has none is left out.
    #[arg(long)]
    pub log_y: bool,
    /// Overwrite an existing file.
    #[arg(long)]
    pub force: bool,
}

impl Plot {
    /// The logs, models and tables among the words: the first, which was meant to be one, and those that are there.
    pub fn files(&self) -> Vec<PathBuf> {
        let is_file = |text: &&String| {
            let path = Path::new(text.as_str());
            let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
            is_log(path) || ["toml", "dxf", "dwg", "csv"].iter().any(|known| ending == *known)
        };
        let rest = self.what.iter().skip(1).filter(is_file);
        self.what.iter().take(1).chain(rest).map(PathBuf::from).collect()
    }

    /// The channels among the words.
    pub fn channels(&self) -> Vec<String> {
        let files = self.files();
        let is_channel =
            |text: &&String| !files.iter().any(|file| file == Path::new(text.as_str()));
        self.what.iter().filter(is_channel).cloned().collect()
    }
}

/// Colours of the picture.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum PlotTheme {
    /// On white.
    Light,
    /// On near black.
    Dark,
}

const EXAMPLES: &str = "\
Examples:
  bksim plot run.mcap
  bksim plot run.mcap --window
  bksim plot run.mcap energy -o energy.svg
  bksim plot model.toml A.angle:deg B.rate:rpm -o angles.pdf
  bksim plot run.mcap --path coupler.P --units mm -o path.png
  bksim plot run.mcap state.A_angle_dot --x state.A_angle -o phase.pdf
  bksim plot sweep.parquet 'max(energy.total)' -o sweep.svg
  bksim plot coarse.mcap fine.mcap energy.total --from 1 --to 2
  bksim plot model.toml measured.csv A.angle:deg -o beside.svg";

fn size(text: &str) -> Result<(f64, f64), String> {
    let side = |text: &str| text.parse::<u16>().ok().map(f64::from);
    let sides = text.split_once(['x', 'X', '×']);
    let sides = sides.and_then(|(width, height)| side(width).zip(side(height)));
    sides.ok_or_else(|| "expected a width and a height, such as 1200x800".to_owned())
}
