//! Cases chosen by their numbers, by how they ended, or by what their rows hold.
//!
//! ```text
//! 3,7,10-12      all      failed      max(reactions.B.fx) > 2 kN and l1 < 0.9 m
//! largest max(reactions.B.fx)      smallest final(state.x)
//! ```

use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use std::path::Path;

use bksim::model::file::WrittenUnit;

use crate::SweepError;
use crate::study::Study;
use crate::table::{Rows, column_named, rows};

/// A choice of cases.
#[derive(Clone, PartialEq, Debug)]
pub enum Chosen {
    /// Cases of these numbers.
    Numbers(Vec<RangeInclusive<u64>>),
    /// Every case.
    All,
    /// Cases whose run did not reach its end.
    Failed,
    /// Cases for which all of these hold.
    Where(Vec<Comparison>),
    /// The one with the largest or the smallest number in a column.
    Extreme {
        /// True of the largest, false of the smallest.
        is_largest: bool,
        /// The column.
        column: String,
    },
}

/// A column next to a number.
#[derive(Clone, PartialEq, Debug)]
pub struct Comparison {
    column: String,
    operator: &'static str,
    number: f64,
    /// `None` of a bare number, which is in SI.
    unit: Option<WrittenUnit>,
}

/// Longer ones first: `<` begins `<=`.
const OPERATORS: [&str; 4] = ["<=", ">=", "<", ">"];

impl Chosen {
    /// Reads a choice as people write it.
    ///
    /// # Errors
    /// The fault in words, with what to write.
    pub fn parse(text: &str) -> Result<Self, String> {
        let text = text.trim();
        match text {
            "all" => return Ok(Self::All),
            "failed" => return Ok(Self::Failed),
            _ => (),
        }
        for (word, is_largest) in [("largest ", true), ("smallest ", false)] {
            if let Some(column) = text.strip_prefix(word) {
                return Ok(Self::Extreme { is_largest, column: plain(column) });
            }
        }
        if text.starts_with(|c: char| c.is_ascii_digit()) && !text.contains(['<', '>']) {
            return text.split(',').map(numbers).collect::<Result<_, _>>().map(Self::Numbers);
        }
        text.split(" and ").map(comparison).collect::<Result<_, _>>().map(Self::Where)
    }

    /// The numbers of the chosen cases, ascending; `table` is that of the sweep, and finished.
    ///
    /// # Errors
    /// Cases and columns that the sweep does not have, units of another kind, and those of the table.
    pub fn cases(&self, study: &Study, table: &Path) -> Result<Vec<u64>, NoCases> {
        let n_cases = study.n_cases();
        match self {
            Self::All => Ok((0..n_cases).collect()),
            Self::Numbers(ranges) => {
                let last = ranges.iter().map(|range| *range.end()).max().unwrap_or_default();
                if last >= n_cases {
                    let last_case = n_cases.saturating_sub(1);
                    return Err(NoCases::Unknown(format!(
                        "there is no case {last}: they have the numbers 0 to {last_case}"
                    )));
                }
                let all: BTreeSet<u64> = ranges.iter().cloned().flatten().collect();
                Ok(all.into_iter().collect())
            }
            Self::Failed => {
                let rows = rows(table).map_err(SweepError::table(table))?;
                let failed = rows.cases.iter().zip(&rows.is_done).filter(|(_, is_done)| !**is_done);
                Ok(failed.map(|(&case, _)| case).collect())
            }
            Self::Where(comparisons) => {
                let rows = rows(table).map_err(SweepError::table(table))?;
                let mut is_chosen = vec![true; rows.cases.len()];
                for comparison in comparisons {
                    let (values, number) = comparison.of(study, &rows)?;
                    let holds = |value: f64| match comparison.operator {
                        "<" => value < number,
                        "<=" => value <= number,
                        ">" => value > number,
                        _ => value >= number,
                    };
                    let all = is_chosen.iter_mut().zip(values);
                    all.for_each(|(chosen, &value)| *chosen &= holds(value));
                }
                let chosen = rows.cases.iter().zip(is_chosen).filter(|(_, chosen)| *chosen);
                Ok(chosen.map(|(&case, _)| case).collect())
            }
            Self::Extreme { is_largest, column } => {
                let rows = rows(table).map_err(SweepError::table(table))?;
                let values = values(study, &rows, column)?.1;
                let known = values.iter().enumerate().filter(|(_, value)| !value.is_nan());
                // Of equal ones the first.
                let better = |a: f64, b: f64| {
                    let order = a.partial_cmp(&b).unwrap_or(Ordering::Equal);
                    if *is_largest { order } else { order.reverse() }
                };
                let best = known.reduce(|best, next| {
                    if better(*next.1, *best.1) == Ordering::Greater { next } else { best }
                });
                Ok(best.map(|(place, _)| rows.cases[place]).into_iter().collect())
            }
        }
    }
}

/// Why no cases can be chosen.
#[derive(Debug, thiserror::Error)]
pub enum NoCases {
    /// The sweep has no such case or column; in words.
    #[error("{0}")]
    Unknown(String),
    /// The table cannot be read.
    #[error(transparent)]
    Table(#[from] SweepError),
}

impl Comparison {
    /// The values of its column, and its number in SI.
    fn of<'r>(&self, study: &Study, rows: &'r Rows) -> Result<(&'r [f64], f64), NoCases> {
        let (unit, values) = values(study, rows, &self.column)?;
        let Some(written) = self.unit else { return Ok((values, self.number)) };
        let own = WrittenUnit::parse(&unit).unwrap_or(WrittenUnit::PURE);
        if !own.is_alike(&written) {
            let own = if unit.is_empty() { "a pure number".to_owned() } else { unit };
            return Err(NoCases::Unknown(format!(
                "`{}` is in {own}, not in {}",
                self.column,
                written.si()
            )));
        }
        Ok((values, written.to_si(self.number)))
    }
}

/// The unit and the values of a column.
fn values<'r>(study: &Study, rows: &'r Rows, name: &str) -> Result<(String, &'r [f64]), NoCases> {
    let columns = study.input_columns().into_iter().chain(study.output_columns());
    let units: Vec<(String, String)> = columns.map(|column| (column.name, column.unit)).collect();
    let names: Vec<&str> = rows.columns.iter().map(|(name, _)| name.as_str()).collect();
    let place = column_named(&names, name)
        .map_err(|help| NoCases::Unknown(format!("the table has no column `{name}`: {help}")))?;
    let (known, values) = &rows.columns[place];
    let unit = units.into_iter().find(|(name, _)| name == known).map(|(_, unit)| unit);
    Ok((unit.unwrap_or_default(), values))
}

/// A name with single spaces, as columns have them.
fn plain(name: &str) -> String {
    name.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// `7` or `10-12`.
fn numbers(text: &str) -> Result<RangeInclusive<u64>, String> {
    let number = |text: &str| {
        let text = text.trim();
        text.parse::<u64>()
            .map_err(|_| format!("`{text}` is no number of a case: write for example 3,7,10-12"))
    };
    let Some((first, last)) = text.split_once('-') else {
        let case = number(text)?;
        return Ok(case..=case);
    };
    let (first, last) = (number(first)?, number(last)?);
    if first > last {
        return Err(format!("`{first}-{last}` holds no case: write `{last}-{first}`"));
    }
    Ok(first..=last)
}

/// `max(reactions.B.fx) > 2 kN`.
fn comparison(text: &str) -> Result<Comparison, String> {
    let help = "write numbers of cases (3,7,10-12), `all`, `failed`, `largest COLUMN`, or a comparison such as \
                \"max(energy.kinetic) > 2 J\"";
    // The last one: a column such as `first(x > 1 m)` holds one, too.
    let found =
        OPERATORS.into_iter().filter_map(|operator| Some((text.rfind(operator)?, operator)));
    let Some((at, operator)) =
        found.max_by_key(|&(at, operator)| (at + operator.len(), operator.len()))
    else {
        return Err(format!("`{text}` chooses no cases: {help}"));
    };
    let (column, value) = (plain(&text[..at]), text[at + operator.len()..].trim());
    let end = value.find(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c)));
    let (number, unit) = value.split_at(end.unwrap_or(value.len()));
    let number = number.parse::<f64>().ok().filter(|number| number.is_finite());
    let (Some(number), false) = (number, column.is_empty()) else {
        return Err(format!(
            "`{}` is no comparison of a column with a number: {help}",
            text.trim()
        ));
    };
    let unit = match unit.trim() {
        "" => None,
        unit => Some(WrittenUnit::parse(unit).ok_or_else(|| format!("`{unit}` is no unit"))?),
    };
    Ok(Comparison { column, operator, number, unit })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_are_read_as_people_write_them() {
        let number = |text: &str| Chosen::parse(text);
        assert_eq!(number("3, 7,10-12"), Ok(Chosen::Numbers(vec![3..=3, 7..=7, 10..=12])));
        assert_eq!(number("all"), Ok(Chosen::All));
        let column = "final(x)".to_owned();
        assert_eq!(number("largest final(x)"), Ok(Chosen::Extreme { is_largest: true, column }));
        let Ok(Chosen::Where(found)) = number("first(x  > 1 m) <= 2 ms and l >= -1e-3") else {
            panic!("two comparisons")
        };
        assert_eq!((found[0].column.as_str(), found[0].operator), ("first(x > 1 m)", "<="));
        assert_eq!(found[0].unit.map(|unit| unit.to_si(found[0].number)), Some(2e-3));
        assert_eq!((found[1].column.as_str(), found[1].operator), ("l", ">="));
        assert_eq!((found[1].number, found[1].unit), (-1e-3, None));
    }

    #[test]
    fn what_chooses_nothing_says_what_to_write() {
        for text in ["", "3,x", "12-10", "l", "l > ", "> 3", "l > 3 parsecs", "-1", "l > 1e999"] {
            let fault = Chosen::parse(text).expect_err(text);
            assert!(fault.contains("write") || fault.contains("unit"), "{text}: {fault}");
        }
    }
}
