//! The type of a table of `[joints.…]`.

use super::play::has_play;
use super::tree::Table;
use crate::joint::JointType;

/// The word that is a link where it has a `length`, and a cylinder where it has none.
pub(super) const DISTANCE: &str = "distance";

/// Keys of a distance, whichever it is.
pub(super) const DISTANCE_KEYS: [&str; 7] =
    ["type", "between", "length", "min", "max", "restitution", "coordinate"];

/// The type of a joint with the word `word`; `None` of an unknown word.
pub(super) fn type_of(word: &str, table: &Table) -> Option<&'static JointType> {
    let word = match word {
        DISTANCE if table.get("length").is_some() => "link",
        DISTANCE => "cylinder",
        // Contacts hold its bodies together.
        word if has_play(word, table) => "planar",
        word => word,
    };
    JointType::of_word(word)
}
