//! Edits of a DWG file: on what the library read of it, written again.

use std::panic::{AssertUnwindSafe, catch_unwind};

use acadrust::entities::EntityType;
use acadrust::tables::AppId;
use acadrust::types::{Handle as Key, Vector3};
use acadrust::xdata::{ExtendedDataRecord, XDataValue};
use acadrust::{CadDocument, DwgWriter};
use bksim_model::diagnostic::Diagnostic;

use super::{Edit, Entry, check_text, missing, no_attribute, no_entity, no_record};
use crate::codes;
use crate::drawing::Handle;
use crate::kind::APPLICATION;
use crate::open::read_dwg;

/// The drawing with its edits done.
pub(super) fn apply(bytes: Vec<u8>, release: &str, edits: &[Edit]) -> Result<Vec<u8>, Diagnostic> {
    let mut document = read_dwg(bytes, release)?;
    for edit in edits {
        change(&mut document, edit)?;
    }
    let write = || DwgWriter::write_to_vec(&document);
    if let Ok(Ok(bytes)) = catch_unwind(AssertUnwindSafe(write)) {
        return Ok(bytes);
    }
    let message = format!("the DWG drawing of {release} cannot be written");
    Err(Diagnostic::error(codes::DOES_NOT_FIT, message).help("save it as DXF, and edit that"))
}

fn change(document: &mut CadDocument, edit: &Edit) -> Result<(), Diagnostic> {
    match edit {
        Edit::AddRecord { entity, kind, entries } => {
            register(document);
            let mut values = ours(document, *entity)?;
            values.extend([XDataValue::String(kind.clone()), control("{")]);
            for entry in entries {
                values.extend(entry_values(entry)?);
            }
            values.push(control("}"));
            store(document, *entity, values)
        }
        Edit::SetEntries { entity, record_idx, entries } => {
            let mut values = ours(document, *entity)?;
            let none = || no_record(*entity, *record_idx);
            for (key, entry) in entries {
                let (start, end) = nth_record(&values, *record_idx).ok_or_else(none)?;
                let inner = start + 2..end - 1;
                let changed = with_entry(&values[inner.clone()], key, entry.as_ref())?;
                values.splice(inner, changed);
            }
            store(document, *entity, values)
        }
        Edit::RemoveRecord { entity, record_idx } => {
            let mut values = ours(document, *entity)?;
            let none = || no_record(*entity, *record_idx);
            let (start, end) = nth_record(&values, *record_idx).ok_or_else(none)?;
            values.drain(start..end);
            store(document, *entity, values)
        }
        Edit::RemoveAll { entity } if ours(document, *entity)?.is_empty() => {
            Err(no_record(*entity, 0))
        }
        Edit::RemoveAll { entity } => store(document, *entity, Vec::new()),
        Edit::SetAttribute { insert, tag, value } => set_attribute(document, *insert, tag, value),
        Edit::RemoveInsert { insert } => remove_insert(document, *insert),
    }
}

/// The entries of a record with one changed or removed; one that was not there comes last.
fn with_entry(
    entries: &[XDataValue],
    key: &str,
    entry: Option<&Entry>,
) -> Result<Vec<XDataValue>, Diagnostic> {
    let mut new = entry.map_or(Ok(Vec::new()), entry_values)?;
    let mut all = Vec::new();
    for old in split_entries(entries) {
        // An entry that stands there twice is one afterwards.
        if has_key(old, key) {
            all.append(&mut new);
        } else {
            all.extend_from_slice(old);
        }
    }
    all.append(&mut new);
    Ok(all)
}

fn key(handle: Handle) -> Key {
    Key::new(handle.0)
}

fn entity(document: &mut CadDocument, handle: Handle) -> Result<&mut EntityType, Diagnostic> {
    document.get_entity_mut(key(handle)).ok_or_else(|| no_entity(handle))
}

fn register(document: &mut CadDocument) {
    if document.app_ids.get(APPLICATION).is_none() {
        let mut application = AppId::new(APPLICATION);
        application.handle = document.allocate_handle();
        document.app_ids.add_or_replace(application);
    }
}

/// The values of our extended data on an entity.
fn ours(document: &CadDocument, handle: Handle) -> Result<Vec<XDataValue>, Diagnostic> {
    let entity = document.get_entity(key(handle)).ok_or_else(|| no_entity(handle))?;
    let record = entity.common().extended_data.get_record(APPLICATION);
    Ok(record.map_or_else(Vec::new, |record| record.values.clone()))
}

/// Replaces our extended data on an entity; none at all for no values.
fn store(
    document: &mut CadDocument,
    handle: Handle,
    values: Vec<XDataValue>,
) -> Result<(), Diagnostic> {
    let application = document.app_ids.get(APPLICATION).map(|it| it.handle.value());
    let data = &mut entity(document, handle)?.common_mut().extended_data;
    // The data that were read are kept as bytes too, and those would win.
    data.raw_dwg_eed.retain(|(owner, _)| Some(*owner) != application);
    let others: Vec<ExtendedDataRecord> =
        data.records().iter().filter(|it| it.application_name != APPLICATION).cloned().collect();
    let raw = std::mem::take(&mut data.raw_dwg_eed);
    *data = acadrust::xdata::ExtendedData::new();
    data.raw_dwg_eed = raw;
    for record in others {
        data.add_record(record);
    }
    if !values.is_empty() {
        let mut record = ExtendedDataRecord::new(APPLICATION);
        record.values = values;
        data.add_record(record);
    }
    Ok(())
}

fn control(bracket: &str) -> XDataValue {
    XDataValue::ControlString(bracket.to_owned())
}

fn is_control(value: &XDataValue, bracket: &str) -> bool {
    matches!(value, XDataValue::ControlString(text) if text == bracket)
}

/// Where a record begins and ends: its kind, `{`, entries, `}`.
fn nth_record(values: &[XDataValue], n: usize) -> Option<(usize, usize)> {
    let mut start = 0;
    for number in 0..=n {
        let is_record = values.get(start + 1).is_some_and(|it| is_control(it, "{"));
        let length = values.get(start..)?.iter().position(|it| is_control(it, "}"))? + 1;
        if !is_record {
            return None;
        }
        if number == n {
            return Some((start, start + length));
        }
        start += length;
    }
    None
}

/// The entries of a record: a text, and the values up to the next one.
fn split_entries(values: &[XDataValue]) -> impl Iterator<Item = &[XDataValue]> {
    values.chunk_by(|_, next| !matches!(next, XDataValue::String(_)))
}

fn has_key(entry: &[XDataValue], key: &str) -> bool {
    matches!(entry.first(), Some(XDataValue::String(text))
        if text.split('=').next().unwrap_or(text).trim().eq_ignore_ascii_case(key))
}

fn entry_values(entry: &Entry) -> Result<Vec<XDataValue>, Diagnostic> {
    let vector = |[x, y]: [f64; 2]| Vector3::new(x, y, 0.0);
    let name = |key: &String| XDataValue::String(key.clone());
    Ok(match entry {
        Entry::Text { key, value } => {
            let text = format!("{key}={value}");
            check_text(&text, text.len())?;
            vec![XDataValue::String(text)]
        }
        Entry::Point { key, point } => vec![name(key), XDataValue::Position3D(vector(*point))],
        Entry::Direction { key, direction } => {
            vec![name(key), XDataValue::Direction3D(vector(*direction))]
        }
    })
}

fn set_attribute(
    document: &mut CadDocument,
    handle: Handle,
    tag: &str,
    value: &str,
) -> Result<(), Diagnostic> {
    check_text(value, value.len())?;
    let EntityType::Insert(insert) = entity(document, handle)? else {
        return Err(missing(format!("the entity with the handle {:X} is no insert", handle.0)));
    };
    let named = insert.attributes.iter_mut().filter(|it| it.tag.eq_ignore_ascii_case(tag));
    let n_set = named.map(|attribute| value.clone_into(&mut attribute.value)).count();
    if n_set == 0 { Err(no_attribute(handle, tag)) } else { Ok(()) }
}

fn remove_insert(document: &mut CadDocument, handle: Handle) -> Result<(), Diagnostic> {
    if !matches!(entity(document, handle)?, EntityType::Insert(_)) {
        return Err(missing(format!("the entity with the handle {:X} is no insert", handle.0)));
    }
    document.remove_entity(key(handle)).ok_or_else(|| no_entity(handle))?;
    let names: Vec<String> = document.block_records.iter().map(|it| it.name.clone()).collect();
    for name in names {
        if let Some(block) = document.block_records.get_mut(&name) {
            block.entity_handles.retain(|owned| *owned != key(handle));
        }
    }
    Ok(())
}
