//! `bksim plot`: curves of runs as pictures.

mod choose;
mod compose;
mod curves;
mod swept;
mod window;

use std::io::Write;
use std::path::{Path, PathBuf};

use bksim::log::{LogError, Selection};
use bksim_plot::{Figure, Format, PlotError, Screen, Size, Theme};
use serde_json::{Value, json};

use bksim_cli::args::plot::{Plot, PlotTheme};
use bksim_cli::exit::{Failure, Status};
use bksim_cli::origin::{is_of_model, stamped};
use bksim_cli::output;
use bksim_cli::output_file::OutputFile;
use bksim_cli::render;
use bksim_cli::source::logged::is_log;
use choose::{Plan, Quantity};
use compose::{Drawing, Plotted};
use curves::{CurveRequest, Run};

/// Columns where there is no terminal.
const TEXT_WIDTH: u16 = 100;
/// Rows of a panel in text.
const PANEL_HEIGHT: u16 = 18;

pub(crate) fn run(args: &Plot, as_json: bool) -> Result<Status, Failure> {
    let (paths, patterns) = logs_and_channels(&args.what)?;
    args.output.as_deref().map_or(Ok(()), |path| format(path).map(drop))?;
    if swept::is_table(&paths[0]) {
        return swept::run(args, &paths[0], &patterns, as_json);
    }
    let screenshot = window::check(args, &paths)?;
    let span = [args.from.unwrap_or(f64::NEG_INFINITY), args.to.unwrap_or(f64::INFINITY)];
    if span[0].partial_cmp(&span[1]) != Some(std::cmp::Ordering::Less) {
        return Err(Failure::usage(
            "there is no time from --from to --to",
            "--from is the earlier",
        ));
    }
    let mut runs = Vec::new();
    let named: Vec<String> = patterns.iter().chain(&args.x).cloned().collect();
    for path in &paths {
        let mut run = Run::open(path).map_err(|e| bad_log(path, &e))?;
        run.measure(&named)?;
        runs.push(run);
    }
    let model_name = runs[0].header.model_name.clone();
    let picture = args.output.as_deref().map(|path| {
        let may_replace = args.force || is_of_model(path, &model_name);
        picture(path, &paths, may_replace)
    });
    let picture = picture.transpose()?;
    let headers: Vec<_> = runs.iter().map(|run| &run.header).collect();
    let first = &paths[0];
    let plan = if patterns.is_empty() {
        Plan::overview(headers[0], runs.len())
    } else {
        Plan::named(&headers, &patterns).map_err(|e| bad_log(first, &e))?
    };
    let x = args.x.as_ref().map(|name| abscissa(name, &runs[0])).transpose()?;

    // The curves.
    let (quantities, is_zoomed) = (plan.quantities().collect(), args.window);
    let wish = CurveRequest { quantities, x: x.as_ref(), span, is_zoomed };
    let mut drawn = Vec::new();
    for run in &mut runs {
        let curves = run.curves(&wish);
        drawn.push(curves.map_err(|e| bad_log(&run.path, &e))?);
    }
    let drawing = Drawing { runs: &runs, plan: &plan, x: x.as_ref(), drawn: &drawn };
    let plotted = drawing.plotted(args.title.as_deref(), args.log_y);
    if plotted.n_values() == 0 {
        let what = "has no values of these channels in this time".to_owned();
        let help = Some(format!("`bksim info {}` lists what it holds", first.display()));
        return Err(Failure::Input { path: first.clone(), what, help });
    }
    if !as_json {
        warn(&runs);
    }
    if args.window {
        window::show(args, screenshot.as_ref(), &plotted)?;
    }
    if let Some((output, format)) = &picture {
        let bytes = drawn_as(args, *format, &plotted.figure)?;
        put(output, &stamped(output.path(), bytes, &model_name))?;
    }
    if as_json {
        let format = picture.map(|(_, format)| format);
        output::json("plot", report(args, format, &runs, &plotted))?;
    } else if let Some(path) = &args.screenshot {
        output::text(&format!("wrote {}: {}", path.display(), plotted.summary()))?;
    } else if args.window {
        // What is to be said of it has been seen.
    } else if let Some(path) = &args.output {
        output::text(&format!("wrote {}: {}", path.display(), plotted.summary()))?;
    } else {
        let left_out = plotted.left_out().map(|words| format!("\n{words}")).unwrap_or_default();
        output::styled(&format!("{}{left_out}", text_of(&plotted.figure)))?;
    }
    Ok(Status::Done)
}

/// The picture in characters, as wide as the terminal.
fn text_of(figure: &Figure) -> String {
    let screen = Screen {
        width: terminal_size::terminal_size().map_or(TEXT_WIDTH, |(width, _)| width.0),
        panel_height: PANEL_HEIGHT,
        has_colors: true,
    };
    figure.renamed(&output::unstyled).to_text(screen).trim_end().to_owned()
}

/// The words of the command line, sorted: files that are there or end as logs do, and the rest.
fn logs_and_channels(what: &[String]) -> Result<(Vec<PathBuf>, Vec<String>), Failure> {
    // The first is a log, or was meant to be one.
    let (first, rest) = what.split_first().ok_or_else(|| {
        Failure::usage("there is no log to draw", "name one: `bksim plot run.mcap`")
    })?;
    if swept::is_table(Path::new(first)) {
        return Ok((vec![PathBuf::from(first)], rest.to_vec()));
    }
    let (logs, channels): (Vec<&String>, Vec<&String>) =
        rest.iter().partition(|text| is_log(Path::new(text)));
    let paths = std::iter::once(first).chain(logs).map(PathBuf::from).collect();
    Ok((paths, channels.into_iter().cloned().collect()))
}

/// The file, and the format that its name asks for; refuses names that cannot be written.
fn picture(path: &Path, read: &[PathBuf], force: bool) -> Result<(OutputFile, Format), Failure> {
    let format = format(path)?;
    Ok((planned(path, read, force)?, format))
}

/// The format that the name of a picture asks for.
fn format(path: &Path) -> Result<Format, Failure> {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    match ending.to_ascii_lowercase().as_str() {
        "svg" => Ok(Format::Svg),
        "png" => Ok(Format::Png),
        "pdf" => Ok(Format::Pdf),
        _ => {
            let message = format!("`{}` has no ending that names a picture", path.display());
            Err(Failure::usage(message, "end the name with .svg, .png or .pdf"))
        }
    }
}

/// The file of a picture; refuses names of what is read, or of what is there already.
fn planned(path: &Path, read: &[PathBuf], force: bool) -> Result<OutputFile, Failure> {
    let read: Vec<&Path> = read.iter().map(PathBuf::as_path).collect();
    OutputFile::plan(path, ("log", &read), force, "nothing was written")
}

/// Writes a picture.
fn put(output: &OutputFile, bytes: &[u8]) -> Result<(), Failure> {
    let mut out = output.create()?;
    out.write_all(bytes).map_err(|e| Failure::writing(output.path(), &e))?;
    out.finish()
}

/// The channel of the abscissa, which is one.
fn abscissa(name: &str, run: &Run) -> Result<Quantity, Failure> {
    let selection = Selection::new(&run.header, [name]).map_err(|e| bad_log(&run.path, &e))?;
    match selection.columns() {
        [column] => Ok(Quantity::channel(column, true)),
        columns => Err(Failure::usage(
            format!("`--x {name}` names {} channels", columns.len()),
            "name one of them",
        )),
    }
}

fn drawn_as(args: &Plot, format: Format, figure: &Figure) -> Result<Vec<u8>, Failure> {
    let theme = match args.theme {
        None | Some(PlotTheme::Light) => Theme::LIGHT,
        Some(PlotTheme::Dark) => Theme::DARK,
    };
    let size = args.size.map(|(width, height)| Size { width, height });
    figure.render(format, size, &theme).map_err(|error| match error {
        PlotError::Size { .. } => Failure::usage(error.to_string(), "choose another --size"),
        other => {
            let path = args.output.as_deref().unwrap_or(Path::new("the picture"));
            Failure::file(path, format!("cannot be drawn: {other}"), None)
        }
    })
}

fn warn(runs: &[Run]) {
    for run in runs {
        let path = run.path.display();
        if !run.is_complete {
            render::warning(&format!("`{path}` was cut off before its run ended"));
        }
        if let Some(why) = &run.coarse_because {
            render::warning(&format!("`{path}` is drawn through its samples alone: {why}"));
        }
    }
}

fn report(args: &Plot, format: Option<Format>, runs: &[Run], plotted: &Plotted) -> Value {
    let logs = runs.iter().map(|run| {
        json!({
            "log": run.path.display().to_string(),
            "model": run.header.model_name,
            "complete": run.is_complete,
        })
    });
    json!({
        "output": args.output.as_ref().map(|path| path.display().to_string()),
        "format": match format {
            Some(format) => format_word(format),
            None if args.window => "window",
            None => "text",
        },
        "screenshot": args.screenshot.as_ref().map(|path| path.display().to_string()),
        "title": plotted.figure.title,
        "x": args.x,
        "runs": logs.collect::<Vec<_>>(),
        "panels": plotted.panels_json(runs),
        "left_out": plotted.n_left_out,
    })
}

fn format_word(format: Format) -> &'static str {
    match format {
        Format::Svg => "svg",
        Format::Png => "png",
        Format::Pdf => "pdf",
    }
}

fn bad_log(path: &Path, error: &LogError) -> Failure {
    let what = format!("cannot be drawn: {error}");
    match error {
        LogError::UnknownChannel { .. } => Failure::usage(
            format!("`{}` {what}", path.display()),
            &format!("`bksim info {}` lists the channels", path.display()),
        ),
        LogError::Io(error) => Failure::reading(path, error),
        _ => Failure::Input { path: path.to_owned(), what, help: None },
    }
}
