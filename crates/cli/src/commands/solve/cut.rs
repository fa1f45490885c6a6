//! [`Cut`]: why the log ends a run before its end, as a diagnostic.

use std::path::Path;

use bksim::model::diagnostic::Diagnostic;
use bksim::sim::codes;

use crate::output::number;

/// Why a run was stopped for its log.
pub(super) enum Cut {
    /// It has reached its limit, bytes.
    Full(u64),
    /// A number for it is not finite.
    NotFinite {
        /// Name of the channel.
        channel: String,
        /// s.
        t: f64,
        /// The number.
        value: f64,
    },
}

impl Cut {
    /// The fault of the run, which has come to `t`; its log is in the file `path`.
    pub(super) fn fault(&self, t: f64, path: &Path) -> Diagnostic {
        match self {
            Self::Full(limit) => {
                let log = path.display();
                let size = in_words(*limit);
                let message =
                    format!("the log has reached its limit of {size} at t = {} s", number(t));
                let help = format!(
                    "log less: a longer `every`, `--channels own`, a shorter `t_end`; or go on with \
                     `bksim solve --resume {log} --log-limit {}`",
                    in_words(limit.saturating_mul(10)).replace(' ', "")
                );
                Diagnostic::error(codes::LOG_FULL, message)
                    .note("what is there can be read; of a stiff motion every step is kept, too")
                    .help(help)
            }
            Self::NotFinite { channel, t, value } => {
                let t = number(*t);
                let message =
                    format!("`{channel}` has no finite value at t = {t} s: it is {value}");
                Diagnostic::error(codes::NO_FINITE_NUMBER, message).help(
                    "leave it out of the log, or end the run before: `--t-end`; what is logged up to there can be read",
                )
            }
        }
    }
}

/// A size in the largest unit in which it is a number of few digits.
fn in_words(bytes: u64) -> String {
    const UNITS: [(u64, &str); 4] =
        [(1_000_000_000_000, "TB"), (1_000_000_000, "GB"), (1_000_000, "MB"), (1000, "kB")];
    let unit = UNITS.iter().find(|(unit, _)| bytes >= *unit && bytes.is_multiple_of(unit / 100));
    match unit {
        #[expect(clippy::cast_precision_loss, reason = "a few digits")]
        Some((unit, name)) => format!("{} {name}", bytes as f64 / *unit as f64),
        None => format!("{bytes} B"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_is_written_as_the_option_reads_it() {
        for (bytes, words) in [
            (2_000_000_000, "2 GB"),
            (1_500_000, "1.5 MB"),
            (64_000, "64 kB"),
            (1_073_741_824, "1073741824 B"),
        ] {
            assert_eq!(in_words(bytes), words);
        }
    }
}
