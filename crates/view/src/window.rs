//! The window: a mechanism that moves, its curves, and the clock that both follow.
//!
//! ```text
//! Source → Loader    reads the files, and again when they change, on a thread of its own
//! Clock              the instant shown
//! Show at that t     poses, and additions to them
//! Eye                the camera
//! Hand               a pose in place of the show's, or a live motion
//! App                one frame: the bar, the curves, the picture, and its overlays
//! ```
//!
//! [`open_figure`] shows curves alone.
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
mod cutting;
mod eye;
mod grid;
mod hand;
mod icon;
mod measure;
mod number;
mod options;
mod overlay;
mod panel;
mod report;
mod said;
mod server;
mod source;
mod style;
mod values;
mod viewport;

use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;

pub use self::chart::open_figure;
pub use self::options::{Look, WindowOptions};
pub use self::report::{Figures, Outcome, Report, WindowError};
pub use self::source::{Load, Loaded, Save, Source, Task};

use self::app::App;
use self::source::Loader;

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
    let shared = Rc::clone(&outcome);
    let own = options.clone();
    run(&source.name.clone(), options, move |created| {
        let context = created.egui_ctx.clone();
        let loader = Loader::start(source, move || context.request_repaint());
        let app = App::new(created, &own, loader, report, shared)?;
        Some(Box::new(app))
    })?;
    Ok(outcome.take())
}

/// Runs the application that `create` makes, in a window with the title of a file; `create` returns
/// none if there is no adapter.
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
    match server::guarded(|| eframe::run_native(&title, native, create))? {
        Ok(()) => Ok(()),
        Err(error @ (eframe::Error::Winit(_) | eframe::Error::WinitEventLoop(_))) => {
            Err(WindowError::NoDisplay(without_location(&error.to_string())))
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

/// A message of the library for windows without its location in the source.
fn without_location(message: &str) -> String {
    let parts = message.split(": ").filter(|part| !part.contains(".rs:"));
    parts.last().unwrap_or(message).trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_of_libraries_lose_their_location_in_the_source() {
        let message =
            "winit EventLoopError: os error at /a/winit/src/mod.rs:788: Failed to connect";
        assert_eq!(without_location(message), "Failed to connect");
        assert_eq!(without_location("no event loop"), "no event loop");
    }
}
