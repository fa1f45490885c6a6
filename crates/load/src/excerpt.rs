//! Faults for people (an excerpt with carets) and for programs (JSON).

use std::ops::Range;

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use anstream::adapter::strip_str;
use bksim::messages::{self, phrase, worded};
use bksim::model::diagnostic::{Diagnostic, Label, Severity};
use bksim::translation::Translation;
use serde_json::{Value, json};

use crate::text::{Located, Text, line_and_column};

/// Excerpts are cut around their carets to this width.
pub const WIDTH: usize = 120;

/// One diagnostic as text with an excerpt, styled for a terminal.
pub fn styled(source: &Text, fault: &Diagnostic) -> String {
    let level = match fault.severity {
        Severity::Error => named(Level::ERROR, "error"),
        Severity::Warning => named(Level::WARNING, "warning"),
    };
    let (fault, explanation) = worded(fault);
    let notes_of =
        |words: &Translation| [&words.title, &words.meaning, &words.cure].map(|text| wrapped(text));
    let explained = explanation.into_iter().flat_map(notes_of);
    let fault = explained.fold(fault, Diagnostic::note);
    let Located { path, text, fault } = source.locate(&fault);
    let fault = &fault;
    let path = path.display().to_string();
    let mut group = level
        .primary_title(&fault.message)
        .id(fault.code.0)
        .elements(Vec::<annotate_snippets::Element<'_>>::new());
    if !fault.labels.is_empty() {
        let Window { text, first_line, spans } = Window::around(text, &fault.labels);
        let mut snippet = Snippet::source(text).line_start(first_line).path(&path).fold(true);
        for (label_idx, (label, span)) in fault.labels.iter().zip(spans).enumerate() {
            let kind =
                if label_idx == 0 { AnnotationKind::Primary } else { AnnotationKind::Context };
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

/// A level by its word in the language that is spoken.
fn named(level: Level<'static>, english: &'static str) -> Level<'static> {
    level.with_name(messages::level(english))
}

/// A text in lines that fit next to the mark of a note.
fn wrapped(text: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("one line at least");
        if !line.is_empty() && line.chars().count() + word.chars().count() >= WIDTH - 20 {
            lines.push(word.to_owned());
        } else {
            let space = if line.is_empty() { "" } else { " " };
            line.push_str(space);
            line.push_str(word);
        }
    }
    lines.join("\n")
}

/// A message without an excerpt needs no empty margin line below its title.
fn without_margin(rendered: &str) -> String {
    let is_margin = |line: &&str| strip_str(line).to_string().trim() == "|";
    rendered.lines().filter(|line| !is_margin(line)).collect::<Vec<_>>().join("\n")
}

fn notes<'a>(mut group: Group<'a>, fault: &'a Diagnostic) -> Group<'a> {
    for note in &fault.notes {
        group = group.element(named(Level::NOTE, "note").message(note));
    }
    if let Some(help) = &fault.help {
        group = group.element(named(Level::HELP, "help").message(help));
    }
    group
}

/// The lines of a text that an excerpt shows, and those between them: a drawing has a hundred thousand, and each excerpt
/// would count them all.
struct Window {
    text: String,
    /// Number of its first line in the whole text, from one.
    first_line: usize,
    /// The labels in it.
    spans: Vec<Range<usize>>,
}

/// Lines on either side of a label that are kept as they are; others between two labels are empty.
const KEPT_LINES: usize = 4;

impl Window {
    fn around(text: &str, labels: &[Label]) -> Self {
        let spans: Vec<Range<usize>> =
            labels.iter().map(|label| clamp(text, label.span.clone())).collect();
        let first = spans.iter().map(|span| span.start).min().unwrap_or(0);
        let last = spans.iter().map(|span| span.end).max().unwrap_or(0);
        let start = line_start(text, first, KEPT_LINES);
        let end = line_end(text, last, KEPT_LINES);
        let first_line = 1 + text[..start].matches('\n').count();

        // What is kept of it: all of a few lines, or those around each label.
        let near = |span: &Range<usize>| {
            line_start(text, span.start, KEPT_LINES)..line_end(text, span.end, KEPT_LINES)
        };
        let mut kept: Vec<Range<usize>> = spans.iter().map(near).collect();
        kept.sort_unstable_by_key(|range| range.start);
        let (mut shown, mut at) = (String::new(), start);
        let mut moves = Vec::new();
        for range in &kept {
            if range.start > at {
                let n_lines = text[at..range.start].matches('\n').count();
                shown.extend(std::iter::repeat_n('\n', n_lines));
                at = range.start;
            }
            moves.push((at, shown.len()));
            if range.end > at {
                shown.push_str(&text[at..range.end]);
                at = range.end;
            }
        }
        debug_assert!(at == end || spans.is_empty(), "the last label ends the window");
        let moved = |at: usize| {
            let found = moves.iter().rev().find(|(from, _)| *from <= at);
            found.map_or(0, |(from, to)| to + (at - from)).min(shown.len())
        };
        let spans = spans.iter().map(|span| moved(span.start)..moved(span.end)).collect();
        Self { first_line, spans, text: shown }
    }
}

/// The beginning of the line at a byte, or of one some lines before.
fn line_start(text: &str, at: usize, n_before: usize) -> usize {
    let mut breaks = text[..at].rmatch_indices('\n');
    breaks.nth(n_before).map_or(0, |(found, _)| found + 1)
}

/// The end of the line at a byte, with its line end, or of one some lines after.
fn line_end(text: &str, at: usize, n_after: usize) -> usize {
    let mut breaks = text[at..].match_indices('\n');
    breaks.nth(n_after).map_or(text.len(), |(found, _)| at + found + 1)
}

/// Spans of a lossily decoded text may not fit it.
fn clamp(text: &str, span: Range<usize>) -> Range<usize> {
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
    described(source, fault, &mut Lines::default())
}

/// Excerpt as of [`json`], with the lines of a text that have been found before.
fn described<'t>(source: &'t Text, fault: &Diagnostic, lines: &mut Lines<'t>) -> Value {
    let Located { path, text, fault } = source.locate(fault);
    lines.find_in(text);
    let word = match fault.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    let label = |label: &Label| {
        let (line, column) = lines.line_and_column(label.span.start);
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
    let mut lines = Lines::default();
    faults.iter().map(|fault| described(source, fault, &mut lines)).collect()
}

/// The lines of a text, found once for all of its faults.
#[derive(Default)]
struct Lines<'t> {
    text: &'t str,
    /// First bytes of the lines after the first one.
    starts: Vec<usize>,
}

impl<'t> Lines<'t> {
    fn find_in(&mut self, text: &'t str) {
        if !std::ptr::eq(self.text, text) {
            let starts = text.match_indices('\n').map(|(at, _)| at + 1).collect();
            *self = Self { text, starts };
        }
    }

    /// Line and column of a byte; see [`line_and_column`].
    fn line_and_column(&self, byte: usize) -> (usize, usize) {
        let n_before = self.starts.partition_point(|&start| start <= byte);
        let start = n_before.checked_sub(1).map_or(0, |last| self.starts[last]);
        // The line is the whole text.
        let (_, column) = line_and_column(&self.text[start..], byte.min(self.text.len()) - start);
        (n_before + 1, column)
    }
}

/// A message without an excerpt, styled for a terminal.
pub fn titled(message: &str, help: Option<&str>) -> String {
    let message = phrase(message);
    let help = help.map(phrase);
    let mut group = Group::with_title(named(Level::ERROR, "error").primary_title(message));
    if let Some(help) = help {
        group = group.element(named(Level::HELP, "help").message(help));
    }
    without_margin(&Renderer::styled().term_width(WIDTH).render(&[group]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_excerpt_of_a_long_text_shows_what_the_whole_one_would() {
        let lines: Vec<String> = (1..=400).map(|line| format!("line {line} \u{e4}\n")).collect();
        let text = lines.concat();
        let at = |line: usize| {
            let start = text.find(&format!("line {line} ")).expect("a line");
            start..start + 4
        };
        for lines in [vec![1], vec![400], vec![7, 9], vec![350, 20], vec![1, 3, 200, 400]] {
            let labels: Vec<Label> =
                lines.iter().map(|&line| Label { span: at(line), text: String::new() }).collect();
            let window = Window::around(&text, &labels);
            for (line, span) in lines.iter().zip(window.spans) {
                assert_eq!(&window.text[span.clone()], "line", "{lines:?}");
                let (found, column) = line_and_column(&window.text, span.start);
                assert_eq!((window.first_line + found - 1, column), (*line, 1), "{lines:?}");
            }
            let n_shown = window.text.lines().filter(|line| !line.is_empty()).count();
            assert!(n_shown <= 9 * lines.len(), "{n_shown} lines of {lines:?}");
        }
    }

    #[test]
    fn lines_are_found_once() {
        let text = "one\n\u{e4} two\r\n\nthree";
        let mut lines = Lines::default();
        lines.find_in(text);
        for byte in 0..=text.len() + 2 {
            assert_eq!(lines.line_and_column(byte), line_and_column(text, byte), "{byte}");
        }
    }
}
