//! LaTeX: an article with amsmath, booktabs and longtable, or its formulas alone.

use super::layout::Markup;
use super::{Cell, Page};

const PREAMBLE: &str = r"\documentclass[a4paper,11pt,fleqn]{article}
\usepackage[utf8]{inputenc}
\usepackage{textcomp}
\IfFileExists{lmodern.sty}{\usepackage[T1]{fontenc}\usepackage{lmodern}}{}
\usepackage[margin=25mm]{geometry}
\usepackage{amsmath,array,booktabs,longtable}
\allowdisplaybreaks
\setlength{\parindent}{0pt}
\setlength{\LTleft}{0pt}
\setlength{\mathindent}{1em}
";
/// Width of the text, ems.
const TEXT_WIDTH: f64 = 41.0;
/// Width of a letter of text and space between columns, ems.
const LETTER: f64 = 0.52;
const GAP: f64 = 1.2;

/// A complete document.
pub(super) fn document(page: &Page) -> String {
    let title = format!("Equations of motion: {}", escaped(&page.title));
    format!(
        "{PREAMBLE}\\title{{{title}}}\n\\author{{}}\n\\date{{}}\n\n\
         \\begin{{document}}\n\\maketitle\n\n{}\n\\end{{document}}",
        MARKUP.sections(page)
    )
}

/// The formulas, one `align*` for each section.
pub(super) fn formulas(page: &Page) -> String {
    MARKUP.formulas(page)
}

const MARKUP: Markup = Markup {
    comment: "% ",
    heading: ["\\section*{", "}"],
    group: ["\\begin{align*}", "\\end{align*}"],
    next_line: " \\\\\n  ",
    after_name: "\\colon\\quad",
    indent: "\\quad {}",
    remark,
    first_line,
    escaped,
    table,
};

fn remark(text: &str) -> String {
    format!(" \\quad \\text{{({})}}", escaped(text))
}

/// After `&` a minus would stand between terms: braces make it a sign.
fn first_line(formula: &str) -> String {
    match formula.strip_prefix('-') {
        Some(rest) => format!("{{-}}{rest}"),
        None => formula.to_owned(),
    }
}

/// A table that may run over pages; columns that would be too wide are set in paragraphs.
fn table(header: &[&'static str], rows: &[Vec<Cell>]) -> String {
    let widths: Vec<f64> =
        (0..header.len()).map(|c| super::column_width(header[c], rows, c) * LETTER).collect();
    let total: f64 = widths.iter().sum::<f64>() + GAP * widths.len() as f64;
    let column = |c: usize| {
        if total > TEXT_WIDTH && widths[c] > TEXT_WIDTH / 4.0 {
            let share = widths[c] / total * TEXT_WIDTH;
            return format!(">{{\\raggedright\\arraybackslash}}p{{{share:.1}em}}");
        }
        let is_number = rows.iter().all(|row| matches!(row[c], Cell::Number(_)));
        if is_number { "r".to_owned() } else { "l".to_owned() }
    };
    let columns: Vec<String> = (0..header.len()).map(column).collect();
    let line = |row: &Vec<Cell>| row.iter().map(cell).collect::<Vec<_>>().join(" & ");
    let body: Vec<String> = rows.iter().map(|row| format!("{} \\\\", line(row))).collect();
    format!(
        "\\begin{{longtable}}{{@{{}}{}@{{}}}}\n\\toprule\n{} \\\\\n\\midrule\n\\endhead\n\
         {}\n\\bottomrule\n\\end{{longtable}}",
        columns.concat(),
        header.iter().map(|h| escaped(h)).collect::<Vec<_>>().join(" & "),
        body.join("\n"),
    )
}

fn cell(cell: &Cell) -> String {
    match cell {
        Cell::Words(text) | Cell::Number(text) => escaped(text),
        Cell::Code(text) => format!("\\texttt{{{}}}", escaped(text)),
        Cell::Formula(formula) => format!("${formula}$"),
    }
}

/// Text with the characters that LaTeX would take for its own.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '\\' => out.push_str("\\textbackslash{}"),
            '~' => out.push_str("\\textasciitilde{}"),
            '^' => out.push_str("\\textasciicircum{}"),
            '#' | '$' | '%' | '&' | '_' | '{' | '}' => out.extend(['\\', c]),
            '²' => out.push_str("\\textsuperscript{2}"),
            '³' => out.push_str("\\textsuperscript{3}"),
            '⁴' => out.push_str("\\textsuperscript{4}"),
            '⁻' => out.push_str("\\textsuperscript{--}"),
            '¹' => out.push_str("\\textsuperscript{1}"),
            c => out.push(c),
        }
    }
    out
}
