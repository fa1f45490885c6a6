//! The page behind every diagnostic code.

use bksim_mbs::{codes, file};

/// The Markdown page of a code such as `M012`; letters may be lower case.
pub fn explain(code: &str) -> Option<&'static str> {
    let mut others = codes::PAGES.iter().chain(bksim_cad::codes::PAGES);
    let of_run = others.find(|(known, _, _)| known.0.eq_ignore_ascii_case(code.trim()));
    of_run.map(|&(_, _, page)| page).or_else(|| file::explain(code.trim()))
}

/// Every code with its title, in order.
pub fn explained_codes() -> Vec<(&'static str, &'static str)> {
    let of_file = file::PAGES.iter().map(|page| (page.code.0, page.title));
    let others = codes::PAGES.iter().chain(bksim_cad::codes::PAGES);
    let mut all: Vec<_> = of_file.chain(others.map(|&(code, title, _)| (code.0, title))).collect();
    all.sort_unstable();
    all
}
