//! `bksim explain CODE`: the page of a diagnostic.

use serde_json::json;

use crate::args::Explain;
use crate::exit::{Failure, Status};
use crate::output::{self, table};

pub(crate) fn run(args: &Explain, as_json: bool) -> Result<Status, Failure> {
    let Some(code) = &args.code else {
        let mut codes = bksim::explained_codes();
        codes.extend(bksim_sweep::codes::PAGES.iter().map(|(code, title, _)| (code.0, *title)));
        codes.sort_unstable();
        if as_json {
            let codes: Vec<_> =
                codes.iter().map(|(code, title)| json!({ "code": code, "title": title })).collect();
            output::json("explain", json!({ "codes": codes }))?;
        } else {
            let rows = codes.iter().map(|&(code, title)| vec![code.to_owned(), title.to_owned()]);
            output::text(&table(&rows.collect::<Vec<_>>()))?;
        }
        return Ok(Status::Done);
    };
    let mut of_sweeps = bksim_sweep::codes::PAGES.iter();
    let of_sweep = of_sweeps.find(|(known, ..)| known.0.eq_ignore_ascii_case(code.trim()));
    let page = bksim::explain(code).or(of_sweep.map(|(.., page)| *page)).ok_or_else(|| {
        let message = format!("no diagnostic has the code `{code}`");
        Failure::usage(message, "`bksim explain` lists all codes")
    })?;
    if as_json {
        output::json("explain", json!({ "code": code.to_uppercase(), "page": page }))?;
    } else {
        output::text(page.trim_end())?;
    }
    Ok(Status::Done)
}
