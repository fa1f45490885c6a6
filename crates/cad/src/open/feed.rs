//! The part of a drawing that is interpreted, as a small drawing of its own.
//!
//! A drawing holds far more than a mechanism needs: objects, plot settings, previews, solids in
//! foreign formats. Only what is of use goes on: the names of layers and blocks, plane geometry,
//! texts, inserts and our own extended data; of any other entity its type, handle and layer.
//! The rest can neither fail nor exhaust the memory.

use std::ops::Range;

use crate::drawing::Handle;
use crate::kind::APPLICATION;
use crate::tags::{GroupValue, Tags, ValueType, Version, Writer};

/// Entities that are read whole.
#[rustfmt::skip]
const READ: &[&str] = &[
    "ARC",
    "ATTDEF",
    "ATTRIB",
    "BLOCK",
    "CIRCLE",
    "3DFACE",
    "ELLIPSE",
    "HATCH",
    "INSERT",
    "LINE",
    "LWPOLYLINE",
    "MTEXT",
    "POINT",
    "POLYLINE",
    "SEQEND",
    "SOLID",
    "SPLINE",
    "TEXT",
    "TRACE",
    "VERTEX",
];

/// Groups that are kept of any other entity: what it is, its handle, owner and layer.
const HEAD: &[i16] = &[0, 5, 8, 330];

/// Groups that are kept of an entry of a table: handle, name, flags, colour and subclass.
const ENTRY: &[i16] = &[0, 2, 5, 62, 70, 100];

/// Tables that are kept.
const TABLES: &[&str] = &["LAYER", "BLOCK_RECORD"];

/// Versions that are interpreted.
const VERSIONS: &[u16] = &[1009, 1012, 1014, 1015, 1018, 1021, 1024, 1027, 1032];

/// Handles from here on stand for records without a handle of their own.
const MADE_UP: u64 = 1 << 44;
/// Handles from here on stand for ends of blocks that the file lacks.
const ENDS: u64 = 1 << 45;

/// A record of a section with entities.
#[derive(Clone, Debug)]
pub(super) struct Record {
    /// Groups of the record.
    pub(super) tags: Range<usize>,
    /// True if it is one of those that are read whole.
    pub(super) is_read: bool,
}

impl Tags {
    /// The handle under which the interpreted drawing knows the record that begins at `start`: its
    /// own, or a made-up one where it has none or shares it with an earlier record.
    pub fn known_handle(&self, record: Range<usize>) -> Handle {
        let made_up = Handle(MADE_UP + record.start as u64);
        let own = self.handle_of(record.clone()).filter(|own| own.0 != 0 && own.0 < MADE_UP);
        own.filter(|&own| self.record(own).is_some_and(|first| first.start == record.start))
            .unwrap_or(made_up)
    }

    /// The record of a handle of the interpreted drawing, made-up ones included.
    pub fn known_record(&self, handle: Handle) -> Option<Range<usize>> {
        match handle.0.checked_sub(MADE_UP) {
            None => self.record(handle),
            Some(start) => self.record_from(usize::try_from(start).ok()?),
        }
    }

    /// The handle, unless it is made up and not in the file.
    pub fn own_handle(&self, handle: Handle) -> Option<Handle> {
        (handle.0 < MADE_UP).then_some(handle)
    }
}

/// The records of the sections `BLOCKS` or `ENTITIES`, without those of paper space.
pub(super) fn records(tags: &Tags, section: &str) -> Vec<Record> {
    let sections = tags.sections().iter().filter(|it| it.name.eq_ignore_ascii_case(section));
    let all = sections.flat_map(|section| tags.records(section.tags.clone()));
    // A block has an end whatever that says of paper, and nothing stands between two blocks.
    let (mut is_open, mut is_in_blocks) = (false, false);
    all.filter(|record| {
        if tags.is_word(record.start, "BLOCK") {
            (is_open, is_in_blocks) = (!is_on_paper(tags, record.clone()), true);
            return is_open;
        }
        if tags.is_word(record.start, "ENDBLK") {
            return std::mem::replace(&mut is_open, false);
        }
        !is_on_paper(tags, record.clone()) && (is_open || !is_in_blocks)
    })
    .map(|record| {
        let is_read = READ.iter().any(|name| tags.is_word(record.start, name));
        Record { tags: record, is_read }
    })
    .collect()
}

/// Group 67 of the entity itself is 1.
fn is_on_paper(tags: &Tags, record: Range<usize>) -> bool {
    record
        .take_while(|&idx| tags.code(idx) < 1000)
        .any(|idx| tags.code(idx) == 67 && tags.integer(idx) == Some(1))
}

/// The groups of a record that are interpreted, handle excluded.
pub(super) fn kept(tags: &Tags, record: &Record) -> Vec<usize> {
    let mut kept = Vec::with_capacity(record.tags.len());
    // In a group `{ACAD_REACTORS … }`; in an embedded object; in our extended data.
    let (mut in_group, mut in_embedded, mut in_ours) = (false, false, false);
    let mut in_head = true;
    for idx in record.tags.clone() {
        let code = tags.code(idx);
        match code {
            102 => in_group = tags.raw(idx).trim_ascii().starts_with(b"{"),
            101 => in_embedded = true,
            100 => in_head = tags.is_word(idx, "AcDbEntity"),
            1001 => {
                (in_group, in_embedded) = (false, false);
                in_ours = tags.is_word(idx, APPLICATION);
            }
            _ => (),
        }
        let is_wanted = match code {
            // The preview of an entity, what belongs to other programs; the handle is written again.
            5 | 102 | 105 | 160 | 310..=319 => false,
            92 => record.is_read && !in_head,
            1000.. => in_ours,
            _ => record.is_read || HEAD.contains(&code) || code == 100 && in_head,
        };
        if is_wanted && !in_group && (!in_embedded || in_ours) {
            kept.push(idx);
        }
    }
    kept
}

/// The drawing to be interpreted, in the form of the file.
pub(super) fn feed(tags: &Tags) -> Vec<u8> {
    let mut out = Writer::new(tags);
    if let crate::container::Container::Binary { .. } = tags.container() {
        out.begin(crate::container::SENTINEL);
    }
    header(tags, &mut out);
    tables(tags, &mut out);
    let paper = paper_spaces(tags);
    for section in ["BLOCKS", "ENTITIES"] {
        out.push(0, GroupValue::Text("SECTION")).push(2, GroupValue::Text(section));
        // What stands among the entities is in the model space, whatever that is called, unless its
        // owner is a sheet of paper.
        let is_left_out = |idx: usize| {
            tags.code(idx) == 330 && tags.handle(idx).is_some_and(|it| !paper.contains(&it))
        };
        let is_left_out = |idx: usize| section == "ENTITIES" && is_left_out(idx);
        let mut open = None;
        for record in records(tags, section) {
            let start = record.tags.start;
            if tags.is_word(start, "BLOCK")
                && let Some(unended) = open.replace(start)
            {
                end_of_block(unended, &mut out);
            }
            if tags.is_word(start, "ENDBLK") {
                open = None;
            }
            entity(tags, &record, &mut out, is_left_out);
        }
        if let Some(unended) = open {
            end_of_block(unended, &mut out);
        }
        out.push(0, GroupValue::Text("ENDSEC"));
    }
    out.push(0, GroupValue::Text("EOF"));
    out.finish()
}

/// The end of a block that has none in the file.
fn end_of_block(block: usize, out: &mut Writer<'_>) {
    let handle = ENDS + block as u64;
    out.push(0, GroupValue::Text("ENDBLK"));
    out.push(5, GroupValue::Text(&format!("{handle:X}"))).push(8, GroupValue::Text("0"));
}

fn header(tags: &Tags, out: &mut Writer<'_>) {
    let Version(number) = tags.version();
    let version = VERSIONS.iter().rev().find(|&&known| known <= number).unwrap_or(&1009);
    out.push(0, GroupValue::Text("SECTION")).push(2, GroupValue::Text("HEADER"));
    out.push(9, GroupValue::Text("$ACADVER")).push(1, GroupValue::Text(&format!("AC{version}")));
    if let Some(page) = tags.header("$DWGCODEPAGE").filter(|&idx| tags.code(idx) == 3) {
        out.push(9, GroupValue::Text("$DWGCODEPAGE")).copy(&tags.bytes()[tags.span(page)]);
    }
    out.push(0, GroupValue::Text("ENDSEC"));
}

fn tables(tags: &Tags, out: &mut Writer<'_>) {
    out.push(0, GroupValue::Text("SECTION")).push(2, GroupValue::Text("TABLES"));
    let all = tags.section("TABLES").map_or(0..0, |section| section.tags.clone());
    let mut is_kept = false;
    for record in tags.records(all) {
        if tags.is_word(record.start, "TABLE") {
            let name = record.clone().find(|&idx| tags.code(idx) == 2);
            is_kept = name.is_some_and(|idx| TABLES.iter().any(|name| tags.is_word(idx, name)));
        }
        if is_kept {
            let is_known = tags.known_handle(record.clone()).0 < MADE_UP;
            for idx in record.take_while(|&idx| tags.code(idx) < 1000) {
                let code = tags.code(idx);
                let is_number =
                    ValueType::of(code) == ValueType::Text || tags.integer(idx).is_some();
                if ENTRY.contains(&code) && is_number && (code != 5 || is_known) {
                    out.copy(&tags.bytes()[tags.span(idx)]);
                }
            }
        }
    }
    out.push(0, GroupValue::Text("ENDSEC"));
}

/// Handles of the block records that are sheets of paper.
fn paper_spaces(tags: &Tags) -> Vec<Handle> {
    let all = tags.section("TABLES").map_or(0..0, |section| section.tags.clone());
    let blocks = tags.records(all).filter(|record| tags.is_word(record.start, "BLOCK_RECORD"));
    let is_paper = |record: &Range<usize>| {
        let name = record.clone().find(|&idx| tags.code(idx) == 2);
        name.is_some_and(|idx| tags.text(idx).trim().to_uppercase().starts_with("*PAPER_SPACE"))
    };
    blocks.filter(is_paper).filter_map(|record| tags.handle_of(record)).collect()
}

fn entity(tags: &Tags, record: &Record, out: &mut Writer<'_>, is_left_out: impl Fn(usize) -> bool) {
    let handle = tags.known_handle(record.tags.clone());
    if tags.is_word(record.tags.start, "ENDBLK") {
        // Whatever else stands there, some of it twice, says nothing.
        out.push(0, GroupValue::Text("ENDBLK"));
        out.push(5, GroupValue::Text(&format!("{:X}", handle.0))).push(8, GroupValue::Text("0"));
        return;
    }
    for idx in kept(tags, record).into_iter().filter(|&idx| !is_left_out(idx)) {
        out.copy(&tags.bytes()[tags.span(idx)]);
        if idx == record.tags.start {
            out.push(5, GroupValue::Text(&format!("{:X}", handle.0)));
        }
    }
}
