//! Edits of an existing drawing that leave everything else as it is.
//!
//! A DXF file is spliced: the groups of an edit are replaced, every other byte stays, comments and
//! line ends included. A DWG file has no such groups; it is written again from what was read of it.

mod application;
mod dwg;
mod dxf;
mod splice;
mod xdata;

use bksim_model::diagnostic::Diagnostic;

use crate::codes;
use crate::container::{Container, recognise, with_line_feeds};
use crate::drawing::Handle;
use crate::geometry::Point;
use crate::open::{OpenOptions, check};
use crate::tags::Tags;

/// One change of a drawing.
#[derive(Clone, PartialEq, Debug)]
pub enum Edit {
    /// Adds a record to the extended data of an entity.
    AddRecord {
        /// The entity.
        entity: Handle,
        /// The kind, as in [`crate::kind::Kind::name`].
        kind: String,
        /// Entries of the dictionary, in order.
        entries: Vec<Entry>,
    },
    /// Changes entries of a record; those that it lacks are added at its end.
    SetEntries {
        /// The entity.
        entity: Handle,
        /// The number of the record on the entity, from zero.
        record_idx: usize,
        /// The entries to be changed; `None` removes one.
        entries: Vec<(String, Option<Entry>)>,
    },
    /// Removes a record; with the last one, all of our extended data.
    RemoveRecord {
        /// The entity.
        entity: Handle,
        /// The number of the record on the entity, from zero.
        record_idx: usize,
    },
    /// Removes all of our extended data from an entity, broken records included.
    RemoveAll {
        /// The entity.
        entity: Handle,
    },
    /// Changes the value of an attribute of an insert.
    SetAttribute {
        /// The insert.
        insert: Handle,
        /// The tag of the attribute, in any case.
        tag: String,
        /// Value of the entry; empty for none.
        value: String,
    },
    /// Removes an insert with its attributes.
    RemoveInsert {
        /// The insert.
        insert: Handle,
    },
}

/// One entry of a record.
#[derive(Clone, PartialEq, Debug)]
pub enum Entry {
    /// `key=value`.
    Text {
        /// The key.
        key: String,
        /// The value.
        value: String,
    },
    /// A key and a point that moves, turns and scales with the entity: group 1011.
    Point {
        /// `at` or `to`.
        key: String,
        /// Drawing units, world axes.
        point: Point,
    },
    /// A key and a direction that turns with the entity: group 1013.
    Direction {
        /// `axis`.
        key: String,
        /// Of any length.
        direction: Point,
    },
}

impl Entry {
    /// The key.
    pub fn key(&self) -> &str {
        match self {
            Self::Text { key, .. } | Self::Point { key, .. } | Self::Direction { key, .. } => key,
        }
    }
}

/// A drawing after its edits.
#[derive(Clone, Debug)]
pub struct Patched {
    /// The file.
    pub bytes: Vec<u8>,
    /// Warnings for the author.
    pub warnings: Vec<Diagnostic>,
}

/// Applies edits to a drawing, one after the other.
///
/// Record numbers are those after the edits before, so the records of an entity are best removed
/// from the last to the first.
///
/// # Errors
/// Those of [`check`]; `D060` for an entity, record or attribute that is not there, `D061` for
/// values that the file cannot hold.
pub fn apply(bytes: Vec<u8>, edits: &[Edit]) -> Result<Patched, Vec<Diagnostic>> {
    let fail = |fault: Diagnostic| vec![fault];
    let options = OpenOptions::default();
    if let Ok(Container::Dwg(release)) = recognise(&bytes) {
        let bytes = dwg::apply(bytes, release, edits).map_err(fail)?;
        let message = format!("the DWG drawing of {release} was written again");
        let warning = Diagnostic::warning(codes::WRITTEN_ANEW, message)
            .note("what is not understood of it may be lost; in DXF every other byte is kept")
            .help("keep a copy, or work on a DXF of the drawing");
        return Ok(Patched { bytes, warnings: vec![warning] });
    }
    let has_old_line_ends = with_line_feeds(&bytes).is_some();
    let checked = check(bytes, &options)?;
    let (mut tags, warnings) = (checked.tags, checked.warnings);
    for edit in edits {
        let bytes = dxf::edited(&tags, edit).map_err(fail)?;
        let container = recognise(&bytes).map_err(fail)?;
        tags = Tags::scan(bytes, container).map_err(fail)?;
    }
    let mut bytes = tags.into_bytes();
    if has_old_line_ends {
        bytes.iter_mut().filter(|byte| **byte == b'\n').for_each(|byte| *byte = b'\r');
    }
    Ok(Patched { bytes, warnings })
}

fn missing(message: String) -> Diagnostic {
    Diagnostic::error(codes::NOT_THERE, message)
        .help("`bksim cad list` shows what is attached to the drawing, with the handles")
}

fn no_entity(handle: Handle) -> Diagnostic {
    missing(format!("the drawing has no entity with the handle {:X}", handle.0))
}

fn no_record(handle: Handle, record_idx: usize) -> Diagnostic {
    let number = record_idx + 1;
    missing(format!("the entity with the handle {:X} has no record {number} of ours", handle.0))
}

fn no_attribute(insert: Handle, tag: &str) -> Diagnostic {
    missing(format!("the insert with the handle {:X} has no attribute `{tag}`", insert.0))
        .note("an insert has the attributes its block had when it was inserted")
        .help("insert the block of `bksim cad template` anew, or synchronise its attributes")
}

/// Text of extended data or an attribute takes at most this many bytes: DXF reference, group 1000.
const LONGEST_TEXT: usize = 255;

/// Extended data of one entity takes at most this many bytes: DXF reference, *Extended Data*.
const MOST_XDATA: usize = 16_383;

/// Checks that text fits into the file.
fn check_text(text: &str, n_bytes: usize) -> Result<(), Diagnostic> {
    let fault = |what: String| Err(Diagnostic::error(codes::DOES_NOT_FIT, what));
    if let Some(control) = text.chars().find(|it| it.is_control()) {
        return fault(format!("`{}` has the control character {control:?}", text.escape_debug()));
    }
    if n_bytes > LONGEST_TEXT {
        let shown: String = text.chars().take(40).collect();
        let message = format!("`{shown}…` takes {n_bytes} bytes in the drawing");
        return fault(message).map_err(|it| {
            it.note(format!("a text of extended data has at most {LONGEST_TEXT} bytes"))
                .help("put the long value into a parameter of a model file beside the drawing")
        });
    }
    Ok(())
}
