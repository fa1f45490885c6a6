//! LaTeX: an article with amsmath, booktabs and longtable, or its formulas alone.

use super::{Body, Cell, Formula, Label, Page, Section};

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
    let body: Vec<String> = page.sections.iter().map(section).collect();
    format!(
        "{PREAMBLE}\\title{{{title}}}\n\\author{{}}\n\\date{{}}\n\n\
         \\begin{{document}}\n\\maketitle\n\n{}\n\\end{{document}}",
        body.join("\n")
    )
}

/// The formulas, one block for each section.
pub(super) fn formulas(page: &Page) -> String {
    let block = |(title, formulas): (&str, &[Formula])| format!("% {title}\n{}", align(formulas));
    page.formula_sections().map(block).collect::<Vec<_>>().join("\n")
}

fn section(section: &Section) -> String {
    let heading = format!("\\section*{{{}}}", super::capitalised(section.title));
    let body = match &section.body {
        Body::Formulas(formulas) => align(formulas),
        Body::Table { header, rows } => table(header, rows),
        Body::Words(words) => words
            .iter()
            .map(|w| format!("{}.", escaped(&super::capitalised(w))))
            .collect::<Vec<_>>()
            .join("\n\n"),
    };
    format!("{heading}\n{body}\n")
}

fn align(formulas: &[Formula]) -> String {
    let rows: Vec<String> = formulas.iter().flat_map(rows).collect();
    format!("\\begin{{align*}}\n  {}\n\\end{{align*}}", rows.join(" \\\\\n  "))
}

/// The lines of a formula, the first with its label.
fn rows(formula: &Formula) -> Vec<String> {
    let n = formula.lines.len();
    let row = |(at, line): (usize, &super::Line)| {
        let (label, relation) = match &formula.label {
            Label::Left(left) => (left.clone(), "= "),
            Label::Zero(name) => (format!("{name}\\colon\\quad"), ""),
        };
        let (label, indent) = match at {
            0 => (label.as_str(), relation),
            _ => ("", "\\quad {}"),
        };
        let end = match (&formula.label, at + 1 == n, formula.remark.as_str()) {
            (_, false, _) | (Label::Left(_), true, "") => String::new(),
            (Label::Left(_), true, remark) => format!(" \\quad \\text{{({})}}", escaped(remark)),
            (Label::Zero(_), true, _) => " = 0".to_owned(),
        };
        // Behind `&` a sign would be one between terms.
        let formula = match line.formula.strip_prefix('-').filter(|_| at == 0) {
            Some(rest) => format!("{{-}}{rest}"),
            None => line.formula.clone(),
        };
        format!("{label} & {indent}{formula}{end}")
    };
    formula.lines.iter().enumerate().map(row).collect()
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
