//! Codes of edits that cannot be made.

bksim_model::codes! {
    UNREADABLE = "W001", "an edit of a text that cannot be read";
    MISSING = "W002", "an edit of something that is not there";
    NAME = "W003", "a name that cannot be given";
    PLACE = "W004", "a point whose place is a formula";
    BRACES = "W005", "a section in braces";
    USED = "W006", "a parameter that is still used";
}
