//! [`WindowOptions`]: the start of a window, and its automatic actions.

use std::time::{Duration, Instant};

use bksim_scene::Section;

/// The start of a window, and its automatic actions.
#[derive(Clone, PartialEq, Debug)]
pub struct WindowOptions {
    /// The first instant shown, s; the start of the motion if none.
    pub t: Option<f64>,
    /// True if the motion is paused at first.
    pub is_paused: bool,
    /// The plane that cuts a spatial mechanism at first.
    pub section: Option<Section>,
    /// Width and height of the window, points.
    pub size: [f32; 2],
    /// Light or dark.
    pub look: Look,
    /// Time after the files have been read at which a picture of the window is taken, and it
    /// closes.
    pub shot_after: Option<Duration>,
    /// Number of frames after which the window closes.
    pub n_frames: Option<usize>,
    /// Instant from which the time to the first frame is measured.
    pub started: Instant,
}

/// Light or dark.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Look {
    /// The setting of the system; light where it has none.
    #[default]
    System,
    /// Dark on light.
    Light,
    /// Light on dark.
    Dark,
}
