//! The commands of the studio, run as a user runs them: one module for each subject.

#[path = "../../cli/tests/common/mod.rs"]
mod common;
mod curves;
mod diagnostics;
mod handover;
mod json;
mod page;
mod parquet;
mod pictures;
mod plot;
mod readmes;
mod render;
mod sheet;
mod sweep;
mod view;
