//! Faults for people (an excerpt with carets) and for programs (JSON).

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use anstream::adapter::strip_str;
use bksim::model::diagnostic::{Diagnostic, Label, Severity};
use serde_json::{Value, json};

use crate::text::{Located, Text, line_and_column};

/// Excerpts are cut around their carets to this width.
pub const WIDTH: usize = 120;

/// One diagnostic as text with an excerpt, styled for a terminal.
pub fn styled(source: &Text, fault: &Diagnostic) -> String {
    let level = match fault.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let Located { path, text, fault } = source.locate(fault);
    let fault = &fault;
    let path = path.display().to_string();
    let mut group = level
        .primary_title(&fault.message)
        .id(fault.code.0)
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

/// One diagnostic as text without styles.
pub fn plain(source: &Text, fault: &Diagnostic) -> String {
    strip_str(&styled(source, fault)).to_string()
}

/// One diagnostic as JSON: code, severity, message, file, labels with lines and columns, notes, help.
pub fn json(source: &Text, fault: &Diagnostic) -> Value {
    let Located { path, text, fault } = source.locate(fault);
    let word = match fault.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    let label = |label: &Label| {
        let (line, column) = line_and_column(text, label.span.start);
        json!({
            "line": line, "column": column,
            "start": label.span.start, "end": label.span.end,
            "text": label.text,
        })
    };
    json!({
        "code": fault.code.0,
        "severity": word,
        "message": fault.message,
        "file": path.display().to_string(),
        "labels": fault.labels.iter().map(label).collect::<Vec<_>>(),
        "notes": fault.notes,
        "help": fault.help,
    })
}

/// All diagnostics of a list as JSON.
pub fn json_all(source: &Text, faults: &[Diagnostic]) -> Value {
    faults.iter().map(|fault| json(source, fault)).collect()
}

/// A message without an excerpt, styled for a terminal.
pub fn titled(message: &str, help: Option<&str>) -> String {
    let mut group = Group::with_title(Level::ERROR.primary_title(message));
    if let Some(help) = help {
        group = group.element(Level::HELP.message(help));
    }
    without_margin(&Renderer::styled().term_width(WIDTH).render(&[group]))
}
