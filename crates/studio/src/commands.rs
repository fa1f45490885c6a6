//! One file per command.

pub(crate) mod bode;
pub(crate) mod design;
pub(crate) mod edit;
pub(crate) mod inverse;
pub(crate) mod module;
pub(crate) mod page;
pub(crate) mod panels;
pub(crate) mod plot;
pub(crate) mod polygons;
pub(crate) mod render;
pub(crate) mod sheet;
pub(crate) mod sweep;
pub(crate) mod view;
