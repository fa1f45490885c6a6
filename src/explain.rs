//! The pages behind the diagnostic codes.

use bksim_model::diagnostic::Page;
use bksim_model::file;
use bksim_sim::codes;

use crate::{design_codes, sweep_codes};

/// Every code there is, those of models, runs and drawings first, with its page.
pub fn explained_codes() -> impl Iterator<Item = &'static Page> {
    let of_questions = bksim_analysis::codes::PAGES;
    let of_runs = file::PAGES.iter().chain(codes::PAGES).chain(bksim_cad::codes::PAGES);
    let of_runs =
        of_runs.chain(bksim_import::PAGES).chain(bksim_edit::PAGES).chain(bksim_fmu::PAGES);
    of_runs.chain(sweep_codes::PAGES).chain(design_codes::PAGES).chain(of_questions)
}

/// The page of a code such as `M012`; letters may be lower case.
pub fn explain(code: &str) -> Option<&'static Page> {
    explained_codes().find(|page| page.code.0.eq_ignore_ascii_case(code.trim()))
}
