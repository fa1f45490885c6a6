//! Faults of pictures and films that are not written.

use bksim_view::film::FilmError;
use bksim_view::offscreen::CanvasError;

use bksim_cli::args::render::Render;
use bksim_cli::exit::Failure;

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
