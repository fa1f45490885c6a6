//! [`Header`] and [`EndStatus`] as MCAP metadata records, which are maps of text.

use std::collections::BTreeMap;

use mcap::records::Metadata;
use sha2::{Digest as _, Sha256};

use crate::{EndStatus, Header, LogError, NotUnique, Outcome, Quantity};

pub(crate) const RUN: &str = "bksim.run";
pub(crate) const PARAMETERS: &str = "bksim.parameters";
pub(crate) const OPTIONS: &str = "bksim.options";
pub(crate) const UNIQUENESS: &str = "bksim.uniqueness";
pub(crate) const END: &str = "bksim.end";
/// Name of the attachment with the state of a stopped run.
pub(crate) const CHECKPOINT: &str = "bksim.checkpoint";

const DIGEST: &str = "digest";
const SUMMARY_PREFIX: &str = "summary.";

/// Hexadecimal SHA-256, lower case.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    hex(Sha256::digest(bytes).as_ref())
}

fn hex(bytes: &[u8]) -> String {
    let digit = |nibble: u8| char::from_digit(nibble.into(), 16).expect("four bits are a digit");
    bytes.iter().flat_map(|byte| [digit(byte >> 4), digit(byte & 15)]).collect()
}

/// The records before the first sample: parameters, options, and the run itself last.
pub(crate) fn header_records(header: &Header) -> [Metadata; 3] {
    let quantity = |quantity: &Quantity| match quantity.unit.as_str() {
        "" => format!("{:?}", quantity.value),
        unit => format!("{:?} {unit}", quantity.value),
    };
    let parameters = header.parameters.iter().map(|(name, value)| (name.clone(), quantity(value)));
    let parameters = Metadata { name: PARAMETERS.into(), metadata: parameters.collect() };
    let options = Metadata { name: OPTIONS.into(), metadata: header.options.clone() };
    let mut run = Metadata { name: RUN.into(), metadata: BTreeMap::new() };
    for (key, value) in [
        ("model_name", header.model_name.clone()),
        ("model_format", header.model_format.clone()),
        ("model_sha256", sha256(header.model_text.as_bytes())),
        ("version", header.version.clone()),
        ("t_start", format!("{:?}", header.t_start)),
        ("t_end", format!("{:?}", header.t_end)),
    ] {
        run.metadata.insert(key.into(), value);
    }
    let digest = digest(&[&parameters, &options, &run]);
    run.metadata.insert(DIGEST.into(), digest);
    [parameters, options, run]
}

/// Fills `header` from the three records; topics and model text are left as they are.
///
/// Returns the SHA-256 of the model text.
pub(crate) fn read_header(
    parameters: &Metadata,
    options: Metadata,
    run: &mut Metadata,
    header: &mut Header,
) -> Result<String, LogError> {
    // Metadata records have no checksum of their own, and the one of the whole file comes last.
    let saved = run.metadata.remove(DIGEST).ok_or(LogError::NotARun { missing: "the digest" })?;
    if saved != digest(&[parameters, &options, run]) {
        return Err(LogError::damaged("the digest of the run's metadata is wrong"));
    }
    header.model_name = take(run, "model_name")?;
    header.model_format = take(run, "model_format")?;
    header.version = take(run, "version")?;
    header.t_start = number(&take(run, "t_start")?)?;
    header.t_end = number(&take(run, "t_end")?)?;
    header.options = options.metadata;
    for (name, text) in &parameters.metadata {
        let (value, unit) = text.split_once(' ').unwrap_or((text, ""));
        let quantity = Quantity { value: number(value)?, unit: unit.into() };
        header.parameters.insert(name.clone(), quantity);
    }
    take(run, "model_sha256")
}

/// SHA-256 over names, keys and values, each with its length in front so that none can shift.
fn digest(records: &[&Metadata]) -> String {
    let mut digest = Sha256::new();
    let mut add = |text: &str| {
        digest.update((text.len() as u64).to_le_bytes());
        digest.update(text);
    };
    for record in records {
        add(&record.name);
        for (key, value) in &record.metadata {
            add(key);
            add(value);
        }
    }
    hex(digest.finalize().as_ref())
}

/// The record of a change, with a digest: what a killed run leaves has no checksum of the whole.
pub(crate) fn uniqueness_record(change: &NotUnique) -> Metadata {
    let mut record = Metadata { name: UNIQUENESS.into(), metadata: BTreeMap::new() };
    for (key, value) in [
        ("t", format!("{:?}", change.t)),
        ("self_stresses", change.n_self_stresses.to_string()),
        ("channels", change.channels.join("\n")),
    ] {
        record.metadata.insert(key.into(), value);
    }
    let digest = digest(&[&record]);
    record.metadata.insert(DIGEST.into(), digest);
    record
}

pub(crate) fn read_uniqueness(mut record: Metadata) -> Result<NotUnique, LogError> {
    let saved = take(&mut record, DIGEST)?;
    if saved != digest(&[&record]) {
        return Err(LogError::damaged("the digest of a record on uniqueness is wrong"));
    }
    let count = take(&mut record, "self_stresses")?;
    let is_no_count = |_| LogError::damaged(format!("`{count}` is not a count"));
    Ok(NotUnique {
        t: number(&take(&mut record, "t")?)?,
        n_self_stresses: count.parse().map_err(is_no_count)?,
        channels: take(&mut record, "channels")?.lines().map(str::to_owned).collect(),
    })
}

pub(crate) fn end_record(end: &EndStatus) -> Metadata {
    let outcome = match end.outcome {
        Outcome::ReachedEnd => "reached_end",
        Outcome::Stopped => "stopped",
    };
    let summary = end.summary.iter();
    let mut metadata: BTreeMap<_, _> =
        summary.map(|(key, value)| (format!("{SUMMARY_PREFIX}{key}"), value.clone())).collect();
    metadata.insert("outcome".into(), outcome.into());
    metadata.insert("t_end".into(), format!("{:?}", end.t_end));
    metadata.insert("reason".into(), end.reason.clone());
    if !end.details.is_empty() {
        metadata.insert("details".into(), end.details.clone());
    }
    Metadata { name: END.into(), metadata }
}

pub(crate) fn read_end(mut record: Metadata) -> Result<EndStatus, LogError> {
    let outcome = match take(&mut record, "outcome")?.as_str() {
        "reached_end" => Outcome::ReachedEnd,
        "stopped" => Outcome::Stopped,
        other => return Err(LogError::damaged(format!("unknown outcome `{other}`"))),
    };
    let mut end = EndStatus::new(
        outcome,
        number(&take(&mut record, "t_end")?)?,
        &take(&mut record, "reason")?,
    );
    end.details = record.metadata.remove("details").unwrap_or_default();
    for (key, value) in record.metadata {
        if let Some(key) = key.strip_prefix(SUMMARY_PREFIX) {
            end.summary.insert(key.into(), value);
        }
    }
    Ok(end)
}

fn take(record: &mut Metadata, key: &str) -> Result<String, LogError> {
    let missing = || LogError::damaged(format!("metadata `{}` has no `{key}`", record.name));
    record.metadata.get(key).cloned().ok_or_else(missing).inspect(|_| {
        record.metadata.remove(key);
    })
}

fn number(text: &str) -> Result<f64, LogError> {
    text.parse().map_err(|_| LogError::damaged(format!("`{text}` is not a number")))
}
