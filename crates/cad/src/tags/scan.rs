//! The one pass over the bytes of a drawing.

use acadrust::io::dxf::code_page::encoding_from_code_page;
use bksim_model::diagnostic::Diagnostic;

use super::{Tag, TagSection, Tags, ValueType, Version};
use crate::codes;
use crate::container::{Container, SENTINEL, with_line_feeds};

/// A drawing of more groups is refused: their positions alone would take 200 MB.
const MOST_TAGS: usize = 16_000_000;

/// Group codes of the DXF reference.
const CODES: std::ops::RangeInclusive<i32> = -5..=1071;

impl Tags {
    /// Finds the groups, records and sections of a DXF drawing.
    ///
    /// # Errors
    /// `D002` for more groups than are read, `D003` where a group code should stand and none does.
    pub fn scan(bytes: Vec<u8>, container: Container) -> Result<Self, Diagnostic> {
        let bytes = with_line_feeds(&bytes).unwrap_or(bytes);
        let (groups, end) = match container {
            Container::Text { start } => lines(&bytes, start)?,
            Container::Binary { has_wide_codes } => binary_groups(&bytes, has_wide_codes)?,
            Container::Dwg(_) => (Vec::new(), 0),
        };
        let mut scanned = Self {
            bytes,
            container,
            groups,
            records: Vec::new(),
            sections: Vec::new(),
            handles: Vec::new(),
            end,
            is_complete: false,
            version: Version::R12,
            encoding: None,
        };
        scanned.find_records();
        scanned.find_sections();
        scanned.find_handles();
        scanned.find_encoding();
        Ok(scanned)
    }

    fn find_records(&mut self) {
        let starts = self.groups.iter().enumerate().filter(|(_, tag)| tag.code == 0);
        // At most 16 million.
        self.records = starts.filter_map(|(idx, _)| u32::try_from(idx).ok()).collect();
        self.is_complete = self.groups.last().is_some_and(|tag| tag.code == 0)
            && self.is_word(self.len() - 1, "EOF");
    }

    fn find_sections(&mut self) {
        let mut open: Option<TagSection> = None;
        for &start in &self.records {
            let tag_idx = start as usize;
            let begins = self.is_word(tag_idx, "SECTION");
            let ends = self.is_word(tag_idx, "ENDSEC");
            if !begins && !ends && !self.is_word(tag_idx, "EOF") {
                continue;
            }
            if let Some(mut section) = open.take() {
                section.tags.end = tag_idx;
                section.is_closed = ends;
                self.sections.push(section);
            }
            if begins && tag_idx + 1 < self.len() && self.code(tag_idx + 1) == 2 {
                let name = self.text(tag_idx + 1).trim().to_owned();
                let tags = tag_idx + 2..self.len();
                open = Some(TagSection { name, tags, is_closed: false });
            }
        }
        self.sections.extend(open);
    }

    fn find_handles(&mut self) {
        let mut handles = Vec::new();
        for section in &self.sections {
            if matches!(section.name.as_str(), "HEADER" | "CLASSES" | "THUMBNAILIMAGE") {
                continue;
            }
            for record in self.records(section.tags.clone()) {
                let start = u32::try_from(record.start).expect("more groups are refused");
                if let Some(handle) = self.handle_of(record) {
                    handles.push((handle.0, start));
                }
            }
        }
        handles.sort_unstable();
        self.handles = handles;
    }

    fn find_encoding(&mut self) {
        let version = self.header("$ACADVER").map(|idx| self.text(idx).trim().to_owned());
        let digits = version.as_deref().and_then(|name| name.strip_prefix("AC"));
        if let Some(number) = digits.and_then(|digits| digits.parse().ok()) {
            self.version = Version(number);
        }
        if self.version < Version::R2007 {
            let page = self.header("$DWGCODEPAGE").map(|idx| self.text(idx).trim().to_owned());
            self.encoding = page.and_then(|page| encoding_from_code_page(&page));
        }
    }
}

fn too_many() -> Diagnostic {
    Diagnostic::error(
        codes::TOO_LARGE,
        format!("the drawing has more than {MOST_TAGS} groups of data"),
    )
    .help("delete what is not of the mechanism, or save it as a drawing of its own")
}

/// The groups of a text: a line with the code and a line with the value each, up to `EOF`.
fn lines(bytes: &[u8], start: usize) -> Result<(Vec<Tag>, usize), Diagnostic> {
    let mut tags = Vec::new();
    let mut at = start;
    while let Some(value) = next_line(bytes, at) {
        let Some(code) = group_code(&bytes[at..value]) else {
            let is_cut = next_line(bytes, value).is_none() && !bytes.ends_with(b"\n");
            if is_cut {
                break;
            }
            return Err(no_group_code(bytes, at..value, tags.len()));
        };
        let Some(end) = next_line(bytes, value) else { break };
        if tags.len() == MOST_TAGS {
            return Err(too_many());
        }
        tags.push(tag(code, at, value)?);
        at = end;
        if code == 0 && bytes[value..end].trim_ascii().eq_ignore_ascii_case(b"EOF") {
            break;
        }
    }
    Ok((tags, at))
}

/// Where the line after the one at `at` begins; `None` when there is no line at `at`.
fn next_line(bytes: &[u8], at: usize) -> Option<usize> {
    let rest = bytes.get(at..).filter(|rest| !rest.is_empty())?;
    Some(rest.iter().position(|&byte| byte == b'\n').map_or(bytes.len(), |end| at + end + 1))
}

fn group_code(line: &[u8]) -> Option<i16> {
    let code = std::str::from_utf8(line).ok()?.trim().parse::<i32>().ok()?;
    i16::try_from(code).ok().filter(|_| CODES.contains(&code))
}

fn no_group_code(bytes: &[u8], line: std::ops::Range<usize>, n_tags: usize) -> Diagnostic {
    let words = String::from_utf8_lossy(bytes[line.clone()].trim_ascii()).into_owned();
    let shown: String = words.chars().take(40).collect();
    let message =
        format!("no group code on line {}, but `{}`", 2 * n_tags + 1, shown.escape_debug());
    Diagnostic::error(codes::DAMAGED, message)
        .at(line.start..line.start + bytes[line].trim_ascii_end().len(), "a number from 0 to 1071")
        .note("lines of a DXF file come in pairs, a group code and its value; one is missing or in excess")
        .help("save the drawing again from the CAD program, without editing the text")
}

fn tag(code: i16, start: usize, value: usize) -> Result<Tag, Diagnostic> {
    let start = u32::try_from(start).map_err(|_| too_many())?;
    let value = u32::try_from(value).map_err(|_| too_many())?;
    Ok(Tag { code, start, value })
}

/// The groups of a binary file, up to `EOF`.
fn binary_groups(bytes: &[u8], has_wide_codes: bool) -> Result<(Vec<Tag>, usize), Diagnostic> {
    let mut tags = Vec::new();
    let mut at = SENTINEL.len();
    while let Some((code, value)) = binary_code(bytes, at, has_wide_codes) {
        if !CODES.contains(&i32::from(code)) {
            let message = format!("no group code at byte {at}, but {code}");
            return Err(Diagnostic::error(codes::DAMAGED, message)
                .note("the binary file is damaged before this byte")
                .help("save the drawing again from the CAD program, best as ASCII DXF"));
        }
        let Some(end) = binary_end(bytes, code, value) else { break };
        if tags.len() == MOST_TAGS {
            return Err(too_many());
        }
        tags.push(tag(code, at, value)?);
        at = end;
        if code == 0 && bytes[value..end].eq_ignore_ascii_case(b"EOF\0") {
            break;
        }
    }
    Ok((tags, at))
}

/// A group code and where its value begins.
fn binary_code(bytes: &[u8], at: usize, has_wide_codes: bool) -> Option<(i16, usize)> {
    let wide = |at: usize| {
        let code = bytes.get(at..at + 2)?.try_into().ok().map(i16::from_le_bytes)?;
        Some((code, at + 2))
    };
    match bytes.get(at)? {
        _ if has_wide_codes => wide(at),
        255 => wide(at + 1),
        &code => Some((code.into(), at + 1)),
    }
}

/// Where the value of `code` ends; `None` when the file ends before.
fn binary_end(bytes: &[u8], code: i16, value: usize) -> Option<usize> {
    let length = match ValueType::of(code) {
        ValueType::Text => bytes.get(value..)?.iter().position(|&byte| byte == 0)? + 1,
        ValueType::Chunk => usize::from(*bytes.get(value)?) + 1,
        ValueType::Real | ValueType::Huge => 8,
        ValueType::Long => 4,
        ValueType::Short => 2,
        ValueType::Flag => 1,
    };
    (value + length <= bytes.len()).then_some(value + length)
}
