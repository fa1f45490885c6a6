//! The name of our application in the table `APPID`: without it, CAD programs refuse the file.

use std::ops::Range;

use super::splice::Splice;
use crate::drawing::Handle;
use crate::kind::APPLICATION;
use crate::tags::{GroupValue, Tags, Version, Writer};

/// The splices that register the application: none if it is registered.
pub(super) fn register(tags: &Tags) -> Vec<Splice> {
    let Some(table) = table(tags) else { return with_new_table(tags) };
    let records: Vec<Range<usize>> = tags.records(table.clone()).collect();
    let is_ours = |record: &Range<usize>| {
        let mut own = record.clone();
        tags.is_word(record.start, "APPID")
            && own.any(|idx| tags.code(idx) == 2 && tags.is_word(idx, APPLICATION))
    };
    if records.iter().any(is_ours) {
        return Vec::new();
    }
    let head = records.first().cloned().unwrap_or(table.start..table.start);
    let owner = tags.handle_of(head);
    // In R12 handles are optional: as the others of the table have it.
    let has_handles = tags.version() > Version::R12
        || records
            .iter()
            .any(|it| tags.is_word(it.start, "APPID") && tags.handle_of(it.clone()).is_some());
    let mut fresh = Fresh::new(tags);
    let mut out = Writer::new(tags);
    push_entry(tags, &mut out, has_handles.then(|| fresh.take()), owner);
    let mut splices = vec![Splice::insert(tags, table.end, out.finish())];
    splices.extend(fresh.seed(tags));
    splices
}

/// The groups of the table `APPID`, its `ENDTAB` excluded.
fn table(tags: &Tags) -> Option<Range<usize>> {
    let section = tags.section("TABLES")?;
    let is_ours = |record: &Range<usize>| {
        let name = record.clone().find(|&idx| tags.code(idx) == 2);
        tags.is_word(record.start, "TABLE") && name.is_some_and(|idx| tags.is_word(idx, "APPID"))
    };
    let head = tags.records(section.tags.clone()).find(is_ours)?;
    let mut rest = tags.records(head.end..section.tags.end);
    let end = rest.find(|record| tags.is_word(record.start, "ENDTAB"))?;
    Some(head.start..end.start)
}

/// The table is missing, as in drawings written by hand: it is added with its section.
fn with_new_table(tags: &Tags) -> Vec<Splice> {
    let has_handles = tags.version() > Version::R12;
    let mut fresh = Fresh::new(tags);
    let mut out = Writer::new(tags);
    let section = tags.section("TABLES").map(|section| section.tags.end);
    if section.is_none() {
        out.push(0, GroupValue::Text("SECTION")).push(2, GroupValue::Text("TABLES"));
    }
    out.push(0, GroupValue::Text("TABLE")).push(2, GroupValue::Text("APPID"));
    let owner = has_handles.then(|| fresh.take());
    if let Some(owner) = owner {
        out.push(5, GroupValue::Text(&hex(owner))).push(330, GroupValue::Text("0"));
        out.push(100, GroupValue::Text("AcDbSymbolTable"));
    }
    out.push(70, GroupValue::Integer(1));
    push_entry(tags, &mut out, has_handles.then(|| fresh.take()), owner);
    out.push(0, GroupValue::Text("ENDTAB"));
    if section.is_none() {
        out.push(0, GroupValue::Text("ENDSEC"));
    }
    // Tables come before blocks, and blocks before entities.
    let first = ["BLOCKS", "ENTITIES"].iter().find_map(|name| tags.section(name));
    let before = first.map_or(0, |section| section.tags.start - 2);
    let mut splices = vec![Splice::insert(tags, section.unwrap_or(before), out.finish())];
    splices.extend(fresh.seed(tags));
    splices
}

fn push_entry(tags: &Tags, out: &mut Writer<'_>, handle: Option<Handle>, owner: Option<Handle>) {
    out.push(0, GroupValue::Text("APPID"));
    if let Some(handle) = handle {
        out.push(5, GroupValue::Text(&hex(handle)));
    }
    // From R13 on every record names its owner and its classes.
    if tags.version() > Version::R12 {
        if let Some(owner) = owner {
            out.push(330, GroupValue::Text(&hex(owner)));
        }
        out.push(100, GroupValue::Text("AcDbSymbolTableRecord"));
        out.push(100, GroupValue::Text("AcDbRegAppTableRecord"));
    }
    out.push(2, GroupValue::Text(APPLICATION)).push(70, GroupValue::Integer(0));
}

fn hex(handle: Handle) -> String {
    format!("{:X}", handle.0)
}

/// Handles that nothing in the drawing has yet.
struct Fresh {
    next: u64,
    is_used: bool,
}

impl Fresh {
    fn new(tags: &Tags) -> Self {
        let seed = tags.header("$HANDSEED").and_then(|idx| tags.handle(idx));
        let largest = tags.largest_handle().map_or(0, |handle| handle.0);
        let next = seed.map_or(0, |handle| handle.0).max(largest.saturating_add(1)).max(1);
        Self { next, is_used: false }
    }

    fn take(&mut self) -> Handle {
        self.is_used = true;
        self.next += 1;
        Handle(self.next - 1)
    }

    /// The header's next handle, raised.
    fn seed(&self, tags: &Tags) -> Option<Splice> {
        let idx = tags.header("$HANDSEED").filter(|_| self.is_used)?;
        Some(Splice { range: tags.value_span(idx), bytes: hex(Handle(self.next)).into_bytes() })
    }
}
