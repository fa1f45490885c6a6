//! [`LogError`]: why a log cannot be written, read or exported.

use std::io;

/// Why a log cannot be written, read or exported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// The stream under the log failed.
    #[error("log input/output failed: {0}")]
    Io(#[from] io::Error),

    /// The bytes do not begin as an MCAP file does.
    #[error("not an MCAP file")]
    NotMcap,

    /// A sound MCAP file (so far), but not one that bksim wrote.
    #[error("MCAP file holds no bksim run: {missing} is missing")]
    NotARun {
        /// The record that every bksim log begins with.
        missing: &'static str,
    },

    /// The bytes contradict themselves: a checksum, a length or a reference is wrong.
    #[error("log is damaged: {reason}")]
    Damaged {
        /// The contradiction.
        reason: String,
    },

    /// A chunk is compressed, and this build has no decompression: that of WebAssembly.
    #[error("log is compressed, which this build of bksim cannot read")]
    Compressed,

    /// A record is larger than any reader of this crate accepts.
    #[error("{what} takes {bytes} bytes, the limit is {limit}")]
    TooLarge {
        /// The record.
        what: &'static str,
        /// Size of the record.
        bytes: u64,
        /// The largest size that is written or read.
        limit: u64,
    },

    /// A topic is not `/` and identifiers joined by `/`, or a field is not an identifier.
    #[error("`{name}` cannot name a {what}")]
    BadName {
        /// "topic" or "field".
        what: &'static str,
        /// The name as given.
        name: String,
    },

    /// Two topics or two fields of a topic answer to one name; `t` and `/log` are taken.
    #[error("{what} `{name}` is there twice")]
    DuplicateName {
        /// "topic" or "field".
        what: &'static str,
        /// The name.
        name: String,
    },

    /// A sample does not have one value per field of its topic.
    #[error("topic `{topic}` has {expected} fields, the sample {given} values")]
    WrongLength {
        /// The topic.
        topic: String,
        /// Number of fields that the topic has.
        expected: usize,
        /// The number of values given.
        given: usize,
    },

    /// A sample time is not a number, or lies before the previous sample.
    #[error("sample at t = {t:?} s after t = {previous:?} s")]
    BadTime {
        /// The time that was refused.
        t: f64,
        /// The last accepted time.
        previous: f64,
    },

    /// A value of a sample is infinite or no number.
    #[error("`{channel}` has no finite value at t = {t:?} s: it is {value}")]
    NotFinite {
        /// Name of the channel, as columns have it.
        channel: String,
        /// Time of the sample, s.
        t: f64,
        /// The value.
        value: f64,
    },

    /// An earlier write failed, so the file ends there.
    #[error("the log was abandoned after a write failed")]
    Abandoned,

    /// No channel of the log has this name or matches this pattern.
    #[error("no channel matches `{name}`{}", close_names(.close))]
    UnknownChannel {
        /// The name or pattern as given.
        name: String,
        /// Existing names that look alike, the closest first.
        close: Vec<String>,
    },

    /// The writer of a table in another format failed.
    #[error("cannot write {format}: {reason}")]
    Table {
        /// Name of the format.
        format: &'static str,
        /// The writer's own words.
        reason: String,
    },
}

impl LogError {
    /// Shorthand for [`LogError::Damaged`].
    pub(crate) fn damaged(reason: impl Into<String>) -> LogError {
        LogError::Damaged { reason: reason.into() }
    }
}

impl From<mcap::McapError> for LogError {
    fn from(error: mcap::McapError) -> LogError {
        match error {
            mcap::McapError::Io(error) => LogError::Io(error),
            mcap::McapError::BadMagic => LogError::NotMcap,
            mcap::McapError::AttemptedWriteAfterFailure => LogError::Abandoned,
            // Binary parse errors print several lines; the first one says it.
            error => LogError::damaged(error.to_string().lines().next().unwrap_or_default()),
        }
    }
}

fn close_names(close: &[String]) -> String {
    match close {
        [] => String::new(),
        names => format!(", did you mean `{}`", names.join("`, `")),
    }
}
