//! Export of a log as Parquet, through the column writers alone: no Arrow.

use std::io::{Read, Write};
use std::sync::Arc;

use ::parquet::basic::{Compression, Repetition, Type as PhysicalType, ZstdLevel};
use ::parquet::data_type::DoubleType;
use ::parquet::errors::ParquetError;
use ::parquet::file::metadata::KeyValue;
use ::parquet::file::properties::WriterProperties;
use ::parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use ::parquet::schema::types::{Type, TypePtr};
use bksim::log::export::{Exported, rows};
use bksim::log::{LogError, LogReader, Selection};
use bksim_cli::origin::file_of;

/// Cells held in memory before a row group is written: 64 MiB of doubles.
const CELLS_PER_GROUP: usize = 8 << 20;

/// Writes the selected signals as Parquet with zstd: a required double `t`, and an optional double
/// per signal, null where a topic has no sample at that time.
///
/// The key-value metadata hold `bksim.version`, `bksim.model_name`, `bksim.model_sha256`, and for
/// each signal that has a unit `unit.state.angle` and so on; `unit.t` is `s`.
///
/// # Errors
/// As [`bksim::log::export::to_csv`], and [`LogError::Table`].
pub fn to_parquet<R: Read>(
    log: LogReader<R>,
    selection: &Selection,
    out: impl Write + Send,
) -> Result<Exported, LogError> {
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        // Samples of a motion hardly ever repeat.
        .set_dictionary_enabled(false)
        .set_key_value_metadata(Some(key_values(&log, selection)))
        .build();
    let schema = schema(selection).map_err(unwritten)?;
    let mut file =
        SerializedFileWriter::new(out, schema, Arc::new(properties)).map_err(unwritten)?;
    let mut group = Group::new(selection.columns().len());
    let exported = rows(log, selection, |t, cells| {
        group.push(t, cells);
        let is_full = group.t.len() >= group.n_rows_max;
        if is_full { group.write(&mut file).map_err(unwritten) } else { Ok(()) }
    })?;
    if !group.t.is_empty() {
        group.write(&mut file).map_err(unwritten)?;
    }
    file.close().map_err(unwritten)?;
    Ok(exported)
}

#[expect(clippy::needless_pass_by_value, reason = "it maps errors")]
fn unwritten(error: ParquetError) -> LogError {
    LogError::Table { format: "Parquet", reason: error.to_string() }
}

fn key_values<R: Read>(log: &LogReader<R>, selection: &Selection) -> Vec<KeyValue> {
    let entry = |key: &str, value: &str| KeyValue::new(key.to_owned(), value.to_owned());
    let units = selection.columns().iter().filter(|column| !column.unit.is_empty());
    let units = units.map(|column| entry(&format!("unit.{}", column.name), &column.unit));
    [
        entry("bksim.version", &log.header().version),
        entry("bksim.model_name", &log.header().model_name),
        entry("bksim.model_file", &file_of(log.header())),
        entry("bksim.model_sha256", log.model_sha256()),
        entry("unit.t", "s"),
    ]
    .into_iter()
    .chain(units)
    .collect()
}

fn schema(selection: &Selection) -> Result<TypePtr, ParquetError> {
    let double = |name: &str, repetition| {
        let column = Type::primitive_type_builder(name, PhysicalType::DOUBLE);
        column.with_repetition(repetition).build().map(Arc::new)
    };
    let t = std::iter::once(double("t", Repetition::REQUIRED));
    let signals = selection.columns().iter();
    let signals = signals.map(|column| double(&column.name, Repetition::OPTIONAL));
    let fields = t.chain(signals).collect::<Result<_, _>>()?;
    Type::group_type_builder("run").with_fields(fields).build().map(Arc::new)
}

/// Rows waiting to be written, by column.
struct Group {
    t: Vec<f64>,
    columns: Vec<OptionalColumn>,
    n_rows_max: usize,
}

/// The values that are there, and for each row whether one is: Parquet's definition level.
#[derive(Clone, Default)]
struct OptionalColumn {
    values: Vec<f64>,
    levels: Vec<i16>,
}

impl Group {
    fn new(n_columns: usize) -> Group {
        let n_rows_max = (CELLS_PER_GROUP / (n_columns + 1)).max(1);
        Group { t: Vec::new(), columns: vec![OptionalColumn::default(); n_columns], n_rows_max }
    }

    fn push(&mut self, t: f64, cells: &[Option<f64>]) {
        self.t.push(t);
        for (column, cell) in self.columns.iter_mut().zip(cells) {
            column.values.extend(cell);
            column.levels.push(cell.is_some().into());
        }
    }

    /// Writes the rows as one row group and forgets them.
    fn write<W: Write + Send>(
        &mut self,
        file: &mut SerializedFileWriter<W>,
    ) -> Result<(), ParquetError> {
        let mut group = file.next_row_group()?;
        write_column(&mut group, &self.t, None)?;
        self.t.clear();
        for column in &mut self.columns {
            write_column(&mut group, &column.values, Some(&column.levels))?;
            column.values.clear();
            column.levels.clear();
        }
        group.close()?;
        Ok(())
    }
}

fn write_column<W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    values: &[f64],
    levels: Option<&[i16]>,
) -> Result<(), ParquetError> {
    let missing = || ParquetError::General("the schema has fewer columns than the rows".into());
    let mut column = group.next_column()?.ok_or_else(missing)?;
    column.typed::<DoubleType>().write_batch(values, levels, None)?;
    column.close()
}
