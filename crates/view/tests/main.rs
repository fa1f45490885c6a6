//! Pictures of the renderer, and films.

mod films;
mod golden;
