//! `bksim view`: a window that shows the mechanism moving.

mod motion;

use std::cell::Cell;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bksim::edit::names::defined;
use bksim::edit::{Edit, Places, edited};
use bksim::model::file::ShownUnits;
use bksim_view::window::{Look, Outcome, Report, Save, Source, WindowError, WindowOptions, open};
use serde_json::{Value, json};

use self::motion::Motion;
use crate::curve_fault::no_curve;
use bksim_cli::args::view::View;
use bksim_cli::exit::{Failure, Status};
use bksim_cli::origin::{is_of_model, stamped};
use bksim_cli::output;
use bksim_cli::output_file::{check_ending, put};
use bksim_cli::render;
use bksim_cli::source::is_stdin;
use bksim_cli::source::shown::shown_units;

pub(crate) fn run(args: &View, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let started = Instant::now();
    check(args)?;
    let model = args.reading.model(&args.input);
    let units = args.reading.shown(&args.input).map(str::to_owned);
    shown_units(units.as_deref(), "", ShownUnits::default())?;
    let mode = args.mode.request().map_err(|e| no_curve(&args.input, &e))?;
    let motion = Motion {
        model,
        units,
        nesting,
        curves: [args.curve.clone(), args.path.clone()].concat(),
        mode,
        is_cut: args.section.is_some(),
    };
    let (file, is_written) = (args.input.clone(), is_written(&args.input));
    let save: Option<Save> = (motion.takes_values() && is_written)
        .then(|| Box::new(move |values: &[(String, String)]| save(&file, values)) as Save);
    let source = Source {
        name: args.input.display().to_string(),
        files: vec![args.input.clone()].into_iter().filter(|path| !is_stdin(path)).collect(),
        takes_values: motion.takes_values(),
        save,
        load: Box::new(move |task| motion.load(task)),
    };
    let options = WindowOptions {
        t: args.t,
        is_paused: args.paused,
        section: args.section,
        size: args.size,
        look: match (args.dark, args.light) {
            (true, _) => Look::Dark,
            (_, true) => Look::Light,
            _ => Look::System,
        },
        shot_after: args.screenshot.as_ref().map(|_| Duration::from_secs_f64(args.after)),
        n_frames: args.frames.map(|n| n as usize),
        started,
    };
    let outcome = open(source, &options, Box::new(reporter(&args.input, as_json)));
    let instead = "`bksim render` makes pictures and films without a window";
    let outcome = outcome.map_err(|e| no_window(&e, instead))?;

    if let (Some(path), Some(png)) = (&args.screenshot, &outcome.png) {
        put(path, &stamped(path, png.clone(), &shown_name(&args.input)))?;
    }
    if as_json {
        output::json("view", describe(args, &outcome))?;
    } else if let Some(text) = summary(args, &outcome) {
        output::report(&text)?;
    }
    Ok(Status::Done)
}

/// True for a model file, whose text can be edited: no drawing, and nothing from a pipe.
fn is_written(input: &Path) -> bool {
    !is_stdin(input) && input.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"))
}

/// Writes values of parameters into a model file; all other bytes stay.
fn save(file: &Path, values: &[(String, String)]) -> Result<(), String> {
    let mut text = fs::read_to_string(file)
        .map_err(|error| format!("`{}` cannot be read: {error}", file.display()))?;
    for (name, value) in values {
        let own = defined(&Places::of(&text));
        if !own.iter().any(|known| known.section == "parameters" && known.name == *name) {
            let path = file.display();
            return Err(format!("parameter `{name}` is given in another file than `{path}`"));
        }
        let edit = Edit::Set { path: format!("parameters.{name}"), value: value.clone() };
        text = edited(&text, &edit).map_err(|fault| fault.diagnostic(&text).message)?;
    }
    put(file, text.as_bytes()).map_err(|failure| render::failure_text(&failure))
}

/// The name of the file that is shown: its model may change while it is.
fn shown_name(input: &Path) -> String {
    input.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Refuses what cannot be shown, and pictures that cannot be written, before a window opens.
fn check(args: &View) -> Result<(), Failure> {
    let input = &args.input;
    let is_directory = || fs::metadata(input).map(|known| known.is_dir());
    if !is_stdin(input) && is_directory().map_err(|e| Failure::reading(input, &e))? {
        let help = Some(format!("name a file in it: `{}`", input.join("model.toml").display()));
        return Err(Failure::file(input, "is a directory, not a model or a log".to_owned(), help));
    }
    let Some(path) = &args.screenshot else { return Ok(()) };
    if path.canonicalize().ok().is_some_and(|own| input.canonicalize().ok() == Some(own)) {
        let what = "is what is to be shown, and would be overwritten".to_owned();
        return Err(Failure::file(path, what, Some("name another file".to_owned())));
    }
    if path.exists() && !args.force && !is_of_model(path, &shown_name(input)) {
        let help = Some("add --force to overwrite it".to_owned());
        return Err(Failure::file(path, "exists already; nothing was written".to_owned(), help));
    }
    check_ending(path, &["png"])?;
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    if let Some(parent) = parent.filter(|parent| !parent.is_dir()) {
        let what = format!("cannot be written: there is no directory `{}`", parent.display());
        return Err(Failure::file(path, what, None));
    }
    Ok(())
}

/// Tells on stderr what happens in the window, unless a program listens.
fn reporter(input: &Path, as_json: bool) -> impl FnMut(Report<'_>) + use<> {
    let input: PathBuf = input.to_owned();
    let n_loads = Cell::new(0);
    move |report| {
        if as_json {
            return;
        }
        match report {
            Report::FirstFrame => (),
            Report::Loaded(seconds) => {
                if n_loads.replace(n_loads.get() + 1) > 0 {
                    let path = input.display();
                    render::line(&format!("`{path}` is shown anew, after {seconds:.2} s"));
                }
            }
            Report::Fault(text) => {
                n_loads.set(n_loads.get() + 1);
                render::line(text);
            }
            Report::Unwatched(why) => {
                render::warning(&format!("changes of the file will not be noticed: {why}"));
            }
        }
    }
}

/// Why there is no window, and what to do about it or `instead`.
pub(super) fn no_window(error: &WindowError, instead: &str) -> Failure {
    let help = format!("{}; {instead}", error.help());
    let what = match error {
        WindowError::Lost => "the window is closed",
        _ => "no window can be opened",
    };
    Failure::Unavailable { message: format!("{what}: {error}"), help }
}

fn describe(args: &View, outcome: &Outcome) -> Value {
    let figures = &outcome.figures;
    let screenshot = args.screenshot.as_ref().filter(|_| outcome.png.is_some());
    json!({
        "first_frame_s": figures.first_frame_s,
        "frames": figures.n_frames,
        "frames_per_second": figures.frames_per_second,
        "cpu_s_per_frame": figures.cpu_s_per_frame,
        "draw_calls": figures.n_draws,
        "primitives": figures.n_primitives,
        "bytes_per_frame": figures.n_bytes,
        "loads": outcome.loads.len(),
        "faulty_loads": outcome.loads.iter().filter(|is_good| !**is_good).count(),
        "screenshot": screenshot.map(|path| path.display().to_string()),
    })
}

/// The message when the window was closed by itself.
fn summary(args: &View, outcome: &Outcome) -> Option<String> {
    let figures = &outcome.figures;
    let mut lines = Vec::new();
    if args.frames.is_some() {
        if let Some(seconds) = figures.first_frame_s {
            lines.push(format!("first frame after {seconds:.2} s"));
        }
        if let (Some(rate), Some(cpu)) = (figures.frames_per_second, figures.cpu_s_per_frame) {
            lines.push(format!(
                "{} frames, {rate:.1} a second, {:.2} ms of CPU time each",
                figures.n_frames,
                1e3 * cpu
            ));
        }
        lines.push(format!(
            "{} draw calls, {} primitives, {} bytes for the last of them",
            figures.n_draws, figures.n_primitives, figures.n_bytes
        ));
    }
    if let (Some(path), Some(_)) = (&args.screenshot, &outcome.png) {
        lines.push(format!("wrote {}", path.display()));
    }
    (!lines.is_empty()).then(|| lines.join("\n"))
}
