//! Events, results and errors of a window.

use crate::offscreen::INSTALL;

/// An event in a window, reported as it happens.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Report<'a> {
    /// The first frame with a motion was shown.
    FirstFrame,
    /// The files have been read without a fault, in so many seconds.
    Loaded(f64),
    /// The files have been read, with this fault.
    Fault(&'a str),
    /// Changes of the files will not be noticed, for this reason.
    Unwatched(&'a str),
}

/// The result of a window that was closed.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Outcome {
    /// Speed of the run.
    pub figures: Figures,
    /// Whether each reading of the files was without a fault.
    pub loads: Vec<bool>,
    /// The picture of [`WindowOptions::shot_after`](super::WindowOptions::shot_after), as PNG.
    pub png: Option<Vec<u8>>,
}

/// The speed of a window.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Figures {
    /// From [`WindowOptions::started`](super::WindowOptions::started) to the first frame with a
    /// motion, s.
    pub first_frame_s: Option<f64>,
    /// Number of frames counted, if [`WindowOptions::n_frames`](super::WindowOptions::n_frames) are
    /// requested.
    pub n_frames: usize,
    /// Rate of the counted frames.
    pub frames_per_second: Option<f64>,
    /// Time of the window's thread for a counted frame, without waiting for the display, s.
    pub cpu_s_per_frame: Option<f64>,
    /// Draw calls of the last picture.
    pub n_draws: usize,
    /// Triangles, segments and rods in it.
    pub n_primitives: usize,
    /// Bytes sent to the graphics card for it.
    pub n_bytes: usize,
}

/// Error of opening a window.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WindowError {
    /// There is no display to open it on.
    #[error("there is no display: {0}")]
    NoDisplay(String),
    /// No graphics adapter can paint it.
    #[error("there is no graphics adapter: {0}")]
    NoAdapter(String),
    /// The display server has ended before the window did.
    #[error("the display server has gone away")]
    Lost,
    /// The library for windows failed.
    #[error("the window failed: {0}")]
    Failed(String),
}

impl WindowError {
    /// Remedy for the error.
    pub fn help(&self) -> &'static str {
        match self {
            Self::NoDisplay(_) => {
                "a window needs a display: set DISPLAY, or log in with `ssh -X` from afar"
            }
            Self::NoAdapter(_) => INSTALL,
            Self::Lost => "start it again",
            Self::Failed(_) => "the message of the window system above may help",
        }
    }
}
