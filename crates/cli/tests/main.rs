//! The command, run as a user runs it: one module for each subject.

mod again;
mod answers;
mod cad_edit;
mod cams;
mod channels;
mod code;
mod collection;
mod common;
mod efforts;
mod equations;
mod expr;
mod faults;
mod handover;
mod info;
mod lsp;
mod lsp_client;
mod outputs;
mod outsiders;
mod parts;
mod questions;
mod report;
mod schema;
