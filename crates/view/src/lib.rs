//! The animated view of a run: the renderer on the graphics card, pictures, films, and the window.
//!
//! ```text
//! Playback + Scene → Show        a run with its additions, at any instant
//! Show → Frame → SceneRenderer   a few draw calls, in a window or on a canvas without one
//! Canvas → film                  PNG, GIF and MP4, one frame after another
//! Request → Rendering → file     pictures and films on request
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
