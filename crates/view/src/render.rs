//! Pictures and films on request: [`Request::prepare`] chooses the open options,
//! [`Rendering::write`] writes the file.

use std::io::Write;
use std::ops::RangeInclusive;
use std::sync::Arc;

use bksim::analysis::AnalysisError;
use bksim::sim::run::Unreplayed;
pub use bksim_scene::request::{Background, DENSITIES, FACTORS, MOST_GHOSTS, SIDES};

use crate::film::{
    Clip, Film, FilmError, FilmFormat, Palette, ShootError, Stage, aspect_ratio, write_png,
};
use crate::offscreen::{Canvas, CanvasError};
use crate::show::{Show, ShowOptions};

/// File format of a picture or a film.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Format {
    /// One instant as pixels.
    Png,
    /// One instant as lines; needs no graphics adapter.
    Svg,
    /// A part of the motion.
    Film(FilmFormat),
}

/// Usual length of the longer side of a picture, points, which lines and letters are sized for.
const POINTS: f64 = 640.0;

impl Format {
    /// All formats with their file extensions.
    pub const ALL: &[(&str, Self)] = &[
        ("png", Self::Png),
        ("svg", Self::Svg),
        ("gif", Self::Film(FilmFormat::Gif)),
        #[cfg(feature = "mp4")]
        ("mp4", Self::Film(FilmFormat::Mp4)),
        ("apng", Self::Film(FilmFormat::Apng)),
    ];

    /// The format of files with an extension, upper or lower case.
    pub fn of_ending(ending: &str) -> Option<Self> {
        let known = Self::ALL.iter().find(|(name, _)| ending.eq_ignore_ascii_case(name));
        known.map(|(_, format)| *format)
    }

    /// File extension of the format.
    #[expect(clippy::missing_panics_doc, reason = "the table has a row for each format")]
    pub fn name(self) -> &'static str {
        let entry = Self::ALL.iter().find(|(_, format)| *format == self);
        entry.map(|(name, _)| *name).expect("every format is in the table")
    }

    /// True if it shows more than one instant.
    pub fn is_film(self) -> bool {
        matches!(self, Self::Film(_))
    }

    /// Default of the longer side, pixels.
    fn usual_length(self) -> f64 {
        match self {
            Self::Svg | Self::Film(FilmFormat::Gif) => POINTS,
            _ => 2.0 * POINTS,
        }
    }

    /// Default of the pixels per point: the longer side of a picture has [`POINTS`], so that a
    /// large picture is a small one enlarged. The units of SVG are points.
    fn usual_density(self, [width, height]: [u32; 2]) -> f32 {
        #[expect(clippy::cast_possible_truncation, reason = "pixels")]
        let per_point = (f64::from(width.max(height)) / POINTS) as f32;
        if self == Self::Svg { 1.0 } else { per_point.max(*DENSITIES.start()) }
    }

    fn fitting(self, size: [u32; 2]) -> [u32; 2] {
        if let Self::Film(film) = self { film.fitting(size) } else { size }
    }

    /// Default size for a ratio of width to height.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "16 to 16384")]
    fn usual_size(self, ratio: f64) -> [u32; 2] {
        let length = self.usual_length();
        let [width, height] =
            if ratio >= 1.0 { [length, length / ratio] } else { [length * ratio, length] };
        [width, height].map(|x| (x / 2.0).round().max(8.0) as u32 * 2)
    }
}

/// Largest number of frames: more than half a day of film.
const MOST_FRAMES: usize = 1_000_000;
/// Largest number of pixels in a film as GIF or APNG, which hardly compress a motion: gigabytes.
const MOST_PIXELS: usize = 8_000_000_000;

/// A picture or a film to render. Options that are `None` are chosen to suit the mechanism.
#[derive(Clone, PartialEq, Debug)]
pub struct Request {
    /// The format of the file.
    pub format: Format,
    /// The instant of a picture, s; the middle of the motion by default.
    pub at: Option<f64>,
    /// The begin of a film, s; the start of the motion by default.
    pub from: Option<f64>,
    /// The end of a film, s; the end of the motion by default.
    pub to: Option<f64>,
    /// Frames a second of a film, in [`FACTORS`]; [`FilmFormat::usual_fps`] by default.
    pub fps: Option<f64>,
    /// Seconds of the motion in a second of film, in [`FACTORS`]; 1 by default.
    pub speed: Option<f64>,
    /// Width and height, pixels, in [`SIDES`]; by default they fit the motion.
    pub size: Option<[u32; 2]>,
    /// Pixels per point, in [`DENSITIES`]; by default in proportion to the size.
    pub density: Option<f32>,
    /// Azimuth and elevation of the direction of view of a spatial mechanism, degrees.
    pub view: Option<[f64; 2]>,
    /// The background.
    pub background: Background,
    /// Additions to the mechanism; trails and colours are replaced by those of the request.
    pub options: ShowOptions,
    /// Names of points that leave trails; the name of a body means its centre of mass.
    pub trails: Vec<String>,
    /// Curves laid over the mechanism, as [`Show::lay_over`] reads them.
    pub curves: Vec<String>,
}

/// Error of rendering.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// Options of films in the request of a picture.
    #[error("a picture shows one instant: `at` chooses it")]
    FilmTimes,
    /// The instant of a picture in the request of a film.
    #[error("a film shows more than the instant `at`: choose the part of the motion that it shows")]
    PictureTime,
    /// A number outside of its range.
    #[error("`{option}` is not a number from {low} to {high}")]
    Range {
        /// Name of the option.
        option: &'static str,
        /// Smallest value.
        low: f64,
        /// Largest value.
        high: f64,
    },
    /// An instant outside of the motion.
    #[error("`{option}` = {t} s lies outside of the motion, {} s to {} s", span[0], span[1])]
    Outside {
        /// Name of the option.
        option: &'static str,
        /// The instant, s.
        t: f64,
        /// First and last instant of the motion, s.
        span: [f64; 2],
    },
    /// More frames than a million.
    #[error("the film would have {0} frames: show a part of the motion, or raise `speed`")]
    TooLong(usize),
    /// More pixels than a film that hardly compresses should have.
    #[error(
        "the film would have {n_frames} frames and could take {gigabytes} GB: make it smaller or \
         shorter, or an MP4"
    )]
    TooLarge {
        /// Number of frames.
        n_frames: usize,
        /// Size of the file at most.
        gigabytes: usize,
    },
    /// An option of spatial mechanisms for a planar one.
    #[error("`{option}` is for spatial mechanisms, and this one is planar")]
    Planar {
        /// Name of the option.
        option: &'static str,
    },
    /// A trail of an unknown point.
    #[error("nothing that can leave a trail is called `{name}`: {}", known.join(", "))]
    UnknownPoint {
        /// The name.
        name: String,
        /// Names of all points.
        known: Vec<String>,
    },
    /// The motion is not that of the mechanism.
    #[error(transparent)]
    Unreplayed(#[from] Unreplayed),
    /// A curve that the mechanism has not.
    #[error(transparent)]
    Curves(#[from] AnalysisError),
    /// There is no graphics adapter, or it fails.
    #[error(transparent)]
    Canvas(#[from] CanvasError),
    /// The file cannot be written.
    #[error(transparent)]
    Film(#[from] FilmError),
}

impl From<ShootError> for RenderError {
    fn from(error: ShootError) -> Self {
        match error {
            ShootError::Unreplayed(error) => Self::Unreplayed(error),
            ShootError::Canvas(error) => Self::Canvas(error),
        }
    }
}

impl Request {
    /// A request without options.
    pub fn new(format: Format) -> Self {
        Self {
            format,
            at: None,
            from: None,
            to: None,
            fps: None,
            speed: None,
            size: None,
            density: None,
            view: None,
            background: Background::default(),
            options: ShowOptions::default(),
            trails: Vec::new(),
            curves: Vec::new(),
        }
    }

    /// Checks the options that do not depend on the motion.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn check(&self) -> Result<(), RenderError> {
        let of_films = [self.from, self.to, self.fps, self.speed];
        if !self.format.is_film() && of_films.iter().any(Option::is_some) {
            return Err(RenderError::FilmTimes);
        }
        if self.format.is_film() && self.at.is_some() {
            return Err(RenderError::PictureTime);
        }
        let past = self.options.past_s;
        let past = past.is_finite().then_some(past);
        for (option, value) in [("fps", self.fps), ("speed", self.speed), ("past", past)] {
            check_range(option, value, &FACTORS)?;
        }
        let sides = f64::from(*SIDES.start())..=f64::from(*SIDES.end());
        for side in self.size.into_iter().flatten() {
            check_range("size", Some(f64::from(side)), &sides)?;
        }
        let densities = f64::from(*DENSITIES.start())..=f64::from(*DENSITIES.end());
        check_range("density", self.density.map(f64::from), &densities)?;
        for angle in self.view.into_iter().flatten() {
            check_range("view", Some(angle), &(-360.0..=360.0))?;
        }
        let ghosts = self.options.ghosts as f64;
        check_range("ghosts", Some(ghosts), &(0.0..=f64::from(MOST_GHOSTS)))
    }

    /// Chooses the open options for a motion, and sets up a canvas.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn prepare(&self, mut show: Show) -> Result<Rendering, RenderError> {
        self.check()?;
        let format = self.format;
        let theme = self.background.theme();
        let trails = self.trails.iter().map(|name| marker(&show, name));
        let trails = trails.collect::<Result<_, _>>()?;
        show.options =
            ShowOptions { trails, legend: true, dark: theme.is_dark, ..self.options.clone() };
        show.lay_over(&self.curves)?;
        let clip = self.clip(&show)?;
        let of_space = [("view", self.view.is_some()), ("section", self.options.section.is_some())];
        let given = of_space.into_iter().find(|(_, is_given)| *is_given && show.scene().is_planar);
        if let Some((option, _)) = given {
            return Err(RenderError::Planar { option });
        }
        let size = match self.size {
            Some(size) => size,
            None => format.usual_size(aspect_ratio(&mut show, self.view)?),
        };
        let size = format.fitting(size);
        check_pixels(format, size, &clip)?;
        let density = self.density.unwrap_or_else(|| format.usual_density(size));
        let points = size.map(|n| f64::from(n) / f64::from(density));
        let mut stage = Stage::new(show, theme, self.view, points)?;
        stage.is_transparent = self.background == Background::Transparent;
        let mut canvas = None;
        if format != Format::Svg {
            let mut opened = Canvas::new(size, density)?;
            opened.scene_mut().set_scene(Arc::clone(stage.show.scene()), &theme);
            canvas = Some(opened);
        }
        Ok(Rendering { format, size, clip, stage, canvas })
    }

    /// The instants of the film; of a picture, one.
    fn clip(&self, show: &Show) -> Result<Clip, RenderError> {
        let span @ [first, last] = show.span();
        let within = |option, t: Option<f64>, usual| match t {
            None => Ok(usual),
            Some(t) if t >= first.min(last) && t <= first.max(last) => Ok(t),
            Some(t) => Err(RenderError::Outside { option, t, span }),
        };
        let Format::Film(film) = self.format else {
            let t = within("at", self.at, 0.5 * (first + last))?;
            return Ok(Clip { from: t, to: t, fps: 1.0, speed: 1.0 });
        };
        let from = within("from", self.from, first)?;
        let to = within("to", self.to, last)?;
        let fps = self.fps.unwrap_or_else(|| film.usual_fps());
        let clip = Clip { from, to, fps, speed: self.speed.unwrap_or(1.0) };
        let n_frames = clip.n_frames();
        if n_frames > MOST_FRAMES {
            return Err(RenderError::TooLong(n_frames));
        }
        Ok(clip)
    }
}

fn check_range(
    option: &'static str,
    value: Option<f64>,
    range: &RangeInclusive<f64>,
) -> Result<(), RenderError> {
    let (low, high) = (*range.start(), *range.end());
    match value {
        Some(value) if !range.contains(&value) => Err(RenderError::Range { option, low, high }),
        _ => Ok(()),
    }
}

/// Refuses a film that no disk should hold, before its first frame is drawn.
fn check_pixels(format: Format, size: [u32; 2], clip: &Clip) -> Result<(), RenderError> {
    let bytes_per_pixel = match format {
        Format::Film(FilmFormat::Gif) => 1,
        Format::Film(FilmFormat::Apng) => 4,
        _ => return Ok(()),
    };
    let n_frames = clip.n_frames();
    let n_pixels = size.into_iter().map(|n| n as usize).fold(n_frames, usize::saturating_mul);
    if n_pixels <= MOST_PIXELS {
        return Ok(());
    }
    let gigabytes = n_pixels.saturating_mul(bytes_per_pixel) / 1_000_000_000;
    Err(RenderError::TooLarge { n_frames, gigabytes })
}

/// The index of the marker with a name.
fn marker(show: &Show, name: &str) -> Result<usize, RenderError> {
    let markers = &show.scene().markers;
    markers.iter().position(|marker| marker.name == name).ok_or_else(|| {
        let known = markers.iter().map(|marker| marker.name.clone()).collect();
        RenderError::UnknownPoint { name: name.to_owned(), known }
    })
}

/// A request with all options chosen, ready to be written.
pub struct Rendering {
    /// The format of the file.
    pub format: Format,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// The instants of the film; of a picture, one.
    pub clip: Clip,
    stage: Stage,
    canvas: Option<Canvas>,
}

impl Rendering {
    /// Number of pictures in the file.
    pub fn n_frames(&self) -> usize {
        if self.format.is_film() { self.clip.n_frames() } else { 1 }
    }

    /// Name of the graphics adapter, if one is needed.
    pub fn adapter(&self) -> Option<&str> {
        self.canvas.as_ref().map(Canvas::adapter)
    }

    /// Writes the file; `go_on` gets each instant before it is drawn, s, and returns whether to
    /// continue. Returns `false` if it did not: then the file is incomplete and useless.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn write(
        &mut self,
        mut out: impl Write,
        go_on: &mut dyn FnMut(f64) -> bool,
    ) -> Result<bool, RenderError> {
        let is_whole = match (self.format, &mut self.canvas) {
            (Format::Film(film), Some(canvas)) => {
                shoot(&mut out, film, &self.clip, &mut self.stage, canvas, go_on)?
            }
            (_, Some(canvas)) => {
                let (image, _) = self.stage.shoot(canvas, self.clip.from)?;
                write_png(&mut out, &image)?;
                true
            }
            (_, None) => {
                let picture = self.stage.picture(self.clip.from)?;
                let title = &self.stage.show.playback().mechanism().model.name;
                let svg = bksim_scene::titled_svg(&picture, title);
                out.write_all(svg.as_bytes()).map_err(FilmError::Io)?;
                true
            }
        };
        out.flush().map_err(FilmError::Io)?;
        Ok(is_whole)
    }
}

/// Writes a film, frame by frame; returns whether it is complete.
fn shoot(
    out: &mut impl Write,
    format: FilmFormat,
    clip: &Clip,
    stage: &mut Stage,
    canvas: &mut Canvas,
    go_on: &mut dyn FnMut(f64) -> bool,
) -> Result<bool, RenderError> {
    let palette = match format {
        FilmFormat::Gif => stage.palette(canvas, clip)?,
        _ => Palette::default(),
    };
    let n_frames = clip.n_frames();
    let mut film = Film::begin(out, format, canvas.size(), clip.fps, n_frames, palette)?;
    for k in 0..n_frames {
        let t = clip.time(k);
        if !go_on(t) {
            return Ok(false);
        }
        let (image, _) = stage.shoot(canvas, t)?;
        film.add(&image)?;
    }
    film.finish()?;
    Ok(true)
}
