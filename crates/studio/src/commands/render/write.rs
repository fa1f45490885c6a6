//! Files of pictures and films: written next to their paths, and renamed when they are whole.

use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use bksim_view::film::FilmError;
use bksim_view::offscreen::CanvasError;

use bksim_cli::args::render::Render;
use bksim_cli::exit::Failure;

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

    pub(super) fn create(&self) -> Result<BufWriter<File>, Failure> {
        let file = File::create(&self.part).map_err(|e| Failure::writing(&self.path, &e))?;
        Ok(BufWriter::new(file))
    }

    /// Moves what was written to its place if it is whole, and gives its size in bytes; else takes it
    /// away.
    pub(super) fn finish(self, is_whole: Result<bool, Failure>) -> Result<Option<u64>, Failure> {
        if let Ok(true) = is_whole {
            fs::rename(&self.part, &self.path).map_err(|e| Failure::writing(&self.path, &e))?;
            let known = fs::metadata(&self.path).map_err(|e| Failure::writing(&self.path, &e))?;
            return Ok(Some(known.len()));
        }
        // What is left of it is of no use to anybody.
        let _ = fs::remove_file(&self.part);
        is_whole.map(|_| None)
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

pub(super) fn unwritten(args: &Render, error: &FilmError) -> Failure {
    match error {
        FilmError::Io(error) => Failure::writing(&args.output, error),
        other => Failure::file(&args.output, format!("cannot be written: {other}"), None),
    }
}
