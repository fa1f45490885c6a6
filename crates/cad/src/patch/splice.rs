//! Edits of a DXF file: some bytes make way for others.

use std::ops::Range;

use bksim_model::diagnostic::Diagnostic;

use super::{Edit, application, check_text, missing, no_attribute, no_entity, xdata};
use crate::drawing::Handle;
use crate::tags::{Tags, Value, Writer};

/// Bytes that take the place of others.
#[derive(Debug)]
pub(super) struct Splice {
    pub(super) range: Range<usize>,
    pub(super) bytes: Vec<u8>,
}

impl Splice {
    /// Adds bytes before the group `tag_idx`.
    pub(super) fn insert(tags: &Tags, tag_idx: usize, bytes: Vec<u8>) -> Self {
        let at = tags.span_of(tag_idx..tag_idx).start;
        Self { range: at..at, bytes }
    }

    /// Replaces groups.
    pub(super) fn replace(tags: &Tags, groups: Range<usize>, bytes: Vec<u8>) -> Self {
        Self { range: tags.span_of(groups), bytes }
    }
}

/// The file with one edit done.
pub(super) fn edited(tags: &Tags, edit: &Edit) -> Result<Vec<u8>, Diagnostic> {
    let mut splices = Vec::new();
    match edit {
        Edit::AddRecord { entity, kind, entries } => {
            splices.extend(application::register(tags));
            splices.push(xdata::add(tags, record(tags, *entity)?, kind, entries)?);
        }
        Edit::SetEntries { entity, record_idx, entries } => {
            splices.extend(xdata::set(tags, record(tags, *entity)?, *record_idx, entries)?);
        }
        Edit::RemoveRecord { entity, record_idx } => {
            splices.push(xdata::remove(tags, record(tags, *entity)?, *record_idx)?);
        }
        Edit::RemoveAll { entity } => {
            splices.push(xdata::remove_all(tags, record(tags, *entity)?)?);
        }
        Edit::SetAttribute { insert, tag, value } => {
            splices.extend(set_attribute(tags, *insert, tag, value)?);
        }
        Edit::RemoveInsert { insert } => {
            let whole = tags.compound(insert_record(tags, *insert)?);
            splices.push(Splice::replace(tags, whole, Vec::new()));
        }
    }
    Ok(apply(tags.bytes(), splices))
}

/// The bytes with the splices done; they do not overlap.
fn apply(bytes: &[u8], mut splices: Vec<Splice>) -> Vec<u8> {
    splices.sort_by_key(|splice| splice.range.start);
    let mut edited = Vec::with_capacity(bytes.len());
    let mut kept = 0;
    for splice in splices {
        edited.extend_from_slice(&bytes[kept..splice.range.start]);
        edited.extend_from_slice(&splice.bytes);
        kept = splice.range.end;
    }
    edited.extend_from_slice(&bytes[kept..]);
    edited
}

/// The record of an entity: not of a table, not of an object.
fn record(tags: &Tags, handle: Handle) -> Result<Range<usize>, Diagnostic> {
    let record = tags.record(handle).ok_or_else(|| no_entity(handle))?;
    let holds = |name: &str| {
        let mut named = tags.sections().iter().filter(|it| it.name.eq_ignore_ascii_case(name));
        named.any(|section| section.tags.contains(&record.start))
    };
    if holds("ENTITIES") || holds("BLOCKS") { Ok(record) } else { Err(no_entity(handle)) }
}

fn insert_record(tags: &Tags, handle: Handle) -> Result<Range<usize>, Diagnostic> {
    let record = record(tags, handle)?;
    if tags.is_word(record.start, "INSERT") {
        return Ok(record);
    }
    let kind = tags.text(record.start);
    Err(missing(format!(
        "the entity with the handle {:X} is a {}, no insert",
        handle.0,
        kind.trim()
    )))
}

/// Group 1 of the attributes with this tag, in its one-line and its several-line form.
fn set_attribute(
    tags: &Tags,
    insert: Handle,
    tag: &str,
    value: &str,
) -> Result<Vec<Splice>, Diagnostic> {
    check_text(value, tags.encode(value).len())?;
    let record = insert_record(tags, insert)?;
    let whole = tags.compound(record.clone());
    let mut splices = Vec::new();
    for attribute in tags.records(record.end..whole.end) {
        let own: Vec<usize> = attribute.take_while(|&idx| tags.code(idx) < 1000).collect();
        let is_named = |idx: &usize| tags.code(*idx) == 2 && tags.is_word(*idx, tag);
        if own.iter().any(is_named) {
            for &idx in own.iter().filter(|&&idx| tags.code(idx) == 1) {
                let mut group = Writer::new(tags);
                group.push(1, Value::Text(value));
                splices.push(Splice::replace(tags, idx..idx + 1, group.finish()));
            }
        }
    }
    if splices.is_empty() { Err(no_attribute(insert, tag)) } else { Ok(splices) }
}
