//! `bksim new NAME`: a small commented model that solves, or one of the examples.

mod pictures;

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use bksim::model::file::suggest;
use serde_json::json;

use crate::args::New;
use crate::examples::EXAMPLES;
use crate::exit::{Failure, Status};
use crate::output::{self, table};
use crate::output_file::put;

const TEMPLATE: &str = include_str!("../../new.toml");

/// The name and the bytes of a file.
type NamedBytes = (String, Cow<'static, [u8]>);

/// The model file of an example, its drawing, and the model file next to that drawing.
const MODEL: &str = "model.toml";
const DRAWING: &str = "drawing.dxf";
const SIDECAR: &str = "drawing.toml";

pub(crate) fn run(args: &New, as_json: bool) -> Result<Status, Failure> {
    let Some(name) = args.name.as_deref() else { return list(args.pictures, as_json) };
    let files = match &args.template {
        Some(template) => of_example(template, stem(name), args.drawing)?,
        None => vec![(format!("{}.toml", stem(name)), Cow::Borrowed(TEMPLATE.as_bytes()))],
    };
    let paths: Vec<PathBuf> = files.iter().map(|(file, _)| PathBuf::from(file)).collect();
    if let Some(path) = paths.iter().find(|path| path.exists() && !args.force) {
        let help = Some("choose another name, or add --force to overwrite it".to_owned());
        return Err(Failure::file(path, "exists already".to_owned(), help));
    }
    let folder = paths[0].parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
        let there = folder.display();
        let what = format!("cannot be written: there is no directory `{there}`");
        return Err(Failure::file(
            &paths[0],
            what,
            Some(format!("make it with `mkdir -p {there}`")),
        ));
    }
    for (path, (_, bytes)) in paths.iter().zip(&files) {
        put(path, bytes)?;
    }
    let written: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    if as_json {
        output::json("new", json!({ "output": written[0], "files": written }))?;
    } else {
        let first = match written[0].as_str() {
            name if name.contains(char::is_whitespace) => format!("\"{name}\""),
            name => name.to_owned(),
        };
        output::report(&format!("wrote {}\nnext:  bksim solve {first}", written.join(", ")))?;
    }
    Ok(Status::Done)
}

fn stem(name: &str) -> &str {
    let path = Path::new(name);
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    let is_known = ["toml", "dxf"].contains(&ending);
    if is_known { &name[..name.len() - ending.len() - 1] } else { name }
}

/// The files of an example under a new name, that to be solved first. Names of other files stay, as the model
/// refers to them.
fn of_example(template: &str, stem: &str, wants_drawing: bool) -> Result<Vec<NamedBytes>, Failure> {
    let Some(example) = EXAMPLES.iter().find(|example| example.name == template) else {
        let names: Vec<&str> = EXAMPLES.iter().map(|example| example.name).collect();
        let message = format!("there is no template `{template}`");
        return Err(Failure::usage(message, &suggest(template, &names)));
    };
    let has = |name: &str| example.files.iter().any(|(file, _)| *file == name);
    let as_drawing = wants_drawing || !has(MODEL);
    if as_drawing && !has(DRAWING) {
        let message = format!("the template `{template}` has no drawing");
        return Err(Failure::usage(message, "leave out --drawing"));
    }
    let renamed = |name: &str| match name {
        MODEL | SIDECAR if (name == SIDECAR) == as_drawing => Some(format!("{stem}.toml")),
        DRAWING if as_drawing => Some(format!("{stem}.dxf")),
        MODEL | SIDECAR | DRAWING => None,
        other => Some(Path::new(stem).with_file_name(other).display().to_string()),
    };
    // The model next to a drawing names it.
    let contents = |name: &str, bytes: &'static [u8]| match std::str::from_utf8(bytes) {
        Ok(text) if name == SIDECAR => {
            Cow::Owned(text.replace(DRAWING, &format!("{stem}.dxf")).into_bytes())
        }
        _ => Cow::Borrowed(bytes),
    };
    let files = example.files.iter();
    let files = files.filter_map(|&(name, bytes)| Some((renamed(name)?, contents(name, bytes))));
    let mut files: Vec<(String, Cow<'static, [u8]>)> = files.collect();
    let is_drawing_alone = as_drawing && !has(SIDECAR);
    let first = format!("{stem}.{}", if is_drawing_alone { "dxf" } else { "toml" });
    files.sort_by_key(|(name, _)| *name != first);
    Ok(files)
}

/// Prints the templates.
fn list(has_pictures: bool, as_json: bool) -> Result<Status, Failure> {
    if as_json {
        let templates = EXAMPLES.iter().map(|example| {
            let files: Vec<&str> = example.files.iter().map(|(name, _)| *name).collect();
            json!({ "name": example.name, "title": example.title, "files": files })
        });
        output::json("new", json!({ "templates": templates.collect::<Vec<_>>() }))?;
    } else if has_pictures {
        let all = EXAMPLES.iter().map(|example| {
            let has = |name: &str| example.files.iter().any(|(file, _)| *file == name);
            let first = [MODEL, SIDECAR, DRAWING].into_iter().find(|name| has(name));
            let lines = first.and_then(|first| pictures::lines(example.files, first));
            let indented = lines.into_iter().flatten().map(|line| format!("\n    {line}"));
            format!("{}: {}{}\n", example.name, example.title, indented.collect::<String>())
        });
        let all: Vec<String> = all.collect();
        output::text(&format!("{}\nnext:  bksim new NAME --template TEMPLATE", all.join("\n")))?;
    } else {
        let rows: Vec<Vec<String>> = EXAMPLES
            .iter()
            .map(|example| vec![example.name.to_owned(), example.title.to_owned()])
            .collect();
        output::text(&format!("{}\nnext:  bksim new NAME --template TEMPLATE", table(&rows)))?;
    }
    Ok(Status::Done)
}
