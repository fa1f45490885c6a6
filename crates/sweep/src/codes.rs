//! Codes of faults in what a sweep asks for.

use bksim::mbs::diagnostic::Code;

macro_rules! codes {
    ($($name:ident = $code:literal, $title:literal;)*) => {
        $(#[doc = $title] pub const $name: Code = Code($code);)*

        /// Every code of a sweep: code, title, page.
        pub const PAGES: &[(Code, &str, &str)] = &[$((
            $name,
            $title,
            include_str!(concat!("../../../docs/diagnostics/", $code, ".md")),
        )),*];
    };
}

codes! {
    BAD_AXIS = "P001", "an axis that spans nothing";
    UNKNOWN_AXIS = "P002", "an axis that nothing has";
    AXIS_TWICE = "P003", "an axis given twice";
    N_CASES = "P004", "too many cases, or none";
    UNKNOWN_OUTPUT = "P005", "an output that no run has";
    OTHER_SWEEP = "P006", "another sweep in the way";
    BAD_OPTION = "P007", "a setting out of range";
}
