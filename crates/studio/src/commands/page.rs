//! `bksim page`: a run as one file that every browser opens.

mod live;

use std::fs::File;
use std::io::{BufReader, Write};
use std::path::{Path, PathBuf};

use bksim::log::LogReader;
use bksim::model::file::ShownUnits;
use bksim::playback::{Playback, PlaybackError};
use bksim_page::{IS_BUNDLED, Options, PageError, page};
use serde_json::json;

use crate::curve_fault::no_curve;
use crate::modal::mode_of_run;
use bksim_cli::args::ModelArgs;
use bksim_cli::args::page::Page;
use bksim_cli::commands::solve::RunFile;
use bksim_cli::exit::{Failure, Status};
use bksim_cli::origin::{file_of, is_of_model, stamped};
use bksim_cli::output;
use bksim_cli::output_file::{OutputFile, check_ending};
use bksim_cli::render;
use bksim_cli::source::shown::shown_units;

/// The advice of a build without a page.
pub(crate) const NO_PAGE: &str = "install Node.js 18 or later with npm, and build bksim again: the page's script is bundled then";

pub(crate) fn run(args: &Page, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let path = output_path(args);
    check_ending(&path, &["html", "htm"])?;
    if !IS_BUNDLED {
        return Err(Failure::usage(PageError::NotBundled.to_string(), NO_PAGE));
    }
    if args.live {
        return live::run(args, &path, as_json, nesting);
    }
    let run = RunFile::open(&args.run, nesting, as_json)?;
    if let Some(status) = run.interrupted() {
        return Ok(status);
    }
    let name = &run.name;
    let file = File::open(run.log()).map_err(|e| Failure::reading(name, &e))?;
    let log = LogReader::open(BufReader::new(file)).map_err(|e| no_page(name, &e, None))?;
    let label = file_of(log.header());
    let may_replace = args.force || is_of_model(&path, &label);
    let output =
        OutputFile::plan(&path, ("log", &[name.as_path()]), may_replace, "nothing was written")?;
    let mut playback = Playback::open(log).map_err(|e| unplayable(name, &e))?;
    if let Some(request) = args.mode.request().map_err(|e| no_curve(name, &e))? {
        let model = ModelArgs::of(name);
        playback = mode_of_run(&playback, &model, &request)?.playback;
    }
    let text = &playback.log().header.model_text;
    let units = shown_units(args.run.reading.shown(name), text, ShownUnits::of_model(text))?;
    let options = Options {
        title: args.title.clone(),
        curves: [args.curve.clone(), args.path.clone()].concat(),
        has_assemblies: args.assemblies,
        units,
        ..Options::default()
    };
    let page = page(&mut playback, &options).map_err(|e| match e {
        PageError::Curves(error) => no_curve(name, &error),
        other => no_page(name, &other, None),
    })?;
    let mut out = output.create()?;
    let html = stamped(&path, page.html.into_bytes(), &label);
    out.write_all(&html).map_err(|e| Failure::writing(&path, &e))?;
    out.finish()?;

    let n_bytes = html.len();
    if as_json {
        let [kept, all] = page.n_channels;
        let body = json!({
            "output": path.display().to_string(),
            "bytes": n_bytes,
            "polynomials": page.n_pieces,
            "deviation": page.deviation,
            "curves": kept,
            "curves_of_run": all,
            "remarks": page.remarks.join(" "),
            "diagnostics": run.diagnostics,
        });
        output::json("page", body)?;
    } else {
        for remark in &page.remarks {
            render::warning(remark);
        }
        let size = output::number((n_bytes as f64 / 1e3).round());
        output::report(&format!("wrote {}: {size} kB", path.display()))?;
    }
    Ok(run.status)
}

/// Where the page goes.
fn output_path(args: &Page) -> PathBuf {
    args.output.clone().unwrap_or_else(|| {
        let stem =
            args.run.input.file_stem().filter(|stem| *stem != "-").unwrap_or("model".as_ref());
        let mut name = stem.to_owned();
        name.push(".html");
        PathBuf::from(name)
    })
}

fn unplayable(path: &Path, error: &PlaybackError) -> Failure {
    let help = match error {
        PlaybackError::NoMotion => Some("a page shows a motion: solve to a later end time"),
        PlaybackError::Model(_) => Some("solve the model again with this version of bksim"),
        _ => None,
    };
    no_page(path, error, help)
}

pub(crate) fn no_page(path: &Path, error: &dyn std::fmt::Display, help: Option<&str>) -> Failure {
    let what = format!("cannot be made a page of: {error}");
    Failure::Input { path: path.to_owned(), what, help: help.map(str::to_owned) }
}
