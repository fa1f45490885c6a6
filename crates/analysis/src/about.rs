//! [`About`]: the state that an answer is about, as it is asked for.

use std::str::FromStr;

use crate::drive::quantity;

/// The state that equations are linearised about.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub enum About {
    /// The equilibrium nearest to the start, whatever its stability.
    #[default]
    Static,
    /// The stable equilibrium nearest to the start.
    Stable,
    /// The equilibrium of this number, from one, as [`statics`](crate::statics()) lists them.
    Number(usize),
    /// The start as it is, moving if the model says so.
    Start,
    /// The state of the run at this time, s.
    Instant(f64),
}

impl FromStr for About {
    type Err = String;

    /// Reads `static`, `stable`, the number of an equilibrium, `start` or an instant, `t=1 s`.
    fn from_str(text: &str) -> Result<Self, String> {
        let time = || {
            let after = text.trim().strip_prefix('t')?.trim_start().strip_prefix('=')?;
            quantity(after, "s").ok()
        };
        match text {
            "static" => Ok(Self::Static),
            "stable" => Ok(Self::Stable),
            "start" => Ok(Self::Start),
            _ => text.parse().map(Self::Number).or_else(|_| time().map(Self::Instant).ok_or(())).map_err(|()| {
                "expected `static`, `stable`, the number of an equilibrium, `start` or an instant of the run, such as `t=1 s`"
                    .to_owned()
            }),
        }
    }
}
