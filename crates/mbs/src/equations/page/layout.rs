//! The layout that typesetting languages share: headings, groups of formulas, formulas in lines.
//!
//! A language is a [`Markup`]: the strings that differ, and the functions for its text and tables.

use super::{Body, Cell, Formula, Label, Line, Page, Section, capitalised};

/// The parts of the layout that differ between two languages.
pub(super) struct Markup {
    /// Opens a comment up to the end of the line.
    pub(super) comment: &'static str,
    /// Before and after a heading.
    pub(super) heading: [&'static str; 2],
    /// Before and after a group of formulas.
    pub(super) group: [&'static str; 2],
    /// Between two lines of a group.
    pub(super) next_line: &'static str,
    /// After the name of an equation.
    pub(super) after_name: &'static str,
    /// Before the second and further lines of a formula.
    pub(super) indent: &'static str,
    /// The remark at the end of a definition.
    pub(super) remark: fn(&str) -> String,
    /// The first line of a formula.
    pub(super) first_line: fn(&str) -> String,
    /// Text with the characters that the language would take for its own.
    pub(super) escaped: fn(&str) -> String,
    /// A table.
    pub(super) table: fn(&[&'static str], &[Vec<Cell>]) -> String,
}

impl Markup {
    /// All sections of a page with their headings.
    pub(super) fn sections(&self, page: &Page) -> String {
        page.sections.iter().map(|s| self.section(s)).collect::<Vec<_>>().join("\n")
    }

    /// The formulas, one group for each section.
    pub(super) fn formulas(&self, page: &Page) -> String {
        let group = |(title, formulas): (&str, &[Formula])| {
            format!("{}{title}\n{}", self.comment, self.group(formulas))
        };
        page.formula_sections().map(group).collect::<Vec<_>>().join("\n")
    }

    fn section(&self, section: &Section) -> String {
        let [before, after] = self.heading;
        let body = match &section.body {
            Body::Formulas(formulas) => self.group(formulas),
            Body::Table { header, rows } => (self.table)(header, rows),
            Body::Words(words) => words
                .iter()
                .map(|w| format!("{}.", (self.escaped)(&capitalised(w))))
                .collect::<Vec<_>>()
                .join("\n\n"),
        };
        format!("{before}{}{after}\n{body}\n", capitalised(section.title))
    }

    fn group(&self, formulas: &[Formula]) -> String {
        let lines: Vec<String> = formulas.iter().flat_map(|formula| self.lines(formula)).collect();
        let [before, after] = self.group;
        format!("{before}\n  {}\n{after}", lines.join(self.next_line))
    }

    /// The lines of a formula, the first with its label.
    fn lines(&self, formula: &Formula) -> Vec<String> {
        let n = formula.lines.len();
        let line = |(at, line): (usize, &Line)| {
            let start = match (&formula.label, at) {
                (Label::Left(left), 0) => format!("{left} & = "),
                (Label::Zero(name), 0) => format!("{name}{} & ", self.after_name),
                _ => format!(" & {}", self.indent),
            };
            let terms =
                if at == 0 { (self.first_line)(&line.formula) } else { line.formula.clone() };
            let end = match (&formula.label, at + 1 == n, formula.remark.as_str()) {
                (_, false, _) | (Label::Left(_), true, "") => String::new(),
                (Label::Left(_), true, remark) => (self.remark)(remark),
                (Label::Zero(_), true, _) => " = 0".to_owned(),
            };
            format!("{start}{terms}{end}")
        };
        formula.lines.iter().enumerate().map(line).collect()
    }
}
