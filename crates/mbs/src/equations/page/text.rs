//! Plain text: headings, indented lines, tables in columns.

use super::aligned::aligned;
use super::{Body, Cell, Formula, Label, Page, Section};

/// Sections that explain the names in formulas; they follow the formulas.
const EXPLANATIONS: [&str; 5] =
    ["contacts", "multipliers", "parameters", "operations", "certificate"];

/// The formulas, then what their names mean.
pub(super) fn formulas(page: &Page) -> String {
    written(page, formula)
}

/// Formulas with signs and terms in columns.
pub(super) fn aligned_formulas(page: &Page) -> String {
    written(page, aligned)
}

/// Every section in order.
pub(super) fn document(page: &Page) -> String {
    let title = format!("Equations of motion: {}", page.title);
    let rule = "=".repeat(title.chars().count());
    let body = page.sections.iter().map(|s| section(s, aligned));
    [vec![title, rule, String::new()], body.collect()].concat().join("\n").trim_end().to_owned()
}

/// Formulas by the given layout, then the tables that belong to them.
fn written(page: &Page, layout: fn(&Formula, usize) -> Vec<String>) -> String {
    let is_formula = |s: &&Section| matches!(s.body, Body::Formulas(_));
    let explanations =
        EXPLANATIONS.iter().filter_map(|title| page.sections.iter().find(|s| s.title == *title));
    let all = page.sections.iter().filter(is_formula).chain(explanations);
    all.map(|s| section(s, layout)).collect::<Vec<_>>().join("\n").trim_end().to_owned()
}

fn section(section: &Section, layout: fn(&Formula, usize) -> Vec<String>) -> String {
    let mut lines = vec![section.title.to_owned()];
    match &section.body {
        Body::Formulas(formulas) => {
            let label = |f: &Formula| f.label.plain().chars().count();
            let width = formulas.iter().map(label).max().unwrap_or(0);
            lines.extend(formulas.iter().flat_map(|f| layout(f, width)));
        }
        Body::Table { header, rows } => lines.extend(table(header, rows)),
        Body::Words(words) => lines.extend(words.iter().map(|w| format!("  {w}"))),
    }
    lines.push(String::new());
    lines.join("\n")
}

/// One formula in one line.
fn formula(formula: &Formula, _: usize) -> Vec<String> {
    let lines: Vec<&str> = formula.lines.iter().map(|line| line.formula.as_str()).collect();
    let sum = lines.join(" ");
    let remark =
        if formula.remark.is_empty() { String::new() } else { format!("    ({})", formula.remark) };
    vec![match &formula.label {
        Label::Left(left) => format!("  {left} = {sum}{remark}"),
        Label::Zero(name) => format!("  {name}:  {sum} = 0"),
    }]
}

/// Columns under their headers; a column that says what the one before it says is left out.
fn table(header: &[&'static str], rows: &[Vec<Cell>]) -> Vec<String> {
    let text = |cell: &Cell| match cell {
        Cell::Words(text) | Cell::Code(text) | Cell::Number(text) | Cell::Formula(text) => {
            text.clone()
        }
    };
    let repeats = |column: usize| {
        column > 0 && rows.iter().all(|row| text(&row[column]) == text(&row[column - 1]))
    };
    let columns: Vec<usize> = (0..header.len()).filter(|&c| !repeats(c)).collect();
    let mut cells: Vec<Vec<String>> = vec![columns.iter().map(|&c| header[c].to_owned()).collect()];
    cells.extend(rows.iter().map(|row| columns.iter().map(|&c| text(&row[c])).collect()));
    let is_number = |c: usize| rows.iter().all(|row| matches!(row[columns[c]], Cell::Number(_)));
    let count = |text: &String| bksim_expr::Notation::columns(text);
    let width = |c: usize| cells.iter().map(|row| count(&row[c])).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns.len()).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().enumerate().map(|(c, cell)| {
            let fill = " ".repeat(widths[c] - count(cell));
            // The first column of numbers is a name's; the others stand to the right.
            if is_number(c) { format!("{fill}{cell}") } else { format!("{cell}{fill}") }
        });
        format!("  {}", cells.collect::<Vec<_>>().join("  ")).trim_end().to_owned()
    };
    cells.iter().map(line).collect()
}
