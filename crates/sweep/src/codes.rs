//! Codes of faults in what a sweep asks for.

use bksim::model::diagnostic::Page;

bksim::model::codes! {
    BAD_AXIS = "P001", "an axis that spans nothing";
    UNKNOWN_AXIS = "P002", "an axis that nothing has";
    AXIS_TWICE = "P003", "an axis given twice";
    N_CASES = "P004", "too many cases, or none";
    UNKNOWN_OUTPUT = "P005", "an output that no run has";
    OTHER_SWEEP = "P006", "another sweep in the way";
    BAD_OPTION = "P007", "a setting out of range";
}

/// Every code there is, those of models, runs and drawings first, with its page.
pub fn explained_codes() -> impl Iterator<Item = &'static Page> {
    bksim::explained_codes().chain(PAGES)
}

/// The page of a code such as `P001`; letters may be lower case.
pub fn explain(code: &str) -> Option<&'static Page> {
    explained_codes().find(|page| page.code.0.eq_ignore_ascii_case(code.trim()))
}
