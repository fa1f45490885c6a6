//! The pages behind the diagnostic codes.

use bksim_mbs::diagnostic::Page;
use bksim_mbs::{codes, file};

/// Every code of models, runs and drawings, with its page.
pub fn explained_codes() -> impl Iterator<Item = &'static Page> {
    file::PAGES.iter().chain(codes::PAGES).chain(bksim_cad::codes::PAGES)
}
