//! The mode of small motions that is shown in place of a run, and the state that it is about.

use bksim::analysis::{About, AnalysisError, ModeRequest, quantity};
use clap::Args;

/// A mode of small motions in place of the run.
#[derive(Args, Clone, Debug)]
pub struct ModeArgs {
    /// Show this mode of small motions in place of the run: 1 is the first one of `bksim modes`.
    #[arg(long, value_name = "N")]
    pub mode: Option<usize>,
    /// The mode's largest change of a body's angle, `10 deg`, or, where no body turns, of a position, `5 mm`.
    #[arg(long, value_name = "SIZE", requires = "mode")]
    pub amplitude: Option<String>,
    /// The pose that the mode is about, as of `bksim modes --at`: `static`, `stable`, the number of an equilibrium, or `start`.
    #[arg(long, value_name = "STATE", default_value = "static", requires = "mode")]
    pub mode_at: About,
}

impl ModeArgs {
    /// The mode that is asked for, if one is.
    ///
    /// # Errors
    /// [`AnalysisError::BadRange`] for an amplitude that is neither an angle nor a length.
    pub fn request(&self) -> Result<Option<ModeRequest>, AnalysisError> {
        let Some(number) = self.mode else { return Ok(None) };
        let read = |text: &String| quantity(text, "rad").or_else(|_| quantity(text, "m"));
        let amplitude = self.amplitude.as_ref().map(read).transpose()?;
        Ok(Some(ModeRequest { number, amplitude, about: self.mode_at }))
    }
}
