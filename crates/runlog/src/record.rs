//! A run as a log: its channels, the samples that fill them, and the options kept with them.
//!
//! ```text
//! Mechanism ─ Channels ─┬─ Recorder   samples, sensitivities and events to a log
//!                       └─ table      samples as rows of numbers, and back
//! ```

mod contents;
mod recorder;
mod rods;
mod sensitivities;
mod shown;
mod stage;
mod table;

pub use crate::channels::{Channels, INPUTS, Signal};
pub use contents::{Contents, compliance_options, compliances, overrides, set_option};
pub use recorder::Recorder;
pub use sensitivities::{sensitivity_columns, sensitivity_row, weight_columns};

/// Version of bksim, written into every log.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
