//! Measured curves as text: columns with names and units in the heading, gaps where cells are empty.

use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::WrittenUnit;

use crate::codes;

/// A file of measurements, and the run that they are of.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct DataFile {
    /// Name of the file, for messages.
    pub name: String,
    /// Text of the file: `t [s], theta [deg]` in the first line; commas, semicolons or tabs between cells.
    pub text: String,
    /// Parameters with other values in this run.
    pub set: Vec<(String, String)>,
}

/// Columns in SI; NaN where a cell is empty.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Columns {
    pub(crate) names: Vec<String>,
    pub(crate) units: Vec<Option<WrittenUnit>>,
    /// By row.
    pub(crate) rows: Vec<Vec<f64>>,
}

impl Columns {
    pub(crate) fn named(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }
}

/// A heading as name and unit: `theta [deg]`, `theta (deg)`, `theta`.
fn heading(text: &str) -> Option<(String, Option<WrittenUnit>)> {
    let text = text.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((name, unit)) = text.strip_suffix(close).and_then(|text| text.rsplit_once(open))
        {
            let unit = unit.trim();
            let read = if unit.is_empty() || unit == "-" {
                Some(WrittenUnit::PURE)
            } else {
                WrittenUnit::parse(unit)
            };
            return Some((name.trim().to_owned(), Some(read?)));
        }
    }
    Some((text.to_owned(), None))
}

/// Reads a file of measurements.
///
/// # Errors
/// [`codes::BAD_DATA`] with the line.
pub(crate) fn columns(file: &DataFile) -> Result<Columns, Diagnostic> {
    let bad = |line: usize, what: &str| {
        let message = format!("line {line} of `{}` {what}", file.name);
        let help = "write names with units in the first line, `t [s], theta [deg]`, then a line of numbers for each instant";
        Diagnostic::error(codes::BAD_DATA, message).help(help)
    };
    let text = file.text.trim_start_matches('\u{feff}');
    let first = text.lines().find(|line| !is_comment(line)).unwrap_or_default();
    let divider = if first.contains('\t') {
        b'\t'
    } else if first.contains(';') {
        b';'
    } else {
        b','
    };
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(divider)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(text.as_bytes());
    let headings = reader.headers().map_err(|_| bad(1, "cannot be read"))?.clone();
    let read: Option<Vec<_>> = headings.iter().map(heading).collect();
    let (names, units): (Vec<String>, Vec<Option<WrittenUnit>>) =
        read.ok_or_else(|| bad(1, "has a unit that is none"))?.into_iter().unzip();
    if names.iter().all(|name| name.parse::<f64>().is_ok()) {
        return Err(bad(1, "has no names of columns"));
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|_| bad(rows.len() + 2, "cannot be read"))?;
        let line =
            record.position().map_or(rows.len() + 2, |at| usize::try_from(at.line()).unwrap_or(0));
        let mut row = vec![f64::NAN; names.len()];
        if record.len() > names.len() {
            return Err(bad(line, "has more cells than there are columns"));
        }
        for ((cell, value), unit) in record.iter().zip(&mut row).zip(&units) {
            if cell.is_empty() || cell.eq_ignore_ascii_case("nan") {
                continue;
            }
            let number = cell.parse::<f64>().or_else(|_| cell.replace(',', ".").parse::<f64>());
            let number = number
                .map_err(|_| bad(line, &format!("has the cell `{cell}`, which is no number")))?;
            *value = unit.map_or(number, |unit| unit.to_si(number));
        }
        rows.push(row);
    }
    if rows.is_empty() {
        return Err(bad(2, "is missing: there are no numbers"));
    }
    Ok(Columns { names, units, rows })
}

fn is_comment(line: &str) -> bool {
    line.trim().is_empty() || line.starts_with('#')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_gaps_and_decimal_commas_are_read() {
        let file = DataFile {
            name: "run".to_owned(),
            text: "# a remark\nt [ms];theta [deg]\n0;90\n1,5;\n".to_owned(),
            ..DataFile::default()
        };
        let read = columns(&file).expect("columns");
        assert_eq!(read.names, ["t", "theta"]);
        assert!((read.rows[0][1] - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert!((read.rows[1][0] - 0.0015).abs() < 1e-15 && read.rows[1][1].is_nan());
    }

    #[test]
    fn a_cell_that_is_no_number_is_named() {
        let file = DataFile {
            name: "run".to_owned(),
            text: "t,x\n0,abc\n".to_owned(),
            ..DataFile::default()
        };
        let fault = columns(&file).expect_err("a fault");
        assert!(fault.message.contains("line 2") && fault.message.contains("abc"), "{fault:?}");
    }
}
