//! Results of a suite: tables, goals with the numbers found, and notes.

use std::fmt;

use serde_json::{Map, Value, json};

/// A table of text; numbers are written by [`seconds`] and [`ratio`].
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    pub(crate) fn new<S: Into<String>>(header: impl IntoIterator<Item = S>) -> Self {
        Self { header: header.into_iter().map(Into::into).collect(), rows: Vec::new() }
    }

    /// Appends a row.
    pub(crate) fn push<S: Into<String>>(&mut self, row: impl IntoIterator<Item = S>) {
        self.rows.push(row.into_iter().map(Into::into).collect());
    }

    /// The table in Markdown.
    fn to_markdown(&self) -> String {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let rule: String = self.header.iter().map(|_| " --- |").collect();
        let rows: String = self.rows.iter().map(|row| line(row)).collect();
        format!("{}|{rule}\n{rows}", line(&self.header))
    }
}

impl fmt::Display for Table {
    /// Writes the first column aligned to the left, all others to the right.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lines = || std::iter::once(&self.header).chain(&self.rows);
        let width = |column: usize| {
            let cells = lines().filter_map(|line| line.get(column));
            cells.map(|cell| cell.chars().count()).max().expect("the header has every column")
        };
        let widths: Vec<usize> = (0..self.header.len()).map(width).collect();
        for (line_idx, line) in lines().enumerate() {
            for (column, (cell, &width)) in line.iter().zip(&widths).enumerate() {
                if column == 0 {
                    write!(f, "{cell:<width$}")?;
                } else {
                    write!(f, "  {cell:>width$}")?;
                }
            }
            writeln!(f)?;
            if line_idx == 0 {
                let total = widths.iter().sum::<usize>() + 2 * widths.len().saturating_sub(1);
                writeln!(f, "{}", "-".repeat(total))?;
            }
        }
        Ok(())
    }
}

/// The good side of a bound.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Goal {
    AtMost,
    AtLeast,
}

/// A goal with the number found.
#[derive(Clone, Debug)]
pub(crate) struct Check {
    /// Description of the number.
    pub(crate) what: String,
    /// The number; NaN where it could not be measured.
    pub(crate) found: f64,
    /// The good side of the bound.
    pub(crate) goal: Goal,
    /// The bound.
    pub(crate) bound: f64,
}

impl Check {
    /// `found ≤ bound`
    pub(crate) fn at_most(what: impl Into<String>, found: f64, bound: f64) -> Self {
        Self { what: what.into(), found, goal: Goal::AtMost, bound }
    }

    /// `found ≥ bound`
    pub(crate) fn at_least(what: impl Into<String>, found: f64, bound: f64) -> Self {
        Self { what: what.into(), found, goal: Goal::AtLeast, bound }
    }

    /// Whether the goal is met; unknown without a number.
    pub(crate) fn is_met(&self) -> Option<bool> {
        (!self.found.is_nan()).then_some(match self.goal {
            Goal::AtMost => self.found <= self.bound,
            Goal::AtLeast => self.found >= self.bound,
        })
    }
}

impl fmt::Display for Check {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = match self.goal {
            Goal::AtMost => "<=",
            Goal::AtLeast => ">=",
        };
        let verdict = match self.is_met() {
            Some(true) => "met   ",
            Some(false) => "MISSED",
            None => "open  ",
        };
        let (found, bound) = (short(self.found), short(self.bound));
        write!(f, "{verdict}  {}: {found} (goal {sign} {bound})", self.what)
    }
}

/// The results of one suite.
#[derive(Clone, Debug)]
pub(crate) struct Report {
    /// The name on the command line.
    pub(crate) name: &'static str,
    /// Title in one line.
    pub(crate) title: &'static str,
    /// The tables.
    pub(crate) tables: Vec<Table>,
    /// The goals.
    pub(crate) checks: Vec<Check>,
    /// Missing peers, sizes left out, and other facts that a reader must know.
    pub(crate) notes: Vec<String>,
    /// All numbers, for programs.
    pub(crate) numbers: Map<String, Value>,
}

impl Report {
    /// An empty report.
    pub(crate) fn new(name: &'static str, title: &'static str) -> Self {
        let (tables, checks, notes) = (Vec::new(), Vec::new(), Vec::new());
        Self { name, title, tables, checks, notes, numbers: Map::new() }
    }

    /// Tables, goals and notes in Markdown.
    pub(crate) fn to_markdown(&self) -> String {
        let mut goals = Table::new(["", "found", "goal", "met"]);
        for check in &self.checks {
            let sign = if check.goal == Goal::AtMost { "≤" } else { "≥" };
            let verdict = check.is_met().map_or("", |is_met| if is_met { "yes" } else { "**no**" });
            let bound = format!("{sign} {}", short(check.bound));
            goals.push([check.what.clone(), short(check.found), bound, verdict.to_owned()]);
        }
        let tables = self.tables.iter().chain([&goals]).filter(|table| !table.rows.is_empty());
        let tables: Vec<String> = tables.map(Table::to_markdown).collect();
        let notes: Vec<String> = self.notes.iter().map(|note| format!("- {note}\n")).collect();
        format!("## {}\n\n{}\n{}", self.title, tables.join("\n"), notes.concat())
    }

    /// All reports as one JSON document.
    pub(crate) fn all_to_json(reports: &[Self]) -> String {
        let one = |report: &Self| {
            let check = |check: &Check| {
                json!({
                    "what": check.what,
                    "found": check.found,
                    "goal": if check.goal == Goal::AtMost { "at most" } else { "at least" },
                    "bound": check.bound,
                    "met": check.is_met(),
                })
            };
            json!({
                "suite": report.name,
                "title": report.title,
                "checks": report.checks.iter().map(check).collect::<Vec<_>>(),
                "notes": report.notes,
                "numbers": report.numbers,
            })
        };
        let document = json!({ "suites": reports.iter().map(one).collect::<Vec<_>>() });
        format!("{document:#}\n")
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\n== {}: {} ==", self.name, self.title)?;
        for table in &self.tables {
            writeln!(f, "\n{table}")?;
        }
        for check in &self.checks {
            writeln!(f, "{check}")?;
        }
        for note in &self.notes {
            writeln!(f, "note: {note}")?;
        }
        Ok(())
    }
}

/// A duration with a fitting unit.
pub(crate) fn seconds(value: f64) -> String {
    let units = [(1.0, "s"), (1e-3, "ms"), (1e-6, "us"), (1e-9, "ns")];
    let (scale, unit) =
        units.into_iter().find(|&(scale, _)| value >= scale).unwrap_or((1e-9, "ns"));
    if value.is_nan() { "-".to_owned() } else { format!("{} {unit}", short(value / scale)) }
}

/// A ratio, or `-` without one.
pub(crate) fn ratio(value: f64) -> String {
    if value.is_nan() { "-".to_owned() } else { short(value) }
}

/// Three significant digits.
fn short(value: f64) -> String {
    if value.is_nan() {
        return "not measured".to_owned();
    }
    if value == 0.0 || value.abs() >= 100.0 {
        return format!("{value:.0}");
    }
    if value.abs() < 1e-4 {
        return format!("{value:.1e}");
    }
    let (mut digits, mut scaled) = (0, value.abs());
    while scaled < 99.95 && digits < 8 {
        (digits, scaled) = (digits + 1, 10.0 * scaled);
    }
    let text = format!("{value:.digits$}");
    if text.contains('.') {
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, expected) in [
            (0.002, "0.002"),
            (2e-8, "2.0e-8"),
            (1.254, "1.25"),
            (37.04, "37"),
            (225_000.4, "225000"),
            (0.0, "0"),
        ] {
            assert_eq!(short(value), expected);
        }
        assert_eq!(seconds(1.5e-5), "15 us");
        assert_eq!(seconds(f64::NAN), "-");
    }

    #[test]
    fn a_goal_without_a_number_is_open() {
        assert_eq!(Check::at_most("x", f64::NAN, 1.0).is_met(), None);
        assert_eq!(Check::at_most("x", 1.0, 1.0).is_met(), Some(true));
        assert_eq!(Check::at_least("x", 2.9, 3.0).is_met(), Some(false));
    }

    #[test]
    fn markdown_has_a_rule_below_the_header() {
        let mut report = Report::new("a", "A");
        let mut table = Table::new(["item", "time"]);
        table.push(["a", "1 ms"]);
        report.tables.push(table);
        report.checks.push(Check::at_least("fast", 2.0, 3.0));
        let expected = "## A\n\n| item | time |\n| --- | --- |\n| a | 1 ms |\n\n\
                        |  | found | goal | met |\n| --- | --- | --- | --- |\n\
                        | fast | 2 | ≥ 3 | **no** |\n\n";
        assert_eq!(report.to_markdown(), expected);
    }

    #[test]
    fn columns_are_aligned() {
        let mut table = Table::new(["item", "time"]);
        table.push(["a", "1 ms"]);
        table.push(["long", "10 ms"]);
        assert_eq!(table.to_string(), "item   time\n-----------\na      1 ms\nlong  10 ms\n");
    }
}
