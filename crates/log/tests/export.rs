//! Exported tables.

use crate::common::{N_SAMPLES, end, run, state, time};
use bksim_log::{LogError, LogReader, Selection, export::to_csv};

#[test]
fn csv_joins_topics_on_time_and_keeps_every_bit() -> Result<(), LogError> {
    let bytes = run()?;
    let log = LogReader::open(&bytes[..])?;
    let selection =
        Selection::new(log.header(), ["solver.energy", "state.ratio", "state.A_angle"])?;
    let mut text = Vec::new();
    let exported = to_csv(log, &selection, &mut text)?;
    assert_eq!((exported.n_rows, exported.end), (u64::from(N_SAMPLES), Some(end())));

    let mut lines = std::str::from_utf8(&text).expect("text").lines();
    assert_eq!(lines.next(), Some("t,solver.energy.total,state.ratio,state.A_angle"));
    for (i, line) in (0..).zip(lines) {
        let cells: Vec<Option<f64>> = line.split(',').map(|cell| cell.parse().ok()).collect();
        let [angle, _, ratio] = state(i);
        let energy = (i % 10 == 0).then_some(f64::from(i));
        let expected = [Some(time(i)), energy, Some(ratio), Some(angle)];
        let bits = |cells: &[Option<f64>]| {
            cells.iter().map(|cell| cell.map(f64::to_bits)).collect::<Vec<_>>()
        };
        assert_eq!(bits(&cells), bits(&expected), "row {i}: {line}");
    }
    Ok(())
}

#[test]
fn a_topic_sampled_twice_at_one_time_makes_two_rows() -> Result<(), LogError> {
    use bksim_log::{Field, Header, LogWriter, Topic};
    let mut header = Header::new("ball", "toml", "", "");
    let state = header.add_topic(Topic::new("/state", [Field::new("v", "m/s", "")]));
    let mut writer = LogWriter::create(Vec::new(), &header)?;
    for (t, v) in [(0.0, -1.0), (0.5, -2.0), (0.5, 2.0)] {
        writer.write(state, t, &[v])?;
    }
    let bytes = writer.finish(&end())?;
    let log = LogReader::open(&bytes[..])?;
    let all = Selection::all(log.header());
    let mut text = Vec::new();
    to_csv(log, &all, &mut text)?;
    assert_eq!(text, b"t,state.v\n0.0,-1.0\n0.5,-2.0\n0.5,2.0\n");
    Ok(())
}
