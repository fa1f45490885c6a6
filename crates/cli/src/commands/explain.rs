//! `bksim explain CODE`: the page of a diagnostic.

use bksim::{explain, explained_codes};
use serde_json::json;

use crate::args::Explain;
use crate::exit::{Failure, Status};
use crate::output::{self, table};

pub(crate) fn run(args: &Explain, as_json: bool) -> Result<Status, Failure> {
    let Some(code) = &args.code else {
        let mut pages: Vec<_> = explained_codes().collect();
        pages.sort_unstable_by_key(|page| page.code);
        if as_json {
            let codes: Vec<_> = pages
                .iter()
                .map(|page| json!({ "code": page.code.0, "title": page.title }))
                .collect();
            output::json("explain", json!({ "codes": codes }))?;
        } else {
            let rows = pages.iter().map(|page| [page.code.0, page.title].map(str::to_owned).into());
            output::text(&table(&rows.collect::<Vec<_>>()))?;
        }
        return Ok(Status::Done);
    };
    let page = explain(code).ok_or_else(|| {
        let message = format!("no diagnostic has the code `{code}`");
        Failure::usage(message, "`bksim explain` lists all codes")
    })?;
    if as_json {
        output::json("explain", json!({ "code": page.code.0, "page": page.text }))?;
    } else {
        output::text(page.text.trim_end())?;
    }
    Ok(Status::Done)
}
