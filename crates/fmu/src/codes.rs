//! Codes of the faults of exports, one row each; the page is what `bksim explain` prints.

bksim_model::codes! {
    TOO_LARGE = "F001", "a mechanism that is too large for a solver in C";
    BACKWARDS = "F002", "a run backwards in time";
}
