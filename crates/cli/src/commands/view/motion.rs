//! From a model or a log to what a window shows, as often as the file changes.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use bksim::log::LogReader;
use bksim::playback::{Playback, PlaybackError};
use bksim_view::show::{Show, solve};
use bksim_view::window::{Loaded, Task};

use crate::args::ModelArgs;
use crate::exit::Failure;
use crate::render;
use crate::source::{Text, derive, load};

/// The first bytes of every MCAP file.
const MCAP: [u8; 8] = *b"\x89MCAP0\r\n";

/// Where a window's motion comes from.
pub(super) struct Motion {
    pub(super) model: ModelArgs,
    pub(super) nesting: usize,
}

impl Motion {
    /// Reads the file, and solves it if it is a model.
    pub(super) fn load(&self, task: &Task) -> Loaded {
        let path = &self.model.model;
        let mut loaded = if is_log(path) { Self::log(path) } else { self.solved(task) };
        // The file itself is watched whatever is wrong with it.
        loaded.files.push(path.clone());
        loaded
    }

    /// The motion in a log, which may still be written.
    fn log(path: &Path) -> Loaded {
        let opened = || {
            let file = File::open(path).map_err(|e| Failure::reading(path, &e))?;
            let bad = |error: PlaybackError| Failure::Input {
                path: path.to_owned(),
                what: format!("cannot be shown: {error}"),
                help: None,
            };
            let log = LogReader::open(BufReader::new(file)).map_err(|e| bad(e.into()))?;
            Playback::open(log).map_err(bad)
        };
        match opened() {
            Ok(playback) => {
                Loaded { show: Some(Box::new(Show::new(playback))), ..Loaded::default() }
            }
            Err(failure) => faulty(&failure),
        }
    }

    /// The motion of a model.
    fn solved(&self, task: &Task) -> Loaded {
        let read = match load(&self.model, self.nesting) {
            Ok(read) => read,
            Err(failure) => return faulty(&failure),
        };
        let (source, solver) = (read.source, read.model.solve.clone());
        let files = files_of(&source);
        let mechanism = match derive(&source, read.model) {
            Ok(mechanism) => mechanism,
            Err(failure) => return faulty(&failure),
        };
        let length = solver.t_end - solver.t_start;
        let go_on = |t: f64| {
            task.set_part((t - solver.t_start) / length);
            !task.is_stopped()
        };
        let solved = solve(mechanism, &source.text, &go_on);
        if task.is_stopped() {
            return Loaded { files, is_abandoned: true, ..Loaded::default() };
        }
        match solved {
            Ok(solved) => {
                let fault = solved.fault.map(|fault| render::plain_text(&source, &fault));
                let show = Some(Box::new(Show::new(solved.playback)));
                Loaded { show, fault, files, is_abandoned: false }
            }
            Err(PlaybackError::Model(rejected)) => faulty(&source.rejected(rejected.0)),
            Err(error) => Loaded { fault: Some(error.to_string()), files, ..Loaded::default() },
        }
    }
}

/// What is wrong, in the words of the other commands, and the files in which it may be put right.
fn faulty(failure: &Failure) -> Loaded {
    let files = match failure {
        Failure::Model { source, .. } => files_of(source),
        Failure::File { path, .. } | Failure::Input { path, .. } => vec![path.clone()],
        _ => Vec::new(),
    };
    Loaded { fault: Some(render::failure_text(failure)), files, ..Loaded::default() }
}

fn files_of(source: &Text) -> Vec<PathBuf> {
    source.files().into_iter().map(Path::to_owned).collect()
}

/// Whether a file begins as logs do. One that cannot be read is none.
fn is_log(path: &Path) -> bool {
    let mut start = [0; MCAP.len()];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut start));
    read.is_ok() && start == MCAP
}
