//! Logs exported as Parquet.

#[path = "../../log/tests/common/mod.rs"]
mod run;

use bksim_log::{LogReader, Selection};
use bksim_studio::to_parquet;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::RowAccessor;
use run::{N_SAMPLES, run, state, time};

#[test]
fn parquet_holds_the_table_with_units_and_provenance() -> Result<(), Box<dyn std::error::Error>> {
    let bytes = run()?;
    let log = LogReader::open(&bytes[..])?;
    let sha256 = log.model_sha256().to_owned();
    let all = Selection::all(log.header());
    let mut table = Vec::new();
    to_parquet(log, &all, &mut table)?;

    let reader = SerializedFileReader::new(bytes::Bytes::from(table))?;
    let key_values = reader.metadata().file_metadata().key_value_metadata().cloned();
    let value_of = |key: &str| {
        let entries = key_values.iter().flatten();
        entries.filter(|entry| entry.key == key).find_map(|entry| entry.value.clone())
    };
    assert_eq!(value_of("bksim.model_sha256"), Some(sha256));
    assert_eq!(value_of("unit.state.A_omega").as_deref(), Some("rad/s"));
    let mut n_rows = 0;
    for (i, row) in (0..).zip(reader.get_row_iter(None)?) {
        let row = row?;
        n_rows += 1;
        let [angle, omega, ratio] = state(i);
        for (column_idx, expected) in [time(i), angle, omega, ratio].into_iter().enumerate() {
            assert_eq!(row.get_double(column_idx)?.to_bits(), expected.to_bits());
        }
        assert_eq!(row.get_double(4).ok(), (i % 10 == 0).then_some(f64::from(i)));
    }
    assert_eq!(n_rows, N_SAMPLES);
    Ok(())
}
