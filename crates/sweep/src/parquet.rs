//! Rows as Parquet, through the column writers alone: no Arrow.
//!
//! | column | type | |
//! |---|---|---|
//! | `case` | int64 | number of the case, from 0 |
//! | one per axis | double | its value, SI |
//! | one per output | double, may be null | null unless the run reached its end |
//! | `status` | text | `done`, `refused`, `no start`, `stopped` |
//! | `code`, `reason` | text, may be null | why a case failed |
//! | `t_reached` | double | last instant, s |
//! | `steps` | int64 | steps of the integrator |
//!
//! The key-value metadata hold the model and all that was asked (`bksim.model`, `bksim.plan`, …) and
//! for each column that has a unit `unit.max(energy.total)` and so on.

use std::fs::File;
use std::io::Write;
use std::sync::Arc;

use ::parquet::basic::{
    Compression, Encoding, LogicalType, Repetition, Type as PhysicalType, ZstdLevel,
};
use ::parquet::column::writer::ColumnCloseResult;
use ::parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use ::parquet::errors::ParquetError;
use ::parquet::file::metadata::KeyValue;
use ::parquet::file::properties::{EnabledStatistics, WriterProperties, WriterPropertiesPtr};
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use ::parquet::schema::types::{ColumnPath, Type, TypePtr};
use bksim::VERSION;
use sha2::{Digest, Sha256};

use crate::case::Row;
use crate::study::{Study, hex};

/// Names of the columns that every sweep has.
const OWN: [&str; 6] = ["case", "status", "code", "reason", "t_reached", "steps"];

/// How the rows of a study lie in a table.
#[derive(Debug)]
pub(crate) struct Layout {
    schema: TypePtr,
    /// Names and units of the axes, then of the outputs.
    inputs: Vec<(String, String)>,
    outputs: Vec<(String, String)>,
    about: Vec<KeyValue>,
}

impl Layout {
    pub(crate) fn new(study: &Study) -> Result<Self, ParquetError> {
        let inputs = study.input_columns().into_iter().map(|column| {
            let is_taken = OWN.contains(&column.name.as_str());
            let name = if is_taken { format!("set.{}", column.name) } else { column.name };
            (name, column.unit)
        });
        let inputs: Vec<(String, String)> = inputs.collect();
        let outputs = study.output_columns().into_iter().map(|column| (column.name, column.unit));
        let outputs: Vec<(String, String)> = outputs.collect();
        let schema = schema(&inputs, &outputs)?;
        let about = about(study, inputs.iter().chain(&outputs));
        Ok(Self { schema, inputs, outputs, about })
    }

    /// A table of these rows in one row group, with some more metadata.
    pub(crate) fn write(
        &self,
        rows: &[Row],
        more: Vec<KeyValue>,
        out: impl Write + Send,
    ) -> Result<(), ParquetError> {
        let properties = self.properties(more);
        let mut file = SerializedFileWriter::new(out, Arc::clone(&self.schema), properties)?;
        let mut group = file.next_row_group()?;
        self.write_group(rows, &mut group)?;
        group.close()?;
        file.close()?;
        Ok(())
    }

    fn write_group<W: Write + Send>(
        &self,
        rows: &[Row],
        group: &mut SerializedRowGroupWriter<'_, W>,
    ) -> Result<(), ParquetError> {
        let whole = |value: u64| i64::try_from(value).unwrap_or(i64::MAX);
        let cases: Vec<i64> = rows.iter().map(|row| whole(row.case)).collect();
        write::<Int64Type, _>(group, &cases, None)?;
        for idx in 0..self.inputs.len() {
            let values: Vec<f64> = rows.iter().map(|row| row.inputs[idx]).collect();
            write::<DoubleType, _>(group, &values, None)?;
        }
        let is_done: Vec<i16> =
            rows.iter().map(|row| row.ending.fault().is_none().into()).collect();
        for idx in 0..self.outputs.len() {
            let values: Vec<f64> =
                rows.iter().filter_map(|row| row.outputs.get(idx)).copied().collect();
            write::<DoubleType, _>(group, &values, Some(&is_done))?;
        }
        let words: Vec<ByteArray> = rows.iter().map(|row| row.ending.word().into()).collect();
        write::<ByteArrayType, _>(group, &words, None)?;
        let is_failed: Vec<i16> = is_done.iter().map(|done| 1 - done).collect();
        let faults = || rows.iter().filter_map(|row| row.ending.fault());
        let codes: Vec<ByteArray> = faults().map(|fault| fault.code.into()).collect();
        write::<ByteArrayType, _>(group, &codes, Some(&is_failed))?;
        let reasons: Vec<ByteArray> = faults().map(|fault| fault.reason.as_str().into()).collect();
        write::<ByteArrayType, _>(group, &reasons, Some(&is_failed))?;
        let times: Vec<f64> = rows.iter().map(|row| row.t).collect();
        write::<DoubleType, _>(group, &times, None)?;
        let steps: Vec<i64> = rows.iter().map(|row| whole(row.n_steps)).collect();
        write::<Int64Type, _>(group, &steps, None)
    }

    fn properties(&self, more: Vec<KeyValue>) -> WriterPropertiesPtr {
        let about = [self.about.clone(), more].concat();
        let builder = WriterProperties::builder()
            // A row group has one page per column: statistics of it are enough.
            .set_statistics_enabled(EnabledStatistics::Chunk)
            .set_key_value_metadata(Some(about));
        // Results are hardly smaller when compressed, and a compressor for each column of each part
        // takes longer than its rows; reasons and counters repeat.
        let path = |name: &str| ColumnPath::new(vec![name.to_owned()]);
        let builder = ["status", "code", "reason"].into_iter().map(path).fold(
            builder.set_dictionary_enabled(false),
            |builder, text| {
                let zstd = Compression::ZSTD(ZstdLevel::default());
                let builder = builder.set_column_compression(text.clone(), zstd);
                builder.set_column_dictionary_enabled(text, true)
            },
        );
        let builder = ["case", "steps"].into_iter().map(path).fold(builder, |builder, counter| {
            builder.set_column_encoding(counter, Encoding::DELTA_BINARY_PACKED)
        });
        Arc::new(builder.build())
    }

    /// A table whose row groups are those of other tables with this layout, byte for byte.
    pub(crate) fn joined<W: Write + Send>(&self, out: W) -> Result<Joined<W>, ParquetError> {
        let properties = self.properties(Vec::new());
        SerializedFileWriter::new(out, Arc::clone(&self.schema), properties).map(Joined)
    }
}

impl Study {
    /// How its rows lie in a table; the same one whenever it is asked for.
    pub(crate) fn layout(&self) -> Result<&Layout, ParquetError> {
        match self.layout.get() {
            Some(layout) => Ok(layout),
            None => Layout::new(self).map(|layout| self.layout.get_or_init(|| layout)),
        }
    }
}

/// A table that is put together.
pub(crate) struct Joined<W: Write + Send>(SerializedFileWriter<W>);

impl<W: Write + Send> Joined<W> {
    /// Copies the row groups of a table without decoding them.
    pub(crate) fn append(&mut self, table: &File) -> Result<(), ParquetError> {
        let reader = SerializedFileReader::new(table.try_clone()?)?;
        for group in reader.metadata().row_groups() {
            let mut out = self.0.next_row_group()?;
            for column in group.columns() {
                let close = ColumnCloseResult {
                    bytes_written: u64::try_from(column.compressed_size()).unwrap_or_default(),
                    rows_written: u64::try_from(group.num_rows()).unwrap_or_default(),
                    metadata: column.clone(),
                    bloom_filter: None,
                    column_index: None,
                    offset_index: None,
                };
                out.append_column(table, close)?;
            }
            out.close()?;
        }
        Ok(())
    }

    pub(crate) fn finish(self) -> Result<(), ParquetError> {
        self.0.close().map(|_| ())
    }
}

/// Number of rows and metadata of a table; an error when it is damaged.
pub(crate) fn survey(table: &File) -> Result<(u64, Vec<KeyValue>), ParquetError> {
    let reader = SerializedFileReader::new(table.try_clone()?)?;
    let metadata = reader.metadata().file_metadata();
    let n_rows = u64::try_from(metadata.num_rows()).unwrap_or_default();
    Ok((n_rows, metadata.key_value_metadata().cloned().unwrap_or_default()))
}

pub(crate) fn entry(key: &str, value: &str) -> KeyValue {
    KeyValue::new(key.to_owned(), value.to_owned())
}

/// What a table says about itself.
fn about<'a>(study: &Study, columns: impl Iterator<Item = &'a (String, String)>) -> Vec<KeyValue> {
    let units = columns.filter(|(_, unit)| !unit.is_empty());
    let units = units.map(|(name, unit)| entry(&format!("unit.{name}"), unit));
    let fixed: Vec<String> =
        study.request.fixed.iter().map(|(name, value)| format!("{name}={value}")).collect();
    [
        entry("bksim.version", VERSION),
        entry("bksim.model_name", study.model_name()),
        entry("bksim.model_sha256", &hex(&Sha256::digest(study.model_text().as_bytes()))),
        entry("bksim.model", study.model_text()),
        entry("bksim.set", &fixed.join("\n")),
        entry("bksim.plan", &study.plan_text()),
        entry("bksim.options", study.options_text()),
        entry("bksim.fingerprint", &study.fingerprint()),
        entry("unit.t_reached", "s"),
    ]
    .into_iter()
    .chain(units)
    .collect()
}

fn schema(
    inputs: &[(String, String)],
    outputs: &[(String, String)],
) -> Result<TypePtr, ParquetError> {
    let column = |name: &str, kind, repetition| {
        let builder = Type::primitive_type_builder(name, kind).with_repetition(repetition);
        let is_text = kind == PhysicalType::BYTE_ARRAY;
        builder.with_logical_type(is_text.then_some(LogicalType::String)).build().map(Arc::new)
    };
    let (required, optional) = (Repetition::REQUIRED, Repetition::OPTIONAL);
    let (whole, real, text) = (PhysicalType::INT64, PhysicalType::DOUBLE, PhysicalType::BYTE_ARRAY);
    let mut fields = vec![column("case", whole, required)?];
    for (name, _) in inputs {
        fields.push(column(name, real, required)?);
    }
    for (name, _) in outputs {
        fields.push(column(name, real, optional)?);
    }
    fields.extend([
        column("status", text, required)?,
        column("code", text, optional)?,
        column("reason", text, optional)?,
        column("t_reached", real, required)?,
        column("steps", whole, required)?,
    ]);
    Type::group_type_builder("sweep").with_fields(fields).build().map(Arc::new)
}

fn write<T: DataType, W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    values: &[T::T],
    levels: Option<&[i16]>,
) -> Result<(), ParquetError> {
    let missing = || ParquetError::General("the schema has fewer columns than the rows".into());
    let mut column = group.next_column()?.ok_or_else(missing)?;
    column.typed::<T>().write_batch(values, levels, None)?;
    column.close()
}
