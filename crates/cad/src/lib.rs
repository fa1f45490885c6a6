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
//! A drawing says the same as a model file: it becomes the text of a model, with the location of every
//! value in the drawing, and from there on nothing knows of drawings.

pub mod attach;
pub mod attachment;
pub mod backdrop;
pub mod codes;
pub mod compose;
pub mod container;
pub mod doctor;
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
mod unread;
pub mod write;
