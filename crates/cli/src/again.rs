//! `--watch`: a command that is done again whenever the files of its models change.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use bksim_load::{InputError, Request, Watch, is_stdin, load};

use crate::args::Command;
use crate::exit::{Failure, Status};
use crate::progress::StopWish;
use crate::quiet::is_quiet;
use crate::render;

/// Time between two looks for a signal.
const LOOK: Duration = Duration::from_millis(100);
/// Time in which an editor may go on writing.
const SETTLE: Duration = Duration::from_millis(60);

/// Waits for changes of the command's models, after it was done once, and does it again after each; gives the
/// status of the last time when a signal comes.
///
/// # Errors
/// A command without a model, and a system that notices no changes.
pub(crate) fn again(
    command: &Command,
    mut status: u8,
    once: &dyn Fn() -> u8,
) -> Result<u8, Failure> {
    let inputs: Vec<PathBuf> =
        command.inputs().into_iter().filter(|path| !is_stdin(path)).collect();
    if inputs.is_empty() {
        let message = "--watch is for commands that read a model from a file";
        return Err(Failure::usage(message, "leave it out"));
    }
    let stop = StopWish::watch().map_err(|e| Failure::reading(&inputs[0], &e))?;
    let (changed, changes) = channel();
    let watch = Watch::new(move || {
        // Nobody waits any more when this fails.
        let _ = changed.send(());
    });
    let mut watch = watch.map_err(|error| Failure::Unavailable {
        message: format!("changes of files cannot be noticed: {error}"),
        help: "leave out --watch".to_owned(),
    })?;
    loop {
        let files: Vec<PathBuf> = inputs.iter().flat_map(|input| files_of(input)).collect();
        watch.set_files(&files);
        let names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
        if !is_quiet() {
            render::line(&format!("watching {}", names.join(", ")));
        }
        let is_ended = [Status::Interrupted, Status::Terminated].map(Status::code);
        if is_ended.contains(&status) || !has_changed(&changes, &stop) {
            return Ok(status);
        }
        status = once();
    }
}

/// Waits for a change; false when a signal comes first.
fn has_changed(changes: &Receiver<()>, stop: &StopWish) -> bool {
    loop {
        match changes.recv_timeout(LOOK) {
            Ok(()) => break,
            Err(RecvTimeoutError::Disconnected) => return false,
            Err(RecvTimeoutError::Timeout) if stop.status().is_some() => return false,
            Err(RecvTimeoutError::Timeout) => (),
        }
    }
    // One saving is many changes.
    while changes.recv_timeout(SETTLE).is_ok() {}
    stop.status().is_none()
}

/// The files that a model is read from, itself first, whatever is wrong with it.
fn files_of(input: &Path) -> Vec<PathBuf> {
    let source = match load(&Request::new(input)) {
        Ok(loaded) => Some(loaded.source),
        Err(InputError::Model { source_text, .. }) => Some(*source_text),
        Err(_) => None,
    };
    let mut files = vec![input.to_owned()];
    let others = source.iter().flat_map(|source| source.files());
    for other in others {
        if !files.iter().any(|known| known == other) {
            files.push(other.to_owned());
        }
    }
    files
}
