//! `bksim explain CODE`: the page of a diagnostic.

use serde_json::json;

use crate::args::Explain;
use crate::exit::{Failure, Status};
use crate::output::{self, table};

pub(crate) fn run(args: &Explain, as_json: bool) -> Result<Status, Failure> {
    let Some(code) = &args.code else {
        let codes = bksim::explained_codes();
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
    let page = bksim::explain(code).ok_or_else(|| {
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
