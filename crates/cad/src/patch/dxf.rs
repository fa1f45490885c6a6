//! Edits of a DXF file, as splices of its bytes.

use std::ops::Range;

use bksim_model::diagnostic::Diagnostic;

use super::splice::{Splice, apply};
use super::{Edit, application, check_text, missing, no_attribute, no_entity, xdata};
use crate::drawing::Handle;
use crate::tags::{GroupValue, Tags, Writer};

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
                group.push(1, GroupValue::Text(value));
                splices.push(Splice::replace(tags, idx..idx + 1, group.finish()));
            }
        }
    }
    if splices.is_empty() { Err(no_attribute(insert, tag)) } else { Ok(splices) }
}
