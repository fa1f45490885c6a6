//! One file per command.

pub(crate) mod assemble;
pub(crate) mod cad;
pub(crate) mod check;
pub(crate) mod equations;
pub(crate) mod explain;
pub(crate) mod export;
pub(crate) mod expr;
pub(crate) mod info;
pub(crate) mod new;
pub(crate) mod page;
pub(crate) mod plot;
pub(crate) mod render;
pub(crate) mod solve;
pub(crate) mod sweep;
pub(crate) mod view;
