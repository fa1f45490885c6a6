//! The pages behind the diagnostic codes.

use bksim_model::diagnostic::Page;
use bksim_model::file;
use bksim_sim::codes;

/// Every code of models, runs and drawings, with its page.
pub fn explained_codes() -> impl Iterator<Item = &'static Page> {
    file::PAGES.iter().chain(codes::PAGES).chain(bksim_cad::codes::PAGES)
}
