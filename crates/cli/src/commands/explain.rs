//! `bksim explain CODE`: the page of a diagnostic.

use bksim::model::diagnostic::Page;
use bksim::translation::{page, translation};
use bksim::{explain, explained_codes};
use serde_json::json;

use crate::args::text::Explain;
use crate::exit::{Failure, Status};
use crate::output::{self, table};
use bksim::translation::spoken as language;

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
            let title = |page: &Page| {
                let words = translation(page.code.0, language());
                words.map_or(page.title.to_owned(), |words| words.title.clone())
            };
            let rows = pages.iter().map(|page| vec![page.code.0.to_owned(), title(page)]);
            output::text(&table(&rows.collect::<Vec<_>>()))?;
        }
        return Ok(Status::Done);
    };
    let unknown = || {
        let message = format!("no diagnostic has the code `{code}`");
        Failure::usage(message, "`bksim explain` lists all codes")
    };
    let code = explain(code).ok_or_else(unknown)?.code.0;
    let text = page(code, language()).ok_or_else(unknown)?;
    if as_json {
        output::json("explain", json!({ "code": code, "page": text }))?;
    } else {
        output::text(text.trim_end())?;
    }
    Ok(Status::Done)
}
