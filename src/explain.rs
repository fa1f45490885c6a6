//! The page behind every diagnostic code.

use bksim_mbs::{codes, file};

/// The Markdown page of a code such as `M012`; letters may be lower case.
pub fn explain(code: &str) -> Option<&'static str> {
    let of_run =
        codes::PAGES.iter().find(|(known, _, _)| known.0.eq_ignore_ascii_case(code.trim()));
    of_run.map(|&(_, _, page)| page).or_else(|| file::explain(code.trim()))
}

/// Every code with its title, in order.
pub fn explained_codes() -> Vec<(&'static str, &'static str)> {
    let of_file = file::PAGES.iter().map(|page| (page.code.0, page.title));
    let of_run = codes::PAGES.iter().map(|&(code, title, _)| (code.0, title));
    of_file.chain(of_run).collect()
}
