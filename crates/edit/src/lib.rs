//! A mechanism under the hand: the text of a model, edits of it, poses that are dragged, its motion, and answers.
//!
//! ```text
//! Edit ──→ Document ──→ text ──→ Held: the last good model ──→ Pose     a point is dragged
//!          undo, redo            faults with places         ├─→ Motion   solved, or its values replayed
//!                                                           └─→ Answers  freedoms, assemblies, equations
//! Session: all of it by requests and answers in JSON, for a page
//! ```
//!
//! An edit changes the bytes that it is about and no others. Nothing here opens files, prints, or asks for the time.

mod answers;
mod apply;
pub mod codes;
mod controls;
mod copy;
mod delete;
mod document;
mod draft;
mod draw;
mod edit;
mod forces;
mod group;
mod hand;
mod limits;
mod live;
pub mod names;
mod numbers;
mod places;
mod pose;
mod reading;
pub mod scan;
mod session;
mod solver;
mod start;
mod view;
mod written;

pub use apply::edited;
pub use codes::PAGES;
pub use controls::range_about;
pub use document::Document;
pub use edit::{Deed, Edit, EditError, End};
pub use forces::WrittenForces;
pub use hand::Hold;
pub use live::{Left, Live, hold_of};
pub use places::Places;
pub use pose::{Posed, limit_words};
pub use session::{Answer, Session};
pub use solver::{Moved, Solver};
