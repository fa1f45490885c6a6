//! Records of our extended data, as groups of a DXF file.

use std::ops::Range;

use bksim_model::diagnostic::Diagnostic;

use super::splice::Splice;
use super::{Entry, LONGEST_TEXT, MOST_XDATA, check_text, no_record};
use crate::codes;
use crate::drawing::Handle;
use crate::kind::APPLICATION;
use crate::tags::{GroupValue, Tags, Writer};

/// Adds a record to an entity.
pub(super) fn add(
    tags: &Tags,
    entity: Range<usize>,
    kind: &str,
    entries: &[Entry],
) -> Result<Splice, Diagnostic> {
    let mut out = Writer::new(tags);
    let ours = ours(tags, entity.clone());
    if ours.is_none() {
        out.push(1001, GroupValue::Text(APPLICATION));
    }
    out.push(1000, GroupValue::Text(kind)).push(1002, GroupValue::Text("{"));
    for entry in entries {
        push(tags, &mut out, entry)?;
    }
    out.push(1002, GroupValue::Text("}"));
    let bytes = out.finish();
    check_size(tags, entity.clone(), bytes.len())?;
    Ok(Splice::insert(tags, ours.map_or(entity.end, |ours| ours.end), bytes))
}

/// Changes entries of a record.
pub(super) fn set(
    tags: &Tags,
    entity: Range<usize>,
    record_idx: usize,
    changes: &[(String, Option<Entry>)],
) -> Result<Vec<Splice>, Diagnostic> {
    let record = nth_record(tags, entity.clone(), record_idx)?;
    // Between the opening and the closing bracket.
    let inner = record.start + 2..record.end - 1;
    let mut splices = Vec::new();
    let mut added = Writer::new(tags);
    for (key, entry) in changes {
        let known: Vec<Range<usize>> =
            entries(tags, inner.clone()).filter(|it| has_key(tags, it, key)).collect();
        let mut out = Writer::new(tags);
        if let Some(entry) = entry {
            push(tags, if known.is_empty() { &mut added } else { &mut out }, entry)?;
        }
        let mut bytes = out.finish();
        // An entry that stands there twice is one afterwards.
        for known in known {
            splices.push(Splice::replace(tags, known, std::mem::take(&mut bytes)));
        }
    }
    let added = added.finish();
    let n_new = added.len() + splices.iter().map(|splice| splice.bytes.len()).sum::<usize>();
    check_size(tags, entity, n_new)?;
    splices.push(Splice::insert(tags, inner.end, added));
    Ok(splices)
}

/// Removes a record, and with the last one the name of the application.
pub(super) fn remove(
    tags: &Tags,
    entity: Range<usize>,
    record_idx: usize,
) -> Result<Splice, Diagnostic> {
    let record = nth_record(tags, entity.clone(), record_idx)?;
    let whole = ours(tags, entity).unwrap_or(record.clone());
    let is_all = whole.start + 1 == record.start && whole.end == record.end;
    Ok(Splice::replace(tags, if is_all { whole } else { record }, Vec::new()))
}

/// Removes whatever stands under the name of the application.
pub(super) fn remove_all(tags: &Tags, entity: Range<usize>) -> Result<Splice, Diagnostic> {
    let handle = tags.handle_of(entity.clone()).unwrap_or(Handle(0));
    let whole = ours(tags, entity).ok_or_else(|| no_record(handle, 0))?;
    Ok(Splice::replace(tags, whole, Vec::new()))
}

/// Our extended data on an entity, the name of the application included.
fn ours(tags: &Tags, entity: Range<usize>) -> Option<Range<usize>> {
    let is_application = |idx: &usize| tags.code(*idx) == 1001;
    let start =
        entity.clone().find(|idx| is_application(idx) && tags.is_word(*idx, APPLICATION))?;
    let end = (start + 1..entity.end).find(is_application).unwrap_or(entity.end);
    Some(start..end)
}

/// A record: its kind, `{`, entries, `}`.
fn nth_record(tags: &Tags, entity: Range<usize>, n: usize) -> Result<Range<usize>, Diagnostic> {
    let handle = tags.handle_of(entity.clone()).unwrap_or(Handle(0));
    let none = || no_record(handle, n);
    let ours = ours(tags, entity).ok_or_else(none)?;
    let mut start = ours.start + 1;
    for number in 0..=n {
        let is_record = start + 1 < ours.end
            && tags.code(start) == 1000
            && tags.code(start + 1) == 1002
            && tags.is_word(start + 1, "{");
        let closes = |idx: &usize| tags.code(*idx) == 1002 && tags.is_word(*idx, "}");
        let end = (start..ours.end).find(closes).filter(|_| is_record).ok_or_else(none)? + 1;
        if number == n {
            return Ok(start..end);
        }
        start = end;
    }
    Err(none())
}

/// The entries of a record: a text, and the groups up to the next one.
fn entries(tags: &Tags, inner: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let starts = inner.clone().filter(|&idx| tags.code(idx) == 1000);
    let ends = starts.clone().skip(1).chain(std::iter::once(inner.end));
    starts.zip(ends).map(|(start, end)| start..end)
}

fn has_key(tags: &Tags, entry: &Range<usize>, key: &str) -> bool {
    let text = tags.text(entry.start);
    let own = text.split_once('=').map_or(&*text, |(key, _)| key);
    own.trim().eq_ignore_ascii_case(key)
}

fn push(tags: &Tags, out: &mut Writer<'_>, entry: &Entry) -> Result<(), Diagnostic> {
    let mut point = |key: &str, code: i16, [x, y]: [f64; 2]| {
        out.push(1000, GroupValue::Text(key));
        out.push(code, GroupValue::Real(x)).push(code + 10, GroupValue::Real(y));
        out.push(code + 20, GroupValue::Real(0.0));
    };
    match entry {
        Entry::Text { key, value } => {
            let text = format!("{key}={value}");
            check_text(&text, tags.encode(&text).len())?;
            out.push(1000, GroupValue::Text(&text));
        }
        Entry::Point { key, point: at } => point(key, 1011, *at),
        Entry::Direction { key, direction } => point(key, 1013, *direction),
    }
    Ok(())
}

/// Checks that the extended data of an entity stay within what the format allows.
fn check_size(tags: &Tags, entity: Range<usize>, n_new: usize) -> Result<(), Diagnostic> {
    let foreign = entity.clone().find(|&idx| tags.code(idx) >= 1000).unwrap_or(entity.end);
    let size = tags.span_of(foreign..entity.end).len() + n_new;
    if size <= MOST_XDATA {
        return Ok(());
    }
    let message = format!("the extended data of the entity would take {size} bytes");
    Err(Diagnostic::error(codes::DOES_NOT_FIT, message)
        .note(format!("an entity has at most {MOST_XDATA}, in texts of {LONGEST_TEXT}"))
        .help("attach some of it to another entity"))
}
