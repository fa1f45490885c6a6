//! [`Tags`]: a DXF drawing as its group codes and values, with the position of each in the file.
//!
//! Nothing here knows what an entity is: that is left to the library that interprets drawings. This
//! is what guards, messages with line numbers, and edits that keep every other byte work on.

mod scan;
mod write;

use std::borrow::Cow;
use std::ops::Range;

use acadrust::io::dxf::code_page::{
    LegacyEncoding, decode_legacy_escapes, decode_legacy_escapes_in, encode_legacy_string,
};

use crate::container::Container;
use crate::drawing::Handle;

pub use write::{GroupValue, Writer};

/// The type of a group's value, by its code: DXF reference, *Group Code Value Types*.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ValueType {
    /// A string; a handle is one of hexadecimal digits.
    Text,
    /// A double.
    Real,
    /// 16 bits.
    Short,
    /// 32 bits.
    Long,
    /// 64 bits.
    Huge,
    /// One byte: 0 or 1.
    Flag,
    /// A chunk of bytes.
    Chunk,
}

impl ValueType {
    /// The type of the values of `code`.
    pub fn of(code: i16) -> Self {
        match code {
            10..=59 | 110..=149 | 210..=239 | 460..=469 | 1010..=1059 => Self::Real,
            60..=79 | 170..=179 | 270..=289 | 370..=389 | 400..=409 | 1060..=1070 => Self::Short,
            90..=99 | 420..=429 | 440..=459 | 1071 => Self::Long,
            160..=169 => Self::Huge,
            290..=299 => Self::Flag,
            310..=319 | 1004 => Self::Chunk,
            _ => Self::Text,
        }
    }
}

/// Where a group stands; its value ends where the next group begins.
#[derive(Clone, Copy, Debug)]
struct Tag {
    code: i16,
    start: u32,
    value: u32,
}

/// A section of the drawing.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct TagSection {
    /// `HEADER`, `ENTITIES`, …
    pub name: String,
    /// The groups between its name and its `ENDSEC`.
    pub tags: Range<usize>,
    /// True if there is an `ENDSEC`.
    pub is_closed: bool,
}

/// The version of a drawing, as the number of its name: 1009 is R12, 1015 is R2000.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Version(pub u16);

impl Version {
    /// The last version whose handles are optional and whose entities have no subclasses.
    pub const R12: Self = Self(1009);
    /// The first version in UTF-8.
    pub const R2007: Self = Self(1021);
}

/// A DXF drawing, scanned.
#[derive(Clone, Debug)]
pub struct Tags {
    bytes: Vec<u8>,
    container: Container,
    groups: Vec<Tag>,
    /// The groups with code 0, each the first of a record.
    records: Vec<u32>,
    sections: Vec<TagSection>,
    /// Sorted; the first groups of the records that have handles.
    handles: Vec<(u64, u32)>,
    /// The byte after the last group.
    end: usize,
    /// True if the last group is the `EOF` of a whole drawing.
    is_complete: bool,
    version: Version,
    encoding: Option<LegacyEncoding>,
}

impl Tags {
    /// The bytes of the file.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The bytes of the file, without the rest.
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    /// The format of the file.
    pub fn container(&self) -> Container {
        self.container
    }

    /// Number of groups.
    pub fn len(&self) -> usize {
        self.groups.len()
    }

    /// True if there is no group at all.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// True if the file ends with its `EOF` group.
    pub fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// The byte after the last group.
    pub fn end(&self) -> usize {
        self.end
    }

    /// Version by `$ACADVER`; R12 when it is not stated.
    pub fn version(&self) -> Version {
        self.version
    }

    /// The group code.
    pub fn code(&self, tag_idx: usize) -> i16 {
        self.groups[tag_idx].code
    }

    /// The bytes of a whole group, with its line ends.
    pub fn span(&self, tag_idx: usize) -> Range<usize> {
        self.groups[tag_idx].start as usize..self.start_of(tag_idx + 1)
    }

    /// The bytes of several groups.
    pub fn span_of(&self, tags: Range<usize>) -> Range<usize> {
        self.start_of(tags.start)..self.start_of(tags.end)
    }

    fn start_of(&self, tag_idx: usize) -> usize {
        self.groups.get(tag_idx).map_or(self.end, |tag| tag.start as usize)
    }

    /// The bytes of a value: without spaces and line end in text, without NUL and length in binary
    /// files.
    pub fn value_span(&self, tag_idx: usize) -> Range<usize> {
        let (start, end) = (self.groups[tag_idx].value as usize, self.start_of(tag_idx + 1));
        if let Container::Binary { .. } = self.container {
            return match ValueType::of(self.code(tag_idx)) {
                ValueType::Text => start..end.saturating_sub(1).max(start),
                ValueType::Chunk => (start + 1).min(end)..end,
                _ => start..end,
            };
        }
        let line = &self.bytes[start..end];
        let line = line.strip_suffix(b"\n").unwrap_or(line);
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        start..start + line.len()
    }

    /// The bytes of a value.
    pub fn raw(&self, tag_idx: usize) -> &[u8] {
        &self.bytes[self.value_span(tag_idx)]
    }

    /// A value as text, out of the code page, with `\U+00E9` and `^J` resolved.
    pub fn text(&self, tag_idx: usize) -> Cow<'_, str> {
        let raw = self.raw(tag_idx);
        if raw.is_ascii() && !raw.iter().any(|byte| matches!(byte, b'\\' | b'^')) {
            return String::from_utf8_lossy(raw);
        }
        let text = match self.encoding {
            Some(encoding) => decode_legacy_escapes_in(&encoding.decode(raw).0, encoding),
            None => decode_legacy_escapes(&match std::str::from_utf8(raw) {
                Ok(text) => Cow::Borrowed(text),
                Err(_) => raw.iter().map(|&byte| char::from(byte)).collect(),
            }),
        };
        Cow::Owned(uncaret(&text))
    }

    /// True if a value is these words, spaces and case aside.
    pub fn is_word(&self, tag_idx: usize, word: &str) -> bool {
        self.raw(tag_idx).trim_ascii().eq_ignore_ascii_case(word.as_bytes())
    }

    /// A value as a number, where it is one.
    pub fn number(&self, tag_idx: usize) -> Option<f64> {
        if matches!(self.container, Container::Binary { .. }) {
            if ValueType::of(self.code(tag_idx)) == ValueType::Real {
                return self.raw(tag_idx).try_into().ok().map(f64::from_le_bytes);
            }
            #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
            return self.integer(tag_idx).map(|value| value as f64);
        }
        std::str::from_utf8(self.raw(tag_idx)).ok()?.trim().parse().ok()
    }

    /// A value as an integer, where it is one.
    pub fn integer(&self, tag_idx: usize) -> Option<i64> {
        let raw = self.raw(tag_idx);
        if matches!(self.container, Container::Binary { .. }) {
            return match ValueType::of(self.code(tag_idx)) {
                ValueType::Short => raw.try_into().ok().map(|it| i16::from_le_bytes(it).into()),
                ValueType::Long => raw.try_into().ok().map(|it| i32::from_le_bytes(it).into()),
                ValueType::Huge => raw.try_into().ok().map(i64::from_le_bytes),
                ValueType::Flag => raw.first().map(|&byte| byte.into()),
                _ => None,
            };
        }
        std::str::from_utf8(raw).ok()?.trim().parse().ok()
    }

    /// A value as a handle, where it is one.
    pub fn handle(&self, tag_idx: usize) -> Option<Handle> {
        let digits = std::str::from_utf8(self.raw(tag_idx)).ok()?;
        u64::from_str_radix(digits.trim(), 16).ok().map(Handle)
    }

    /// The line of the group code, counted from one; `None` in binary files.
    pub fn line(&self, tag_idx: usize) -> Option<usize> {
        matches!(self.container, Container::Text { .. }).then_some(2 * tag_idx + 1)
    }

    /// The sections, in file order.
    pub fn sections(&self) -> &[TagSection] {
        &self.sections
    }

    /// The section of this name.
    pub fn section(&self, name: &str) -> Option<&TagSection> {
        self.sections.iter().find(|section| section.name.eq_ignore_ascii_case(name))
    }

    /// The records that begin within `tags`: an entity, a table entry or an object each.
    pub fn records(&self, tags: Range<usize>) -> impl Iterator<Item = Range<usize>> {
        let first = self.records.partition_point(|&start| (start as usize) < tags.start);
        let starts = self.records[first..].iter().map(|&start| start as usize);
        let ends = self.records[first..].iter().skip(1).map(|&start| start as usize);
        let end = tags.end;
        starts
            .zip(ends.chain(std::iter::once(self.groups.len())))
            .take_while(move |&(start, _)| start < end)
            .map(move |(start, stop)| start..stop.min(end))
    }

    /// The record with a handle.
    pub fn record(&self, handle: Handle) -> Option<Range<usize>> {
        let found = self.handles.partition_point(|&(known, _)| known < handle.0);
        let &(known, start) = self.handles.get(found)?;
        (known == handle.0).then(|| self.record_at(start as usize))
    }

    /// The record whose first group is `start`.
    pub fn record_from(&self, start: usize) -> Option<Range<usize>> {
        let start = u32::try_from(start).ok()?;
        self.records.binary_search(&start).ok().map(|_| self.record_at(start as usize))
    }

    fn record_at(&self, start: usize) -> Range<usize> {
        let next = self.records.partition_point(|&other| other as usize <= start);
        start..self.records.get(next).map_or(self.groups.len(), |&stop| stop as usize)
    }

    /// The record that begins with `record` and those that belong to it: vertices or attributes up
    /// to their `SEQEND`.
    pub fn compound(&self, record: Range<usize>) -> Range<usize> {
        let part = match self.raw(record.start).trim_ascii() {
            b"POLYLINE" => "VERTEX",
            b"INSERT" => "ATTRIB",
            _ => return record,
        };
        let mut whole = record;
        for next in self.records(whole.end..self.groups.len()) {
            if self.is_word(next.start, "SEQEND") {
                return whole.start..next.end;
            }
            if !self.is_word(next.start, part) {
                break;
            }
            whole.end = next.end;
        }
        whole
    }

    /// The handle of a record: its first group 5, or 105 of a dimension style.
    pub fn handle_of(&self, record: Range<usize>) -> Option<Handle> {
        let code = if self.is_word(record.start, "DIMSTYLE") { 105 } else { 5 };
        let own = record.take_while(|&tag_idx| self.code(tag_idx) != 1001);
        own.into_iter().find(|&idx| self.code(idx) == code).and_then(|idx| self.handle(idx))
    }

    /// The line that says what the record of a handle of the interpreted drawing is, and the last line
    /// of it. A group is two lines: its code and its value.
    pub fn lines_of(&self, handle: Handle) -> Option<[usize; 2]> {
        let record = self.known_record(handle)?;
        Some([self.line(record.start)? + 1, self.line(record.end.checked_sub(1)?)? + 1])
    }

    /// The value of a variable of the header, such as `$INSUNITS`.
    pub fn header(&self, name: &str) -> Option<usize> {
        let mut tags = self.section("HEADER")?.tags.clone();
        let variable = tags.find(|&idx| self.code(idx) == 9 && self.is_word(idx, name))?;
        (variable + 1 < self.groups.len() && self.code(variable + 1) != 9).then_some(variable + 1)
    }

    /// Text as the bytes of the file; what its code page lacks becomes `\U+00E9`.
    pub fn encode(&self, text: &str) -> Vec<u8> {
        match self.encoding {
            Some(encoding) => encode_legacy_string(text, encoding),
            None => text.as_bytes().to_vec(),
        }
    }

    /// The largest handle in use.
    pub fn largest_handle(&self) -> Option<Handle> {
        self.handles.last().map(|&(handle, _)| Handle(handle))
    }
}

/// The text of a drawing for excerpts: each byte that is no UTF-8 becomes `?`, so that byte ranges
/// of the file are ranges of the text. Empty for binary files.
pub fn excerpt_text(bytes: &[u8]) -> String {
    if !matches!(crate::container::recognise(bytes), Ok(Container::Text { .. })) {
        return String::new();
    }
    let old = crate::container::with_line_feeds(bytes);
    let bytes = old.as_deref().unwrap_or(bytes);
    let mut text = String::with_capacity(bytes.len());
    for chunk in bytes.utf8_chunks() {
        text.push_str(chunk.valid());
        text.extend(chunk.invalid().iter().map(|_| '?'));
    }
    text
}

/// `^J` is a line end, `^I` a tab, `^ ` the caret itself.
fn uncaret(text: &str) -> String {
    if !text.contains('^') {
        return text.to_owned();
    }
    text.replace("^J", "\n").replace("^M", "\r").replace("^I", "\t").replace("^ ", "^")
}
