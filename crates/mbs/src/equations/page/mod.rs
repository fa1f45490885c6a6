//! The equations with everything that a reader needs to understand them, as sections of a page.
//!
//! [`Page::new`] gathers tables and formulas once, in one notation; each format then only says how
//! headings, tables and broken formulas are written. A page is printed as a whole document, which
//! typesets without editing, or as its formulas alone.

mod aligned;
mod content;
mod html;
mod latex;
mod layout;
mod text;
mod typst;

use std::collections::{BTreeSet, HashSet};

use bksim_expr::{Expr, Notation, Printer, SymbolId};

use super::arrange::{Kind, Part};
use super::{Level, Proof, ReadingForm, RowName};
use crate::quantity::Quantity;
use crate::system::SymbolicSystem;
use bksim_model::Model;

/// The subject of a page: a model with its equations.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// The model.
    pub model: &'a Model,
    /// Equations of the subject.
    pub system: &'a SymbolicSystem,
    /// Coordinates with unit, in order.
    pub coordinates: &'a [Quantity],
    /// Multipliers with unit and meaning, in order.
    pub multipliers: &'a [Quantity],
    /// The equations as they are shown.
    pub form: &'a ReadingForm,
    /// The proof that they are right.
    pub proof: &'a Proof,
}

/// The notation and layout of a page.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Style {
    /// Plain text, one line for each formula; formulas read back.
    Text,
    /// Text in columns for a terminal, formulas in lines of at most this many characters.
    Aligned {
        /// Characters of a line.
        width: usize,
        /// Greek letters, dots and indices instead of identifiers.
        unicode: bool,
    },
    /// LaTeX; the document needs amsmath, booktabs and longtable.
    Latex,
    /// Typst.
    Typst,
    /// MathML; the document is an HTML page.
    MathMl,
}

impl Style {
    fn notation(self) -> Notation {
        match self {
            Self::Text | Self::Aligned { unicode: false, .. } => Notation::Text,
            Self::Aligned { unicode: true, .. } => Notation::Unicode,
            Self::Latex => Notation::Latex,
            Self::Typst => Notation::Typst,
            Self::MathMl => Notation::MathMl,
        }
    }

    /// Width of a line of formula, characters or ems: the text width without a
    /// label of some characters, the indent and the `= 0`.
    fn line_width(self, n_label: usize) -> f64 {
        match self {
            Self::Text => f64::INFINITY,
            Self::Aligned { width, .. } => width.saturating_sub(n_label + 10).max(20) as f64,
            Self::Latex | Self::Typst | Self::MathMl => 36.0 - 0.36 * n_label.min(24) as f64,
        }
    }
}

/// One cell of a table.
#[derive(Clone, PartialEq, Eq, Debug)]
enum Cell {
    /// Plain words, not yet escaped.
    Words(String),
    /// A name of the model file.
    Code(String),
    /// A number, set to the right.
    Number(String),
    /// A formula in the page's notation.
    Formula(String),
}

/// A formula in lines.
#[derive(Clone, PartialEq, Eq, Debug)]
struct Formula {
    /// The text before it: `T =`, or the coordinate of an equation.
    label: Label,
    lines: Vec<Line>,
    /// The text after the last line: value and unit of a definition.
    remark: String,
}

/// The text before a formula.
#[derive(Clone, PartialEq, Eq, Debug)]
enum Label {
    /// The left side of an equation.
    Left(String),
    /// The name of an equation whose right side is zero.
    Zero(String),
}

impl Label {
    /// The label as plain text.
    fn plain(&self) -> String {
        match self {
            Self::Left(left) => format!("{left} ="),
            Self::Zero(name) => format!("{name}:"),
        }
    }
}

/// One line of a formula.
#[derive(Clone, PartialEq, Eq, Debug)]
struct Line {
    formula: String,
    /// The kind of its terms, where lines are sorted by it.
    kind: Option<Kind>,
}

/// One section of a page.
#[derive(Clone, PartialEq, Eq, Debug)]
struct Section {
    title: &'static str,
    body: Body,
}

#[derive(Clone, PartialEq, Eq, Debug)]
enum Body {
    Table { header: Vec<&'static str>, rows: Vec<Vec<Cell>> },
    Formulas(Vec<Formula>),
    Words(Vec<String>),
}

/// Everything that is printed about the equations of one model.
#[derive(Clone, Debug)]
pub struct Page {
    title: String,
    style: Style,
    sections: Vec<Section>,
}

impl Page {
    /// Gathers the sections.
    pub fn new(subject: &Subject<'_>, style: Style) -> Self {
        Self::with_levels(subject, style, &[])
    }

    /// Page ([`Page::new`]) with further equations after the constraints.
    pub fn with_levels(subject: &Subject<'_>, style: Style, levels: &[Level]) -> Self {
        let mut form = content::form_for(subject, style);
        // Reactions and accelerations of bodies come last in products, as those of coordinates do.
        let known: HashSet<SymbolId> = (form.trailing.iter().copied())
            .chain(subject.model.parameters.iter().map(|parameter| parameter.symbol))
            .chain(form.groups.iter().map(|group| group.symbol))
            .chain(subject.system.coordinates().iter().map(|coordinate| coordinate.q))
            .collect();
        let rows = levels.iter().flat_map(|level| &level.rows);
        let symbols = rows.flat_map(|(_, left)| subject.model.pool.symbols_of(*left));
        let further: BTreeSet<SymbolId> =
            symbols.filter(|symbol| !known.contains(symbol)).collect();
        form.trailing.extend(further);
        let subject = Subject { form: &form, ..*subject };
        let n_label = subject.coordinates.iter().map(|c| c.name.chars().count()).max().unwrap_or(0);
        let printer = form.printer(subject.model, style.notation());
        let writer = Writer { subject, style, printer, n_label };
        Self {
            title: subject.model.name.clone(),
            style,
            sections: content::sections(&writer, levels),
        }
    }

    /// A complete document.
    pub fn document(&self) -> String {
        match self.style {
            Style::Text | Style::Aligned { .. } => text::document(self),
            Style::Latex => latex::document(self),
            Style::Typst => typst::document(self),
            Style::MathMl => html::document(self),
        }
    }

    /// The formulas, for a document that is there already; as text, with the tables that explain
    /// their names.
    pub fn formulas(&self) -> String {
        match self.style {
            Style::Text => text::formulas(self),
            Style::Aligned { .. } => text::aligned_formulas(self),
            Style::Latex => latex::formulas(self),
            Style::Typst => typst::formulas(self),
            Style::MathMl => html::formulas(self),
        }
    }

    /// The sections as HTML, formulas of each cut after about so many bytes. Formulas are in the
    /// notation of the page: [`Style::MathMl`] is what belongs there.
    pub fn excerpts(&self, bytes: usize) -> Vec<Excerpt> {
        self.sections.iter().map(|section| html::excerpt(section, bytes)).collect()
    }

    fn formula_sections(&self) -> impl Iterator<Item = (&'static str, &[Formula])> {
        self.sections.iter().filter_map(|section| match &section.body {
            Body::Formulas(formulas) => Some((section.title, formulas.as_slice())),
            _ => None,
        })
    }
}

/// A section of a page as HTML without its document.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Excerpt {
    /// Heading of the excerpt.
    pub title: String,
    /// A table, paragraphs, or a `<math>` element in a `div`.
    pub html: String,
    /// Lines of formulas that are not in it.
    pub n_left_out: usize,
}

/// Writes the parts of a page in its notation.
#[derive(Clone, Copy)]
struct Writer<'a> {
    subject: Subject<'a>,
    style: Style,
    printer: Printer<'a>,
    /// Characters of the longest name before a formula.
    n_label: usize,
}

impl Writer<'_> {
    /// A sum as a formula: in one line if it fits, in lines otherwise.
    fn formula(&self, label: Label, terms: &[Expr], remark: String) -> Formula {
        let width = self.style.line_width(self.n_label) - self.remark_width(&remark);
        let lines = self.printer.lines(terms, width).into_iter();
        let lines = lines.map(|formula| Line { formula, kind: None }).collect();
        Formula { label, lines, remark }
    }

    fn remark_width(&self, remark: &str) -> f64 {
        let n = remark.chars().count() as f64;
        match self.style {
            _ if remark.is_empty() => 0.0,
            Style::Text | Style::Aligned { .. } => n + 6.0,
            Style::Latex | Style::Typst | Style::MathMl => 0.5 * n + 2.0,
        }
    }

    /// A Lagrange equation: in one line if it fits, otherwise each kind of terms in its own lines.
    fn equation(&self, label: Label, i: usize) -> Formula {
        let pool = &self.subject.model.pool;
        let form = self.subject.form;
        let whole = self.formula(label, &form.equation_terms(pool, i), String::new());
        let has_kinds = matches!(self.style, Style::Aligned { .. });
        if whole.lines.len() <= 1 && !has_kinds {
            return whole;
        }
        let mut lines = Vec::new();
        let mut parts = form.equations[i].as_slice();
        while let Some(first) = parts.first() {
            let kind = first.kind;
            let n = parts.iter().take_while(|part| part.kind == kind).count();
            let (these, rest) = parts.split_at(n);
            parts = rest;
            // On a terminal, a column after the lines names their kind.
            let n_title = if has_kinds { Kind::LONGEST_TITLE + 2 } else { 0 };
            let width = self.style.line_width(self.n_label + n_title);
            let written = |parts: &[Part], is_first: bool| {
                let terms: Vec<Expr> = parts.iter().flat_map(|part| part.terms(pool)).collect();
                if is_first {
                    self.printer.lines(&terms, width)
                } else {
                    self.printer.further_lines(&terms, width)
                }
            };
            // What does not fit in one line begins a line for each acceleration or multiplier.
            let mut together = written(these, lines.is_empty());
            if together.len() > 1 {
                let alone =
                    |(at, part)| written(std::slice::from_ref(part), lines.is_empty() && at == 0);
                together = these.iter().enumerate().flat_map(alone).collect();
            }
            lines.extend(together.into_iter().map(|formula| Line { formula, kind: Some(kind) }));
        }
        Formula { lines, ..whole }
    }
}

impl Writer<'_> {
    /// A name that is no symbol of the model.
    fn name(&self, name: &str) -> String {
        self.style.notation().name(name)
    }

    /// The letter of a function that is no symbol of the model; with an index where a symbol has that letter.
    fn letter(&self, letter: &str, index: &str) -> String {
        match self.subject.model.pool.find_symbol(letter) {
            None => self.name(letter),
            Some(_) => self.name(&format!("{letter}_{index}")),
        }
    }

    /// The name of a row of further equations.
    fn row_name(&self, name: RowName) -> String {
        let pool = &self.subject.model.pool;
        let partial = |top: &str, by: SymbolId| {
            let by = self.printer.symbol(by);
            match self.style {
                Style::Latex => format!("\\frac{{\\partial {top}}}{{\\partial {by}}}"),
                Style::Typst => format!("frac(partial {top}, partial {by})"),
                Style::MathMl => format!(
                    "<mfrac><mrow><mo>∂</mo>{top}</mrow><mrow><mo>∂</mo>{by}</mrow></mfrac>"
                ),
                Style::Text | Style::Aligned { .. } => format!("∂{top}/∂{by}"),
            }
        };
        let [rate, sum] = match self.style {
            Style::Latex => [r"\frac{d}{dt} ", r"\textstyle\sum \lambda \, "],
            Style::Typst => ["frac(d, d t) ", "sum lambda thin "],
            Style::MathMl => [
                "<mfrac><mi>d</mi><mrow><mi>d</mi><mi>t</mi></mrow></mfrac>",
                "<mo>∑</mo><mi>λ</mi>",
            ],
            Style::Text | Style::Aligned { .. } => ["d/dt ", "Σ λ "],
        };
        let lagrangian = self.letter("L", "total");
        match name {
            RowName::Symbol(name) => self.printer.expr(name),
            RowName::Lagrangian => lagrangian,
            RowName::ByRate(v) => partial(&lagrangian, v),
            RowName::RateOf(v) => format!("{rate}{}", partial(&lagrangian, v)),
            RowName::By(q) => partial(&lagrangian, q),
            RowName::Load(q) => self.name(&format!("Q_{}", pool.symbol_name(q))),
            RowName::OfConstraints(q) => format!("{sum}{}", partial(&self.letter("g", "k"), q)),
        }
    }

    /// The separator of formulas in one cell.
    fn comma(&self) -> &'static str {
        match self.style {
            Style::Latex => ",\\; ",
            Style::Typst => ", med ",
            Style::MathMl => "<mo separator=\"true\">,</mo>",
            Style::Text | Style::Aligned { .. } => ", ",
        }
    }

    /// Words within a formula.
    fn words(&self, text: &str) -> String {
        match self.style {
            _ if text.is_empty() => String::new(),
            Style::Latex => format!("\\text{{{}}}", latex::escaped(text)),
            Style::Typst => format!(" \"{text}\""),
            Style::MathMl => format!("<mtext>{}</mtext>", text.replace(' ', "\u{a0}")),
            Style::Text | Style::Aligned { .. } => text.to_owned(),
        }
    }
}

/// A title as a heading.
fn capitalised(title: &str) -> String {
    let mut chars = title.chars();
    chars.next().map_or(String::new(), |c| c.to_uppercase().chain(chars).collect())
}

/// About how many characters wide a column is.
fn column_width(header: &str, rows: &[Vec<Cell>], column: usize) -> f64 {
    let width = |cell: &Cell| match cell {
        Cell::Words(text) | Cell::Number(text) => text.chars().count() as f64,
        Cell::Code(text) => 1.05 * text.chars().count() as f64,
        // Half of the source of a formula are commands.
        Cell::Formula(text) => 0.5 * text.chars().count() as f64,
    };
    let cells = rows.iter().map(|row| width(&row[column]));
    cells.fold(header.chars().count() as f64, f64::max)
}

/// Exponents of a unit raised: `kg m²`.
fn unit(text: &str) -> String {
    text.replace("^-2", "⁻²")
        .replace("^-1", "⁻¹")
        .replace("^2", "²")
        .replace("^3", "³")
        .replace("^4", "⁴")
        .replace('*', " ")
}

/// A number of at most nine significant digits.
fn number(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".to_owned() } else { value.to_string() };
    }
    if !(1e-4..1e9).contains(&value.abs()) {
        return format!("{value:.3e}");
    }
    let rounded: f64 = format!("{value:.8e}").parse().expect("digits of a finite number");
    rounded.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_units_are_short() {
        assert_eq!([0.1 + 0.2, 25.0, 2e-5, -0.0].map(number), ["0.3", "25", "2.000e-5", "0"]);
        assert_eq!(number(2.0 / 3.0), "0.666666667");
        assert_eq!(["kg m^2", "N*m", "m/s^2"].map(unit), ["kg m²", "N m", "m/s²"]);
    }
}
