//! Groups as the bytes of a file, in the style of that file.

use super::{Tags, ValueType};
use crate::container::Container;

/// A value to be written.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum GroupValue<'a> {
    /// For codes of text; written in the code page of the file.
    Text(&'a str),
    /// For codes of real numbers.
    Real(f64),
    /// For codes of integers.
    Integer(i64),
}

/// Collects groups in the style of a file: its code width, its line ends, its code page.
#[derive(Debug)]
pub struct Writer<'a> {
    tags: &'a Tags,
    line_end: &'static [u8],
    pads_codes: bool,
    bytes: Vec<u8>,
}

impl<'a> Writer<'a> {
    /// A writer in the style of `tags`.
    pub fn new(tags: &'a Tags) -> Self {
        let first = if tags.is_empty() { &[][..] } else { &tags.bytes()[tags.span(0)] };
        let line_end: &[u8] = if first.ends_with(b"\r\n") { b"\r\n" } else { b"\n" };
        Self { tags, line_end, pads_codes: first.starts_with(b" "), bytes: Vec::new() }
    }

    /// Adds a group.
    pub fn push(&mut self, code: i16, value: GroupValue<'_>) -> &mut Self {
        match self.tags.container() {
            Container::Binary { has_wide_codes } => self.push_binary(code, value, has_wide_codes),
            _ => self.push_lines(code, value),
        }
        self
    }

    /// Adds groups as they stand in the file.
    pub fn copy(&mut self, bytes: &[u8]) -> &mut Self {
        // The last line of a file may lack its end.
        if matches!(self.tags.container(), Container::Text { .. })
            && self.bytes.last().is_some_and(|&byte| byte != b'\n')
        {
            self.bytes.extend_from_slice(self.line_end);
        }
        self.bytes.extend_from_slice(bytes);
        self
    }

    /// Adds bytes that are no groups: what stands before the first one.
    pub fn begin(&mut self, bytes: &[u8]) -> &mut Self {
        self.bytes.extend_from_slice(bytes);
        self
    }

    /// The bytes of all groups.
    pub fn finish(self) -> Vec<u8> {
        self.bytes
    }

    fn push_lines(&mut self, code: i16, value: GroupValue<'_>) {
        let code = if self.pads_codes { format!("{code:>3}") } else { code.to_string() };
        let text = match value {
            GroupValue::Text(text) => self.tags.encode(text),
            // The shortest text that reads back as the same number, always with a point or an `e`.
            GroupValue::Real(number) => format!("{number:?}").into_bytes(),
            GroupValue::Integer(number) => number.to_string().into_bytes(),
        };
        self.copy(&[code.as_bytes(), self.line_end, &text, self.line_end].concat());
    }

    fn push_binary(&mut self, code: i16, value: GroupValue<'_>, has_wide_codes: bool) {
        match u8::try_from(code) {
            Ok(byte) if !has_wide_codes && byte != 255 => self.bytes.push(byte),
            _ => {
                if !has_wide_codes {
                    self.bytes.push(255);
                }
                self.bytes.extend_from_slice(&code.to_le_bytes());
            }
        }
        match value {
            GroupValue::Text(text) => {
                let text = self.tags.encode(text);
                self.bytes.extend_from_slice(&text);
                self.bytes.push(0);
            }
            GroupValue::Real(number) => self.bytes.extend_from_slice(&number.to_le_bytes()),
            GroupValue::Integer(number) => {
                let width = match ValueType::of(code) {
                    ValueType::Flag => 1,
                    ValueType::Short => 2,
                    ValueType::Long => 4,
                    _ => 8,
                };
                // Little-endian two's complement: the low bytes are the narrower number.
                self.bytes.extend_from_slice(&number.to_le_bytes()[..width]);
            }
        }
    }
}
