//! One file per command.

pub mod analysis;
pub(crate) mod assemble;
pub(crate) mod cad;
pub(crate) mod check;
pub(crate) mod code;
pub(crate) mod equations;
pub(crate) mod expand;
pub(crate) mod explain;
pub mod export;
mod export_robot;
pub(crate) mod expr;
pub(crate) mod fmu;
pub(crate) mod import;
mod import_drawing;
pub(crate) mod info;
pub(crate) mod new;
pub(crate) mod parts;
pub(crate) mod report;
pub(crate) mod schema;
pub(crate) mod shell;
pub mod solve;
