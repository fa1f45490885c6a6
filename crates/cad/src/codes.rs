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
    OPEN_OUTLINE = "D020", "an open outline";
    AMBIGUOUS_ENDS = "D021", "ends that meet in more than one way";
    CROSSING_OUTLINES = "D022", "outlines that cross";
    DOUBLE_OUTLINE = "D023", "outlines on top of each other";
    NO_AREA = "D024", "an outline without area";
    NO_CURVE = "D025", "numbers that make no curve";
    SNAPPED = "D026", "a gap that was closed";
    // What is attached.
    // Writing.
}
