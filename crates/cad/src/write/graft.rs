//! New entities in a drawing that exists, every other byte of which stays as it is.
//!
//! ```text
//! canvas → small drawing of the same release → its LAYER and ENTITIES records, group by group
//!        → new handles, the target's owners    → before the end of the table, of the section
//! ```
//!
//! Apart from the insertions, one value changes: `$HANDSEED`, the next free handle.

use std::ops::Range;

use bksim_model::diagnostic::Diagnostic;

use super::canvas::{Canvas, Mark, Release, WriteError};
use crate::codes;
use crate::container::recognise;
use crate::drawing::Handle;
use crate::tags::{GroupValue, Tags, ValueType, Version, Writer};

/// Marks to add to a drawing, with their layers.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Addition {
    /// Names and colours.
    pub(super) layers: Vec<(&'static str, u8)>,
    /// With the layer of each.
    pub(super) marks: Vec<(&'static str, Mark)>,
}

impl Addition {
    /// Marks on one layer.
    pub(crate) fn on_layer(layer: &'static str, colour: u8, marks: Vec<Mark>) -> Self {
        let marks: Vec<_> = marks.into_iter().map(|mark| (layer, mark)).collect();
        Self { layers: vec![(layer, colour)], marks }
    }
}

/// Why nothing was added.
#[derive(Debug)]
pub enum Ungrafted {
    /// The drawing lacks the section that the entities would stand in.
    Drawing(Box<Diagnostic>),
    /// The new entities cannot be written.
    Write(WriteError),
}

impl From<WriteError> for Ungrafted {
    fn from(error: WriteError) -> Self {
        Self::Write(error)
    }
}

impl From<Diagnostic> for Ungrafted {
    fn from(fault: Diagnostic) -> Self {
        Self::Drawing(Box::new(fault))
    }
}

/// Adds marks to a drawing; returns the bytes of the file.
///
/// # Errors
/// [`Ungrafted`].
pub fn graft(target: &Tags, addition: &Addition) -> Result<Vec<u8>, Ungrafted> {
    let scion = scion(target.version(), addition)?;
    let entities = target.section("ENTITIES").filter(|section| section.is_closed);
    let entities = entities.ok_or_else(|| {
        Diagnostic::error(codes::NO_ROOM, "the drawing has no section ENTITIES to draw in")
    })?;
    let mut grafting = Grafting::new(target, &scion);

    // Both are collected in file order of the target: tables come before entities.
    let mut inserts: Vec<(usize, Vec<u8>)> = Vec::new();
    if let Some(table) = table(target, "LAYER") {
        let mut writer = Writer::new(target);
        grafting.layers(&table, &mut writer);
        inserts.push((target.span(table.end).start, writer.finish()));
    }
    let mut writer = Writer::new(target);
    for record in scion.records(own_entities(&scion)) {
        grafting.entity(record, &mut writer);
    }
    inserts.push((target.span(entities.tags.end).start, writer.finish()));
    let seed = target.header("$HANDSEED").filter(|_| grafting.has_handles);
    Ok(spliced(target, inserts, seed.map(|tag_idx| (tag_idx, grafting.next))))
}

/// The additions as a drawing of their own.
fn scion(version: Version, addition: &Addition) -> Result<Tags, Ungrafted> {
    let release = Release::ALL.into_iter().rev().find(|(.., tag)| {
        tag.trim_start_matches("AC").parse().is_ok_and(|number: u16| number <= version.0)
    });
    // R13 and R14 have the entities of R2000.
    let release = match release {
        Some((Release::R12, ..)) if version > Version::R12 => Release::R2000,
        Some((release, ..)) => release,
        None => Release::R12,
    };
    let mut canvas = Canvas::new(release, "mm")?;
    for &(name, colour) in &addition.layers {
        canvas.layer(name, colour);
    }
    for (layer, mark) in &addition.marks {
        canvas.draw(layer, mark.clone())?;
    }
    let bytes = canvas.bytes()?;
    let container = recognise(&bytes)?;
    Ok(Tags::scan(bytes, container)?)
}

/// The groups of the additions' entities.
fn own_entities(scion: &Tags) -> Range<usize> {
    scion.section("ENTITIES").expect("a canvas has entities").tags.clone()
}

/// The records of a table, its head first, up to its `ENDTAB`.
fn table(tags: &Tags, name: &str) -> Option<Range<usize>> {
    let tables = tags.section("TABLES")?.tags.clone();
    let mut records = tags.records(tables);
    let head = records.find(|record| {
        let mut groups = record.clone().skip(1);
        tags.is_word(record.start, "TABLE")
            && groups.any(|idx| tags.code(idx) == 2 && tags.is_word(idx, name))
    })?;
    let end = records.find(|record| tags.is_word(record.start, "ENDTAB"))?;
    Some(head.start..end.start)
}

/// The first value of a code in a record.
fn value(tags: &Tags, mut record: Range<usize>, code: i16) -> Option<usize> {
    record.find(|&idx| tags.code(idx) == code)
}

/// Carries records over.
struct Grafting<'a> {
    target: &'a Tags,
    scion: &'a Tags,
    /// The next free handle.
    next: Handle,
    /// Old drawings may go without.
    has_handles: bool,
    /// The block record of the model space.
    space: Option<String>,
}

impl<'a> Grafting<'a> {
    fn new(target: &'a Tags, scion: &'a Tags) -> Self {
        let seed = target.header("$HANDSEED").and_then(|idx| target.handle(idx));
        let largest = target.largest_handle().map_or(0, |handle| handle.0);
        let next = Handle(seed.map_or(0, |seed| seed.0).max(largest + 1));
        let is_old = target.version() <= Version::R12;
        let is_handled = target.header("$HANDLING").and_then(|idx| target.integer(idx));
        let has_handles = !is_old || (is_handled != Some(0) && target.largest_handle().is_some());
        let space = table(target, "BLOCK_RECORD").and_then(|table| {
            let mut records = target.records(table);
            let space = records.find(|record| {
                let name = value(target, record.clone(), 2);
                name.is_some_and(|idx| target.is_word(idx, "*MODEL_SPACE"))
            })?;
            target.handle_of(space).map(|handle| format!("{:X}", handle.0))
        });
        Self { target, scion, next, has_handles, space }
    }

    fn fresh(&mut self) -> String {
        let handle = self.next;
        self.next.0 += 1;
        format!("{:X}", handle.0)
    }

    /// The layers that the target lacks.
    fn layers(&mut self, table: &Range<usize>, writer: &mut Writer<'_>) {
        let Some(own) = self::table(self.scion, "LAYER") else { return };
        let target = self.target;
        let mut records = target.records(table.clone());
        let head = records.next().unwrap_or(table.clone());
        let owner = target.handle_of(head).map(|handle| format!("{:X}", handle.0));
        let known: Vec<Range<usize>> =
            records.filter(|record| target.is_word(record.start, "LAYER")).collect();
        for record in self.scion.records(own).skip(1) {
            let Some(name) = value(self.scion, record.clone(), 2) else { continue };
            let name = self.scion.text(name);
            let is_name = |other: &Range<usize>| {
                let other = value(target, other.clone(), 2);
                other.is_some_and(|idx| target.text(idx).eq_ignore_ascii_case(&name))
            };
            if name == "0" || known.iter().any(is_name) {
                continue;
            }
            let like = known.first().cloned().unwrap_or(0..0);
            self.record(record, writer, owner.as_deref(), &like);
        }
    }

    fn entity(&mut self, record: Range<usize>, writer: &mut Writer<'_>) {
        let space = self.space.clone();
        self.record(record, writer, space.as_deref(), &(0..0));
    }

    /// Copies a record with a new handle; the styles it refers to are taken from `like`, a record of the
    /// target, or left out.
    fn record(
        &mut self,
        record: Range<usize>,
        writer: &mut Writer<'_>,
        owner: Option<&str>,
        like: &Range<usize>,
    ) {
        /// Material, plot style and visual style of a layer.
        const STYLES: [i16; 3] = [347, 390, 348];
        let has_own = value(self.scion, record.clone(), 5).is_some();
        for idx in record.clone() {
            let code = self.scion.code(idx);
            match code {
                5 if self.has_handles => {
                    let handle = self.fresh();
                    writer.push(5, GroupValue::Text(&handle));
                }
                330 => {
                    if let Some(owner) = owner {
                        writer.push(330, GroupValue::Text(owner));
                    }
                }
                _ if STYLES.contains(&code) => {
                    if let Some(idx) = value(self.target, like.clone(), code) {
                        writer.push(code, GroupValue::Text(self.target.text(idx).trim()));
                    }
                }
                // The style of texts is the standard one anyway; old handles mean nothing here.
                5 | 7 => (),
                _ => self.group(idx, writer),
            }
            if idx == record.start && self.has_handles && !has_own {
                let handle = self.fresh();
                writer.push(5, GroupValue::Text(&handle));
            }
        }
    }

    fn group(&self, idx: usize, writer: &mut Writer<'_>) {
        let code = self.scion.code(idx);
        match ValueType::of(code) {
            ValueType::Real => {
                let number = self.scion.number(idx).expect("a canvas writes numbers");
                writer.push(code, GroupValue::Real(number));
            }
            ValueType::Text | ValueType::Chunk => {
                writer.push(code, GroupValue::Text(self.scion.text(idx).as_ref()));
            }
            _ => {
                let number = self.scion.integer(idx).expect("a canvas writes integers");
                writer.push(code, GroupValue::Integer(number));
            }
        }
    }
}

/// The bytes of the target with some inserted and its next handle replaced.
fn spliced(
    target: &Tags,
    mut inserts: Vec<(usize, Vec<u8>)>,
    seed: Option<(usize, Handle)>,
) -> Vec<u8> {
    let mut cuts: Vec<(Range<usize>, Vec<u8>)> =
        inserts.drain(..).map(|(at, bytes)| (at..at, bytes)).collect();
    if let Some((tag_idx, next)) = seed {
        let mut writer = Writer::new(target);
        writer.push(5, GroupValue::Text(&format!("{:X}", next.0)));
        cuts.push((target.span(tag_idx), writer.finish()));
    }
    cuts.sort_by_key(|(range, _)| range.start);
    let bytes = target.bytes();
    let mut out =
        Vec::with_capacity(bytes.len() + cuts.iter().map(|(_, new)| new.len()).sum::<usize>());
    let mut done = 0;
    for (range, new) in cuts {
        out.extend_from_slice(&bytes[done..range.start]);
        out.extend_from_slice(&new);
        done = range.end;
    }
    out.extend_from_slice(&bytes[done..]);
    out
}
