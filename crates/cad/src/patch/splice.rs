//! [`Splice`]: bytes of a file that make way for others.

use std::ops::Range;

use crate::tags::Tags;

/// Bytes that replace others.
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

/// The bytes with the splices done; they do not overlap.
pub(super) fn apply(bytes: &[u8], mut splices: Vec<Splice>) -> Vec<u8> {
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
