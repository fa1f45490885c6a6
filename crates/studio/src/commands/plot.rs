//! `bksim plot`: curves of runs as pictures.

mod choose;
mod compose;
mod curves;
mod player;
mod swept;
mod table;
mod units;
mod window;

use std::io::Write;
use std::path::{Path, PathBuf};

use bksim::log::{Header, LogError, Selection};
use bksim::model::file::ShownUnits;
use bksim_plot::{Figure, Format, PlotError, Screen, Size, Theme};
use serde_json::{Value, json};

use bksim_cli::args::DrawingArgs;
use bksim_cli::args::changes::Changes;
use bksim_cli::args::plot::{Plot, PlotTheme};
use bksim_cli::args::run::{ReadingArgs, RunArgs};
use bksim_cli::commands::solve::RunFile;
use bksim_cli::exit::{Failure, Status};
use bksim_cli::origin::{file_of, is_of_model, stamped};
use bksim_cli::output;
use bksim_cli::output_file::OutputFile;
use bksim_cli::render;
use bksim_cli::source::logged::is_log;
use bksim_cli::source::shown::shown_units;
use choose::{Plan, Quantity};
use compose::{Drawing, Plotted};
use curves::{CurveRequest, Run};
use table::{Table, is_csv};
use units::{Units, name_and_unit};

/// Columns where there is no terminal.
const TEXT_WIDTH: u16 = 100;
/// Rows of a panel in text.
const PANEL_HEIGHT: u16 = 18;

pub(crate) fn run(args: &Plot, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let (paths, asked) = (args.files(), args.channels());
    let mut patterns: Vec<String> =
        asked.iter().map(|asked| name_and_unit(asked).0.into()).collect();
    let x_name = args.x.as_deref().map(|x| name_and_unit(x).0);
    args.output.as_deref().map_or(Ok(()), |path| format(path).map(drop))?;
    if swept::is_table(&paths[0]) {
        return swept::run(args, &paths[0], &asked, as_json);
    }
    let screenshot = window::check(args, &paths)?;
    let span = [args.from.unwrap_or(f64::NEG_INFINITY), args.to.unwrap_or(f64::INFINITY)];
    if span[0].partial_cmp(&span[1]) != Some(std::cmp::Ordering::Less) {
        return Err(Failure::usage(
            "there is no time from --from to --to",
            "--from is the earlier",
        ));
    }
    // The tables, and the logs, of which those of models are made first.
    let tables: Vec<Table> = paths
        .iter()
        .filter(|path| is_csv(path))
        .map(|path| Table::read(path))
        .collect::<Result<_, _>>()?;
    if patterns.is_empty() && args.path.is_empty() {
        patterns = shown_by(&tables, x_name);
    }
    let mut logs = Vec::new();
    for path in paths.iter().filter(|path| !is_csv(path)) {
        let of = RunArgs { input: path.clone(), reading: reading_of(args, path) };
        let log = RunFile::open(&of, nesting, as_json)?;
        if let Some(status) = log.interrupted() {
            return Ok(status);
        }
        logs.push(log);
    }
    let mut named = patterns.clone();
    named.extend(x_name.map(str::to_owned));
    named.extend(args.path.iter().flat_map(|point| coordinates(point)));
    let mut runs = opened(args, (&paths, &logs), tables, &named)?;
    let label = file_of(&runs[0].header);
    let picture = args.output.as_deref().map(|path| {
        let may_replace = args.force || is_of_model(path, &label);
        picture(path, &paths, may_replace)
    });
    let picture = picture.transpose()?;
    let headers: Vec<_> = runs.iter().map(|run| &run.header).collect();
    let first = &runs[0].path.clone();
    let text = &headers[0].model_text;
    let stated = shown_units(args.reading.shown(first), text, ShownUnits::of_model(text))?;
    let with_x: Vec<String> = asked.iter().chain(&args.x).cloned().collect();
    let units = Units::new(stated, &with_x, &headers)?;
    let plan = if !patterns.is_empty() {
        Plan::named(&headers, &patterns, &units).map_err(|e| bad_log(first, &e))?
    } else if args.path.is_empty() {
        Plan::overview(headers[0], runs.len(), &units)
    } else {
        Plan::default()
    };
    let x = x_name.map(|name| abscissa("--x", name, &runs, &units)).transpose()?;
    let missing = missing(&runs, &plan, x.as_ref())?;

    // The curves, then the paths of points.
    let mut plotted = curves_of(args, &mut runs, (&plan, x.as_ref()), (span, &units))?;
    let mut ways = Vec::new();
    for point in &args.path {
        let [x_name, y_name] = coordinates(point);
        let x = abscissa("--path", &x_name, &runs, &units)?;
        let headers: Vec<_> = runs.iter().map(|run| &run.header).collect();
        let plan = Plan::named(&headers, &[y_name], &units).map_err(|e| bad_log(first, &e))?;
        let way = curves_of(args, &mut runs, (&plan, Some(&x)), (span, &units))?;
        ways.push((point.clone(), way));
    }
    plotted.join(ways);
    if plotted.n_values() == 0 {
        let what = "has no values of these channels in this time".to_owned();
        let help = Some(format!("`bksim info {}` lists what it holds", first.display()));
        return Err(Failure::Input { path: first.clone(), what, help });
    }
    if !as_json {
        warn(&runs, &missing);
    }
    if args.window {
        window::show(args, (screenshot.as_ref(), &label), &plotted)?;
    }
    if let Some((output, format)) = &picture {
        let bytes = drawn_as(args, *format, &plotted.figure)?;
        put(output, &stamped(output.path(), bytes, &label))?;
    }
    if as_json {
        let format = picture.map(|(_, format)| format);
        output::json("plot", report(args, format, (&runs, &missing), &plotted))?;
    } else if let Some(path) = &args.screenshot {
        output::report(&format!("wrote {}: {}", path.display(), plotted.summary()))?;
    } else if args.window {
        // What is to be said of it has been seen.
    } else if let Some(path) = &args.output {
        output::report(&format!("wrote {}: {}", path.display(), plotted.summary()))?;
    } else {
        let left_out = plotted.left_out().map(|words| format!("\n{words}")).unwrap_or_default();
        output::styled(&format!("{}{left_out}", text_of(&plotted.figure)))?;
    }
    Ok(Status::Done)
}

/// The logs as runs, with the quantities of these names, then the tables.
fn opened(
    args: &Plot,
    (paths, logs): (&[PathBuf], &[RunFile]),
    tables: Vec<Table>,
    named: &[String],
) -> Result<Vec<Run>, Failure> {
    let mut runs = Vec::new();
    for (path, log) in paths.iter().filter(|path| !is_csv(path)).zip(logs) {
        let mut run = Run::open(path, &log.log()).map_err(|e| bad_log(path, &e))?;
        run.measure(named)?;
        runs.push(run);
    }
    let is_over_time = args.x.is_none() && args.path.is_empty();
    for table in tables {
        let path = table.path().to_owned();
        if is_over_time && !table.has_times() {
            return Err(no_times(&table));
        }
        let headers: Vec<&Header> = runs.iter().map(|run: &Run| &run.header).collect();
        let contents = table.beside(&headers)?;
        runs.push(Run::of_table(&path, contents));
    }
    Ok(runs)
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

/// The curves of a plan over an abscissa, or over the time.
fn curves_of(
    args: &Plot,
    runs: &mut [Run],
    (plan, x): (&Plan, Option<&Quantity>),
    (span, units): ([f64; 2], &Units),
) -> Result<Plotted, Failure> {
    let (quantities, is_zoomed) = (plan.quantities().collect(), args.window);
    let wish = CurveRequest { quantities, x, span, is_zoomed };
    let mut drawn = Vec::new();
    for run in runs.iter_mut() {
        let curves = run.curves(&wish);
        drawn.push(curves.map_err(|e| bad_log(&run.path, &e))?);
    }
    let x_unit = x.map_or_else(|| units.of("", "s"), |x| x.shown.clone());
    let drawing = Drawing { runs, plan, x, x_unit, units, drawn: &drawn };
    Ok(drawing.plotted(args.title.as_deref(), args.log_y))
}

/// Names of the coordinates of a point in the plane of drawing.
fn coordinates(point: &str) -> [String; 2] {
    ["x", "y"].map(|axis| format!("{point}.{axis}"))
}

/// How a file is read: options of models do not concern logs next to them.
fn reading_of(args: &Plot, path: &Path) -> ReadingArgs {
    let has_models = args.files().iter().any(|file| !is_log(file));
    if has_models && is_log(path) {
        let drawing = DrawingArgs { tolerance: None, ..args.reading.drawing.clone() };
        return ReadingArgs { set: Changes::default(), drawing };
    }
    args.reading.clone()
}

/// The file, and the format that its name asks for; refuses names that cannot be written.
pub(super) fn picture(
    path: &Path,
    read: &[PathBuf],
    force: bool,
) -> Result<(OutputFile, Format), Failure> {
    let format = format(path)?;
    Ok((planned(path, read, force)?, format))
}

/// The format that the name of a picture asks for.
fn format(path: &Path) -> Result<Format, Failure> {
    let ending = path.extension().and_then(|ending| ending.to_str());
    ending.and_then(Format::named).ok_or_else(|| {
        let message = format!("`{}` has no ending that names a picture", path.display());
        Failure::usage(message, "end the name with .svg, .png or .pdf")
    })
}

/// The file of a picture; refuses names of what is read, or of what is there already.
fn planned(path: &Path, read: &[PathBuf], force: bool) -> Result<OutputFile, Failure> {
    let read: Vec<&Path> = read.iter().map(PathBuf::as_path).collect();
    OutputFile::plan(path, ("log", &read), force, "nothing was written")
}

/// Writes a picture.
pub(super) fn put(output: &OutputFile, bytes: &[u8]) -> Result<(), Failure> {
    let mut out = output.create()?;
    out.write_all(bytes).map_err(|e| Failure::writing(output.path(), &e))?;
    out.finish()
}

/// The channel of the abscissa, which is one.
fn abscissa(option: &str, name: &str, runs: &[Run], units: &Units) -> Result<Quantity, Failure> {
    let selections = runs.iter().map(|run| Selection::new(&run.header, [name]));
    let selection = selections.reduce(Result::or);
    let selection = selection.expect("a run at least").map_err(|e| bad_log(&runs[0].path, &e))?;
    match selection.columns() {
        [column] => Ok(Quantity::channel(column, true, units)),
        columns => Err(Failure::usage(
            format!("`{option} {name}` names {} channels", columns.len()),
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

/// The columns of tables that are drawn where nothing is named, each once.
fn shown_by(tables: &[Table], x_name: Option<&str>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for name in tables.iter().flat_map(Table::names) {
        if Some(name) != x_name && !names.iter().any(|known| known == name) {
            names.push(name.to_owned());
        }
    }
    names
}

fn no_times(table: &Table) -> Failure {
    let message = format!("`{}` has no column `t`", table.path().display());
    let first = table.names().next().unwrap_or("A.angle");
    Failure::usage(message, &format!("draw it over one of its columns: `--x {first}`"))
}

/// By run the named quantities that it has not.
///
/// # Errors
/// A run that has none of all, or not the abscissa.
fn missing<'p>(
    runs: &[Run],
    plan: &'p Plan,
    x: Option<&Quantity>,
) -> Result<Vec<Vec<&'p str>>, Failure> {
    let mut all = Vec::new();
    for run in runs {
        let of_run = |what: String| {
            let names = Selection::all(&run.header);
            let names: Vec<&str> = names.columns().iter().map(|c| c.name.as_str()).collect();
            let path = run.path.display();
            let help = if run.is_table() {
                format!("it has {}", names.join(", "))
            } else {
                format!("`bksim info {path}` lists the channels")
            };
            Failure::usage(format!("`{path}` has {what}"), &help)
        };
        if let Some(x) = x.filter(|x| !run.has(x)) {
            return Err(of_run(format!("no `{}` to draw over", x.name)));
        }
        let lacks = |quantity: &&Quantity| !run.has(quantity);
        let (n, n_lacking) = (plan.quantities().count(), plan.quantities().filter(lacks).count());
        if n > 0 && n_lacking == n {
            let names: Vec<String> =
                plan.quantities().map(|quantity| format!("`{}`", quantity.name)).collect();
            return Err(of_run(match names.as_slice() {
                [one] => format!("no {one}"),
                many => format!("none of {}", many.join(", ")),
            }));
        }
        let named = plan.quantities().filter(|quantity| quantity.is_named && lacks(quantity));
        all.push(named.map(|quantity| quantity.name.as_str()).collect());
    }
    Ok(all)
}

fn warn(runs: &[Run], missing: &[Vec<&str>]) {
    for (run, missing) in runs.iter().zip(missing) {
        let path = run.path.display();
        if !missing.is_empty() {
            let names: Vec<String> = missing.iter().map(|name| format!("`{name}`")).collect();
            render::warning(&format!("`{path}` has no {}, and no curve of it", names.join(", ")));
        }
        if !run.is_complete {
            render::warning(&format!("`{path}` was cut off before its run ended"));
        }
        if let Some(why) = &run.coarse_because {
            render::warning(&format!("`{path}` is drawn through its samples alone: {why}"));
        }
    }
}

fn report(
    args: &Plot,
    format: Option<Format>,
    (runs, missing): (&[Run], &[Vec<&str>]),
    plotted: &Plotted,
) -> Value {
    let logs = runs.iter().zip(missing).map(|(run, missing)| {
        json!({
            "missing": missing,
            "log": run.path.display().to_string(),
            "model": run.header.model_name,
            "complete": run.is_complete,
        })
    });
    json!({
        "output": args.output.as_ref().map(|path| path.display().to_string()),
        "format": match format {
            Some(format) => format.ending(),
            None if args.window => "window",
            None => "text",
        },
        "screenshot": args.screenshot.as_ref().map(|path| path.display().to_string()),
        "title": plotted.figure.title,
        "x": args.x,
        "runs": logs.collect::<Vec<_>>(),
        "path": args.path,
        "panels": plotted.panels_json(runs),
        "left_out": plotted.n_left_out,
    })
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
