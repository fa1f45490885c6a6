//! Files of pictures and films: written beside their places, and moved there when they are whole.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use bksim_view::film::{Clip, Film, FilmError, FilmFormat, Palette, ShootError, Stage, write_png};
use bksim_view::offscreen::{Canvas, CanvasError};

use super::motion::unreplayed;
use crate::args::render::Render;
use crate::exit::{Failure, Status};
use crate::progress::{Progress, StopWish};

/// How the work ended.
pub(super) enum Made {
    /// A file of this size.
    Written {
        /// Its size.
        n_bytes: u64,
    },
    /// A signal came; there is no file.
    Stopped(Status),
}

/// A file that takes the place of another once it is whole.
#[derive(Debug)]
pub(super) struct Replacing {
    path: PathBuf,
    part: PathBuf,
}

impl Replacing {
    /// Refuses a file that exists, is the input, or has no directory to lie in.
    pub(super) fn check(path: &Path, input: &Path, force: bool) -> Result<Self, Failure> {
        let nothing = "nothing was drawn";
        let directory = path.parent().filter(|parent| !parent.as_os_str().is_empty());
        if let Some(there) = directory.filter(|parent| !parent.is_dir()) {
            let there = there.display();
            let what = format!("cannot be written: there is no directory `{there}`; {nothing}");
            return Err(Failure::file(
                path,
                what,
                Some(format!("make it with `mkdir -p {there}`")),
            ));
        }
        if path.canonicalize().ok().is_some_and(|own| input.canonicalize().ok() == Some(own)) {
            let what = format!("is what is to be drawn, and would be overwritten; {nothing}");
            return Err(Failure::file(path, what, Some("name another file with -o".to_owned())));
        }
        if path.is_dir() {
            let what = format!("is a directory; {nothing}");
            return Err(Failure::file(path, what, Some("name a file in it".to_owned())));
        }
        if path.exists() && !force {
            let help = "add --force to overwrite it, or name another file with -o".to_owned();
            return Err(Failure::file(path, format!("exists; {nothing}"), Some(help)));
        }
        let mut part = path.as_os_str().to_owned();
        part.push(".part");
        Ok(Self { path: path.to_owned(), part: PathBuf::from(part) })
    }

    fn create(&self) -> Result<BufWriter<File>, Failure> {
        let file = File::create(&self.part).map_err(|e| Failure::writing(&self.path, &e))?;
        Ok(BufWriter::new(file))
    }

    /// Moves the whole file to its place, or takes away what was written of it.
    fn finish(self, made: Result<Option<Status>, Failure>) -> Result<Made, Failure> {
        match made {
            Ok(None) => {
                fs::rename(&self.part, &self.path).map_err(|e| Failure::writing(&self.path, &e))?;
                let known =
                    fs::metadata(&self.path).map_err(|e| Failure::writing(&self.path, &e))?;
                Ok(Made::Written { n_bytes: known.len() })
            }
            other => {
                // What is left of it is of no use to anybody.
                let _ = fs::remove_file(&self.part);
                other.map(|status| Made::Stopped(status.unwrap_or(Status::Interrupted)))
            }
        }
    }
}

/// One instant as PNG.
pub(super) fn png(
    args: &Render,
    replacing: Replacing,
    stage: &mut Stage,
    canvas: &mut Canvas,
    t: f64,
) -> Result<Made, Failure> {
    let (image, _) = stage.shoot(canvas, t).map_err(|e| unshot(args, &e))?;
    let mut out = replacing.create()?;
    let written = write_png(&mut out, &image).map_err(|e| unwritten(args, &e));
    let flushed = written.and_then(|()| flush(args, &mut out));
    replacing.finish(flushed.map(|()| None))
}

/// One instant as SVG.
pub(super) fn svg(
    args: &Render,
    replacing: Replacing,
    stage: &mut Stage,
    t: f64,
) -> Result<Made, Failure> {
    let picture = stage.picture(t).map_err(|e| unreplayed(&args.input, e))?;
    let mut out = replacing.create()?;
    let title = &stage.show.playback().mechanism().model.name;
    let written = out.write_all(bksim_scene::titled_svg(&picture, title).as_bytes());
    let written = written.map_err(|e| Failure::writing(&args.output, &e));
    let flushed = written.and_then(|()| flush(args, &mut out));
    replacing.finish(flushed.map(|()| None))
}

/// A film, frame by frame; a signal ends it, and nothing is left.
pub(super) fn film(
    args: &Render,
    replacing: Replacing,
    stage: &mut Stage,
    canvas: &mut Canvas,
    (format, clip): (FilmFormat, &Clip),
    stop: &StopWish,
) -> Result<Made, Failure> {
    let mut out = replacing.create()?;
    let progress = Progress::of("drawing", clip.from, clip.to);
    let mut shoot_all = || -> Result<Option<Status>, Failure> {
        let palette = match format {
            FilmFormat::Gif => stage.palette(canvas, clip).map_err(|e| unshot(args, &e))?,
            _ => Palette::default(),
        };
        let n_frames = clip.n_frames();
        let film = Film::begin(&mut out, format, canvas.size(), clip.fps, n_frames, palette);
        let mut film = film.map_err(|e| unwritten(args, &e))?;
        for k in 0..n_frames {
            if let Some(status) = stop.status() {
                return Ok(Some(status));
            }
            let t = clip.time(k);
            let (image, _) = stage.shoot(canvas, t).map_err(|e| unshot(args, &e))?;
            film.add(&image).map_err(|e| unwritten(args, &e))?;
            progress.reached(t);
        }
        film.finish().map_err(|e| unwritten(args, &e))?;
        flush(args, &mut out).map(|()| None)
    };
    let made = shoot_all();
    progress.finish();
    replacing.finish(made)
}

fn flush(args: &Render, out: &mut impl Write) -> Result<(), Failure> {
    out.flush().map_err(|e| Failure::writing(&args.output, &e))
}

fn unshot(args: &Render, error: &ShootError) -> Failure {
    match error {
        ShootError::Unreplayed(error) => unreplayed(&args.input, *error),
        ShootError::Canvas(error) => undrawn(args, error),
        other => Failure::file(&args.output, format!("cannot be drawn: {other}"), None),
    }
}

/// There is nothing to draw with.
pub(super) fn undrawn(args: &Render, error: &CanvasError) -> Failure {
    let mut help = error.help().map(str::to_owned);
    if let (CanvasError::NoAdapter, Some(help)) = (error, &mut help) {
        help.push_str("; a picture as .svg needs none");
    }
    Failure::file(&args.output, format!("cannot be drawn: {error}"), help)
}

fn unwritten(args: &Render, error: &FilmError) -> Failure {
    match error {
        FilmError::Io(error) => Failure::writing(&args.output, error),
        other => Failure::file(&args.output, format!("cannot be written: {other}"), None),
    }
}
