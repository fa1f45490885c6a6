//! A small run that uses every kind of record.
#![allow(dead_code, reason = "each test file uses a part of it")]

use std::{ops::Range, time::Duration};

use bksim_log::{
    EndStatus, Field, Header, Level, LogError, LogWriter, Outcome, Quantity, Topic, TopicId,
};

/// Number of samples of `/state`; `/energy` has every tenth of its times.
pub(crate) const N_SAMPLES: u32 = 400;

/// The header of the run, and its topics `/state` and `/solver/energy`.
pub(crate) fn header() -> (Header, TopicId, TopicId) {
    let text = "[model]\nname = \"Schubkurbel π\"\n";
    let mut header = Header::new("slider-crank", "toml", text, "0.1.0");
    header.t_start = -2.0;
    let length = Quantity { value: 0.025, unit: "m".into() };
    header.parameters.insert("l1".into(), length);
    header.parameters.insert("ratio".into(), Quantity { value: 1e-300, unit: String::new() });
    header.options.insert("solve.rtol".into(), "1e-6".into());
    header.options.insert("solve.method".into(), "radau".into());
    let state = header.add_topic(Topic::new(
        "/state",
        [
            Field::new("A_angle", "rad", "crank against ground"),
            Field::new("A_omega", "rad/s", ""),
            Field::new("ratio", "", "x3 to l1"),
        ],
    ));
    let energy =
        header.add_topic(Topic::new("/solver/energy", [Field::new("total", "J", "T + V")]));
    (header, state, energy)
}

/// Values of `/state` in sample `i`, among them signed zero and what is no number.
pub(crate) fn state(i: u32) -> [f64; 3] {
    let t = time(i);
    let ratio = match i % 50 {
        0 => -0.0,
        1 => f64::NAN,
        2 => f64::NEG_INFINITY,
        _ => 0.1 * f64::from(i),
    };
    [t.sin(), t.cos() / 3.0, ratio]
}

/// Time of sample `i`, s.
pub(crate) fn time(i: u32) -> f64 {
    -2.0 + 0.01 * f64::from(i)
}

/// How the run ends.
pub(crate) fn end() -> EndStatus {
    let mut end = EndStatus::new(Outcome::Stopped, time(N_SAMPLES - 1), "singular at `elbow`");
    end.summary.insert("n_step".into(), "123".into());
    end.details = r#"{"events": []}"#.into();
    end
}

/// Writes the samples of `range`, and the notes between them.
pub(crate) fn write_samples<W: std::io::Write>(
    writer: &mut LogWriter<W>,
    (topic, energy): (TopicId, TopicId),
    range: Range<u32>,
) -> Result<(), LogError> {
    for i in range {
        writer.write(topic, time(i), &state(i))?;
        if i % 10 == 0 {
            writer.write(energy, time(i), &[f64::from(i)])?;
        }
        if i % 100 == 99 {
            writer.note(Level::Warning, time(i), &format!("step {i} is small"))?;
        }
    }
    Ok(())
}

/// The bytes of the whole run, in chunks that do not depend on the clock.
pub(crate) fn run() -> Result<Vec<u8>, LogError> {
    let (header, topic, energy) = header();
    let mut writer = LogWriter::create(Vec::new(), &header)?.flush_every(Duration::MAX);
    for first in (0..N_SAMPLES).step_by(8) {
        write_samples(&mut writer, (topic, energy), first..first + 8)?;
        writer.flush()?;
    }
    writer.finish(&end())
}
