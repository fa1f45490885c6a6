//! Curves in a window.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bksim_view::window::{Look, WindowOptions, open_figure};

use super::compose::Plotted;
use super::{planned, put};
use crate::commands::view::no_window;
use bksim_cli::args::plot::{Plot, PlotTheme};
use bksim_cli::exit::Failure;
use bksim_cli::origin::{is_of_model, may_be_own, stamped};
use bksim_cli::output_file::{OutputFile, check_ending};

/// Width and height of a window, points.
const SIZE: (f64, f64) = (1200.0, 800.0);
/// Smallest and largest side of a picture.
const SIDES: std::ops::RangeInclusive<f64> = 200.0..=10_000.0;

/// Refuses windows and pictures of them that cannot be made.
pub(super) fn check(args: &Plot, read: &[PathBuf]) -> Result<Option<OutputFile>, Failure> {
    let may_be_own = |path: &Path| args.force || may_be_own(path);
    let screenshot = args.screenshot.as_deref();
    let screenshot = screenshot.map(|path| planned(path, read, may_be_own(path)));
    let screenshot = screenshot.transpose()?;
    args.screenshot.iter().try_for_each(|path| check_ending(path, &["png"]))?;
    match args.size {
        Some((width, height))
            if args.window && !(SIDES.contains(&width) && SIDES.contains(&height)) =>
        {
            let message = format!("there is no window of {width}x{height} pixels");
            Err(Failure::usage(message, "choose a --size with sides from 200 to 10000"))
        }
        _ => Ok(screenshot),
    }
}

/// Shows the figure until the window is closed, and writes the picture of it that was asked for.
pub(super) fn show(
    args: &Plot,
    (screenshot, label): (Option<&OutputFile>, &str),
    plotted: &Plotted,
) -> Result<(), Failure> {
    if let Some(output) = screenshot {
        let may_replace = args.force || is_of_model(output.path(), label);
        output.check_again(may_replace, "nothing was written")?;
    }
    let (width, height) = args.size.unwrap_or(SIZE);
    #[expect(clippy::cast_possible_truncation, reason = "up to 10000")]
    let size = [width as f32, height as f32];
    let options = WindowOptions {
        section: None,
        t: None,
        is_paused: true,
        size,
        look: match args.theme {
            None => Look::System,
            Some(PlotTheme::Light) => Look::Light,
            Some(PlotTheme::Dark) => Look::Dark,
        },
        shot_after: args.screenshot.as_ref().map(|_| Duration::from_secs_f64(args.after)),
        n_frames: None,
        started: Instant::now(),
    };
    let help = "without --window the curves are drawn in the terminal, with -o into a file";
    let outcome = open_figure(&plotted.figure, &options).map_err(|e| no_window(&e, help))?;
    if let (Some(output), Some(png)) = (screenshot, &outcome.png) {
        put(output, &stamped(output.path(), png.clone(), label))?;
    }
    Ok(())
}
