//! The certificate of a run: its options, accuracy, versions, and how it ended.

use std::collections::BTreeMap;

use bksim::log::{Level, Outcome};
use bksim::model::message::counted;
use bksim::playback::Playback;
use bksim::sim::redundancy::UniquenessChange;
use sha2::{Digest, Sha256};

use crate::escape;

/// Largest number of notes of the run that are shown; of more, the page has the count.
const MAX_NOTES: usize = 30;
/// Largest number of channels that are named in one row.
const MAX_NAMES: usize = 24;

/// Options of the log in the order of the table, with their labels.
const OPTIONS: [(&str, &str); 8] = [
    ("method", "Method asked for"),
    ("formulation", "Formulation"),
    ("rtol", "Relative tolerance"),
    ("atol", "Absolute tolerance"),
    ("step", "Step size"),
    ("every", "Output interval, s"),
    ("times", "Output times, s"),
    ("sensitivity", "Derivatives by"),
];

/// The certificate as a table, and the notes of the run as a list.
pub(crate) fn html(playback: &Playback) -> String {
    let rows = rows(playback);
    let row = |(name, value): &(String, String)| {
        format!("<tr><th scope=\"row\">{}</th><td>{}</td></tr>", escape::html(name), value)
    };
    let table: Vec<String> = rows.iter().map(row).collect();
    format!(
        "<table class=\"facts\"><tbody>\n{}\n</tbody></table>\n{}{}",
        table.join("\n"),
        not_unique(playback),
        notes(playback)
    )
}

/// Reactions and efforts that are one of many solutions of the equilibrium, as a table; empty if there are none.
fn not_unique(playback: &Playback) -> String {
    let changes = playback.uniqueness();
    if changes.iter().all(|change| change.uniqueness.is_complete()) {
        return String::new();
    }
    let row = |change: &UniquenessChange| {
        let names = playback.channels().not_unique(&change.uniqueness);
        let told: Vec<&str> = names.iter().take(MAX_NAMES).map(String::as_str).collect();
        let more = match names.len().saturating_sub(MAX_NAMES) {
            0 => String::new(),
            n => format!(" and {n} more"),
        };
        let what = if names.is_empty() { "none".to_owned() } else { told.join(", ") + &more };
        let what = escape::html(&what);
        format!("<tr><th scope=\"row\">From t = {} s</th><td>{what}</td></tr>", change.t)
    };
    let rows: Vec<String> = changes.iter().take(MAX_NOTES).map(row).collect();
    let more = match changes.len().saturating_sub(MAX_NOTES) {
        0 => String::new(),
        n => format!("<p>It changes {}.</p>", counted(n, "more time", "more times")),
    };
    format!(
        "<h3>Reactions that are not unique</h3>\n<p>Joints, drives or stops that repeat each other \
         share these: the run has one of many solutions of the equilibrium.</p>\n\
         <table class=\"facts\"><tbody>\n{}\n</tbody></table>\n{more}",
        rows.join("\n")
    )
}

/// Rows of the table: names as text, values as HTML.
fn rows(playback: &Playback) -> Vec<(String, String)> {
    let log = playback.log();
    let header = &log.header;
    let [first, last] = playback.span();
    let row = |name: &str, value: String| (name.to_owned(), escape::html(&value));

    // The span and the end of the run, and its options.
    let ended = match &log.end {
        Some(end) => match end.outcome {
            Outcome::ReachedEnd => format!("at t = {} s: {}", end.t_end, end.reason),
            Outcome::Stopped => format!("early, at t = {} s: {}", end.t_end, end.reason),
        },
        None => format!("unknown: the log was cut short at t = {last} s"),
    };
    let mut rows = vec![row("Time", format!("{first} s to {last} s")), row("How it ended", ended)];
    for (key, name) in OPTIONS {
        rows.extend(header.options.get(key).map(|value| row(name, value.clone())));
    }

    // Its accuracy and work, as far as the log has them.
    let empty = BTreeMap::new();
    let summary = log.end.as_ref().map_or(&empty, |end| &end.summary);
    let accuracy = |key: &str, name: &str, unit: &str| {
        let value = summary.get(key)?;
        let value = value.parse::<f64>().map_or(value.clone(), |number| format!("{number:.1e}"));
        Some(row(name, format!("{value}{unit}")))
    };
    rows.extend(accuracy("position_residual", "Largest constraint of any sample", " m or rad"));
    rows.extend(accuracy("velocity_residual", "Largest constraint rate", " m/s or rad/s"));
    rows.extend(accuracy("energy_error", "Energy balance kept to", " J"));
    let n_steps = log.segments.len();
    rows.push(row("Steps in the log", n_steps.to_string()));
    rows.extend(summary.get("steps").map(|steps| row("Work", steps.clone())));

    // The parameters that were set, the versions, and the hash of the model.
    let set = header.options.iter().filter_map(|(key, value)| {
        let name = key.strip_prefix("set.")?;
        Some(format!("{name} = {value}"))
    });
    let set = set.collect::<Vec<_>>();
    if !set.is_empty() {
        rows.push(row("Set for this run", set.join(", ")));
    }
    rows.push(row("Solved by", format!("bksim {}", header.version)));
    rows.push(row("Page by", format!("bksim {}", bksim::VERSION)));
    let hash = Sha256::digest(header.model_text.as_bytes());
    let hash = hash.iter().fold(String::new(), |hash, byte| hash + &format!("{byte:02x}"));
    rows.push(("SHA-256 of the model".to_owned(), format!("<code class=\"hash\">{hash}</code>")));
    rows
}

/// Warnings and events of the run, as a list.
fn notes(playback: &Playback) -> String {
    let notes = &playback.log().notes;
    let shown = notes.iter().take(MAX_NOTES).map(|note| {
        let (class, word) = match note.level {
            Level::Debug | Level::Info => ("info", "Note"),
            Level::Warning => ("warning", "Warning"),
            Level::Error => ("error", "Error"),
        };
        let text = escape::html(&note.text);
        format!("<li class=\"{class}\"><b>{word}</b> at t = {} s: {text}</li>", note.t)
    });
    let shown: Vec<String> = shown.collect();
    let more = match notes.len().saturating_sub(MAX_NOTES) {
        0 => String::new(),
        n => format!("<p>{n} more are in the log.</p>"),
    };
    if shown.is_empty() {
        "<p>No warnings.</p>".to_owned()
    } else {
        format!("<ul class=\"notes\">\n{}\n</ul>{more}", shown.join("\n"))
    }
}
