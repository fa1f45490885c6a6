//! Cases from a table: one row each, one column for each axis.
//!
//! ```text
//! l1 [mm], m2, A.rate [rad/s]
//! 800, 2.5, 12
//! 900, 3, 10
//! ```

use bksim::model::diagnostic::Diagnostic;

use crate::axis::{Axis, Values};
use crate::codes;

/// The axes of a table's columns, to be taken in [pairs](crate::Design::Pairs): its header names them, with units
/// in brackets. Columns are divided by commas, semicolons or tabs; next to semicolons and tabs a comma may be the
/// decimal one.
///
/// # Errors
/// A diagnostic with [`codes::BAD_AXIS`] names the row.
pub fn axes_of_table(text: &str) -> Result<Vec<Axis>, Diagnostic> {
    let header = text.lines().find(|line| !is_idle(line)).unwrap_or_default();
    let divider = [';', '\t'].into_iter().find(|&divider| header.contains(divider)).unwrap_or(',');
    let cells = |line: &str| -> Vec<String> {
        line.split(divider).map(|cell| cell.trim().trim_matches('"').trim().to_owned()).collect()
    };

    // The header: names and units.
    let mut columns: Vec<(String, String, Vec<f64>)> = Vec::new();
    for cell in cells(header.trim_start_matches('\u{feff}')) {
        let (name, unit) = match cell.split_once('[') {
            Some((name, unit)) => (name, unit.trim_end().trim_end_matches(']')),
            None => (cell.as_str(), ""),
        };
        if name.trim().is_empty() || name.trim().parse::<f64>().is_ok() {
            let help = "begin with a line that names the columns, as in `l1 [mm], m2`";
            return Err(fault(format!("a table of cases has a column `{cell}`"), help.to_owned()));
        }
        columns.push((name.trim().to_owned(), unit.trim().to_owned(), Vec::new()));
    }

    // The rows, as many numbers in each as there are names.
    let rows = text.lines().enumerate().filter(|(_, line)| !is_idle(line)).skip(1);
    for (line_idx, line) in rows {
        let cells = cells(line);
        if cells.len() != columns.len() {
            let message = format!(
                "line {} of the cases has {} columns, not {}",
                line_idx + 1,
                cells.len(),
                columns.len()
            );
            return Err(fault(
                message,
                "write one number for each name in the first line".to_owned(),
            ));
        }
        for ((.., values), cell) in columns.iter_mut().zip(cells) {
            let point = if divider == ',' { cell.clone() } else { cell.replace(',', ".") };
            let Ok(value) = point.parse() else {
                let message = format!("line {} of the cases: `{cell}` is no number", line_idx + 1);
                return Err(fault(
                    message,
                    "write numbers alone, and units in the first line".to_owned(),
                ));
            };
            values.push(value);
        }
    }
    columns
        .into_iter()
        .map(|(name, unit, values)| Axis::new(&name, Values::List(values), &unit))
        .collect()
}

/// True of lines that say nothing.
fn is_idle(line: &str) -> bool {
    line.trim().is_empty() || line.trim_start().starts_with('#')
}

fn fault(message: String, help: String) -> Diagnostic {
    Diagnostic::error(codes::BAD_AXIS, message).help(help)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_axes_whatever_divides_them() {
        let axes = |text| axes_of_table(text).expect("axes");
        let expected = axes("l1 [mm], m2\n# of the third trial\n800, 2.5\n\n900, 3\n");
        assert_eq!(expected[0].unit, "mm");
        assert_eq!(expected[0].values, Values::List(vec![800.0, 900.0]));
        assert_eq!(expected[1].name, "m2");
        assert_eq!(axes("l1 [mm];m2\n800;2,5\n900;3"), expected);
        assert_eq!(axes("\u{feff}\"l1 [mm]\"\tm2\r\n800\t2.5\r\n900\t3\r\n"), expected);
    }

    #[test]
    fn faults_name_the_line() {
        let message = |text| axes_of_table(text).expect_err("a fault").message;
        assert!(message("a,b\n1,2\n3").contains("line 3"));
        assert!(message("a,b\n\n1,x").contains("line 3 of the cases: `x`"));
        assert!(message("1,2\n3,4").contains("column `1`"));
        assert!(message("").contains("column"));
        assert!(message("a [quux]\n1").contains("quux"));
    }
}
