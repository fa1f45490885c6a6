//! Long sums in lines: before which `+` or `−` a line ends, and how wide marks are.

use super::mark::{FunctionName, Height, Mark, MarkPart, SymbolNames, digits, function_name};
use super::name::Name;

/// A line that is at least this full may end at an outer sign even if more would fit.
const FULL_ENOUGH: f64 = 0.3;

/// A sign before which a line may end.
#[derive(Clone, Copy)]
struct Break {
    /// Index of the sign that begins the next line.
    mark: usize,
    /// Width from the beginning of the formula.
    at: f64,
    /// Parentheses around it.
    depth: usize,
}

/// Cuts marks into lines of at most `width` where signs allow it.
///
/// Outer signs are preferred to those in parentheses. Fractions, roots, exponents and arguments of
/// functions are never cut unless formulas stay within the line.
pub(super) fn broken(
    mut marks: Vec<Mark>,
    is_linear: bool,
    measure: &dyn Fn(&Mark) -> f64,
    width: f64,
) -> Vec<Vec<Mark>> {
    let (breaks, total) = breaks(&marks, is_linear, measure);
    let mut cuts: Vec<usize> = Vec::new();
    let (mut start, mut next) = (0.0, 0);
    while total - start > width && next < breaks.len() {
        let ahead = &breaks[next..];
        let fits = ahead.iter().take_while(|candidate| candidate.at - start <= width).count();
        let within = &ahead[..fits.max(1)];
        let full = within.iter().filter(|candidate| candidate.at - start >= FULL_ENOUGH * width);
        let outermost = |a: &&Break, b: &&Break| b.depth.cmp(&a.depth).then(a.at.total_cmp(&b.at));
        let chosen = full.max_by(outermost).or(within.last());
        let Some(&Break { mark, at, .. }) = chosen else { break };
        cuts.push(mark);
        start = at;
        next += ahead.iter().take_while(|candidate| candidate.mark <= mark).count();
    }
    split_parentheses(&mut marks, &cuts);
    let mut lines = Vec::with_capacity(cuts.len() + 1);
    for &cut in cuts.iter().rev() {
        lines.push(marks.split_off(cut));
    }
    lines.push(marks);
    lines.reverse();
    lines
}

/// All signs before which a line may end, and the width of the whole.
fn breaks(marks: &[Mark], is_linear: bool, measure: &dyn Fn(&Mark) -> f64) -> (Vec<Break>, f64) {
    let mut breaks = Vec::new();
    let (mut depth, mut closed) = (0usize, 0usize);
    let mut meter = WidthMeter::default();
    for (index, mark) in marks.iter().enumerate() {
        match mark {
            Mark::Plus | Mark::Minus if closed == 0 => {
                breaks.push(Break { mark: index, at: meter.width(), depth });
            }
            Mark::Parenthesis(MarkPart::Start, _) => depth += 1,
            Mark::Parenthesis(MarkPart::End, _) => depth = depth.saturating_sub(1),
            _ if is_linear => (),
            mark => match enclosing(mark) {
                Some(MarkPart::Start) => closed += 1,
                Some(MarkPart::End) => closed = closed.saturating_sub(1),
                _ => (),
            },
        }
        meter.add(mark, measure(mark));
    }
    (breaks, meter.width())
}

/// Marks between whose start and end no line ends.
fn enclosing(mark: &Mark) -> Option<MarkPart> {
    match *mark {
        Mark::Fraction(part)
        | Mark::Power(part)
        | Mark::Root(part)
        | Mark::Absolute(part)
        | Mark::Cases(part)
        | Mark::Truth(part)
        | Mark::Arguments(part, _) => Some(part),
        Mark::Raised(_) => Some(MarkPart::End),
        _ => None,
    }
}

/// Marks parentheses whose partner is in another line.
fn split_parentheses(marks: &mut [Mark], cuts: &[usize]) {
    let mut open: Vec<usize> = Vec::new();
    let line_of = |index: usize| cuts.partition_point(|&cut| cut <= index);
    for index in 0..marks.len() {
        match marks[index] {
            Mark::Parenthesis(MarkPart::Start, _) => open.push(index),
            Mark::Parenthesis(MarkPart::End, _) => {
                let Some(start) = open.pop().filter(|&start| line_of(start) != line_of(index))
                else {
                    continue;
                };
                marks[start] = Mark::Parenthesis(MarkPart::Start, Height::Split);
                marks[index] = Mark::Parenthesis(MarkPart::End, Height::Split);
            }
            _ => (),
        }
    }
}

/// Adds up widths; a fraction is as wide as the wider of its parts, an exponent is small.
#[derive(Default)]
struct WidthMeter {
    /// Width so far at each level of fractions, and of the numerator once it is complete.
    levels: Vec<(f64, f64)>,
    width: f64,
    n_small: i32,
}

/// Size of an exponent against its base.
const SMALL: f64 = 0.7;

impl WidthMeter {
    fn width(&self) -> f64 {
        self.width + self.levels.iter().map(|level| level.0).sum::<f64>()
    }

    fn add(&mut self, mark: &Mark, own: f64) {
        match mark {
            Mark::Fraction(MarkPart::Start) => {
                self.levels.push((self.width, 0.0));
                self.width = 0.0;
            }
            Mark::Fraction(MarkPart::Middle) => {
                if let Some(level) = self.levels.last_mut() {
                    level.1 = self.width;
                }
                self.width = 0.0;
            }
            Mark::Fraction(MarkPart::End) => {
                if let Some((before, numerator)) = self.levels.pop() {
                    self.width = before + self.width.max(numerator);
                }
            }
            Mark::Power(MarkPart::Middle) => self.n_small += 1,
            Mark::Power(MarkPart::End) => self.n_small -= 1,
            _ => (),
        }
        self.width += own * SMALL.powi(self.n_small.max(0));
    }
}

/// Width of a mark in ems of a usual mathematics font; of a fraction's end the space around it.
pub(super) fn ems(mark: &Mark, names: &SymbolNames<'_>) -> f64 {
    let letters = |text: &str| 0.5 * text.chars().count() as f64;
    let of_symbol = |symbol| {
        let name = names.of(symbol);
        let Name { letter, subscripts, .. } = Name::of(&name);
        let small: f64 = subscripts.iter().map(|word| word.ems() + 0.1).sum();
        letter.ems() + SMALL * small
    };
    match *mark {
        Mark::Number(ref n) => {
            let (mantissa, exponent) = digits(n);
            letters(&mantissa) + exponent.map_or(0.0, |e| 1.8 + SMALL * letters(&e))
        }
        Mark::Symbol(symbol) => of_symbol(symbol),
        Mark::RaisedSymbol(symbol, n) => of_symbol(symbol) + SMALL * letters(&n.to_string()),
        Mark::Plus | Mark::Minus | Mark::Relation(_) => 1.22,
        Mark::Sign | Mark::Root(MarkPart::Start) => 0.85,
        Mark::Times | Mark::Apply => 0.17,
        Mark::Over | Mark::Arguments(MarkPart::Middle, _) => 0.5,
        Mark::Raised(n) => SMALL * letters(&n.to_string()),
        Mark::Pi
        | Mark::Parenthesis(MarkPart::Start | MarkPart::End, _)
        | Mark::Arguments(MarkPart::Start | MarkPart::End, _) => 0.6,
        Mark::Fraction(MarkPart::End)
        | Mark::Absolute(MarkPart::Start | MarkPart::End)
        | Mark::Truth(MarkPart::Start | MarkPart::End) => 0.3,
        Mark::Function(function, n) => {
            letters(function_name(function)) + 0.17 + if n == 1 { 0.0 } else { 0.5 }
        }
        Mark::Named(function) => {
            let FunctionName { name, primes, by } = names.of_function(function);
            let by: f64 = by.iter().map(|variable| letters(variable)).sum();
            letters(&name) + 0.3 * primes.len() as f64 + SMALL * by
        }
        // Both values are above each other; counting both errs on the wide side.
        Mark::Cases(MarkPart::Start | MarkPart::Middle) | Mark::NotZero => 2.0,
        Mark::Cases(MarkPart::End) => 5.0,
        // No width of their own.
        Mark::Fraction(MarkPart::Start | MarkPart::Middle)
        | Mark::Power(_)
        | Mark::Root(MarkPart::Middle | MarkPart::End)
        | Mark::Absolute(MarkPart::Middle)
        | Mark::Parenthesis(MarkPart::Middle, _)
        | Mark::Otherwise
        | Mark::Truth(MarkPart::Middle) => 0.0,
    }
}
