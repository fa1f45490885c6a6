//! Typst: a document without packages, or its formulas alone.

use super::{Body, Cell, Formula, Label, Page, Section};

const PREAMBLE: &str = r#"#set page(paper: "a4", margin: 25mm, numbering: "1")
#set text(font: "New Computer Modern", size: 11pt)
#set par(justify: false)
#show math.equation: set block(breakable: true)
#show math.equation.where(block: true): set align(left)
#show heading: set block(above: 1.4em, below: 0.8em)
"#;

/// Rows of a table that stays on one page.
const LONGEST_UNBROKEN_TABLE: usize = 12;

/// A complete document.
pub(super) fn document(page: &Page) -> String {
    let title = format!("Equations of motion: {}", escaped(&page.title));
    let body: Vec<String> = page.sections.iter().map(section).collect();
    format!(
        "#set document(title: \"{}\")\n{PREAMBLE}\n\
         #align(center, text(size: 16pt)[{title}])\n\n{}",
        page.title.replace('\\', "\\\\").replace('"', "\\\""),
        body.join("\n")
    )
}

/// The formulas, one block for each section.
pub(super) fn formulas(page: &Page) -> String {
    let block = |(title, formulas): (&str, &[Formula])| format!("// {title}\n{}", block(formulas));
    page.formula_sections().map(block).collect::<Vec<_>>().join("\n")
}

fn section(section: &Section) -> String {
    let heading = format!("= {}", super::capitalised(section.title));
    let body = match &section.body {
        Body::Formulas(formulas) => block(formulas),
        Body::Table { header, rows } => table(header, rows),
        Body::Words(words) => words
            .iter()
            .map(|w| format!("{}.", escaped(&super::capitalised(w))))
            .collect::<Vec<_>>()
            .join("\n\n"),
    };
    format!("{heading}\n{body}\n")
}

fn block(formulas: &[Formula]) -> String {
    let rows: Vec<String> = formulas.iter().flat_map(rows).collect();
    format!("$\n  {}\n$", rows.join(" \\\n  "))
}

/// The lines of a formula, the first with its label.
fn rows(formula: &Formula) -> Vec<String> {
    let n = formula.lines.len();
    let row = |(at, line): (usize, &super::Line)| {
        let (label, relation) = match &formula.label {
            Label::Left(left) => (left.clone(), "= "),
            Label::Zero(name) => (format!("{name} : quad"), ""),
        };
        let (label, indent) = match at {
            0 => (label.as_str(), relation),
            // An empty text before a sign makes it one between terms.
            _ => ("", "quad \"\" "),
        };
        let end = match (&formula.label, at + 1 == n, formula.remark.as_str()) {
            (_, false, _) | (Label::Left(_), true, "") => String::new(),
            (Label::Left(_), true, remark) => format!(" quad \"({remark})\""),
            (Label::Zero(_), true, _) => " = 0".to_owned(),
        };
        format!("{label} & {indent}{}{end}", line.formula)
    };
    formula.lines.iter().enumerate().map(row).collect()
}

fn table(header: &[&'static str], rows: &[Vec<Cell>]) -> String {
    let align = |c: usize| {
        let is_number = rows.iter().all(|row| matches!(row[c], Cell::Number(_)));
        if is_number { "right" } else { "left" }
    };
    let aligns: Vec<&str> = (0..header.len()).map(align).collect();
    let line =
        |row: &Vec<Cell>| format!("  {},", row.iter().map(cell).collect::<Vec<_>>().join(", "));
    let is_short = rows.len() <= LONGEST_UNBROKEN_TABLE;
    let (breakable, end) = if is_short { ("block(breakable: false, ", ")") } else { ("", "") };
    let header = header.iter().map(|h| format!("[{h}]")).collect::<Vec<_>>().join(", ");
    format!(
        "#{breakable}table(\n  columns: {}, align: ({},), stroke: none,\n  table.hline(), \
         table.header({header}), table.hline(stroke: 0.5pt),\n{}\n  table.hline(),\n){end}",
        aligns.len(),
        aligns.join(", "),
        rows.iter().map(line).collect::<Vec<_>>().join("\n"),
    )
}

fn cell(cell: &Cell) -> String {
    match cell {
        Cell::Words(text) | Cell::Number(text) => format!("[{}]", escaped(text)),
        Cell::Code(text) => format!("[#raw(\"{}\")]", text.replace('"', "\\\"")),
        Cell::Formula(formula) => format!("[${formula}$]"),
    }
}

/// Text with the characters that Typst would take for its own.
fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        if "\\*_`$#[]<>@=-+/~'\"".contains(c) {
            out.push('\\');
        }
        out.push(c);
    }
    out
}
