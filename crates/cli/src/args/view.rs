//! The arguments of `bksim view`.

use std::path::PathBuf;

use bksim_scene::Section;
use clap::{ArgAction, Args};

use super::mode::ModeArgs;
use super::run::ReadingArgs;
use super::time::time;

/// A model or a log moving, in a window.
#[derive(Args, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is an option that is given or not")]
pub struct View {
    /// A log, a model file, or a drawing (DXF, DWG); it is watched, and shown again when it changes.
    #[arg(value_name = "MODEL|LOG")]
    pub input: PathBuf,
    /// How a model is read, and in which units values are shown.
    #[command(flatten)]
    pub reading: ReadingArgs,
    /// Lay a curve of the whole motion over the mechanism: the way of a point (`coupler.P`),
    /// `centrode:coupler`, `swept:rocker`, `workspace:arm.P`; may be repeated.
    #[arg(long, value_name = "CURVE")]
    pub curve: Vec<String>,
    /// Lay the path of this point, `coupler.P`, over the mechanism: the same as --curve; may be repeated.
    #[arg(long, value_name = "POINT")]
    pub path: Vec<String>,
    /// A mode in place of the run.
    #[command(flatten)]
    pub mode: ModeArgs,
    /// Cut a spatial mechanism by a plane at first: "x = 20 mm" leaves out the side nearer to the eye, "x < 20 mm"
    /// keeps what is before it, ">" what is behind; or a normal and a point, "[1, 1, 0] = [10, 0, 5] mm".
    #[arg(long, value_name = "PLANE", value_parser = bksim::section::parse)]
    pub section: Option<Section>,
    /// The instant to begin at, s; that of the motion unless given.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = instant)]
    pub t: Option<f64>,
    /// Stand still at first.
    #[arg(long)]
    pub paused: bool,
    /// Width and height of the window.
    #[arg(long, value_name = "WxH", default_value = "1200x760", value_parser = size)]
    pub size: [f32; 2],
    /// Light on dark; as the system wishes unless given.
    #[arg(long, conflicts_with = "light")]
    pub dark: bool,
    /// Dark on light; as the system wishes unless given.
    #[arg(long)]
    pub light: bool,
    /// Write a picture of the window as PNG, and close it.
    #[arg(long, value_name = "FILE")]
    pub screenshot: Option<PathBuf>,
    /// Take the picture so many seconds after the first frame.
    #[arg(long, value_name = "S", default_value_t = 0.5, requires = "screenshot",
          value_parser = seconds)]
    pub after: f64,
    /// Overwrite an existing picture.
    #[arg(long, requires = "screenshot", action = ArgAction::SetTrue)]
    pub force: bool,
    /// Close the window after so many frames, and say how fast they were.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: Option<u32>,
}

fn instant(text: &str) -> Result<f64, String> {
    match time(text) {
        Ok(t) if t.is_finite() => Ok(t),
        _ => {
            Err("expected a time, in seconds or with its unit, such as 0.5 or `500 ms`".to_owned())
        }
    }
}

/// A time to wait, s.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    match time(text) {
        Ok(s) if (0.0..=3600.0).contains(&s) => Ok(s),
        _ => Err("expected seconds, 0 to 3600".to_owned()),
    }
}

/// Smallest and largest side of a window, points.
const SIDES: std::ops::RangeInclusive<f32> = 200.0..=10_000.0;

fn size(text: &str) -> Result<[f32; 2], String> {
    let side = |side: &str| side.parse::<f32>().ok().filter(|side| SIDES.contains(side));
    let sides = text.split_once('x').and_then(|(w, h)| Some([side(w)?, side(h)?]));
    sides.ok_or_else(|| "expected a width and a height from 200, such as 1200x760".to_owned())
}
