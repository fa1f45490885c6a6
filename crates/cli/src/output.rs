//! The output of commands: text to stdout, or one JSON object.

use std::borrow::Cow;
use std::io::Write;
use std::sync::{Mutex, MutexGuard, PoisonError};

use anstream::adapter::strip_str;
use bksim::answered::{Role, answered};
pub use bksim::model::message::counted;
pub use bksim::report::number;
use bksim::translation::Language;
use serde_json::{Map, Value};

use crate::exit::Failure;
use crate::quiet::is_quiet;
use crate::visible::{Styles, visible, visible_json};
use bksim::translation::spoken as language;

/// Prints text and a line end; what a terminal would obey in it is written out.
///
/// # Errors
/// Standard output that cannot be written, or is closed.
pub fn text(text: &str) -> Result<(), Failure> {
    put(&visible(&translated(text), Styles::None))
}

/// An answer in the language that is spoken, but for its tables, which have it already.
pub fn translated(text: &str) -> Cow<'_, str> {
    let language = language();
    if language == Language::English {
        return text.into();
    }
    let is_list = text.contains('\n');
    let line = |line: &str| {
        let words = line.trim_start();
        let indent = &line[..line.len() - words.len()];
        let role = if is_list && indent.is_empty() { Role::Heading } else { Role::Cell };
        let is_row = words.contains("  ");
        let words = if is_row { words.to_owned() } else { answered(words, role, language) };
        format!("{indent}{words}")
    };
    text.split('\n').map(line).collect::<Vec<_>>().join("\n").into()
}

/// Prints a word on what was written, unless `--quiet`.
///
/// # Errors
/// As [`text()`].
pub fn report(report: &str) -> Result<(), Failure> {
    if is_quiet() { Ok(()) } else { text(report) }
}

/// A name from outside for [`styled()`]: with its own colours written out.
pub fn unstyled(name: &str) -> String {
    visible(name, Styles::None).into_owned()
}

/// Text ([`text()`]) with colours in it; those in a name from outside are [`unstyled()`] before.
///
/// # Errors
/// As [`text()`].
pub fn styled(text: &str) -> Result<(), Failure> {
    put(&visible(text, Styles::Kept))
}

/// Text that is printed while a command writes into a file in place of standard output.
static CAPTURED: Mutex<Option<String>> = Mutex::new(None);

fn captured() -> MutexGuard<'static, Option<String>> {
    CAPTURED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs a command; gives what it would have printed, too.
pub(crate) fn capture<T>(run: impl FnOnce() -> T) -> (T, String) {
    *captured() = Some(String::new());
    let done = run();
    (done, captured().take().unwrap_or_default())
}

fn put(text: &str) -> Result<(), Failure> {
    if let Some(content) = captured().as_mut() {
        content.push_str(&strip_str(text).to_string());
        content.push('\n');
        return Ok(());
    }
    let mut stdout = anstream::stdout().lock();
    writeln!(stdout, "{text}").and_then(|()| stdout.flush()).map_err(|e| Failure::stdout(&e))
}

/// The load case that answers are about.
static CASE: Mutex<Option<String>> = Mutex::new(None);

/// Says which load case the next answer is about.
pub(crate) fn about_case(name: Option<&str>) {
    *CASE.lock().unwrap_or_else(PoisonError::into_inner) = name.map(str::to_owned);
}

/// Prints the one JSON object of a command; a body that says `ok` has the last word on it.
///
/// # Errors
/// As [`text()`].
pub fn json(command: &str, body: Value) -> Result<(), Failure> {
    let mut object = Map::new();
    object.insert("ok".into(), Value::Bool(true));
    object.insert("command".into(), command.into());
    if let Some(case) = CASE.lock().unwrap_or_else(PoisonError::into_inner).clone() {
        object.insert("case".into(), case.into());
    }
    if let Value::Object(body) = body {
        object.extend(body);
    }
    object_text(&Value::Object(object))
}

/// Prints one JSON object.
///
/// # Errors
/// As [`text()`].
pub(crate) fn object_text(object: &Value) -> Result<(), Failure> {
    put(&visible_json(&format!("{object:#}")))
}

/// The size of an error or a residual, two significant digits.
pub(crate) fn size(value: f64) -> String {
    if value == 0.0 { "0".into() } else { format!("{value:.1e}") }
}

/// Numbers under one another, their decimal points in one column.
///
/// A value smaller than the rounding of the largest one is shown as 0; JSON has it as it is.
pub(crate) fn column(values: &[f64]) -> Vec<String> {
    let largest = values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let is_rounding = |value: f64| value.abs() < f64::EPSILON * largest;
    let texts: Vec<String> =
        values.iter().map(|&value| number(if is_rounding(value) { 0.0 } else { value })).collect();
    let before_point = |text: &str| text.find(['.', 'e']).unwrap_or(text.len());
    let widest = texts.iter().map(|text| before_point(text)).max().unwrap_or(0);
    texts.iter().map(|text| format!("{}{text}", " ".repeat(widest - before_point(text)))).collect()
}

/// Rows below a row of headings, in the language of the command: left-aligned columns, two spaces apart, each line
/// indented by two.
pub fn table(rows: &[Vec<String>]) -> String {
    in_columns(rows, |row, _| row == 0)
}

/// Rows that begin with a label, as [`table()`].
pub fn facts(rows: &[Vec<String>]) -> String {
    in_columns(rows, |_, column| column == 0)
}

/// Rows of names of a model with what is said of them, as [`table()`].
pub fn listed(rows: &[Vec<String>]) -> String {
    in_columns(rows, |_, _| false)
}

fn in_columns(rows: &[Vec<String>], is_heading: impl Fn(usize, usize) -> bool) -> String {
    let language = language();
    let cell = |row: usize, column: usize, cell: &String| {
        let role = if is_heading(row, column) { Role::Heading } else { Role::Cell };
        answered(cell, role, language)
    };
    let rows = rows.iter().enumerate().map(|(row, cells)| {
        cells.iter().enumerate().map(|(column, text)| cell(row, column, text)).collect()
    });
    let rows: Vec<Vec<String>> = rows.collect();
    let n_columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max()
    };
    let widths: Vec<usize> = (0..n_columns).map(|column| width(column).unwrap_or(0)).collect();
    let line = |row: &Vec<String>| {
        // Not by a format's width, which cannot hold that of any cell.
        let padded = |(cell, &width): (&String, &usize)| {
            format!("{cell}{}", " ".repeat(width - cell.chars().count()))
        };
        let cells: Vec<String> = row.iter().zip(&widths).map(padded).collect();
        format!("  {}", cells.join("  ")).trim_end().to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Rows from columns of equal length.
pub(crate) fn rows_of(columns: &[Vec<String>]) -> Vec<Vec<String>> {
    let n_rows = columns.first().map_or(0, Vec::len);
    (0..n_rows).map(|row| columns.iter().map(|column| column[row].clone()).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_column_line_up_and_rounding_is_zero() {
        assert_eq!(column(&[125.0, -1.5, 0.25, 1e-20]), ["125", " -1.5", "  0.25", "  0"]);
        // A column of small numbers alone is shown as it is.
        assert_eq!(column(&[1e-20, 0.0]), ["1.000e-20", "0"]);
    }
}
