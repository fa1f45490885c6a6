//! `[tables.…] file = "motor.csv"`: rows of measured values from another file.
//!
//! The first line may name the columns, with their units in brackets: `speed [rpm], torque [N m]`. Columns are
//! divided by commas, semicolons or tabs; with semicolons and tabs a comma may be the decimal one.

use super::super::codes;
use super::super::tree::{Entry, Node, Table, Value};
use super::uses::beside;
use super::{Expander, Unopened};
use crate::diagnostic::{Diagnostic, Span};

/// Cells without a number that are reported one by one.
const MOST_CELLS: usize = 5;

/// The help for cells that a spreadsheet or a program left without a value.
const OF_SHEETS: &str = "write the value that was measured, or remove the row";
const OF_WORDS: &str =
    "write numbers alone, and their units in the first line: `angle [deg], force [N]`";

/// True of what programs write for a value that they do not have.
fn is_of_sheet(cell: &str) -> bool {
    let cell = cell.to_ascii_lowercase();
    let names = ["", "nan", "na", "n/a", "null", "none", "inf", "-inf", "infinity", "-", "?"];
    cell.starts_with('#') || names.contains(&cell.as_str())
}

impl Expander<'_> {
    /// Puts the rows of other files into the tables that name them.
    pub(super) fn read_rows(&mut self, root: &mut Table, by: &str) {
        let section = root.entries.iter_mut().find(|section| section.key == "tables");
        let Some(Entry { node: Node { value: Value::Table(tables), .. }, .. }) = section else {
            return;
        };
        for Entry { key, node, .. } in &mut tables.entries {
            let Value::Table(keys) = &mut node.value else { continue };
            let Some(place) = keys.entries.iter().position(|entry| entry.key == "file") else {
                continue;
            };
            let file = keys.entries.remove(place);
            if keys.get("points").is_some() {
                self.report(
                    Diagnostic::error(
                        codes::KEY_CONFLICT,
                        format!("`file` and `points` of table `{key}` exclude each other"),
                    )
                    .at(file.key_span, "")
                    .help("keep one of them"),
                );
                continue;
            }
            let Some((units, points)) = self.rows_of(key, &file.node, by) else { continue };
            let of = |name: &str, node: Node| Entry {
                key: name.to_owned(),
                key_span: file.key_span.clone(),
                node,
            };
            if let (Some(units), None) = (units, keys.get("units")) {
                keys.entries.push(of("units", units));
            }
            keys.entries.push(of("points", points));
        }
    }

    /// The units of the columns, where the file states them, and its rows.
    fn rows_of(&mut self, table: &str, node: &Node, by: &str) -> Option<(Option<Node>, Node)> {
        let Value::Text(file) = &node.value else {
            self.report(
                Diagnostic::error(
                    codes::WRONG_KIND,
                    format!("`file` of table `{table}` is no text"),
                )
                .at(node.span.clone(), "the name of a file, in quotes")
                .help("write for example `file = \"motor.csv\"`"),
            );
            return None;
        };
        let path = beside(by, file);
        let text = match self.text_of(&path) {
            Ok(text) => text,
            Err(Unopened { why, help }) => {
                let usual = "name a file of comma-separated values in the folder of the model";
                self.report(
                    Diagnostic::error(codes::BAD_TABLE, format!("the rows `{path}` {why}"))
                        .at(node.span.clone(), "this file")
                        .help(help.unwrap_or_else(|| usual.to_owned())),
                );
                return None;
            }
        };
        if !self.pays_for(text.len(), table, node.span.clone()) {
            return None;
        }
        let start = self.keep(&path, text);
        let text = self.files[self.files.len() - 1].text.clone();
        let whole = start..start + text.len();
        let divider = divider_of(&text);
        let mut lines = lines_of(&text, start);
        lines.retain(|(line, _)| !line.trim().is_empty() && !line.trim_start().starts_with('#'));

        // A first line that begins with no number has names and perhaps units.
        let (mut units, mut n_columns) = (None, None);
        if let Some((header, span)) = lines.first().cloned() {
            let cells = cells_of(header, divider, span.start);
            if cells.first().is_some_and(|(cell, _)| number(cell, divider).is_none()) {
                n_columns = Some(if cells.len() == 3 { 3 } else { 2 });
                let found = self.header_units(table, &cells)?;
                let node = Node { span, value: Value::Array(found.clone()) };
                units = (!found.is_empty()).then_some(node);
                lines.remove(0);
            }
        }
        let (mut rows, mut n_bad) = (Vec::with_capacity(lines.len()), 0_usize);
        for (row_idx, (line, span)) in lines.into_iter().enumerate() {
            let cells = cells_of(line, divider, span.start);
            let n = *n_columns.get_or_insert(if cells.len() == 3 { 3 } else { 2 });
            if cells.len() != n {
                let message = format!(
                    "row {} of table `{table}` has {} columns, not {}",
                    row_idx + 1,
                    cells.len(),
                    ["two", "three"][n - 2]
                );
                self.report(
                    Diagnostic::error(codes::BAD_TABLE, message)
                        .at(span, "one argument or two, then the value")
                        .help("divide the columns with commas, semicolons or tabs, for example `100, 9.5`"),
                );
                return None;
            }
            let mut pair = Vec::new();
            for (cell, span) in cells {
                let Some(value) = number(cell, divider) else {
                    let found = if cell.is_empty() {
                        "a cell is empty".to_owned()
                    } else {
                        format!("`{cell}` is no number")
                    };
                    let message = format!("row {} of table `{table}`: {found}", row_idx + 1);
                    n_bad += 1;
                    if n_bad <= MOST_CELLS {
                        self.report(
                            Diagnostic::error(codes::BAD_TABLE, message)
                                .at(span, "not a number")
                                .help(if is_of_sheet(cell) { OF_SHEETS } else { OF_WORDS }),
                        );
                    }
                    continue;
                };
                let digits = format!("{value:?}");
                pair.push(Node { span, value: Value::Number { value, digits } });
            }
            rows.push(Node { span, value: Value::Array(pair) });
        }
        if let (true, Some(last)) = (n_bad > MOST_CELLS, self.faults.last_mut()) {
            last.notes.push(format!("{} more cells are no numbers", n_bad - MOST_CELLS));
        }
        (n_bad == 0).then_some((units, Node { span: whole, value: Value::Array(rows) }))
    }

    /// The units in the brackets of a header, none where it has no brackets.
    fn header_units(&mut self, table: &str, cells: &[(&str, Span)]) -> Option<Vec<Node>> {
        let unit = |(cell, span): &(&str, Span)| {
            let (open, close) = (cell.find('[')?, cell.rfind(']')?);
            let text = cell.get(open + 1..close)?.trim().to_owned();
            let span = span.start + open + 1..span.start + close;
            Some(Node { span, value: Value::Text(text) })
        };
        let units: Vec<Option<Node>> = cells.iter().map(unit).collect();
        if units.iter().all(Option::is_none) {
            return Some(Vec::new());
        }
        let span = cells[0].1.start..cells[cells.len() - 1].1.end;
        if units.contains(&None) || !(2..=3).contains(&units.len()) {
            self.report(
                Diagnostic::error(
                    codes::BAD_TABLE,
                    format!(
                        "the first line of table `{table}` has not one unit for each of two or three columns"
                    ),
                )
                .at(span, "names and units of the columns")
                .help("write for example `angle [deg], force [N]`; `[]` for a plain number"),
            );
            return None;
        }
        Some(units.into_iter().flatten().collect())
    }
}

/// The sign between columns: the first of tab, semicolon and comma that the text has.
fn divider_of(text: &str) -> char {
    ['\t', ';'].into_iter().find(|divider| text.contains(*divider)).unwrap_or(',')
}

/// The lines of a text, with their places among all files.
fn lines_of(text: &str, start: usize) -> Vec<(&str, Span)> {
    let mut at = start;
    let line = |line: &str| {
        let from = at;
        at += line.len();
        from
    };
    let starts: Vec<usize> = text.split_inclusive('\n').map(line).collect();
    let lines = text.split_inclusive('\n').map(|line| line.trim_end_matches(['\n', '\r']));
    lines.zip(starts).map(|(line, from)| (line, from..from + line.len())).collect()
}

/// The cells of a line without the blanks and quotes around them, and their places.
fn cells_of(line: &str, divider: char, start: usize) -> Vec<(&str, Span)> {
    let mut at = 0;
    line.split(divider)
        .map(|cell| {
            let bare = cell.trim().trim_matches('"').trim();
            let from = start + at + (bare.as_ptr() as usize).saturating_sub(cell.as_ptr() as usize);
            at += cell.len() + 1;
            (bare, from..from + bare.len())
        })
        .collect()
}

/// The number of a cell; with other dividers than commas a comma may be the decimal one.
fn number(cell: &str, divider: char) -> Option<f64> {
    let is_decimal_comma = divider != ',' && !cell.contains('.');
    let parsed = if is_decimal_comma { cell.replacen(',', ".", 1).parse() } else { cell.parse() };
    parsed.ok().filter(|value: &f64| value.is_finite())
}
