//! Codes of the faults of drawings, one row each; the page is what `bksim explain` prints.

use bksim_mbs::diagnostic::Code;

macro_rules! codes {
    ($($name:ident = $code:literal, $title:literal;)*) => {
        $(#[doc = $title] pub const $name: Code = Code($code);)*

        /// Every code of a drawing: code, title, page.
        pub const PAGES: &[(Code, &str, &str)] = &[$((
            $name,
            $title,
            include_str!(concat!("../../../docs/diagnostics/", $code, ".md")),
        )),*];
    };
}

codes! {
    // Files, containers, units.
    NOT_A_DRAWING = "D001", "not a drawing";
    // Outlines and mass.
    // What is attached.
    // Writing.
    SPATIAL = "D070", "a spatial model cannot be drawn";
    NO_PLACE = "D071", "no place in a drawing";
    DOES_NOT_FIT = "D072", "does not fit into the release";
}
