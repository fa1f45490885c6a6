//! Export as Parquet, through the column writers alone: no Arrow.

use std::{
    io::{Read, Write},
    sync::Arc,
};

use ::parquet::{
    basic::{Compression, Repetition, Type as PhysicalType, ZstdLevel},
    data_type::DoubleType,
    errors::ParquetError,
    file::{
        metadata::KeyValue,
        properties::WriterProperties,
        writer::{SerializedFileWriter, SerializedRowGroupWriter},
    },
    schema::types::{Type, TypePtr},
};

use super::{Exported, rows};
use crate::{LogError, LogReader, Selection};

/// Cells held in memory before a row group is written: 64 MiB of doubles.
const CELLS_PER_GROUP: usize = 8 << 20;

/// Writes the selected signals as Parquet with zstd: a required double `t`, and an optional double
/// per signal, null where a topic has no sample at that time.
///
/// The key-value metadata hold `bksim.version`, `bksim.model_name`, `bksim.model_sha256`, and for
/// each signal that has a unit `unit.state.angle` and so on; `unit.t` is `s`.
///
/// # Errors
/// As [`super::to_csv`], and [`LogError::Parquet`].
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
    let mut file = SerializedFileWriter::new(out, schema(selection)?, Arc::new(properties))?;
    let mut group = Group::new(selection.columns().len());
    let exported = rows(log, selection, |t, cells| {
        group.push(t, cells);
        if group.t.len() >= group.n_rows_max { group.write(&mut file) } else { Ok(()) }
    })?;
    if !group.t.is_empty() {
        group.write(&mut file)?;
    }
    file.close()?;
    Ok(exported)
}

fn key_values<R: Read>(log: &LogReader<R>, selection: &Selection) -> Vec<KeyValue> {
    let entry = |key: &str, value: &str| KeyValue::new(key.to_owned(), value.to_owned());
    let units = selection.columns().iter().filter(|column| !column.unit.is_empty());
    let units = units.map(|column| entry(&format!("unit.{}", column.name), &column.unit));
    [
        entry("bksim.version", &log.header().version),
        entry("bksim.model_name", &log.header().model_name),
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
    ) -> Result<(), LogError> {
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
