//! [`Table`]: an answer in rows and columns.

use std::fmt::Write;

/// Named columns of numbers, all of the same length.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Table {
    /// Heads of the columns.
    pub columns: Vec<Column>,
    /// Rows, each as long as the columns are many.
    pub rows: Vec<Vec<f64>>,
}

/// Head of a column.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Column {
    /// Name: `crank.angle`, `A.fx`.
    pub name: String,
    /// SI unit; empty for plain numbers.
    pub unit: String,
}

impl Column {
    /// A column of this name and unit.
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into() }
    }
}

impl Table {
    /// The numbers of a column.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let idx = self.columns.iter().position(|column| column.name == name)?;
        Some(self.rows.iter().map(|row| row[idx]).collect())
    }

    /// The table as comma-separated values: a line of names, a line for each row. Numbers have as many
    /// digits as tell them apart from all others.
    pub fn csv(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|column| column.name.as_str()).collect();
        let mut text = names.join(",") + "\n";
        for row in &self.rows {
            for (k, cell) in row.iter().enumerate() {
                text.push_str(if k > 0 { "," } else { "" });
                write!(text, "{cell}").expect("a text takes whatever is written to it");
            }
            text.push('\n');
        }
        text
    }
}
