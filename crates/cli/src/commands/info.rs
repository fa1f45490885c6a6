//! `bksim info`: what a log holds.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;

use bksim::describe;
use bksim::log::{Contents, Level, LogError, Note, Outcome, Survey};
use serde_json::{Value, json};

use crate::args::info::Info;
use crate::commands::solve::RunFile;
use crate::exit::{Failure, Status};
use crate::origin::MODEL_FILE;
use crate::output::{self, facts, listed, number, table};

/// Notes that are printed; JSON has all that were read.
const MAX_NOTES: usize = 40;

pub(crate) fn run(args: &Info, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let run = RunFile::open(&args.run, nesting, as_json)?;
    if let Some(status) = run.interrupted() {
        return Ok(status);
    }
    let (path, log) = (&run.name, run.log());
    let open = || File::open(&log).map(|file| BufReader::with_capacity(1 << 18, file));
    let n_bytes = fs::metadata(&log).map_err(|e| Failure::reading(path, &e))?.len();
    let source = open().map_err(|e| Failure::reading(path, &e))?;
    match Survey::read(source) {
        Ok(survey) if as_json => output::json("info", json_of(path, n_bytes, &survey))?,
        Ok(survey) => output::text(&text_of(path, n_bytes, &survey))?,
        Err(LogError::NotARun { .. }) => {
            let source = open().map_err(|e| Failure::reading(path, &e))?;
            let contents = Contents::read(source).map_err(|e| bad_log(path, &e))?;
            if as_json {
                output::json("info", foreign_json(path, n_bytes, &contents))?;
            } else {
                output::text(&foreign_text(path, n_bytes, &contents))?;
            }
        }
        Err(error) => return Err(bad_log(path, &error)),
    }
    Ok(run.status)
}

fn bad_log(path: &Path, error: &LogError) -> Failure {
    if let LogError::Io(error) = error {
        return Failure::reading(path, error);
    }
    let (path, what) = (path.to_owned(), format!("cannot be read: {error}"));
    Failure::Input { path, what, help: None }
}

fn text_of(path: &Path, n_bytes: u64, survey: &Survey) -> String {
    let header = &survey.header;
    let mut rows = vec![
        row("log", &format!("{}, {}", path.display(), bytes(n_bytes))),
        row("model", &format!("{} ({})", header.model_name, header.model_format)),
        row("written by", &format!("bksim {}", header.version)),
        row("samples", &span_words(survey)),
        row("ended", &end_words(survey)),
        row("motion", &motion_words(survey)),
    ];
    if let Some(n) = survey.checkpoint_bytes {
        rows.push(row("resumable", &format!("yes, from a state of {}", bytes(n as u64))));
    }
    let mut sections = vec![facts(&rows)];
    let mut section = |title: &str, rows: Vec<Vec<String>>| {
        let written = if title == "channels" { table(&rows) } else { listed(&rows) };
        if !rows.is_empty() {
            sections.push(format!("{title}\n{written}"));
        }
    };
    let end = survey.end.iter().flat_map(|end| &end.summary);
    let shown = |text: &String| text.parse().map_or_else(|_| text.clone(), number);
    section("results", end.map(|(name, text)| row(name, &shown(text))).collect());
    let shared = super::solve::not_unique(&describe::logged_uniqueness(&survey.not_unique));
    section("reactions that are not unique", shared.into_iter().map(|line| vec![line]).collect());
    // Where the model was is for those who replace the log.
    let options = header.options.iter().filter(|(name, _)| *name != MODEL_FILE);
    section("options", options.map(|(name, text)| row(name, text)).collect());
    let quantity = |(name, quantity): (&String, &bksim::log::Quantity)| {
        row(name, format!("{} {}", number(quantity.value), quantity.unit).trim_end())
    };
    section("parameters", header.parameters.iter().map(quantity).collect());
    section("channels", channel_rows(survey));
    let notes = survey.notes.iter().take(MAX_NOTES);
    let mut notes: Vec<_> = notes.map(note_row).collect();
    if survey.n_notes > MAX_NOTES as u64 {
        notes.push(vec![format!("and {} more", survey.n_notes - MAX_NOTES as u64)]);
    }
    section("events and warnings", notes);
    sections.join("\n\n")
}

fn row(name: &str, text: &str) -> Vec<String> {
    vec![name.to_owned(), text.to_owned()]
}

fn bytes(n: u64) -> String {
    #[expect(clippy::cast_precision_loss, reason = "three digits are shown")]
    let size = n as f64;
    match n {
        1 => "1 byte".to_owned(),
        0..1_000 => format!("{n} bytes"),
        1_000..1_000_000 => format!("{:.1} kB", size / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", size / 1e6),
        _ => format!("{:.2} GB", size / 1e9),
    }
}

fn span_words(survey: &Survey) -> String {
    let n = survey.topics.iter().map(|topic| topic.n_samples).max().unwrap_or(0);
    match survey.span {
        None => "none".to_owned(),
        Some([first, last]) => {
            format!("{n} from t = {} s to {} s", number(first), number(last))
        }
    }
}

fn end_words(survey: &Survey) -> String {
    match &survey.end {
        None => "not known: the log was cut off before its run ended".to_owned(),
        Some(end) => {
            let t = number(end.t_end);
            match end.outcome {
                Outcome::ReachedEnd => format!("at t = {t} s: {}", end.reason),
                Outcome::Stopped => format!("early, at t = {t} s: {}", end.reason),
            }
        }
    }
}

fn motion_words(survey: &Survey) -> String {
    match survey.n_segments {
        0 => "none: curves and pictures join the samples".to_owned(),
        1 => format!("1 step, {} before compression", bytes(survey.motion_bytes)),
        n => format!("{n} steps, {} before compression", bytes(survey.motion_bytes)),
    }
}

fn channel_rows(survey: &Survey) -> Vec<Vec<String>> {
    let topics = survey.header.topics.iter().zip(&survey.topics);
    let of_topic = topics.flat_map(|(topic, count)| {
        let rows = topic.fields.iter().map(|field| {
            let (name, n) = (topic.column_name(field), count.n_samples.to_string());
            vec![name, field.unit.clone(), n, field.description.clone()]
        });
        rows.collect::<Vec<_>>()
    });
    let heading = ["channel", "unit", "samples", "meaning"].map(str::to_owned).to_vec();
    std::iter::once(heading).chain(of_topic).collect()
}

fn note_row(note: &Note) -> Vec<String> {
    vec![level_word(note.level).to_owned(), format!("t = {} s", number(note.t)), note.text.clone()]
}

fn level_word(level: Level) -> &'static str {
    match level {
        Level::Debug => "detail",
        Level::Info => "event",
        Level::Warning => "warning",
        Level::Error => "error",
    }
}

fn json_of(path: &Path, n_bytes: u64, survey: &Survey) -> Value {
    let header = &survey.header;
    // Lists of the log's parts.
    let channels = header.topics.iter().zip(&survey.topics).flat_map(|(topic, count)| {
        topic.fields.iter().map(move |field| {
            json!({
                "name": topic.column_name(field),
                "unit": field.unit,
                "description": field.description,
                "samples": count.n_samples,
            })
        })
    });
    let parameters = header.parameters.iter().map(|(name, quantity)| {
        (name.clone(), json!({ "value": quantity.value, "unit": quantity.unit }))
    });
    let notes = survey
        .notes
        .iter()
        .map(|note| json!({ "level": level_word(note.level), "t": note.t, "text": note.text }));
    // The log as a whole; what an end would tell is null without one.
    let end = survey.end.as_ref();
    json!({
        "log": path.display().to_string(),
        "bytes": n_bytes,
        "kind": "run",
        "model": header.model_name,
        "model_format": header.model_format,
        "model_sha256": survey.model_sha256,
        "version": header.version,
        "t_start": header.t_start,
        "t_first": survey.span.map(|[first, _]| first),
        "t_last": survey.span.map(|[_, last]| last),
        "complete": end.is_some(),
        "reached_end": end.map(|end| end.outcome == Outcome::ReachedEnd),
        "t_end": end.map(|end| end.t_end),
        "reason": end.map(|end| &end.reason),
        "results": end.map(|end| &end.summary),
        "uniqueness": describe::logged_uniqueness(&survey.not_unique),
        "options": header.options,
        "parameters": parameters.collect::<serde_json::Map<_, _>>(),
        "channels": channels.collect::<Vec<_>>(),
        "notes": notes.collect::<Vec<_>>(),
        "all_notes": survey.n_notes,
        "motion": { "steps": survey.n_segments, "bytes": survey.motion_bytes },
        "foreign_messages": survey.n_foreign,
        "checkpoint_bytes": survey.checkpoint_bytes,
    })
}

fn foreign_text(path: &Path, n_bytes: u64, contents: &Contents) -> String {
    let of = |text: &str| if text.is_empty() { "not known".to_owned() } else { text.to_owned() };
    let head = facts(&[
        row("log", &format!("{}, {}", path.display(), bytes(n_bytes))),
        row("kind", "an MCAP file that holds no run of bksim"),
        row("profile", &of(&contents.profile)),
        row("written by", &of(&contents.library)),
        row("complete", if contents.is_complete { "yes" } else { "no: it was cut off" }),
    ]);
    let heading = ["topic", "schema", "encoding", "messages"].map(str::to_owned).to_vec();
    let topics = contents.topics.iter().map(|topic| {
        vec![
            topic.name.clone(),
            topic.schema.clone(),
            topic.encoding.clone(),
            topic.n_messages.to_string(),
        ]
    });
    let topics: Vec<_> = std::iter::once(heading).chain(topics).collect();
    format!("{head}\n\ntopics\n{}", table(&topics))
}

fn foreign_json(path: &Path, n_bytes: u64, contents: &Contents) -> Value {
    let topics = contents.topics.iter().map(|topic| {
        json!({
            "name": topic.name,
            "schema": topic.schema,
            "encoding": topic.encoding,
            "messages": topic.n_messages,
        })
    });
    json!({
        "log": path.display().to_string(),
        "bytes": n_bytes,
        "kind": "other",
        "profile": contents.profile,
        "library": contents.library,
        "complete": contents.is_complete,
        "topics": topics.collect::<Vec<_>>(),
    })
}
