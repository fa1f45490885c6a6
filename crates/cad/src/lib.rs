//! Drawings as mechanisms: bodies, joints and loads attached to the entities of a DXF or DWG file.
//!
//! ```text
//! bytes → tags, guards → Drawing → Attachments → Composition (the text of a model) → mbs
//!         container      read       attach        compose
//!
//! edits:          statement → plan → groups spliced into the bytes        edit, patch
//! new drawings:   templates, models, traces of runs → bytes               write
//! ```
//!
//! A drawing says the same as a model file: what comes of it is the text of a model, with the place
//! in the drawing of every value, and from there on nothing knows of drawings.

pub mod attach;
pub mod attachment;
pub mod codes;
pub mod compose;
pub mod container;
pub mod drawing;
pub mod edit;
pub mod excerpt;
pub mod geometry;
pub mod kind;
pub mod mass;
pub mod model;
pub mod open;
pub mod outline;
pub mod patch;
pub mod read;
pub mod tags;
pub mod units;
pub mod write;
