//! Faults of models that were built in code: they name parts as Python writes them, for no file has their lines.

use std::ops::Range;

use bksim::messages::{level, worded};
use bksim::model::diagnostic::{Diagnostic, Severity};
use bksim_load::{Text, json, plain};
use serde_json::{Value, json};
use toml_edit::{Document, Item};

/// A key or an index on the way to a value.
#[derive(Clone, PartialEq, Debug)]
enum Step {
    Key(String),
    Index(usize),
}

/// One diagnostic as text: with an excerpt of its file, or with the parts that it is about.
pub(crate) fn words(source: &Text, fault: &Diagnostic) -> String {
    if !source.is_built {
        return plain(source, fault);
    }
    let severity = match fault.severity {
        Severity::Error => level("error"),
        Severity::Warning => level("warning"),
    };
    let (fault, _) = worded(fault);
    let mut lines = vec![format!("{severity}[{}]: {}", fault.code.0, fault.message)];
    for label in &fault.labels {
        let part = part(&source.text, &label.span);
        let colon = if label.text.is_empty() { "" } else { ": " };
        lines.push(format!("  --> {part}{colon}{}", label.text));
    }
    lines.extend(fault.notes.iter().map(|note| format!("   = {}: {note}", level("note"))));
    lines.extend(fault.help.iter().map(|help| format!("   = {}: {help}", level("help"))));
    lines.join("\n")
}

/// Diagnostics as JSON; those of a model built in code tell the part of every label, and no file.
pub(crate) fn json_all(source: &Text, faults: &[Diagnostic]) -> Value {
    let one = |fault: &Diagnostic| {
        let mut body = json(source, fault);
        if source.is_built {
            body["file"] = json!("");
            for (k, label) in fault.labels.iter().enumerate() {
                body["labels"][k]["part"] = json!(part(&source.text, &label.span));
            }
        }
        body
    };
    faults.iter().map(one).collect()
}

/// The part of a model's text around a span, as `joints["A"].second`; empty where there is none.
fn part(text: &str, span: &Range<usize>) -> String {
    let Ok(document) = Document::parse(text) else { return String::new() };
    let mut nearest = Nearest { at: span.start, best: None };
    nearest.look_in_table(document.as_table(), &mut Vec::new());
    nearest.best.map(|(_, path)| in_python(&path)).unwrap_or_default()
}

/// The smallest item met so far that has an offset in it.
struct Nearest {
    at: usize,
    best: Option<(usize, Vec<Step>)>,
}

impl Nearest {
    fn offer(&mut self, span: Option<Range<usize>>, path: &[Step]) {
        let Some(span) = span.filter(|span| span.contains(&self.at)) else { return };
        // Of two alike the inner one, which is offered later.
        if self.best.as_ref().is_none_or(|(length, _)| span.len() <= *length) {
            self.best = Some((span.len(), path.to_vec()));
        }
    }

    fn look_in_table(&mut self, table: &dyn toml_edit::TableLike, path: &mut Vec<Step>) {
        for (name, item) in table.iter() {
            path.push(Step::Key(name.to_owned()));
            self.offer(table.key(name).and_then(toml_edit::Key::span), path);
            self.look_in(item, path);
            path.pop();
        }
    }

    fn look_in(&mut self, item: &Item, path: &mut Vec<Step>) {
        self.offer(item.span(), path);
        if let Some(table) = item.as_table_like() {
            self.look_in_table(table, path);
        }
        if let Some(array) = item.as_array() {
            for (idx, value) in array.iter().enumerate() {
                path.push(Step::Index(idx));
                self.look_in(&Item::Value(value.clone()), path);
                path.pop();
            }
        }
    }
}

/// Sections whose entries are objects with attributes.
const OBJECTS: [&str; 4] = ["bodies", "joints", "loads", "drives"];

/// A way through the tables of a model as an expression of Python.
fn in_python(path: &[Step]) -> String {
    let mut text = String::new();
    let section = match path.first() {
        Some(Step::Key(section)) => section.as_str(),
        _ => return text,
    };
    // [solve] is called options there.
    text.push_str(if section == "solve" { "options" } else { section });
    let is_object = OBJECTS.contains(&section);
    let attribute = if is_object { 2 } else { 1 };
    let mut rest = path.iter().enumerate().skip(1);
    while let Some((depth, step)) = rest.next() {
        let has_attributes = is_object || section == "ground";
        match step {
            Step::Key(key) if depth == attribute && has_attributes => {
                let key = match (section, key.as_str(), path.get(depth + 1)) {
                    ("joints", "between", Some(Step::Index(end @ (0 | 1)))) => {
                        rest.next();
                        ["first", "second"][*end]
                    }
                    ("joints", "second", _) => "second_",
                    (_, "from", _) => "from_",
                    (_, key, _) => key,
                };
                text.push('.');
                text.push_str(key);
            }
            Step::Key(key) => text.extend(["[", &format!("{key:?}"), "]"]),
            Step::Index(idx) => text.extend(["[", &idx.to_string(), "]"]),
        }
    }
    text
}
