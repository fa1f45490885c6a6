//! Runs as MCAP files: self-describing channels, with the model and its options inside.
//!
//! ```
//! use bksim_log::{EndStatus, Field, Header, Log, LogWriter, Outcome, Topic};
//!
//! let mut header = Header::new("pendulum", "toml", "# the model", "0.1.0");
//! let state = header.add_topic(Topic::new("/state", [Field::new("angle", "rad", "A to B")]));
//!
//! let mut writer = LogWriter::create(Vec::new(), &header)?;
//! writer.write(state, 0.0, &[0.5])?;
//! writer.write(state, 0.1, &[0.4])?;
//! let bytes = writer.finish(&EndStatus::new(Outcome::ReachedEnd, 0.1, "end time reached"))?;
//!
//! let log = Log::read(&bytes[..])?;
//! assert_eq!(log.header, header);
//! assert_eq!(log.series(state).columns[0], [0.5, 0.4]);
//! assert_eq!(log.end.map(|end| end.outcome), Some(Outcome::ReachedEnd));
//! # Ok::<(), bksim_log::LogError>(())
//! ```
//!
//! # The file
//!
//! In the order of the file, so that a run killed half-way still has its description:
//!
//! | record | holds |
//! |---|---|
//! | attachment `model.toml` | the text of the model |
//! | metadata `bksim.run` | model name and format, SHA-256 of the text, version, start time, digest |
//! | metadata `bksim.parameters` | name -> value and SI unit, such as `0.025 m` |
//! | metadata `bksim.options` | name -> text |
//! | one schema and channel per topic | protobuf message `bksim.State` for topic `/state` and so on: field 1 is `t` in seconds, then one double per signal; units and descriptions are channel metadata `angle.unit`, `angle.description` |
//! | channel `/log` | warnings and events, schema `foxglove.Log` |
//! | channel `/motion` | the motion between samples, one message per step of the integrator: schema `bksim.Motion`, see [`Segment`] |
//! | channels `/tf`, `/scene`, `/spans`, `/joint_states`, `/outlines/…` | the scene and the motion for programs that know nothing of bksim, in schemas that Foxglove has published: see [`Stage`]; this crate's reader passes them over, as it does all whose schema is not in package `bksim` |
//! | chunks of messages | the samples, zstd, each chunk with its CRC |
//! | metadata `bksim.uniqueness` | from when on which channels hold one of many solutions of the equilibrium, among the chunks wherever that changes: see [`NotUnique`] |
//! | attachment `bksim.checkpoint` | the state from which a stopped run goes on; bytes of its solver |
//! | metadata `bksim.end` | how the run ended; `details`: its events, methods, work, residuals and energies as JSON; a log without it was cut short |
//!
//! `log_time` is the distance from the start time in nanoseconds: it starts at 0 however early the
//! run starts, and grows along the run even when it is integrated backwards. The exact time is `t`;
//! lines of `/log` have no other than `log_time`.
//! No record holds a wall-clock time: the same run writes the same samples bit for bit, and the
//! same file when no quarter second passes between two writes.
//!
//! # Invariants
//!
//! Bytes in, bytes out: this crate opens no file. Reading checks every CRC, keeps at most a few
//! records in memory, and answers any bytes with data or a [`LogError`], never with a panic.

mod compression;
mod error;
pub mod export;
mod frames;
mod header;
mod meta;
mod names;
mod read;
mod schema;
mod select;
mod topics;
mod viewer;
mod wire;
mod write;

pub use error::LogError;
pub use header::{
    EndStatus, Field, Header, Level, NotUnique, Note, Outcome, Quantity, Segment, Topic, TopicId,
};
pub use read::{
    Contents, ForeignTopic, Log, LogReader, Make, Making, Record, Request, Series, Survey,
    TopicCount,
};
pub use select::{Column, SHORT, Selection, glob};
pub use topics::{LOG_TOPIC, MOTION_TOPIC};
pub use viewer::{Area, Entity, Joint, JointState, Line, Moment, Placement, Stage, Viewers};
pub use write::LogWriter;
