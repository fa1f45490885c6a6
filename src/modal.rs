//! Modes as motions that are played back like runs.

use bksim_analysis::{AnalysisError, Mode, ModeMotion, ModeRequest, mode_motion};
use bksim_log::Header;
use bksim_model::Model;

use crate::VERSION;
use crate::playback::{Playback, PlaybackError, RunLog};

/// A mode that swings.
#[derive(Debug)]
pub struct Swinging {
    /// One period.
    pub playback: Playback,
    /// The mode.
    pub mode: Mode,
    /// The largest change of a body's angle, rad, or, where no body turns, of a position, m.
    pub amplitude: f64,
    /// s.
    pub period: f64,
}

/// Why a mode cannot be shown.
#[derive(Debug, thiserror::Error)]
pub enum NotSwinging {
    /// The question has no answer.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
    /// The motion cannot be played.
    #[error(transparent)]
    Playback(#[from] PlaybackError),
}

/// A mode of `model` as a motion; `text` is that of the model.
///
/// # Errors
/// [`NotSwinging`].
pub fn swinging(model: Model, text: &str, request: &ModeRequest) -> Result<Swinging, NotSwinging> {
    let name = model.name.clone();
    let ModeMotion { mechanism, segments, mode, amplitude, period } = mode_motion(model, request)?;
    let mut header = Header::new(&name, "toml", text, VERSION);
    header.t_start = segments.first().map_or(0.0, |segment| segment.t0);
    let playback = Playback::new(RunLog::unlogged(header, segments), mechanism)?;
    Ok(Swinging { playback, mode, amplitude, period })
}
