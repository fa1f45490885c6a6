//! An HTML page of its own with MathML, or the `<math>` elements alone.

use super::{Body, Cell, Excerpt, Formula, Label, Page, Section};

const STYLE: &str = "\
body { font: 16px/1.45 'Latin Modern Roman', 'STIX Two Text', Georgia, serif; max-width: 48rem; \
margin: 2rem auto; padding: 0 1rem; color: #111; background: #fff; }
math { font-family: 'Latin Modern Math', 'STIX Two Math', 'Cambria Math', math; }
h1 { font-size: 1.6rem; font-weight: normal; text-align: center; }
h2 { font-size: 1.15rem; margin: 1.6rem 0 0.5rem; }
table { border-collapse: collapse; border-top: 1.5px solid; border-bottom: 1.5px solid; }
th { border-bottom: 0.75px solid; font-weight: normal; text-align: left; }
th, td { padding: 0.15rem 1.2rem 0.15rem 0; vertical-align: baseline; }
td.number, th.number { text-align: right; }
code { font-size: 0.9em; }
div.formulas { overflow-x: auto; overflow-y: hidden; padding: 0.2rem 0; }
div.formulas > math { margin-left: 0; width: max-content; }
math mtd { text-align: left; padding: 0.25em 0; }
math mtable mtable mtd { padding: 0 0.6em 0 0; }
math > mtable > mtr > mtd:first-child { padding-right: 0.3em; }
@media print { body { margin: 0; max-width: none; } mtr { break-inside: avoid; } }
";

/// A complete page.
pub(super) fn document(page: &Page) -> String {
    let title = format!("Equations of motion: {}", escaped(&page.title));
    let body: Vec<String> = page.sections.iter().map(section).collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width\"/>\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n{}\
         </body>\n</html>",
        body.concat()
    )
}

/// The formulas, one `<math>` element for each section.
pub(super) fn formulas(page: &Page) -> String {
    page.formula_sections()
        .map(|(title, formulas)| {
            let rows: Vec<String> = formulas.iter().flat_map(rows).collect();
            format!("<!-- {title} -->\n{}", math(&rows))
        })
        .collect::<Vec<_>>()
        .join("\n")
}

fn section(section: &Section) -> String {
    let Excerpt { title, html, .. } = excerpt(section, usize::MAX);
    format!("<h2>{title}</h2>\n{html}\n")
}

/// A section without its heading, formulas cut after about so many bytes.
pub(super) fn excerpt(section: &Section, bytes: usize) -> Excerpt {
    let mut n_left_out = 0;
    let html = match &section.body {
        Body::Formulas(formulas) => {
            let mut lines = formulas.iter().flat_map(rows).collect::<Vec<_>>();
            let mut length = 0;
            let fits = |line: &String| {
                length += line.len();
                length <= bytes
            };
            let n_kept = lines.iter().map(fits).take_while(|fits| *fits).count();
            n_left_out = lines.len() - n_kept;
            lines.truncate(n_kept);
            format!("<div class=\"formulas\">\n{}\n</div>", math(&lines))
        }
        Body::Table { header, rows } => table(header, rows),
        Body::Words(words) => words
            .iter()
            .map(|w| format!("<p>{}.</p>", escaped(&super::capitalised(w))))
            .collect::<Vec<_>>()
            .join("\n"),
    };
    Excerpt { title: super::capitalised(section.title), html, n_left_out }
}

/// Rows as one element.
fn math(rows: &[String]) -> String {
    format!(
        "<math xmlns=\"http://www.w3.org/1998/Math/MathML\" display=\"block\">\
         <mtable displaystyle=\"true\" columnalign=\"right left\">\n{}\n</mtable></math>",
        rows.join("\n")
    )
}

/// The lines of a formula, the first with its label.
fn rows(formula: &Formula) -> Vec<String> {
    let n = formula.lines.len();
    let row = |(at, line): (usize, &super::Line)| {
        let (label, relation) = match &formula.label {
            Label::Left(left) => (left.clone(), "<mo>=</mo>"),
            Label::Zero(name) => (format!("{name}<mo>:</mo>"), ""),
        };
        let (label, indent) = match at {
            0 => (label.as_str(), relation),
            _ => ("", "<mspace width=\"1em\"/>"),
        };
        let end = match (&formula.label, at + 1 == n, formula.remark.as_str()) {
            (_, false, _) | (Label::Left(_), true, "") => String::new(),
            (Label::Left(_), true, remark) => {
                format!("<mspace width=\"1em\"/><mtext>({})</mtext>", escaped(remark))
            }
            (Label::Zero(_), true, _) => "<mo>=</mo><mn>0</mn>".to_owned(),
        };
        format!(
            "<mtr><mtd><mrow>{label}</mrow></mtd><mtd><mrow>{indent}{}{end}</mrow></mtd></mtr>",
            line.formula
        )
    };
    formula.lines.iter().enumerate().map(row).collect()
}

fn table(header: &[&'static str], rows: &[Vec<Cell>]) -> String {
    let class = |c: usize| {
        let is_number = rows.iter().all(|row| matches!(row[c], Cell::Number(_)));
        if is_number { " class=\"number\"" } else { "" }
    };
    let heading = |(c, h): (usize, &&str)| format!("<th{}>{}</th>", class(c), escaped(h));
    let header: Vec<String> = header.iter().enumerate().map(heading).collect();
    let line = |row: &Vec<Cell>| -> String {
        let datum = |(c, d): (usize, &Cell)| format!("<td{}>{}</td>", class(c), cell(d));
        let cells: Vec<String> = row.iter().enumerate().map(datum).collect();
        format!("<tr>{}</tr>", cells.concat())
    };
    let body: Vec<String> = rows.iter().map(line).collect();
    format!("<table>\n<tr>{}</tr>\n{}\n</table>", header.concat(), body.join("\n"))
}

fn cell(cell: &Cell) -> String {
    match cell {
        Cell::Words(text) | Cell::Number(text) => escaped(text),
        Cell::Code(text) => format!("<code>{}</code>", escaped(text)),
        Cell::Formula(formula) => format!(
            "<math xmlns=\"http://www.w3.org/1998/Math/MathML\"><mrow>{formula}</mrow></math>"
        ),
    }
}

/// Text with the characters that HTML would take for its own.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
