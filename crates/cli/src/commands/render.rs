//! `bksim render`: pictures and films of a motion, without a window.

mod motion;
mod write;

use std::path::Path;
use std::time::Instant;

use bksim_scene::{Color, MarkerKind, Theme};
use bksim_view::film::{Clip, FilmFormat, Stage, shape};
use bksim_view::offscreen::Canvas;
use bksim_view::show::{Show, ShowOptions};
use serde_json::{Value, json};

use self::motion::Opened;
use self::write::{Made, Replacing};
use crate::args::ModelArgs;
use crate::args::render::{Arrows, Background, Render};
use crate::exit::{Failure, Status};
use crate::output;
use crate::progress::StopWish;

/// What is written.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Format {
    Png,
    Svg,
    Film(FilmFormat),
}

/// The longer side of a picture, points, at which lines and letters have the size that suits them.
const POINTS: f64 = 640.0;

impl Format {
    const ALL: [(&str, Self); 5] = [
        ("png", Self::Png),
        ("svg", Self::Svg),
        ("gif", Self::Film(FilmFormat::Gif)),
        ("mp4", Self::Film(FilmFormat::Mp4)),
        ("apng", Self::Film(FilmFormat::Apng)),
    ];

    fn of(path: &Path) -> Result<(&'static str, Self), Failure> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        let known = Self::ALL.into_iter().find(|(name, _)| Some(*name) == ending.as_deref());
        known.ok_or_else(|| {
            let message = format!("`{}` does not say what it should be", path.display());
            let help =
                "end its name with .png or .svg for a picture, .gif, .mp4 or .apng for a film";
            Failure::usage(message, help)
        })
    }

    /// The longer side of a picture of which no size is given, pixels.
    fn usual_length(self) -> f64 {
        match self {
            Self::Svg | Self::Film(FilmFormat::Gif) => POINTS,
            _ => 2.0 * POINTS,
        }
    }

    /// Pixels per point when none are given: the longer side of a picture has [`POINTS`], so that a large
    /// picture is a small one enlarged. The units of SVG are points.
    fn usual_density(self, [width, height]: [u32; 2]) -> f32 {
        #[expect(clippy::cast_possible_truncation, reason = "pixels")]
        let per_point = (f64::from(width.max(height)) / POINTS) as f32;
        if self == Self::Svg { 1.0 } else { per_point.max(0.25) }
    }

    fn fitting(self, size: [u32; 2]) -> [u32; 2] {
        if let Self::Film(film) = self { film.fitting(size) } else { size }
    }
}

pub(crate) fn run(args: &Render, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let begun = Instant::now();
    let (name, format) = Format::of(&args.output)?;
    check_times(args, format)?;
    let replacing = Replacing::check(&args.output, &args.input, args.force)?;
    let model = ModelArgs {
        model: args.input.clone(),
        set: args.set.clone(),
        drawing: args.drawing.clone(),
    };
    let stop = StopWish::watch().map_err(|e| Failure::writing(&args.output, &e))?;
    let opened = motion::open(&model, nesting, as_json, &stop)?;
    if let Some(status) = stop.status() {
        return Ok(status);
    }
    let Opened { mut show, is_complete, diagnostics } = opened;
    show.options = options(args, &show)?;
    let clip = clip(args, &show, format)?;
    if args.view.is_some() && show.scene().is_planar {
        return Err(Failure::usage(
            "--view is for spatial mechanisms, and this one is planar",
            "leave it out",
        ));
    }

    // The picture, and from where it is seen.
    let unreplayed = |e| motion::unreplayed(&args.input, e);
    let size = match args.size {
        Some(size) => size,
        None => usual_size(format, shape(&mut show, args.view).map_err(unreplayed)?),
    };
    let size = format.fitting(size);
    let density = args.density.unwrap_or_else(|| format.usual_density(size));
    let points = size.map(|n| f64::from(n) / f64::from(density));
    let theme = theme(args.background);
    let mut stage = Stage::new(show, theme, args.view, points).map_err(unreplayed)?;
    stage.is_transparent = args.background == Background::Transparent;

    let mut canvas = None;
    if format != Format::Svg {
        let mut opened = Canvas::new(size, density).map_err(|e| write::undrawn(args, &e))?;
        opened.scene_mut().set_scene(std::sync::Arc::clone(stage.show.scene()), &theme);
        canvas = Some(opened);
    }
    let made = match (format, &mut canvas) {
        (Format::Png, Some(canvas)) => write::png(args, replacing, &mut stage, canvas, clip.from)?,
        (Format::Film(film), Some(canvas)) => {
            write::film(args, replacing, &mut stage, canvas, (film, &clip), &stop)?
        }
        _ => write::svg(args, replacing, &mut stage, clip.from)?,
    };
    let n_bytes = match made {
        Made::Written { n_bytes } => n_bytes,
        Made::Stopped(status) => return Ok(status),
    };
    let report = Report { args, name, format, size, clip, n_bytes };
    let adapter = canvas.as_ref().map(Canvas::adapter);
    if as_json {
        let mut body = report.describe(adapter, begun);
        body["complete"] = is_complete.into();
        body["diagnostics"] = diagnostics;
        output::json("render", body)?;
    } else {
        output::text(&report.text(begun))?;
    }
    Ok(Status::Done)
}

/// What was made.
struct Report<'a> {
    args: &'a Render,
    name: &'static str,
    format: Format,
    size: [u32; 2],
    clip: Clip,
    n_bytes: u64,
}

impl Report<'_> {
    fn n_frames(&self) -> usize {
        if let Format::Film(_) = self.format { self.clip.n_frames() } else { 1 }
    }

    fn describe(&self, adapter: Option<&str>, begun: Instant) -> Value {
        let Self { args, size: [width, height], clip, .. } = self;
        let film = matches!(self.format, Format::Film(_));
        json!({
            "output": args.output.display().to_string(),
            "format": self.name,
            "width": width,
            "height": height,
            "frames": self.n_frames(),
            "from": clip.from,
            "to": film.then(|| clip.time(self.n_frames() - 1)),
            "fps": film.then_some(clip.fps),
            "speed": film.then_some(clip.speed),
            "bytes": self.n_bytes,
            "adapter": adapter,
            "seconds": begun.elapsed().as_secs_f64(),
        })
    }

    fn text(&self, begun: Instant) -> String {
        let [width, height] = self.size;
        let path = self.args.output.display();
        let kilobytes = self.n_bytes.div_ceil(1000);
        let seconds = begun.elapsed().as_secs_f64();
        if let Format::Film(_) = self.format {
            let n = self.n_frames();
            let long = n as f64 / self.clip.fps;
            return format!(
                "wrote {path}: {width}x{height}, {n} frames, {long:.1} s, {kilobytes} kB, \
                 in {seconds:.1} s"
            );
        }
        let t = output::number(self.clip.from);
        format!("wrote {path}: {width}x{height}, t = {t} s, {kilobytes} kB, in {seconds:.1} s")
    }
}

/// Refuses options of films for pictures, and the other way round.
fn check_times(args: &Render, format: Format) -> Result<(), Failure> {
    let is_film = matches!(format, Format::Film(_));
    if is_film && args.at.is_some() {
        return Err(Failure::usage(
            "--at is for pictures, and this is a film",
            "say where it begins and ends with --from and --to",
        ));
    }
    let of_films = args.from.is_some() || args.to.is_some() || args.fps.is_some();
    if !is_film && (of_films || args.speed != 1.0) {
        return Err(Failure::usage(
            "--from, --to, --fps and --speed are for films, and this is a picture",
            "choose its instant with --at",
        ));
    }
    Ok(())
}

/// The instants that are shown.
fn clip(args: &Render, show: &Show, format: Format) -> Result<Clip, Failure> {
    let [first, last] = show.span();
    let within = |option: &str, t: f64| {
        if t >= first.min(last) && t <= first.max(last) {
            return Ok(t);
        }
        let help = format!("the motion goes from {first} s to {last} s");
        Err(Failure::usage(format!("`{option} {t}` lies outside of the motion"), &help))
    };
    let Format::Film(film) = format else {
        let t = args.at.map_or(Ok(0.5 * (first + last)), |t| within("--at", t))?;
        return Ok(Clip { from: t, to: t, fps: 1.0, speed: 1.0 });
    };
    let from = args.from.map_or(Ok(first), |t| within("--from", t))?;
    let to = args.to.map_or(Ok(last), |t| within("--to", t))?;
    let fps = args.fps.unwrap_or_else(|| film.usual_fps());
    let clip = Clip { from, to, fps, speed: args.speed };
    if clip.n_frames() > LARGEST_FILM {
        let message = format!("the film would have {} frames", clip.n_frames());
        let help = "show a part of the motion with --from and --to, or raise --speed";
        return Err(Failure::usage(message, help));
    }
    Ok(clip)
}

/// Nobody waits for more frames: half a day of film.
const LARGEST_FILM: usize = 1_000_000;

fn options(args: &Render, show: &Show) -> Result<ShowOptions, Failure> {
    let has = |kind| args.arrows.contains(&kind);
    let trails = args.trail.iter().map(|name| marker(show, name)).collect::<Result<_, _>>()?;
    Ok(ShowOptions {
        labels: args.labels,
        trails,
        past_s: args.past.unwrap_or(f64::INFINITY),
        reactions: has(Arrows::Reactions),
        velocities: has(Arrows::Velocities),
        forces: has(Arrows::Forces),
        ghosts: usize::from(args.ghosts),
        dark: theme(args.background).is_dark,
    })
}

/// The marker of this name; a body's is its centre of mass.
fn marker(show: &Show, name: &str) -> Result<usize, Failure> {
    let markers = &show.scene().markers;
    markers.iter().position(|marker| marker.name == name).ok_or_else(|| {
        let known: Vec<String> =
            markers.iter().map(|marker| format!("`{}`", marker.name)).take(30).collect();
        let joints = markers.iter().filter(|m| matches!(m.kind, MarkerKind::Joint(_))).count();
        let help = format!("{} joints and points have names: {}", joints, known.join(", "));
        let help = if known.is_empty() { "nothing in it has a name".to_owned() } else { help };
        Failure::usage(format!("nothing that can leave a trail is called `{name}`"), &help)
    })
}

/// A colour decides by how bright it is which lines are seen on it.
fn theme(background: Background) -> Theme {
    match background {
        Background::Light | Background::Transparent => Theme::LIGHT,
        Background::Dark => Theme::DARK,
        Background::Color(rgb) => {
            let [_, r, g, b] = rgb.to_be_bytes().map(f64::from);
            // Luma of BT.601.
            let is_dark = 0.299 * r + 0.587 * g + 0.114 * b < 128.0;
            let theme = if is_dark { Theme::DARK } else { Theme::LIGHT };
            Theme { background: Color::opaque(rgb), ..theme }
        }
    }
}

/// A size of this shape.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "16 to 16384")]
fn usual_size(format: Format, ratio: f64) -> [u32; 2] {
    let length = format.usual_length();
    let [width, height] =
        if ratio >= 1.0 { [length, length / ratio] } else { [length * ratio, length] };
    [width, height].map(|x| (x / 2.0).round().max(8.0) as u32 * 2)
}
