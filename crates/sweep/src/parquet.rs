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

use crate::row::Row;

/// Names of the columns that every sweep has.
const OWN: [&str; 6] = ["case", "status", "code", "reason", "t_reached", "steps"];

/// A column of numbers.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Column {
    /// Name of the column.
    pub name: String,
    /// SI unit of its values, empty for none.
    pub unit: String,
}

/// The columns of a table and its metadata.
#[derive(Debug)]
pub(crate) struct Layout {
    schema: TypePtr,
    n_inputs: usize,
    n_outputs: usize,
    about: Vec<KeyValue>,
}

impl Layout {
    /// Of a sweep over `inputs` that keeps `outputs`; `about` is what its tables say about it.
    pub(crate) fn new(
        inputs: Vec<Column>,
        outputs: &[Column],
        mut about: Vec<KeyValue>,
    ) -> Result<Self, ParquetError> {
        let renamed = |Column { name, unit }| {
            let is_taken = OWN.contains(&name.as_str());
            Column { name: if is_taken { format!("set.{name}") } else { name }, unit }
        };
        let inputs: Vec<Column> = inputs.into_iter().map(renamed).collect();
        let with_unit = inputs.iter().chain(outputs).filter(|column| !column.unit.is_empty());
        about.extend(with_unit.map(|Column { name, unit }| entry(&format!("unit.{name}"), unit)));
        let schema = schema(&inputs, outputs)?;
        Ok(Self { schema, n_inputs: inputs.len(), n_outputs: outputs.len(), about })
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
        let whole = |value: u64| i64::try_from(value).expect("cases and steps are counted to 2⁶³");
        let cases: Vec<i64> = rows.iter().map(|row| whole(row.case)).collect();
        write::<Int64Type, _>(group, &cases, None)?;
        for idx in 0..self.n_inputs {
            let values: Vec<f64> = rows.iter().map(|row| row.inputs[idx]).collect();
            write::<DoubleType, _>(group, &values, None)?;
        }
        let is_done: Vec<i16> =
            rows.iter().map(|row| row.ending.fault().is_none().into()).collect();
        for idx in 0..self.n_outputs {
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
                    bytes_written: count(column.compressed_size())?,
                    rows_written: count(group.num_rows())?,
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
    let n_rows = count(metadata.num_rows())?;
    Ok((n_rows, metadata.key_value_metadata().cloned().unwrap_or_default()))
}

/// A count as it stands in a file, which may be damaged.
fn count(stated: i64) -> Result<u64, ParquetError> {
    let negative = |_| ParquetError::General(format!("the table has a count of {stated}"));
    u64::try_from(stated).map_err(negative)
}

pub(crate) fn entry(key: &str, value: &str) -> KeyValue {
    KeyValue::new(key.to_owned(), value.to_owned())
}

fn schema(inputs: &[Column], outputs: &[Column]) -> Result<TypePtr, ParquetError> {
    let column = |name: &str, kind, repetition| {
        let builder = Type::primitive_type_builder(name, kind).with_repetition(repetition);
        let is_text = kind == PhysicalType::BYTE_ARRAY;
        builder.with_logical_type(is_text.then_some(LogicalType::String)).build().map(Arc::new)
    };
    let (required, optional) = (Repetition::REQUIRED, Repetition::OPTIONAL);
    let (whole, real, text) = (PhysicalType::INT64, PhysicalType::DOUBLE, PhysicalType::BYTE_ARRAY);
    let mut fields = vec![column("case", whole, required)?];
    for Column { name, .. } in inputs {
        fields.push(column(name, real, required)?);
    }
    for Column { name, .. } in outputs {
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
