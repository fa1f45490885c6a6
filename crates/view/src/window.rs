//! The window: a mechanism that moves, its curves, and the clock that both follow.
//!
//! ```text
//! Source → Loader    reads the files, and again when they change, on a thread of its own
//! Clock              which instant is shown
//! Show at that t     poses, and what is drawn beside them
//! Eye                from where
//! App                one frame: the bar, the curves, the picture, and what lies over it
//! ```
//!
//! Beside it, [`open_figure`] shows curves alone.
//!
//! It opens no files by itself: a [`Source`] does. Nothing is computed and nothing painted while
//! nothing moves.

mod action;
mod app;
mod chart;
mod choices;
mod clock;
mod controls;
mod curves;
mod eye;
mod icon;
mod measure;
mod number;
mod overlay;
mod panel;
mod picture;
mod source;
mod style;
mod watch;

use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;
use std::time::{Duration, Instant};

pub use self::chart::open_figure;
pub use self::source::{Loaded, Source, Task};

use self::app::App;
use self::source::Loader;

/// How a window begins, and what it is to do by itself.
#[derive(Clone, PartialEq, Debug)]
pub struct WindowOptions {
    /// The first instant shown, s; that of the motion if none.
    pub t: Option<f64>,
    /// Whether time stands still at first.
    pub is_paused: bool,
    /// Width and height of the window, points.
    pub size: [f32; 2],
    /// Light or dark.
    pub look: Look,
    /// Takes a picture of the window so long after the files have been read, and closes it.
    pub shot_after: Option<Duration>,
    /// Closes the window after so many frames.
    pub n_frames: Option<usize>,
    /// From when the time to the first frame is measured.
    pub started: Instant,
}

/// Light or dark.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Look {
    /// As the system wishes; light where it does not tell.
    #[default]
    System,
    /// Dark on light.
    Light,
    /// Light on dark.
    Dark,
}

/// What happens in a window, as it happens.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Report<'a> {
    /// The first frame with a motion is there.
    FirstFrame,
    /// The files have been read without a fault, in so many seconds.
    Loaded(f64),
    /// The files have been read, and this is wrong.
    Fault(&'a str),
    /// Changes of the files will not be noticed, and why.
    Unwatched(&'a str),
}

/// What is left of a window that was closed.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Outcome {
    /// How fast it was.
    pub figures: Figures,
    /// Whether each reading of the files was without a fault.
    pub loads: Vec<bool>,
    /// The picture that was asked for, as PNG.
    pub png: Option<Vec<u8>>,
}

/// How fast a window was.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Figures {
    /// From [`WindowOptions::started`] to the first frame with a motion, s.
    pub first_frame_s: Option<f64>,
    /// Frames counted when [`WindowOptions::n_frames`] are asked for.
    pub n_frames: usize,
    /// Of those.
    pub frames_per_second: Option<f64>,
    /// What the window's thread spent on one of them, without waiting for the display, s.
    pub cpu_s_per_frame: Option<f64>,
    /// Draw calls of the last picture.
    pub n_draws: usize,
    /// Triangles and segments of lines in it.
    pub n_primitives: usize,
    /// Bytes sent to the graphics card for it.
    pub n_bytes: usize,
}

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WindowError {
    /// There is no display to open it on.
    #[error("there is no display: {0}")]
    NoDisplay(String),
    /// No graphics adapter can paint it.
    #[error("there is no graphics adapter: {0}")]
    NoAdapter(String),
    /// The library for windows gave up.
    #[error("the window failed: {0}")]
    Failed(String),
}

impl WindowError {
    /// What to do about it.
    pub fn help(&self) -> &'static str {
        match self {
            Self::NoDisplay(_) => {
                "a window needs a display: set DISPLAY, or log in with `ssh -X` from afar"
            }
            Self::NoAdapter(_) => crate::offscreen::INSTALL,
            Self::Failed(_) => "the words of the window system above may tell what to do",
        }
    }
}

/// Opens a window, and returns when it is closed.
///
/// # Errors
/// [`WindowError`] when it cannot be opened.
pub fn open<'a>(
    source: Source,
    options: &WindowOptions,
    report: Box<dyn FnMut(Report<'_>) + 'a>,
) -> Result<Outcome, WindowError> {
    let outcome = Rc::new(RefCell::new(Outcome::default()));
    let left = Rc::clone(&outcome);
    let own = options.clone();
    run(&source.name.clone(), options, move |created| {
        let context = created.egui_ctx.clone();
        let loader = Loader::start(source, move || context.request_repaint());
        let app = App::new(created, &own, loader, report, left)?;
        Some(Box::new(app))
    })?;
    Ok(outcome.take())
}

/// Opens a window called after a file, with what `create` makes for it, which is nothing if there is no
/// adapter.
fn run<'a>(
    name: &str,
    options: &WindowOptions,
    create: impl FnOnce(&eframe::CreationContext<'_>) -> Option<Box<dyn eframe::App + 'a>> + 'a,
) -> Result<(), WindowError> {
    let title = title(name);
    let viewport = egui::ViewportBuilder::default()
        .with_title(&title)
        .with_app_id("bksim")
        .with_inner_size(options.size)
        .with_min_inner_size([320.0, 240.0])
        .with_icon(egui::IconData::default());
    let mut native = eframe::NativeOptions { viewport, ..eframe::NativeOptions::default() };
    if let egui_wgpu::WgpuSetup::CreateNew(setup) = &mut native.wgpu_options.wgpu_setup {
        // The renderer reads buffers in its vertex shader, which OpenGL does not promise.
        setup.instance_descriptor.backends = wgpu::Backends::PRIMARY;
    }
    let create: eframe::AppCreator<'a> =
        Box::new(move |created| Ok(create(created).ok_or("the window has no adapter")?));
    match eframe::run_native(&title, native, create) {
        Ok(()) => Ok(()),
        Err(error @ (eframe::Error::Winit(_) | eframe::Error::WinitEventLoop(_))) => {
            Err(WindowError::NoDisplay(without_place(&error.to_string())))
        }
        Err(eframe::Error::Wgpu(error)) => Err(WindowError::NoAdapter(error.to_string())),
        Err(error) => Err(WindowError::Failed(error.to_string())),
    }
}

/// The title of a window.
fn title(name: &str) -> String {
    let name = Path::new(name).file_name().map_or(name.into(), |name| name.to_string_lossy());
    format!("{name} – bksim")
}

/// The words of the library for windows without the place in its source that they came from.
fn without_place(words: &str) -> String {
    let told = words.split(": ").filter(|part| !part.contains(".rs:"));
    told.last().unwrap_or(words).trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_libraries_lose_the_place_in_their_source() {
        let words = "winit EventLoopError: os error at /a/winit/src/mod.rs:788: Failed to connect";
        assert_eq!(without_place(words), "Failed to connect");
        assert_eq!(without_place("no event loop"), "no event loop");
    }
}
