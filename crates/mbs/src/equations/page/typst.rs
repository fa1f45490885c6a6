//! Typst: a document without packages, or its formulas alone.

use super::layout::Markup;
use super::{Cell, Page};

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
    format!(
        "#set document(title: \"{}\")\n{PREAMBLE}\n\
         #align(center, text(size: 16pt)[{title}])\n\n{}",
        page.title.replace('\\', "\\\\").replace('"', "\\\""),
        MARKUP.sections(page)
    )
}

/// The formulas, one block for each section.
pub(super) fn formulas(page: &Page) -> String {
    MARKUP.formulas(page)
}

const MARKUP: Markup = Markup {
    comment: "// ",
    heading: ["= ", ""],
    group: ["$", "$"],
    next_line: " \\\n  ",
    after_name: " : quad",
    // An empty text before a sign makes it one between terms.
    indent: "quad \"\" ",
    remark: |text| format!(" quad \"({text})\""),
    first_line: str::to_owned,
    escaped,
    table,
};

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
