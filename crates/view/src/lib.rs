//! The animated view of a run: what is shown, its renderer on the graphics card, pictures and films.
//!
//! ```text
//! Playback + Scene → Show        what is shown of a run, at any instant
//! Show → Frame → SceneRenderer   a few draw calls, in a window or on a canvas without one
//! Canvas → film                  PNG, GIF and MP4, one frame after another
//! Order → Rendering → file       pictures and films as they are asked for
//! ```
//!
//! Everything shown at an instant is computed at that instant; nothing is taken from the sample
//! next to it.

pub mod film;
pub mod offscreen;
pub mod render;
pub mod renderer;
pub mod show;
pub mod window;
pub mod words;
