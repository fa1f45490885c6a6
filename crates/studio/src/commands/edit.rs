//! `bksim edit`: a model in a page of this computer, which writes its file; or edits from the command line.

mod file;
mod server;

use bksim_cli::args::live::Edit as Args;
use bksim_cli::exit::{Failure, Status};
use bksim_cli::output;
use bksim_cli::render;
use bksim_cli::source::{Text, is_stdin};
use bksim_edit::{Document, Edit, EditError};
use bksim_page::{IS_BUNDLED, LiveOptions, PageError, live};
use serde_json::json;

use self::file::ModelFile;
use self::server::Server;
use super::module::{backdrop, module};
use super::page::NO_PAGE;

pub(crate) fn run(args: &Args, as_json: bool) -> Result<Status, Failure> {
    if is_stdin(&args.model) {
        return Err(Failure::usage(
            "a model from standard input has no file to be written",
            "name a model file",
        ));
    }
    let file = ModelFile::open(&args.model)?;
    if !args.apply.is_empty() {
        return apply(args, &file, as_json);
    }
    if !IS_BUNDLED {
        return Err(Failure::usage(PageError::NotBundled.to_string(), NO_PAGE));
    }
    let module = module()?;
    let server = Server::open(args.port)?;
    let url = server.url();
    if as_json {
        output::json("edit", json!({ "url": url, "model": args.model.display().to_string() }))?;
    } else {
        output::report(&format!("open {url} in a browser of this computer; Ctrl+C ends it"))?;
    }
    let units = args.units.as_ref();
    let under = args.under.as_deref().map(|path| backdrop(path, units)).transpose()?;
    let options = LiveOptions { title: None, is_served: true, under };
    let page = |text: &str| live(text, file.name(), &module, &options).map_err(|e| e.to_string());
    server.serve(&file, &page);
    Ok(Status::Done)
}

/// Makes edits and writes the file, or changes nothing.
fn apply(args: &Args, file: &ModelFile, as_json: bool) -> Result<Status, Failure> {
    let before = file.read()?;
    let mut document = Document::new(&before);
    for text in &args.apply {
        let edit: Edit = serde_json::from_str(text).map_err(|error| {
            let help = "write an object such as {\"edit\": \"set\", \"path\": \"bodies.rod.mass\", \"value\": \"2 kg\"}";
            Failure::usage(format!("`--apply` takes an edit as JSON: {error}"), help)
        })?;
        document.apply(&edit).map_err(|error| refused(args, document.text(), &error))?;
    }
    file.write(&before, document.text())?;
    if as_json {
        let body = json!({ "model": args.model.display().to_string(), "edits": args.apply.len() });
        output::json("edit", body)?;
    } else {
        render::line(&format!("wrote {}", args.model.display()));
    }
    Ok(Status::Done)
}

/// An edit that cannot be made, as a fault of the model.
fn refused(args: &Args, text: &str, error: &EditError) -> Failure {
    Failure::Model {
        source: Box::new(Text::new(&args.model, text.to_owned())),
        diagnostics: vec![error.diagnostic(text)],
    }
}
