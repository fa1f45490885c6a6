//! The arguments of `bksim render`.

use std::path::{Path, PathBuf};

use bksim::analysis::About;
use bksim_scene::request::{Background, DENSITIES, FACTORS, MOST_GHOSTS, SIDES};
use bksim_scene::{Section, StandardView};
use clap::{Args, ValueEnum};

use super::changes::Changes;
use super::mode::ModeArgs;
use super::time::time;
use super::{DrawingArgs, ModelArgs};

/// Pictures show one instant; films show the motion from --from to --to.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Render {
    /// A log, or a model or drawing, which is solved first.
    #[arg(value_name = "LOG|MODEL")]
    pub input: PathBuf,
    /// The file; its ending chooses the format: .png, .svg, .gif, .mp4, .apng.
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Overwrite an existing file.
    #[arg(long)]
    pub force: bool,
    /// Values in place of the model's.
    #[command(flatten)]
    pub set: Changes,
    /// How a drawing is read.
    #[command(flatten)]
    pub drawing: DrawingArgs,
    /// The instant that a picture shows, s; the middle of the motion unless given.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = time)]
    pub at: Option<f64>,
    /// Where a film begins, s; at the start of the motion unless given.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = time)]
    pub from: Option<f64>,
    /// Where a film ends, s; at the end of the motion unless given.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = time)]
    pub to: Option<f64>,
    /// Width and height in pixels, such as 1280x720; else the mechanism chooses its shape.
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<[u32; 2]>,
    /// Pixels per point: how large lines and letters are. They grow with the picture unless given.
    #[arg(long, value_name = "FACTOR", value_parser = density)]
    pub density: Option<f32>,
    /// Frames a second of a film; 30, and 25 for GIF, unless given.
    #[arg(long, value_name = "N", value_parser = positive)]
    pub fps: Option<f64>,
    /// Seconds of motion in a second of film: 0.1 is slow motion; 1 unless given.
    #[arg(long, value_name = "FACTOR", value_parser = positive)]
    pub speed: Option<f64>,
    /// Background of the mechanism: light, dark, transparent, or a colour such as #fff8e7.
    #[arg(long, value_name = "COLOUR", default_value = "light", value_parser = background)]
    pub background: Background,
    /// Draw the mechanism faintly at N earlier instants, too.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(..=i64::from(MOST_GHOSTS)))]
    pub ghosts: u16,
    /// How far back ghosts and trails reach, s; to the start of the motion unless given.
    #[arg(long, value_name = "S", value_parser = past)]
    pub past: Option<f64>,
    /// Write names next to joints, points and centres of mass.
    #[arg(long)]
    pub labels: bool,
    /// Write this title in the upper left corner.
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
    /// Write the instant below it, in every frame of a film.
    #[arg(long)]
    pub time: bool,
    /// Write this caption below the mechanism.
    #[arg(long, value_name = "TEXT")]
    pub caption: Option<String>,
    /// Draw the way of this joint, point (`crank.P`) or centre of mass (`crank`); may be repeated.
    #[arg(long, value_name = "POINT")]
    pub trail: Vec<String>,
    /// Lay a curve of the whole motion over the mechanism: the way of a point (`coupler.P`),
    /// `centrode:coupler`, `swept:rocker`, `workspace:arm.P`; may be repeated.
    #[arg(long, value_name = "CURVE")]
    pub curve: Vec<String>,
    /// Lay the path of this point, `coupler.P`, over the mechanism: the same as --curve; may be repeated.
    #[arg(long, value_name = "POINT")]
    pub path: Vec<String>,
    /// Arrows, to one scale over the whole motion.
    #[arg(long, value_enum, value_name = "KINDS", value_delimiter = ',')]
    pub arrows: Vec<Arrows>,
    /// A mode in place of the run.
    #[command(flatten)]
    pub mode: ModeArgs,
    /// From where a spatial mechanism is seen: front, right, top, isometric, or azimuth and elevation in degrees.
    #[arg(long, value_name = "VIEW", value_parser = view, allow_hyphen_values = true)]
    pub view: Option<[f64; 2]>,
    /// Cut a spatial mechanism by a plane: "x = 20 mm" leaves out the side nearer to the eye, "x < 20 mm" keeps what
    /// is before it, ">" what is behind; or a normal and a point of the plane, "[1, 1, 0] = [10, 0, 5] mm".
    #[arg(long, value_name = "PLANE", value_parser = bksim::section::parse)]
    pub section: Option<Section>,
}

impl Render {
    /// The picture or film of a model with nothing else said.
    pub(crate) fn of(model: &ModelArgs, output: &Path) -> Self {
        Self {
            input: model.model.clone(),
            output: output.to_owned(),
            force: false,
            set: model.set.clone(),
            drawing: model.drawing.clone(),
            at: None,
            from: None,
            to: None,
            size: None,
            density: None,
            fps: None,
            speed: None,
            background: Background::default(),
            ghosts: 0,
            past: None,
            labels: false,
            title: None,
            time: false,
            caption: None,
            trail: Vec::new(),
            curve: Vec::new(),
            path: Vec::new(),
            arrows: Vec::new(),
            mode: ModeArgs { mode: None, amplitude: None, mode_at: About::Static },
            view: None,
            section: None,
        }
    }
}

const EXAMPLES: &str = "\
Examples:
  bksim render run.mcap -o start.png --at 0 --labels
  bksim render run.mcap -o motion.mp4 --size 1280x720 --speed 0.25
  bksim render model.toml -o motion.gif --trail rod.P --background dark
  bksim render run.mcap -o forces.svg --at 0.4 --arrows reactions,velocities
  bksim render run.mcap -o inside.png --section \"x = 20 mm\" --view isometric";

/// Which arrows are drawn.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum Arrows {
    /// Joint reactions on the second bodies.
    Reactions,
    /// Velocities of points and centres of mass.
    Velocities,
    /// Applied forces.
    Forces,
}

fn background(text: &str) -> Result<Background, String> {
    text.parse().map_err(str::to_owned)
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let wrong = || "expected width and height from 16 to 16384, such as 1280x720".to_owned();
    let (width, height) = text.split_once(['x', 'X', '×']).ok_or_else(wrong)?;
    let side = |text: &str| text.trim().parse().ok().filter(|n| SIDES.contains(n));
    side(width).zip(side(height)).map(|(w, h)| [w, h]).ok_or_else(wrong)
}

fn past(text: &str) -> Result<f64, String> {
    let value = time(text).ok().filter(|x| FACTORS.contains(x));
    let wrong = "expected a time from 0.000001 to 1000000 s, such as 0.5 or `500 ms`";
    value.ok_or_else(|| wrong.to_owned())
}

fn positive(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|x| FACTORS.contains(x));
    value.ok_or_else(|| "expected a number from 0.000001 to 1000000".to_owned())
}

fn density(text: &str) -> Result<f32, String> {
    let value = text.parse::<f32>().ok().filter(|x| DENSITIES.contains(x));
    value.ok_or_else(|| "expected a number from 0.25 to 8".to_owned())
}

fn view(text: &str) -> Result<[f64; 2], String> {
    if let Some(view) = StandardView::named(text) {
        return Ok(view.angles_deg());
    }
    let wrong = || {
        let names = StandardView::ALL.map(StandardView::word).join(", ");
        format!("expected {names}, or azimuth and elevation in degrees, such as 30,20")
    };
    let (azimuth, elevation) = text.split_once(',').ok_or_else(wrong)?;
    let angle = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.abs() <= 360.0);
    angle(azimuth).zip(angle(elevation)).map(|(a, e)| [a, e]).ok_or_else(wrong)
}
