//! Tables of sweeps as CSV, from those as Parquet.

use std::fs::File;
use std::io::{self, Write};

use ::parquet::errors::ParquetError;
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::record::Field;
use csv::Writer;

/// Writes the rows of a table as CSV: headings, numbers in the fewest digits that tell them, empty cells where there
/// is no value.
///
/// # Errors
/// A damaged table, and those of `out`.
pub(crate) fn to_csv(table: &File, out: impl Write) -> Result<(), ParquetError> {
    let reader = SerializedFileReader::new(table.try_clone()?)?;
    let columns = reader.metadata().file_metadata().schema_descr().columns().to_vec();
    let failed = |error: csv::Error| ParquetError::from(io::Error::from(error));
    let mut out = Writer::from_writer(out);
    out.write_record(columns.iter().map(|column| column.name())).map_err(failed)?;
    for row in reader.get_row_iter(None)? {
        let row = row?;
        let cells = row.get_column_iter().map(|(_, cell)| match cell {
            Field::Null => String::new(),
            Field::Double(value) => value.to_string(),
            Field::Str(text) => text.clone(),
            other => other.to_string(),
        });
        out.write_record(cells).map_err(failed)?;
    }
    out.flush()?;
    Ok(())
}
