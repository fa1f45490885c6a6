//! Exporting chosen channels as a table: one row per time, one column per signal.

use std::io::{Read, Write};

use crate::{EndStatus, LogError, LogReader, NotUnique, Record, Request, Selection};

/// The result of an export.
#[derive(Clone, PartialEq, Debug)]
pub struct Exported {
    /// Rows written, the heading not counted.
    pub n_rows: u64,
    /// From when on which channels are not unique, in the order of the run.
    pub not_unique: Vec<NotUnique>,
    /// How the run ended; `None` if the log was cut short, after its last whole chunk.
    pub end: Option<EndStatus>,
}

/// Writes the selected signals as CSV: a heading `t,state.angle,…`, then one row per time.
///
/// Numbers are the shortest texts that read back as the same bits, or `NaN`, `inf`, `-inf`; a cell
/// stays empty where a topic has no sample at that time. Units are in [`Selection::columns`].
///
/// # Errors
/// As [`LogReader::next_record`], and [`LogError::Io`] from `out`; the rows before are written.
pub fn to_csv<R: Read>(
    log: LogReader<R>,
    selection: &Selection,
    out: impl Write,
) -> Result<Exported, LogError> {
    let names = selection.columns().iter().map(|column| column.name.clone());
    let headings: Vec<String> = std::iter::once("t".to_owned()).chain(names).collect();
    to_csv_as(log, selection, &headings, &|_, value| value, out)
}

/// Table as of [`to_csv`], with headings of the caller's, that of the time first, and `shown` for the value of a column;
/// the time is column 0.
///
/// # Errors
/// As [`to_csv`].
pub fn to_csv_as<R: Read>(
    log: LogReader<R>,
    selection: &Selection,
    headings: &[String],
    shown: &dyn Fn(usize, f64) -> f64,
    out: impl Write,
) -> Result<Exported, LogError> {
    let mut csv = csv::Writer::from_writer(out);
    csv.write_record(headings).map_err(io_error)?;
    let exported = rows(log, selection, |t, cells| {
        csv.write_field(format!("{:?}", shown(0, t))).map_err(io_error)?;
        for (idx, cell) in cells.iter().enumerate() {
            let text = cell.map(|value| format!("{:?}", shown(idx + 1, value)));
            csv.write_field(text.unwrap_or_default()).map_err(io_error)?;
        }
        csv.write_record(None::<&[u8]>).map_err(io_error)
    })?;
    csv.flush()?;
    Ok(exported)
}

fn io_error(error: csv::Error) -> LogError {
    LogError::Io(error.into())
}

/// Joins the samples of one time to rows and hands them to `put`, with one cell per column; topics
/// of which nothing is selected are passed over.
///
/// The writer lets no time run back, so the samples of one time stand next to each other. A topic
/// that is sampled twice at one time, before and after an event, makes two rows.
///
/// # Errors
/// As [`LogReader::next_record`], and those of `put`.
pub fn rows<R: Read>(
    log: LogReader<R>,
    selection: &Selection,
    mut put: impl FnMut(f64, &[Option<f64>]) -> Result<(), LogError>,
) -> Result<Exported, LogError> {
    // The columns of each topic: index in the sample, index in the row.
    let mut columns_of = vec![Vec::new(); log.header().topics.len()];
    for (column_idx, column) in selection.columns().iter().enumerate() {
        columns_of[column.topic.0].push((column.field_idx, column_idx));
    }
    let mut request = Request::default();
    for column in selection.columns() {
        if !request.topics.contains(&column.topic) {
            request.topics.push(column.topic);
        }
    }
    let mut log = log.only(&request);
    let mut cells = vec![None; selection.columns().len()];
    let mut row_t: Option<f64> = None;
    let mut n_rows = 0;
    let mut not_unique = Vec::new();
    while let Some(record) = log.next_record()? {
        let (topic, t, values) = match record {
            Record::Sample { topic, t, values } => (topic, t, values),
            Record::NotUnique(change) => {
                change.add_to(&mut not_unique);
                continue;
            }
            Record::Note(_) | Record::Segment(_) => continue,
        };
        let Some(&(_, first_cell)) = columns_of[topic.0].first() else { continue };
        if let Some(previous) = row_t.filter(|&row_t| row_t != t || cells[first_cell].is_some()) {
            put(previous, &cells)?;
            n_rows += 1;
            cells.fill(None);
        }
        row_t = Some(t);
        for &(field_idx, column_idx) in &columns_of[topic.0] {
            cells[column_idx] = Some(values[field_idx]);
        }
    }
    if let Some(t) = row_t {
        put(t, &cells)?;
        n_rows += 1;
    }
    Ok(Exported { n_rows, not_unique, end: log.end().cloned() })
}
