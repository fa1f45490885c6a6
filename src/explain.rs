//! The pages behind the diagnostic codes.

use bksim_model::diagnostic::Page;
use bksim_model::file;
use bksim_sim::codes;

use crate::{design_codes, sweep_codes};

/// Every code there is, those of models, runs and drawings first, with its page;
/// those of parts that are left out by features are missing.
pub fn explained_codes() -> impl Iterator<Item = &'static Page> {
    let mut pages: Vec<&'static Page> =
        file::PAGES.iter().chain(codes::PAGES).chain(bksim_edit::PAGES).collect();
    #[cfg(feature = "drawings")]
    pages.extend(bksim_cad::codes::PAGES);
    #[cfg(feature = "import")]
    pages.extend(bksim_import::PAGES);
    #[cfg(feature = "fmu")]
    pages.extend(bksim_fmu::PAGES);
    let of_questions = bksim_analysis::codes::PAGES;
    let rest = sweep_codes::PAGES.iter().chain(design_codes::PAGES).chain(of_questions);
    pages.into_iter().chain(rest)
}

/// The page of a code such as `M012`; letters may be lower case.
pub fn explain(code: &str) -> Option<&'static Page> {
    explained_codes().find(|page| page.code.0.eq_ignore_ascii_case(code.trim()))
}
