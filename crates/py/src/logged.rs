//! Runs as logs, and logs as runs.

use std::fs::File;
use std::io::{BufReader, Read, Write};
use std::path::{Path, PathBuf};

use bksim::log::{EndStatus, LogError, LogReader, Outcome, Record};
use bksim::options::described;
use bksim::playback::{LoggedInputs, RunLog, segment_of};
use bksim::record::{
    Contents, INPUTS, Recorder, compliance_options, compliances, overrides, set_option,
};
use bksim::sim::run::{Sample, Summary};
use bksim::sim::sensitivity::StateSensitivity;
use bksim::sim::start::Start;
use bksim_load::Text;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::arrays::{table, transposed, vector};
use crate::engine::Engine;
use crate::fault::{Fault, guard};
use crate::file::{replace, unwritten};
use crate::solution::{Carried, Ending, Facts, Kept, Logged, Rows, Run};

/// Writes the log of a run, replacing a file of that name only once it is whole.
#[pyfunction]
pub(crate) fn save_log(py: Python<'_>, run: Py<Run>, path: PathBuf) -> PyResult<()> {
    let run = run.get();
    let rows = run.rows(py);
    guard(py, || {
        if let Some(Carried { log, .. }) = &run.carried {
            return replace(&path, |out| out.write_all(log).map_err(|e| unwritten(&path, &e)));
        }
        let start = run.engine.get().start()?;
        let unwritten = |e: LogError| unwritten(&path, &e);
        replace(&path, |out| write(run, &rows, start, out).map(drop).map_err(unwritten))
    })
}

/// The log of a run, to be sent to another process or kept.
#[pyfunction]
pub(crate) fn log_bytes(py: Python<'_>, run: Py<Run>) -> PyResult<Bound<'_, PyBytes>> {
    let run = run.get();
    let rows = run.rows(py);
    let log = guard(py, || match (&run.carried, &run.logged) {
        (Some(Carried { log, .. }), _) => Ok(log.clone()),
        (None, Some(_)) => {
            let path = &run.engine.get().source().path;
            let unread = |e| Fault::File(format!("cannot read {}: {e}", path.display()));
            std::fs::read(path).map_err(unread)
        }
        (None, None) => bytes(run, &rows),
    })?;
    Ok(PyBytes::new(py, &log))
}

/// The run of a log that was carried here.
#[pyfunction]
pub(crate) fn carried_run(
    py: Python<'_>,
    path: PathBuf,
    log: Vec<u8>,
    facts: Facts,
) -> PyResult<Run> {
    let run = guard(py, || opened(&path, log.as_slice()))?;
    Ok(made(py, run)?.with_carried(Carried { log, facts }))
}

/// The log of a run as bytes.
pub(crate) fn bytes(run: &Run, rows: &Rows) -> Result<Vec<u8>, Fault> {
    let start = run.engine.get().start()?;
    write(run, rows, start, Vec::new()).map_err(|error| Fault::Log(error.to_string()))
}

fn write<W: Write>(run: &Run, rows: &Rows, start: &Start, out: W) -> Result<W, LogError> {
    let engine = run.engine.get();
    let Kept { options, summary, segments, ending, like, sensitive, .. } = &run.kept;
    let mut simulation = engine.simulation.clone();
    simulation.set_options(options);
    let mut words = described(&simulation.mechanism().model, sensitive);
    words.extend(engine.overrides.iter().map(|(name, value)| set_option(name, value)));
    words.extend(compliance_options(&engine.compliance));
    let contents = Contents { options: &words, sensitive, ..Contents::default() };
    let text = &engine.source().text;
    let mut recorder = Recorder::create_with(out, &simulation, text, start, &contents)?;

    let n_own = rows.n_columns - run.kept.derivatives.len();
    // A segment comes ahead of the samples in it.
    let mut segments = segments.iter().peekable();
    let forward = if options.t_end < start.t { -1.0 } else { 1.0 };
    let mut changes = summary.uniqueness.iter().peekable();
    let of_samples = rows.values.chunks_exact(rows.n_columns.max(1));
    for (&t, values) in rows.t.iter().zip(of_samples) {
        while let Some(segment) = segments.next_if(|s| (t - s.t0) * forward > 0.0) {
            recorder.segment(segment)?;
        }
        while let Some(change) = changes.next_if(|change| (t - change.t) * forward >= 0.0) {
            recorder.uniqueness(change)?;
        }
        let sample = engine.channels().sample_of(t, values, like);
        recorder.write(&sample)?;
        recorder
            .write_sensitivities(t, &derivatives(&values[n_own..], sensitive.len(), &sample))?;
    }
    for segment in segments {
        recorder.segment(segment)?;
    }
    for change in changes {
        recorder.uniqueness(change)?;
    }
    let (outcome, reason) = match ending {
        Ending::Reached => (Outcome::ReachedEnd, "end time reached".to_owned()),
        Ending::Full => (Outcome::Stopped, "no more memory was allowed".to_owned()),
        Ending::Stopped(_) => (Outcome::Stopped, "interrupted".to_owned()),
        Ending::Failed(fault) => {
            (Outcome::Stopped, format!("[{}] {}", fault.code.0, fault.message))
        }
    };
    recorder.finish(summary, outcome, &reason)
}

/// Derivatives of a sample by some quantities from its row.
fn derivatives(row: &[f64], n_sensitive: usize, sample: &Sample) -> Vec<StateSensitivity> {
    let (nq, nc) = (sample.q.len(), sample.lambda.len());
    let of_one = |row: &[f64]| StateSensitivity {
        q: row[..nq].to_vec(),
        v: row[nq..2 * nq].to_vec(),
        a: row[2 * nq..3 * nq].to_vec(),
        lambda: row[3 * nq..3 * nq + nc].to_vec(),
        channels: row[3 * nq + nc..].to_vec(),
    };
    let n_each = row.len() / n_sensitive.max(1);
    row.chunks_exact(n_each.max(1)).map(of_one).collect()
}

/// A run as its log has it.
#[pyfunction]
pub(crate) fn open_log(py: Python<'_>, path: PathBuf) -> PyResult<Run> {
    let run = guard(py, || {
        let file = File::open(&path)
            .map_err(|e| Fault::File(format!("cannot read {}: {e}", path.display())))?;
        opened(&path, BufReader::new(file))
    })?;
    made(py, run)
}

fn made(py: Python<'_>, (engine, t, values, kept, logged): Opened) -> PyResult<Run> {
    let engine = Py::new(py, engine)?;
    let run = Run::new(engine, vector(py, t).unbind(), table(py, values).unbind(), kept);
    Ok(run.with_log(logged))
}

type Opened = (Engine, Vec<f64>, numpy::ndarray::Array2<f64>, Kept, Logged);

/// The run of a log; `path` is where it is from.
fn opened(path: &Path, log: impl Read) -> Result<Opened, Fault> {
    let bad = |e: &dyn std::fmt::Display| Fault::Log(format!("`{}`: {e}", path.display()));
    // Read everything.
    let mut log = LogReader::open(log).map_err(|e| bad(&e))?;
    let header = log.header().clone();

    // Samples by topic: all topics have as many but in a log that was cut short.
    let n_topics = header.topics.len();
    let mut of_topic: Vec<Vec<f64>> = vec![Vec::new(); n_topics];
    let (mut t, mut notes, mut segments) = (Vec::new(), Vec::new(), Vec::new());
    let mut not_unique = Vec::new();
    while let Some(record) = log.next_record().map_err(|e| bad(&e))? {
        match record {
            Record::Sample { topic, t: time, values } => {
                if topic.index() == 0 {
                    t.push(time);
                }
                of_topic[topic.index()].extend_from_slice(values);
            }
            Record::Note(note) => notes.push(note),
            Record::Segment(segment) => segments.push(segment_of(segment)),
            Record::NotUnique(change) => change.add_to(&mut not_unique),
        }
    }
    // Put the topics of a sample side by side, as far as all of them have it.
    let widths: Vec<usize> = header.topics.iter().map(|topic| topic.fields.len()).collect();
    let counts = of_topic.iter().zip(&widths).filter(|(_, width)| **width > 0);
    let n_samples = counts.map(|(values, width)| values.len() / width).min().unwrap_or(0);
    if n_samples == 0 {
        return Err(bad(&"the log was cut before its first sample"));
    }
    t.truncate(n_samples);
    let n_columns: usize = widths.iter().sum();
    let mut values = Vec::with_capacity(n_samples * n_columns);
    for k in 0..n_samples {
        for (of_topic, &width) in of_topic.iter().zip(&widths) {
            values.extend_from_slice(&of_topic[k * width..(k + 1) * width]);
        }
    }
    // Derive the equations again from the model in the log.
    let place = header.topics.iter().position(|topic| topic.name == INPUTS);
    let inputs = place.map(|idx| std::mem::take(&mut of_topic[idx])).unwrap_or_default();
    let columns = header.topics.iter().flat_map(|topic| {
        let described =
            |f: &bksim::log::Field| (topic.column_name(f), f.unit.clone(), f.description.clone());
        topic.fields.iter().map(described).collect::<Vec<_>>()
    });
    let columns = columns.collect();

    let inputs = LoggedInputs { t: t.clone(), values: inputs };
    let run_log = RunLog { inputs, ..RunLog::unlogged(header, Vec::new()) };
    let mechanism = run_log.mechanism().map_err(|e| bad(&e))?;
    let header = run_log.header;
    let source = Text::new(path, header.model_text);
    let options = mechanism.model.solve.clone();
    let mut engine = Engine::new(source, &mechanism, overrides(&header.options), Vec::new(), None)?;
    engine.compliance = compliances(&header.options);
    let end: Option<EndStatus> = log.end().cloned();
    let ending = match &end {
        Some(end) if end.outcome == Outcome::ReachedEnd => Ending::Reached,
        _ => Ending::Stopped(None),
    };
    let kept = Kept {
        options,
        summary: Summary::default(),
        segments,
        ending,
        like: Sample::default(),
        sensitive: Vec::new(),
        derivatives: Vec::new(),
    };
    Ok((
        engine,
        t,
        transposed(&values, n_columns),
        kept,
        Logged { end, notes, not_unique, columns },
    ))
}
