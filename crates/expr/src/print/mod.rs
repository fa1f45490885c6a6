//! Expressions as a person reads them: one walk, five notations.
//!
//! ```text
//! expression ─ order ─ walk ─ marks ─┬─ text      m*x_ddot + c*x_dot        reads back
//!                                    ├─ unicode   m·ẍ + c·ẋ                 for the terminal
//!                                    ├─ latex     m \, \ddot{x} + …
//!                                    ├─ typst     m thin dot.double(x) + …
//!                                    └─ mathml    <mi>m</mi>…
//! ```
//!
//! The canonical order of the pool is blind to names; [`order`] puts terms and factors into the
//! order a person would write. [`walk`] decides on signs, fractions, powers and parentheses and
//! emits [`mark`]s; a notation writes each mark. [`lines`] breaks long sums.

mod count;
mod latex;
mod lines;
mod mark;
mod mathml;
mod name;
mod order;
mod split;
mod text;
mod typst;
mod unicode;
mod walk;
mod written;

pub use count::{OperationCount, Operations};
pub use split::SplitTerm;

use crate::pool::{Expr, Pool, SymbolId};
use mark::{Mark, SymbolNames};
use order::Reader;
use walk::Sum;

/// How formulas are written.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Notation {
    /// Infix with plain identifiers, which [`Pool::parse`] reads back: `m*x_ddot + c*x_dot`.
    Text,
    /// Plain notation with Greek letters, dots, subscripts and superscripts: `m·ẍ + c·ẋ`.
    Unicode,
    /// LaTeX, for mathematics mode; needs no package but amsmath.
    Latex,
    /// Typst, for mathematics mode.
    Typst,
    /// Presentation MathML: the content of a `<math>` element.
    MathMl,
}

impl Notation {
    /// True if fractions and powers stay within the line.
    fn is_linear(self) -> bool {
        matches!(self, Self::Text | Self::Unicode)
    }

    /// Appends a mark.
    fn write(self, mark: &Mark, names: &SymbolNames<'_>, out: &mut String) {
        match self {
            Self::Text => text::write(mark, names, out),
            Self::Unicode => unicode::write(mark, names, out),
            Self::Latex => latex::write(mark, names, out),
            Self::Typst => typst::write(mark, names, out),
            Self::MathMl => mathml::write(mark, names, out),
        }
    }

    /// Columns that a text takes on a terminal, in which dots above letters take none.
    pub fn columns(text: &str) -> usize {
        unicode::columns(text)
    }

    /// An identifier as it is written in formulas: `theta1_dot` is `\dot{\theta}_{1}` in LaTeX.
    pub fn name(self, name: &str) -> String {
        match self {
            Self::Text => name.to_owned(),
            Self::Unicode => unicode::name(name),
            Self::Latex => latex::name(name),
            Self::Typst => typst::name(name),
            Self::MathMl => mathml::name(name),
        }
    }
}

/// Writes expressions of one pool in one notation.
///
/// ```
/// use bksim_expr::{Notation, Pool, Printer};
///
/// let pool = Pool::new();
/// let e = pool.parse("m*x_ddot/2 + sqrt(k)*cos(phi1)").expect("valid");
/// let print = |notation| Printer::new(&pool, notation).expr(e);
/// assert_eq!(print(Notation::Text), "0.5*m*x_ddot + sqrt(k)*cos(phi1)");
/// assert_eq!(print(Notation::Unicode), "0.5·m·x\u{308} + √(k)·cos(φ₁)");
/// assert_eq!(
///     print(Notation::Latex),
///     r"\frac{1}{2} \, m \, \ddot{x} + \sqrt{k} \, \cos \phi_{1}"
/// );
/// assert_eq!(
///     print(Notation::Typst),
///     "frac(1, 2) thin m thin dot.double(x) + sqrt(k) thin cos phi_(1)"
/// );
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Printer<'a> {
    pool: &'a Pool,
    notation: Notation,
    moving: &'a [SymbolId],
    trailing: &'a [SymbolId],
}

impl<'a> Printer<'a> {
    /// A printer that writes factors in the order numbers, symbols by name, sums, calls.
    pub fn new(pool: &'a Pool, notation: Notation) -> Self {
        Self { pool, notation, moving: &[], trailing: &[] }
    }

    /// These symbols come after the other symbols in a product: coordinates after parameters.
    #[must_use]
    pub fn moving(self, symbols: &'a [SymbolId]) -> Self {
        Self { moving: symbols, ..self }
    }

    /// These symbols come last in a product, in the order given: accelerations, multipliers.
    #[must_use]
    pub fn trailing(self, symbols: &'a [SymbolId]) -> Self {
        Self { trailing: symbols, ..self }
    }

    /// One expression. Shared parts are written out each time; [`Pool::operation_count`] gives
    /// the length.
    pub fn expr(&self, e: Expr) -> String {
        let reader = Reader::new(self.pool, &[e], [self.moving, self.trailing]);
        let mut out = String::new();
        self.walk(&reader, walk::whole(e), &mut |mark| self.emit(&mark, &mut out));
        out
    }

    /// The terms joined by `+` and `−` in the given order; `0` when there are none.
    pub fn terms(&self, terms: &[Expr]) -> String {
        let mut out = String::new();
        self.walk_terms(terms, Sum::Begins, &mut |mark| self.emit(&mark, &mut out));
        out
    }

    /// The terms in lines of at most `width` where that can be done: characters for
    /// [`Notation::Text`] and [`Notation::Unicode`], else ems of a usual mathematics font. Lines
    /// break before `+` and `−`: between terms, or inside a long sum in parentheses.
    pub fn lines(&self, terms: &[Expr], width: f64) -> Vec<String> {
        self.broken_lines(terms, Sum::Begins, width)
    }

    /// Lines ([`Printer::lines`]) for terms that go on with a sum: the first line too begins with its
    /// sign.
    pub fn further_lines(&self, terms: &[Expr], width: f64) -> Vec<String> {
        self.broken_lines(terms, Sum::GoesOn, width)
    }

    fn broken_lines(&self, terms: &[Expr], sum: Sum, width: f64) -> Vec<String> {
        let mut marks = Vec::new();
        self.walk_terms(terms, sum, &mut |mark| marks.push(mark));
        let names = SymbolNames { pool: self.pool };
        let measure = |mark: &Mark| match self.notation {
            Notation::Text | Notation::Unicode => {
                let mut out = String::new();
                self.emit(mark, &mut out);
                unicode::columns(&out) as f64
            }
            _ => lines::ems(mark, &names),
        };
        let write = |line: &[Mark]| {
            let mut out = String::new();
            for mark in line {
                self.emit(mark, &mut out);
            }
            out.trim().to_owned()
        };
        lines::broken(marks, self.notation.is_linear(), &measure, width)
            .iter()
            .map(|line| write(line))
            .collect()
    }

    /// A symbol of the pool.
    pub fn symbol(&self, symbol: SymbolId) -> String {
        self.notation.name(&self.pool.symbol_name(symbol))
    }

    fn emit(&self, mark: &Mark, out: &mut String) {
        self.notation.write(mark, &SymbolNames { pool: self.pool }, out);
    }

    fn walk_terms(&self, terms: &[Expr], sum: Sum, emit: &mut dyn FnMut(Mark)) {
        let reader = Reader::new(self.pool, terms, [self.moving, self.trailing]);
        let pieces = match terms {
            [] => walk::whole(self.pool.zero()),
            terms => walk::sum(&reader, self.notation.is_linear(), sum, &reader.in_line(terms)),
        };
        self.walk(&reader, pieces, emit);
    }

    fn walk(&self, reader: &Reader<'_>, pieces: Vec<walk::Piece>, emit: &mut dyn FnMut(Mark)) {
        walk::walk(reader, self.notation, pieces, emit);
    }
}

impl Pool {
    /// Infix text: `+ - * / ^`, function names and plain identifiers; [`Pool::parse`] reads it
    /// back.
    pub fn to_text(&self, e: Expr) -> String {
        Printer::new(self, Notation::Text).expr(e)
    }

    /// LaTeX source for mathematics mode.
    pub fn to_latex(&self, e: Expr) -> String {
        Printer::new(self, Notation::Latex).expr(e)
    }

    /// The terms joined by `+` and `-` in the given order; `0` when there are none.
    pub fn terms_to_text(&self, terms: &[Expr]) -> String {
        Printer::new(self, Notation::Text).terms(terms)
    }
}
