//! `bksim optimize`, `fit`, `tolerance` and `synthesize`: from arguments to questions of `bksim_design`, and answers in
//! words.

mod figure;
mod words;

use std::io::Write;
use std::path::{Path, PathBuf};

use bksim::model::file::ShownUnits;
use bksim_cli::args::ModelArgs;
use bksim_cli::args::design::{Drawn, Fit, Optimize, Synthesize, Tolerance};
use bksim_cli::commands::solve::changes;
use bksim_cli::exit::{Failure, Status};
use bksim_cli::output;
use bksim_cli::output_file::OutputFile;
use bksim_cli::progress::StopWish;
use bksim_cli::render;
use bksim_cli::source::shown::shown_units;
use bksim_cli::source::{Loaded, Text, load_geometry, read_bytes};
use bksim_cli::waiting::{searching, waiting};
use bksim_design::{
    DataFile, DesignError, FitWish, OptimizeWish, Source, ToleranceWish, Unfinished, Watch,
};
use bksim_plot::{Figure, Format, Theme};
use serde::Serialize;
use serde_json::Value;

use self::words::Words;
use super::plot::{picture, put};

/// A model and the question it states, ready to be asked.
struct Asked {
    loaded: Loaded,
    source: Source,
    file: Option<OutputFile>,
    picture: Option<(OutputFile, Format)>,
    stop: StopWish,
    as_json: bool,
    /// Units of the text: asked for, else the model's.
    units: ShownUnits,
}

fn asked(
    model: &ModelArgs,
    (output, drawn): (Option<&Path>, &Drawn),
    (as_json, nesting): (bool, usize),
) -> Result<Asked, Failure> {
    let loaded = load_geometry(model, nesting)?;
    let file = output.map(|path| {
        OutputFile::plan(
            path,
            ("model", &[model.model.as_path()]),
            drawn.force,
            "nothing was computed",
        )
    });
    let file = file.transpose()?;
    let plan = |path: &PathBuf| picture(path, std::slice::from_ref(&model.model), drawn.force);
    let picture = drawn.plot.as_ref().map(plan).transpose()?;
    let stop = StopWish::watch().map_err(|e| {
        Failure::file(&model.model, format!("is not read: signals cannot be handled: {e}"), None)
    })?;
    let source = Source {
        text: loaded.source.text.clone(),
        name: loaded.model.name.clone(),
        fixed: model.set.0.clone(),
        nesting: Some(nesting),
        ..Source::default()
    };
    let text = &loaded.source.text;
    let units = shown_units(model.drawing.shown(&model.model), text, ShownUnits::of_model(text))?;
    Ok(Asked { loaded, source, file, picture, stop, as_json, units })
}

fn failure(source: &Text, error: &DesignError) -> Failure {
    match error.diagnostics() {
        faults if faults.is_empty() => Failure::usage(error.to_string(), "run the command again"),
        faults => source.rejected(faults).into(),
    }
}

impl Asked {
    /// Asks with words of progress on a terminal, until a signal comes; `None` if that was before there was an answer.
    fn answered<T>(
        &self,
        work: &str,
        ask: impl FnOnce(Watch<'_>) -> Result<T, DesignError>,
    ) -> Result<Option<T>, Failure> {
        let wish = &self.stop;
        let stop = || wish.status().is_some();
        let found = searching(work, |word| {
            let reached = |words: &str, share: f64| word.reached(words, share);
            ask(Watch { stop: &stop, reached: &reached, kept: &|| word.keeps() })
        });
        match found {
            Err(DesignError::Stopped) if stop() => Ok(None),
            found => found.map(Some).map_err(|error| failure(&self.loaded.source, &error)),
        }
    }

    fn words(&self) -> Words<'_> {
        Words { name: &self.source.name, model: &self.loaded.model, units: &self.units }
    }

    /// Status of a search that was stopped before it had anything.
    fn ended(&self) -> Status {
        self.stop.status().unwrap_or(Status::Interrupted)
    }

    /// Writes the model of the answer, and prints the answer.
    fn told(
        &self,
        command: &str,
        found: &impl Serialize,
        text: &str,
        (model, figure): (Option<&str>, Option<Figure>),
    ) -> Result<Status, Failure> {
        let status = self.stop.status().unwrap_or(Status::Done);
        let mut written = None;
        if let (Some(file), Some(model)) = (&self.file, model) {
            write(file, model)?;
            written = Some(file.path().display().to_string());
        }
        let mut drawn = None;
        if let (Some((file, format)), Some(figure)) = (&self.picture, figure) {
            let failed =
                |error| Failure::file(file.path(), format!("cannot be drawn: {error}"), None);
            put(file, &figure.render(*format, None, &Theme::LIGHT).map_err(failed)?)?;
            drawn = Some(file.path().display().to_string());
        }
        if self.as_json {
            let mut body = serde_json::to_value(found).unwrap_or(Value::Null);
            body["model"] = self.source.name.as_str().into();
            body["output"] = written.into();
            body["plot"] = drawn.into();
            body["diagnostics"] = render::json_all(&self.loaded.source, &self.loaded.warnings);
            output::json(command, body)?;
        } else {
            render::print_all(&self.loaded.source, &self.loaded.warnings);
            output::text(text)?;
            for name in [written, drawn].into_iter().flatten() {
                output::report(&format!("wrote {name}"))?;
            }
        }
        Ok(status)
    }
}

fn write(file: &OutputFile, text: &str) -> Result<(), Failure> {
    let mut out = file.create()?;
    out.write_all(text.as_bytes()).map_err(|e| Failure::writing(file.path(), &e))?;
    out.finish()
}

pub(crate) fn optimize(args: &Optimize, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let mut asked = asked(&args.model, (args.output.as_deref(), &args.drawn), (as_json, nesting))?;
    let fault = |error: DesignError| failure(&asked.loaded.source, &error);
    let mut wish = OptimizeWish::of_model(&asked.source.text).map_err(fault)?;
    if args.minimize.is_some() || args.maximize.is_some() {
        (wish.minimize, wish.maximize) = (args.minimize.clone(), args.maximize.clone());
        (wish.against, wish.points) = (None, None);
    }
    for (name, range) in &args.vary {
        let (from, to) = range.split_once(':').ok_or_else(|| {
            Failure::usage(
                format!("`{range}` is no range"),
                "write both ends, as in `--vary 'l1=80 mm:120 mm'`",
            )
        })?;
        // A number without a unit has that of the other.
        let unit = to.trim_start_matches(|c: char| c.is_ascii_digit() || "+-.eE ".contains(c));
        let is_bare = from.trim().parse::<f64>().is_ok();
        let from = if is_bare { format!("{} {unit}", from.trim()) } else { from.to_owned() };
        wish.vary.retain(|(known, _)| known != name);
        wish.vary.push((name.clone(), [from.trim().to_owned(), to.trim().to_owned()]));
    }
    wish.subject_to.extend(args.subject_to.iter().cloned());
    wish.over = args.over.clone().or(wish.over);
    wish.starts = args.starts.or(wish.starts);
    asked.source.changes = changes(&args.tuning, asked.loaded.model.solve.t_start)?;
    if args.drawn.plot.is_some() && wish.against.is_none() {
        let help =
            "minimize a list of two outputs, or leave out --plot: `bksim plot` draws motions";
        return Err(Failure::usage("one objective has no front to draw", help));
    }
    if let Some(path) = &args.resume {
        match ends_of(path, wish.against.is_some())? {
            Earlier::Ends(ends) => (wish.starts, wish.from) = (Some(0), ends),
            Earlier::Front(front) => wish.resume = Some(front),
        }
    }
    let found = asked
        .answered("optimizing", |watch| bksim_design::optimize(&asked.source, &wish, watch))?;
    let Some(found) = found else { return Ok(asked.ended()) };
    asked.loaded.warnings.extend(found.warnings.iter().cloned());
    let text = words::optimized(&asked.words(), &found);
    let figure = figure::front(&asked.source.name, &found);
    asked.told("optimize", &found, &text, (Some(&found.model), figure))
}

/// The beginning of a search that goes on.
enum Earlier {
    /// Where its starts are.
    Ends(Vec<Vec<(String, String)>>),
    Front(Unfinished),
}

/// The beginning of a search after an earlier answer, from its `--json`.
fn ends_of(path: &Path, is_front: bool) -> Result<Earlier, Failure> {
    let bytes = read_bytes(path)?;
    let mut answer: Value = serde_json::from_slice(&bytes).unwrap_or(Value::Null);
    let ends = answer["ends"].as_array().into_iter().flatten();
    let values = |end: &Value| -> Option<Vec<(String, String)>> {
        let one = |(name, value): (&String, &Value)| (name.clone(), value.to_string());
        Some(end["quantities"].as_object()?.iter().map(one).collect())
    };
    let ends: Option<Vec<_>> = ends.map(values).collect();
    let ends = ends.filter(|ends| !ends.is_empty() && !is_front).map(Earlier::Ends);
    let front = || serde_json::from_value(answer["unfinished"].take()).ok().map(Earlier::Front);
    ends.or_else(front).ok_or_else(|| Failure::Input {
        path: path.to_owned(),
        what: "has no search to go on with".to_owned(),
        help: Some("give what `bksim optimize MODEL --json` printed, of a front when it was stopped; searches over catalogues begin again".to_owned()),
    })
}

pub(crate) fn fit(args: &Fit, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let mut asked = asked(&args.model, (args.output.as_deref(), &args.drawn), (as_json, nesting))?;
    let fault = |error: DesignError| failure(&asked.loaded.source, &error);
    let mut wish = FitWish::of_model(&asked.source.text).map_err(fault)?;
    for vary in &args.vary {
        let (name, start) = match vary.split_once('=') {
            Some((name, start)) => (name.trim(), Some(start.trim().to_owned())),
            None => (vary.trim(), None),
        };
        wish.vary.retain(|(known, _)| known != name);
        wish.vary.push((name.to_owned(), start));
    }
    for (column, formula) in &args.compare {
        wish.compare.retain(|(known, _)| known != column);
        wish.compare.push((column.clone(), formula.clone()));
    }
    let read = |path: &PathBuf| {
        let text = String::from_utf8_lossy(&read_bytes(path)?).into_owned();
        Ok(DataFile { name: path.display().to_string(), text, set: Vec::new() })
    };
    let data = args.data.iter().map(read).collect::<Result<Vec<_>, Failure>>()?;
    asked.source.changes = changes(&args.tuning, asked.loaded.model.solve.t_start)?;
    let found =
        asked.answered("fitting", |watch| bksim_design::fit(&asked.source, &data, &wish, watch))?;
    let Some(found) = found else { return Ok(asked.ended()) };
    asked.loaded.warnings.extend(found.warnings.iter().cloned());
    let text = words::fitted(&asked.words(), &found);
    let figure = figure::fitted(&asked.source.name, &found);
    asked.told("fit", &found, &text, (Some(&found.model), Some(figure)))
}

pub(crate) fn tolerance(
    args: &Tolerance,
    as_json: bool,
    nesting: usize,
) -> Result<Status, Failure> {
    let mut asked = asked(&args.model, (args.output.as_deref(), &args.drawn), (as_json, nesting))?;
    let fault = |error: DesignError| failure(&asked.loaded.source, &error);
    let mut wish = ToleranceWish::of_model(&asked.source.text).map_err(fault)?;
    wish.of.extend(args.of.iter().cloned());
    for (name, limit) in &args.limit {
        wish.limits.retain(|(known, ..)| known != name);
        wish.limits.push((name.clone(), limit.clone(), None));
    }
    for (name, play) in &args.play {
        wish.play.retain(|(known, _)| known != name);
        wish.play.push((name.clone(), play.clone()));
    }
    for (given, own) in [(&args.keep, &mut wish.keep), (&args.weight, &mut wish.weights)] {
        own.retain(|(known, _)| given.iter().all(|(name, _)| name != known));
        own.extend(given.iter().cloned());
    }
    wish.by = args.by.clone().or(wish.by);
    if args.output.is_some() && wish.keep.is_empty() {
        let help =
            "say what is to be kept, as in `--keep 'rocker.angle=±0.4 deg'`, or leave out -o";
        return Err(Failure::usage("limits are written only if they follow from a result", help));
    }
    if !args.at.is_empty() {
        wish.at.clone_from(&args.at);
    }
    wish.distribution = args.distribution.clone().or(wish.distribution);
    wish.samples = args.samples.or(wish.samples);
    wish.seed = args.seed.or(wish.seed);
    let found =
        asked.answered("sampling", |watch| bksim_design::tolerance(&asked.source, &wish, watch))?;
    let Some(found) = found else { return Ok(asked.ended()) };
    asked.loaded.warnings.extend(found.warnings.iter().cloned());
    let text = words::toleranced(&asked.words(), &found);
    let figure = figure::toleranced(&asked.source.name, &found);
    asked.told("tolerance", &found, &text, (found.model.as_deref(), Some(figure)))
}

pub(crate) fn synthesize(args: &Synthesize, as_json: bool) -> Result<Status, Failure> {
    let text = String::from_utf8_lossy(&read_bytes(&args.task)?).into_owned();
    let source = Text::new(args.task.clone(), text.clone());
    let found = waiting("looking for linkages", || bksim_design::synthesize(&text))
        .map_err(|error| failure(&source, &error))?;
    let mut written = Vec::new();
    if let Some(folder) = &args.output {
        std::fs::create_dir_all(folder).map_err(|e| Failure::writing(folder, &e))?;
        for candidate in &found.candidates {
            let path = folder.join(format!("{}.toml", candidate.name));
            let inputs = [args.task.as_path()];
            let file =
                OutputFile::plan(&path, ("task", &inputs), args.force, "nothing more was written")?;
            write(&file, &candidate.model)?;
            written.push(path.display().to_string());
        }
    }
    if as_json {
        let mut body = serde_json::to_value(&found).unwrap_or(Value::Null);
        body["outputs"] = written.into();
        body["diagnostics"] = render::json_all(&source, &found.warnings);
        output::json("synthesize", body)?;
    } else {
        render::print_all(&source, &found.warnings);
        output::text(&words::synthesized(&found))?;
        for name in written {
            output::report(&format!("wrote {name}"))?;
        }
    }
    Ok(Status::Done)
}
