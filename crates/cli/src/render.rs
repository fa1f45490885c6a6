//! Diagnostics for people (an excerpt with carets) and for programs (JSON).

use std::io::Write;

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use anstream::adapter::strip_str;
use bksim::mbs::diagnostic::{Diagnostic, Severity};
use serde_json::{Value, json};

use crate::exit::Failure;
use crate::output;
use crate::source::{Located, Text, code_text, line_and_column, severity_word};

/// Excerpts are cut around their carets to this width.
const WIDTH: usize = 120;

/// One diagnostic as text, styled; the stream strips the style where it is not wanted.
pub(crate) fn text(source: &Text, fault: &Diagnostic) -> String {
    let level = match fault.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let Located { path, text, fault } = source.locate(fault);
    let fault = &fault;
    let path = path.display().to_string();
    let mut group = level
        .primary_title(&fault.message)
        .id(code_text(fault.code))
        .elements(Vec::<annotate_snippets::Element<'_>>::new());
    if !fault.labels.is_empty() {
        let mut snippet = Snippet::source(text).path(&path).fold(true);
        for (label_idx, label) in fault.labels.iter().enumerate() {
            let kind =
                if label_idx == 0 { AnnotationKind::Primary } else { AnnotationKind::Context };
            let span = clamp(text, label.span.clone());
            let annotation = kind.span(span);
            snippet = snippet.annotation(match label.text.as_str() {
                "" => annotation,
                words => annotation.label(words),
            });
        }
        group = group.element(snippet);
    } else if source.drawn.is_some() || fault.code.0.starts_with('D') {
        // Of a binary file there are no lines to show, but a name.
        group = group.element(Origin::path(&path));
    }
    group = notes(group, fault);
    let rendered = Renderer::styled().term_width(WIDTH).render(&[group]);
    if fault.labels.is_empty() { without_margin(&rendered) } else { rendered }
}

/// A message without an excerpt needs no empty margin line below its title.
fn without_margin(rendered: &str) -> String {
    let is_margin = |line: &&str| strip_str(line).to_string().trim() == "|";
    rendered.lines().filter(|line| !is_margin(line)).collect::<Vec<_>>().join("\n")
}

fn notes<'a>(mut group: Group<'a>, fault: &'a Diagnostic) -> Group<'a> {
    for note in &fault.notes {
        group = group.element(Level::NOTE.message(note));
    }
    if let Some(help) = &fault.help {
        group = group.element(Level::HELP.message(help));
    }
    group
}

/// Spans of a lossily decoded text may not fit it.
fn clamp(text: &str, span: std::ops::Range<usize>) -> std::ops::Range<usize> {
    let boundary = |mut at: usize| {
        at = at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    let start = boundary(span.start);
    start..boundary(span.end).max(start)
}

/// One diagnostic as JSON.
pub(crate) fn json(source: &Text, fault: &Diagnostic) -> Value {
    let Located { path, text, fault } = source.locate(fault);
    let label = |label: &bksim::mbs::diagnostic::Label| {
        let (line, column) = line_and_column(text, label.span.start);
        json!({
            "line": line, "column": column,
            "start": label.span.start, "end": label.span.end,
            "text": label.text,
        })
    };
    json!({
        "code": code_text(fault.code),
        "severity": severity_word(fault.severity),
        "message": fault.message,
        "file": path.display().to_string(),
        "labels": fault.labels.iter().map(label).collect::<Vec<_>>(),
        "notes": fault.notes,
        "help": fault.help,
    })
}

/// All diagnostics of a list as JSON.
pub(crate) fn json_all(source: &Text, faults: &[Diagnostic]) -> Value {
    faults.iter().map(|fault| json(source, fault)).collect()
}

/// Prints diagnostics to stderr.
pub(crate) fn print_all(source: &Text, faults: &[Diagnostic]) {
    for fault in faults {
        to_stderr(&text(source, fault));
    }
}

/// A warning about a file that is no model, on stderr.
pub(crate) fn warning(message: &str) {
    let group = Group::with_title(Level::WARNING.primary_title(message));
    to_stderr(&Renderer::styled().term_width(WIDTH).render(&[group]));
}

/// One diagnostic as text without styles.
pub(crate) fn plain_text(source: &Text, fault: &Diagnostic) -> String {
    strip_str(&text(source, fault)).to_string()
}

/// A failure as text without styles.
pub(crate) fn failure_text(failure: &Failure) -> String {
    let about = |path: &std::path::Path, what: &str| format!("`{}` {what}", path.display());
    let unstyled =
        |message: &str, help: Option<&str>| strip_str(&titled(message, help)).to_string();
    match failure {
        Failure::OutputClosed => String::new(),
        Failure::Model { source, diagnostics } => {
            let texts = diagnostics.iter().map(|fault| plain_text(source, fault));
            texts.collect::<Vec<_>>().join("\n\n")
        }
        Failure::File { path, what, help } | Failure::Input { path, what, help } => {
            unstyled(&about(path, what), help.as_deref())
        }
        Failure::Usage { message, help } => unstyled(message, help.as_deref()),
        Failure::Window { message, help } => unstyled(message, Some(help)),
    }
}

/// A failed command: text on stderr, or one JSON object on stdout.
pub(crate) fn failure(failure: &Failure, command: &str, as_json: bool) {
    let body = match failure {
        Failure::OutputClosed => return,
        Failure::Model { source, diagnostics } => {
            if !as_json {
                print_all(source, diagnostics);
                return;
            }
            json!({ "diagnostics": json_all(source, diagnostics) })
        }
        Failure::File { path, what, help } | Failure::Input { path, what, help } => {
            let message = format!("`{}` {what}", path.display());
            if !as_json {
                plain(&message, help.as_deref());
                return;
            }
            json!({ "file": path.display().to_string(), "message": message, "help": help })
        }
        Failure::Usage { message, help } => {
            if !as_json {
                plain(message, help.as_deref());
                return;
            }
            json!({ "message": message, "help": help })
        }
        Failure::Window { message, help } => {
            if !as_json {
                plain(message, Some(help));
                return;
            }
            json!({ "message": message, "help": help })
        }
    };
    let mut object = json!({
        "ok": false, "command": command, "exit_status": failure.status().code(),
    });
    if let (Some(object), Value::Object(body)) = (object.as_object_mut(), body) {
        object.extend(body);
    }
    // The exit status tells as much when nobody reads the object.
    let _ = output::text(&format!("{object:#}"));
}

fn plain(message: &str, help: Option<&str>) {
    to_stderr(&titled(message, help));
}

/// A message without an excerpt.
fn titled(message: &str, help: Option<&str>) -> String {
    let mut group = Group::with_title(Level::ERROR.primary_title(message));
    if let Some(help) = help {
        group = group.element(Level::HELP.message(help));
    }
    without_margin(&Renderer::styled().term_width(WIDTH).render(&[group]))
}

/// Prints a line of a command that goes on to stderr.
pub(crate) fn line(text: &str) {
    to_stderr(text);
}

/// Prints a line to stderr. Where that cannot be written there is nobody left to tell.
fn to_stderr(text: &str) {
    let _ = writeln!(anstream::stderr().lock(), "{text}");
}
