//! Descriptions of a mechanism and its runs as data for programs: the objects of `--json`, which
//! the Python package hands out, too.

mod equations;
mod events;
mod parts;
mod run;
mod start;
mod uniqueness;

pub use equations::equations;
pub use events::{event_words, events};
pub use parts::{
    coordinate_policy, joint_names, motion_coordinates, parts, redundant, without_bearing,
};
pub use run::{logged_summary, method_word, reason_words, sources, summary};
pub use start::start;
pub use uniqueness::{logged_uniqueness, uniqueness};
