//! Runs of mechanisms to logs and back: recording samples, playing a motion again at any instant, and
//! the words in which programs read of a run.

pub mod channels;
pub mod describe;
pub mod measured;
pub mod overview;
pub mod playback;
pub mod player;
pub mod record;
pub mod report;
pub mod solved;
