//! A finished table, read back: its columns of numbers.

use std::fs::File;
use std::path::Path;

use ::parquet::basic::Repetition;
use ::parquet::errors::ParquetError;
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::record::{Field, Row};
use bksim::model::file::suggest;

use crate::csv::to_csv;
use crate::parquet::Column;

/// The numbers of a sweep.
#[derive(Clone, PartialEq, Debug)]
pub struct Table {
    /// Name of the model.
    pub model_name: String,
    /// The file of the model; empty where the table does not say.
    pub model_file: String,
    /// True where every value of an axis goes with every one of the others.
    pub is_grid: bool,
    /// The varied quantities and their values by case, SI.
    pub inputs: Vec<(Column, Vec<f64>)>,
    /// The outputs by case, SI; NaN where a case failed.
    pub outputs: Vec<(Column, Vec<f64>)>,
}

impl Table {
    /// Reads a table that a sweep has written.
    ///
    /// # Errors
    /// [`ParquetError`] for files that are no Parquet, or no table of a sweep.
    pub fn read(path: &Path) -> Result<Self, ParquetError> {
        let reader = SerializedFileReader::new(File::open(path)?)?;
        let about = reader.metadata().file_metadata();
        let entries = about.key_value_metadata().cloned().unwrap_or_default();
        let entry = |key: &str| {
            entries.iter().find(|entry| entry.key == key).and_then(|entry| entry.value.clone())
        };
        let not_ours = || ParquetError::General("it is no table of `bksim sweep`".to_owned());
        let plan = entry("bksim.plan").ok_or_else(not_ours)?;

        // Columns between the number of the case and how it ended; outputs may be missing.
        let fields = about.schema().get_fields();
        let names: Vec<&str> = fields.iter().map(|field| field.name()).collect();
        let end = names.iter().position(|name| *name == "status").ok_or_else(not_ours)?;
        let column = |name: &str| Column {
            name: name.to_owned(),
            unit: entry(&format!("unit.{name}")).unwrap_or_default(),
        };
        let is_output =
            |idx: usize| fields[idx].get_basic_info().repetition() == Repetition::OPTIONAL;
        let mut columns: Vec<(Column, Vec<f64>)> =
            names[1..end].iter().map(|name| (column(name), Vec::new())).collect();
        for row in reader.get_row_iter(None)? {
            let row = row?;
            for ((_, values), idx) in columns.iter_mut().zip(1..) {
                values.push(number(&row, idx));
            }
        }
        let n_inputs = (1..end).take_while(|&idx| !is_output(idx)).count();
        let outputs = columns.split_off(n_inputs);
        Ok(Self {
            model_name: entry("bksim.model_name").unwrap_or_default(),
            model_file: entry("bksim.model_file").unwrap_or_default(),
            is_grid: plan.lines().next() == Some("grid"),
            inputs: columns,
            outputs,
        })
    }
}

/// A number of a row; NaN where there is none.
fn number(row: &Row, idx: usize) -> f64 {
    match row.get_column_iter().nth(idx) {
        Some((_, Field::Double(value))) => *value,
        _ => f64::NAN,
    }
}

/// The place of the column that a name means: its own, or the only one whose names begin with more than is written,
/// as those of `max(outputs.pin)` do next to `max(pin)`. Spaces do not count.
///
/// # Errors
/// The help, where there is none or more than one.
pub fn column_named(names: &[&str], asked: &str) -> Result<usize, String> {
    let asked_words = words(asked);
    let written: Vec<Vec<&str>> = names.iter().map(|name| words(name)).collect();
    if let Some(place) = written.iter().position(|words| *words == asked_words) {
        return Ok(place);
    }
    let is_short = |words: &&Vec<&str>| {
        let mut pairs = asked_words.iter().zip(*words);
        asked_words.len() == words.len() && pairs.all(|(asked, known)| is_end_of(asked, known))
    };
    let alike: Vec<usize> = (0..names.len()).filter(|&k| is_short(&&written[k])).collect();
    match alike.as_slice() {
        [] => Err(suggest(asked, names)),
        [place] => Ok(*place),
        several => {
            let several: Vec<String> = several.iter().map(|&k| format!("`{}`", names[k])).collect();
            Err(format!("it may be {}: write one of them", several.join(" or ")))
        }
    }
}

/// Names, numbers and signs.
fn words(text: &str) -> Vec<&str> {
    let mut words = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
        let end = if is_part(first) { rest.find(|c| !is_part(c)) } else { Some(first.len_utf8()) };
        let (word, left) = rest.split_at(end.unwrap_or(rest.len()));
        words.push(word);
        rest = left.trim_start();
    }
    words
}

/// True of equal words, and of a name that a longer one ends with: `pin` of `outputs.pin`.
fn is_end_of(asked: &str, known: &str) -> bool {
    let is_name = asked.starts_with(|c: char| c.is_alphabetic() || c == '_');
    let rest = known.strip_suffix(asked);
    rest.is_some_and(|rest| rest.is_empty() || is_name && rest.ends_with('.'))
}

/// The rows of a table, of whichever format, as far as they are numbers.
pub(crate) struct Rows {
    pub(crate) cases: Vec<u64>,
    /// True of each case whose run reached its end.
    pub(crate) is_done: Vec<bool>,
    /// Inputs and outputs by case, SI; NaN where there is no number.
    pub(crate) columns: Vec<(String, Vec<f64>)>,
}

/// The rows of a table that a sweep has written.
///
/// # Errors
/// Those of the file, and of files that are no table of a sweep.
pub(crate) fn rows(path: &Path) -> Result<Rows, ParquetError> {
    let not_ours = || ParquetError::General("it is no table of `bksim sweep`".to_owned());
    let (names, cells) = cells(path)?;
    let status = names.iter().position(|name| name == "status").ok_or_else(not_ours)?;
    let columns = names[1..status].iter().cloned().map(|name| (name, Vec::new()));
    let mut rows = Rows { cases: Vec::new(), is_done: Vec::new(), columns: columns.collect() };
    for row in cells {
        rows.cases.push(row[0].parse().map_err(|_| not_ours())?);
        rows.is_done.push(row[status] == "done");
        for ((_, values), cell) in rows.columns.iter_mut().zip(&row[1..]) {
            values.push(cell.parse().unwrap_or(f64::NAN));
        }
    }
    Ok(rows)
}

/// Headings, and the cells of every row as text; numbers in the fewest digits that tell them.
fn cells(path: &Path) -> Result<(Vec<String>, Vec<Vec<String>>), ParquetError> {
    let mut text = Vec::new();
    if is_csv(path) {
        text = std::fs::read(path)?;
    } else {
        to_csv(&File::open(path)?, &mut text)?;
    }
    let failed = |error: csv::Error| ParquetError::from(std::io::Error::from(error));
    let mut reader = csv::Reader::from_reader(text.as_slice());
    let own = |record: &csv::StringRecord| record.iter().map(str::to_owned).collect::<Vec<_>>();
    let names = own(reader.headers().map_err(failed)?);
    let rows = reader.records().map(|record| record.map(|record| own(&record)).map_err(failed));
    Ok((names, rows.collect::<Result<_, _>>()?))
}

/// True of a table that is text, by the ending of its name.
pub(crate) fn is_csv(table: &Path) -> bool {
    table.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_answers_to_the_end_of_its_names_where_no_other_does() {
        let names =
            ["l1", "max(outputs.pin)", "min(reactions.A.fx)", "min(reactions.B.fx)", "rod.mass"];
        let found = |asked| column_named(&names, asked);
        assert_eq!(found("max(pin)"), Ok(1));
        assert_eq!(found(" max( outputs.pin )"), Ok(1));
        assert_eq!(found("min(B.fx)"), Ok(3));
        assert_eq!(found("mass"), Ok(4));
        let help = found("min(fx)").expect_err("two of them");
        assert_eq!(
            help,
            "it may be `min(reactions.A.fx)` or `min(reactions.B.fx)`: write one of them"
        );
        assert!(found("max(in)").is_err() && found("min(pin)").is_err() && found("ass").is_err());
        // Its own name comes before a longer one; digits are no names.
        assert_eq!(column_named(&["a.x", "x"], "x"), Ok(1));
        assert!(column_named(&["quantile(x, 0.95)"], "quantile(x, 95)").is_err());
    }
}
