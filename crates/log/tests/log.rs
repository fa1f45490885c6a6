//! Logs come back as they were written; readers report losses and damage.

use std::{
    cell::RefCell,
    io::{self, Write},
    rc::Rc,
    time::{Duration, Instant},
};

use crate::common::{N_SAMPLES, end, header, run, state, time, write_samples};
use bksim_log::{
    EndStatus, Field, Header, Level, Log, LogError, LogReader, LogWriter, NotUnique, Outcome,
    Record, Survey, Topic,
};

/// A stream that outlives its writer, as a file does, with room for so many bytes.
#[derive(Clone, Default)]
struct Disk {
    bytes: Rc<RefCell<Vec<u8>>>,
    room: Option<usize>,
}

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let used = self.bytes.borrow().len();
        if self.room.is_some_and(|room| used + bytes.len() > room) {
            return Err(io::ErrorKind::StorageFull.into());
        }
        self.bytes.borrow_mut().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Bits, so that NaN equals itself and zero differs from minus zero.
fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// The times of `/state` and the other records, checked against what was written.
#[track_caller]
fn assert_is_beginning_of_the_run(log: &Log) {
    let (expected, topic, energy) = header();
    assert_eq!(log.header, expected);
    let series = log.series(topic);
    for (i, &t) in (0..).zip(&series.t) {
        let values: Vec<f64> = series.columns.iter().map(|column| column[i as usize]).collect();
        assert_eq!(
            (t.to_bits(), bits(&values)),
            (time(i).to_bits(), bits(&state(i))),
            "sample {i}"
        );
    }
    for (i, (&t, &value)) in (0..).step_by(10).zip(series_of_one(log, energy)) {
        assert_eq!((t, value), (time(i), f64::from(i)));
    }
    for (i, note) in (99..).step_by(100).zip(&log.notes) {
        assert_eq!((note.level, note.t), (Level::Warning, time(i)));
        assert_eq!(note.text, format!("step {i} is small"));
    }
}

fn series_of_one(log: &Log, topic: bksim_log::TopicId) -> impl Iterator<Item = (&f64, &f64)> {
    let series = log.series(topic);
    series.t.iter().zip(&series.columns[0])
}

#[test]
fn a_run_comes_back_bit_for_bit() -> Result<(), LogError> {
    let log = Log::read(&run()?[..])?;
    let (_, topic, energy) = header();
    assert_is_beginning_of_the_run(&log);
    assert_eq!(log.series(topic).t.len(), N_SAMPLES as usize);
    assert_eq!(log.series(energy).t.len(), 40);
    assert_eq!(log.notes.len(), 4);
    assert_eq!(log.end, Some(end()));
    // printf '[model]\nname = "Schubkurbel π"\n' | sha256sum
    let sha256 = "62a84685ed1566c50f4ae27f85ae28439cf12450c83cdcee7c07d56c7055abfc";
    assert_eq!(log.model_sha256, sha256);
    Ok(())
}

#[test]
fn equal_runs_make_equal_files() -> Result<(), LogError> {
    assert!(run()? == run()?);
    Ok(())
}

#[test]
fn a_cut_log_keeps_what_is_whole_and_has_no_end() -> Result<(), LogError> {
    let whole = run()?;
    let (_, topic, _) = header();
    let mut counts = Vec::new();
    for twentieth in 1..20 {
        let log = Log::read(&whole[..whole.len() * twentieth / 20])?;
        assert_is_beginning_of_the_run(&log);
        counts.push((log.series(topic).t.len(), log.end.is_some()));
    }
    // The summary after the data takes the rest of the file.
    let n_ended = counts.iter().filter(|(_, has_end)| *has_end).count();
    assert!(counts.is_sorted() && counts[2].0 < counts[9].0, "{counts:?}");
    assert!(n_ended < 10, "{counts:?}");
    Ok(())
}

#[test]
fn a_cut_log_tells_up_to_the_cut_which_channels_are_not_unique() -> Result<(), LogError> {
    let (header, topic, _) = header();
    let of = |t: f64, names: &[&str]| {
        let channels = names.iter().map(|&name| name.to_owned()).collect();
        NotUnique { t, n_self_stresses: names.len(), channels }
    };
    let changes = [of(0.0, &[]), of(0.25, &["reactions.a.fx", "reactions.b.fx"]), of(0.5, &[])];
    let values = vec![1.0; header.topics[topic.index()].fields.len()];
    let mut writer = LogWriter::create(Vec::new(), &header)?;
    for (k, change) in changes.iter().enumerate() {
        writer.uniqueness(change)?;
        writer.write(topic, change.t, &values)?;
        // Said twice, it is one change.
        writer.uniqueness(&changes[k])?;
    }
    assert!(writer.uniqueness(&of(f64::NAN, &[])).is_err());
    let bytes = writer.finish(&EndStatus::new(Outcome::ReachedEnd, 0.5, ""))?;
    let whole = Survey::read(&bytes[..])?;
    assert_eq!((whole.not_unique.as_slice(), whole.end.is_some()), (&changes[..], true));

    // Cut between the second change and the third.
    let mut lengths = Vec::new();
    for n in 0..bytes.len() {
        let Ok(cut) = Survey::read(&bytes[..n]) else { continue };
        assert_eq!(cut.not_unique, changes[..cut.not_unique.len()], "{n}");
        lengths.push(cut.not_unique.len());
    }
    assert!(lengths.is_sorted() && lengths.contains(&1) && lengths.contains(&2), "{lengths:?}");

    // No byte of a change can be another one.
    let place = bytes.windows(14).position(|w| w == b"reactions.a.fx").expect("the name");
    let mut flipped = bytes.clone();
    flipped[place] ^= 1;
    assert!(matches!(Survey::read(&flipped[..]), Err(LogError::Damaged { .. })));
    Ok(())
}

#[test]
fn a_flipped_byte_never_changes_a_number() -> Result<(), LogError> {
    let whole = run()?;
    let mut n_refused = 0;
    let mut n_cut = 0;
    for position in (0..whole.len()).step_by(7) {
        let mut bytes = whole.clone();
        bytes[position] ^= 1 << (position % 8);
        match Log::read(&bytes[..]) {
            Err(_) => n_refused += 1,
            Ok(log) => {
                assert_is_beginning_of_the_run(&log);
                // Either all is there, or the loss is reported.
                let (_, topic, _) = header();
                let is_whole = log.series(topic).t.len() == N_SAMPLES as usize;
                assert!(is_whole && log.end == Some(end()) || log.end.is_none(), "{position}");
                n_cut += usize::from(log.end.is_none());
            }
        }
    }
    assert!(n_refused > 100 && n_cut > 10, "{n_refused} refused, {n_cut} cut short");
    Ok(())
}

#[test]
fn a_killed_run_keeps_all_that_was_written_an_interval_ago() -> Result<(), LogError> {
    let interval = Duration::from_millis(10);
    let (header, topic, _) = header();
    let disk = Disk::default();
    let mut writer = LogWriter::create(disk.clone(), &header)?.flush_every(interval);
    let begin = Instant::now();
    let mut written = Vec::new();
    let last = loop {
        let last = Instant::now();
        writer.write(topic, written.len() as f64, &[0.0; 3])?;
        written.push(Instant::now());
        // On a busy machine one write may take that long.
        let has_old = written.first().is_some_and(|&time| time + interval < last);
        if has_old && begin.elapsed() > 5 * interval {
            break last;
        }
    };
    // The writer is alive and knows of no end.
    let log = Log::read(&disk.bytes.borrow()[..])?;
    let n_old = written.iter().filter(|&&time| time + interval < last).count();
    let n_kept = log.series(topic).t.len();
    assert!(n_old > 0 && n_kept >= n_old, "{n_kept} kept of {n_old} older than the interval");
    assert_eq!(log.end, None);
    Ok(())
}

#[test]
fn a_dropped_writer_leaves_its_samples_and_no_end() -> Result<(), LogError> {
    let (header, topic, energy) = header();
    let disk = Disk::default();
    let mut writer = LogWriter::create(disk.clone(), &header)?.flush_every(Duration::MAX);
    write_samples(&mut writer, (topic, energy), 0..50)?;
    drop(writer);
    let log = Log::read(&disk.bytes.borrow()[..])?;
    assert_is_beginning_of_the_run(&log);
    assert_eq!((log.series(topic).t.len(), log.end), (50, None));
    Ok(())
}

#[test]
fn a_full_disk_is_reported_wherever_it_happens() -> Result<(), LogError> {
    let whole = run()?;
    let (header, topic, energy) = header();
    let mut n_after_create = 0;
    for room in (0..whole.len()).step_by(whole.len() / 50) {
        let disk = Disk { room: Some(room), ..Disk::default() };
        let Ok(writer) = LogWriter::create(disk.clone(), &header) else { continue };
        n_after_create += 1;
        let mut writer = writer.flush_every(Duration::ZERO);
        let written = write_samples(&mut writer, (topic, energy), 0..N_SAMPLES);
        let error = match written {
            Ok(()) => writer.finish(&end()).map(drop).expect_err("the disk is full"),
            Err(error) => {
                let again = writer.write(topic, time(N_SAMPLES), &[0.0; 3]);
                assert!(matches!(again, Err(LogError::Abandoned)), "{again:?}");
                assert!(matches!(writer.finish(&end()).map(drop), Err(LogError::Abandoned)));
                error
            }
        };
        assert!(matches!(error, LogError::Io(_)), "{error}");
        let log = Log::read(&disk.bytes.borrow()[..])?;
        assert_is_beginning_of_the_run(&log);
        assert_eq!(log.end, None);
    }
    assert!(n_after_create > 10, "{n_after_create}");
    Ok(())
}

#[test]
fn samples_stream_without_the_whole_file() -> Result<(), LogError> {
    let bytes = run()?;
    let mut reader = LogReader::open(&bytes[..])?;
    assert!(reader.end().is_none());
    let mut n_samples = 0;
    while let Some(record) = reader.next_record()? {
        if let Record::Sample { values, .. } = record {
            n_samples += 1;
            assert!(matches!(values.len(), 1 | 3));
        }
    }
    assert_eq!((n_samples, reader.end()), (N_SAMPLES + N_SAMPLES / 10, Some(&end())));
    Ok(())
}

#[test]
fn names_that_could_not_be_found_again_are_refused() {
    let refusal = |topics: &[(&str, &str)]| {
        let mut header = Header::new("m", "toml", "", "");
        for (topic, field) in topics {
            header.add_topic(Topic::new(topic, [Field::new(field, "", "")]));
        }
        LogWriter::create(Vec::new(), &header).map(drop).expect_err("a bad name").to_string()
    };
    assert_eq!(refusal(&[("state", "a")]), "`state` cannot name a topic");
    assert_eq!(refusal(&[("/state/", "a")]), "`/state/` cannot name a topic");
    assert_eq!(refusal(&[("/state", "a b")]), "`a b` cannot name a field");
    assert_eq!(refusal(&[("/state", "t")]), "field `state.t` is there twice");
    assert_eq!(refusal(&[("/log", "a")]), "topic `/log` is there twice");
    assert_eq!(refusal(&[("/a/b", "x"), ("/a_b", "x")]), "topic `/a_b` is there twice");
}

#[test]
fn time_runs_one_way_and_samples_are_complete() -> Result<(), LogError> {
    let mut header = Header::new("m", "toml", "", "");
    (header.t_start, header.t_end) = (1.0, -5.0);
    let topic = header.add_topic(Topic::new("/state", [Field::new("x", "m", "")]));
    let mut writer = LogWriter::create(Vec::new(), &header)?;
    // Backwards from the start is a direction too; repeating a time is allowed.
    for t in [1.0, -1.0, -1.0, -3.0] {
        writer.write(topic, t, &[t])?;
    }
    for t in [-2.0, f64::NAN, f64::NEG_INFINITY] {
        let refused = writer.write(topic, t, &[t]);
        assert!(matches!(refused, Err(LogError::BadTime { previous: -3.0, .. })), "{refused:?}");
    }
    let refused = writer.write(topic, -4.0, &[1.0, 2.0]).expect_err("one field").to_string();
    assert_eq!(refused, "topic `/state` has 1 fields, the sample 2 values");
    let log = Log::read(&writer.finish(&end())?[..])?;
    assert_eq!(log.series(topic).t, [1.0, -1.0, -1.0, -3.0]);
    Ok(())
}

#[test]
fn a_checkpoint_comes_back_with_the_end_of_the_log() -> Result<(), LogError> {
    let (header, topic, _) = header();
    let mut writer = LogWriter::create(Vec::new(), &header)?;
    let values = vec![0.5; header.topics[0].fields.len()];
    writer.write(topic, header.t_start, &values)?;
    let saved: Vec<u8> = (0..=255).cycle().take(5000).collect();
    writer.checkpoint(&saved)?;
    let limit = writer.checkpoint(&vec![0; 1 << 25]);
    assert!(matches!(limit, Err(LogError::TooLarge { .. })), "{limit:?}");
    let bytes = writer.finish(&end())?;

    let mut reader = LogReader::open(&bytes[..])?;
    assert_eq!(reader.checkpoint(), None);
    while reader.next_record()?.is_some() {}
    assert_eq!(reader.checkpoint(), Some(&saved[..]));

    // From a log that was cut after it, but not within it, nor from one with another bit in it.
    let offset = bytes.windows(saved.len()).position(|part| part == saved).expect("its bytes");
    for (n_bytes, expected) in [(4, Some(&saved[..])), (3, None)] {
        let mut cut = LogReader::open(&bytes[..offset + saved.len() + n_bytes])?;
        while cut.next_record()?.is_some() {}
        assert_eq!(cut.checkpoint(), expected);
    }

    // Not from one of a run that had more to say, or has reached its end.
    for (outcome, is_last) in [(Outcome::Stopped, false), (Outcome::ReachedEnd, true)] {
        let mut writer = LogWriter::create(Vec::new(), &header)?;
        writer.checkpoint(&saved)?;
        if !is_last {
            writer.note(Level::Error, header.t_start, "a fault")?;
        }
        let bytes = writer.finish(&EndStatus::new(outcome, header.t_start, ""))?;
        let mut reader = LogReader::open(&bytes[..])?;
        while reader.next_record()?.is_some() {}
        assert_eq!(reader.checkpoint(), None, "{outcome:?}");
        assert_eq!(Survey::read(&bytes[..])?.checkpoint_bytes, None, "{outcome:?}");
    }
    let mut flipped = bytes.clone();
    flipped[offset + 100] ^= 1;
    let mut reader = LogReader::open(&flipped[..])?;
    let read = loop {
        match reader.next_record() {
            Ok(Some(_)) => (),
            Ok(None) => break Ok(()),
            Err(error) => break Err(error),
        }
    };
    assert!(read.is_err(), "{read:?}");
    Ok(())
}

#[test]
fn a_survey_counts_what_a_reader_reads() -> Result<(), LogError> {
    let bytes = crate::common::run()?;
    let log = Log::read(&bytes[..])?;
    let survey = bksim_log::Survey::read(&bytes[..])?;
    for ((id, topic), count) in log.header.topics_with_ids().zip(&survey.topics) {
        let n_samples = log.series(id).t.len() as u64;
        // The time and one number for each field, nine bytes each.
        let bytes = 9 * n_samples * (topic.fields.len() as u64 + 1);
        assert_eq!((count.n_samples, count.bytes), (n_samples, bytes), "{}", topic.name);
    }
    assert_eq!(
        survey.span,
        Some([crate::common::time(0), crate::common::time(crate::common::N_SAMPLES - 1)])
    );
    assert_eq!((survey.notes, survey.end), (log.notes, log.end));
    assert_eq!((survey.header, survey.n_foreign), (log.header, 0));
    Ok(())
}

#[test]
fn what_is_not_wanted_is_passed_over() -> Result<(), LogError> {
    let bytes = crate::common::run()?;
    let (_, state, energy) = header();
    let request = bksim_log::Request { topics: vec![energy], ..bksim_log::Request::default() };
    let mut log = LogReader::open(&bytes[..])?.only(&request);
    let mut n_samples = 0;
    while let Some(record) = log.next_record()? {
        let Record::Sample { topic, .. } = record else { panic!("{record:?}") };
        assert!(topic == energy && topic != state);
        n_samples += 1;
    }
    assert_eq!(n_samples, crate::common::N_SAMPLES / 10);
    assert_eq!(log.end(), Some(&crate::common::end()));
    Ok(())
}
