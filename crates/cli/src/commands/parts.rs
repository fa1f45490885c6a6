//! `bksim parts`: the parts that come with bksim, or the text of one.

use bksim::model::file::suggest;
use bksim::model::library::{LIBRARY, LibraryPart};
use serde_json::json;

use crate::exit::{Failure, Status};
use crate::output::{self, table};

pub(crate) fn run(name: Option<&str>, as_json: bool) -> Result<Status, Failure> {
    let Some(name) = name else { return list(as_json) };
    let Some(part) = LibraryPart::named(name) else {
        let names: Vec<&str> = LIBRARY.iter().map(|part| part.name).collect();
        return Err(Failure::usage(format!("there is no part `{name}`"), &suggest(name, &names)));
    };
    if as_json {
        output::json("parts", json!({ "name": part.name, "model": part.text }))?;
    } else {
        output::text(part.text.trim_end())?;
    }
    Ok(Status::Done)
}

fn list(as_json: bool) -> Result<Status, Failure> {
    if as_json {
        let parts = LIBRARY.iter().map(|part| json!({ "name": part.name, "about": part.about() }));
        output::json("parts", json!({ "parts": parts.collect::<Vec<_>>() }))?;
        return Ok(Status::Done);
    }
    let title = |part: &LibraryPart| {
        let about = part.about();
        about.split(['.', ':']).next().unwrap_or_default().replace('\n', " ")
    };
    let rows: Vec<Vec<String>> =
        LIBRARY.iter().map(|part| vec![part.name.to_owned(), title(part)]).collect();
    output::text(&table(&rows))?;
    Ok(Status::Done)
}
