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
    TOO_LARGE = "D002", "a drawing too large";
    DAMAGED = "D003", "a damaged drawing";
    CUT = "D004", "a drawing cut off";
    ABSURD_NUMBER = "D005", "a number no drawing has";
    NO_UNITS = "D006", "a drawing without units";
    OTHER_UNITS = "D007", "units against those of the drawing";
    UNREADABLE = "D008", "a drawing that cannot be interpreted";
    BLOCK_IN_ITSELF = "D009", "a block within itself";
    // Outlines and mass.
    // What is attached.
    // Writing.
    NOT_THERE = "D060", "nothing there to edit";
    DOES_NOT_FIT = "D061", "a value the drawing cannot hold";
    BY_LAYER = "D062", "attached by its layer";
    WRITTEN_ANEW = "D063", "a drawing written anew";
    NO_SUCH_KEY = "D064", "a key that the kind does not have";
    NAME_TAKEN = "D065", "a name that is taken";
}
