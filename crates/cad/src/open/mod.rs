//! From the bytes of a file to a drawing that can be interpreted without harm.
//!
//! ```text
//! bytes → container → tags → guards → feed → document
//!                       DWG: document → binary DXF, and from there the same way
//! ```

mod blocks;
mod feed;
mod guard;

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

use acadrust::tables::BlockRecord;
use acadrust::{CadDocument, DwgReadOptions, DwgReader, DxfReader, DxfWriter};
use bksim_model::diagnostic::Diagnostic;

use crate::codes;
use crate::container::{Container, recognise};
use crate::drawing::LengthUnit;
use crate::tags::Tags;
use crate::units::{self, Stated};

pub use guard::describe;

/// Options of opening a drawing.
#[derive(Clone, PartialEq, Debug)]
pub struct OpenOptions {
    /// The length of one unit of the drawing; the drawing's own statement unless given.
    pub unit: Option<LengthUnit>,
    /// Larger files are refused; bytes. 128 MiB by default.
    pub largest_file: usize,
}

impl Default for OpenOptions {
    fn default() -> Self {
        Self { unit: None, largest_file: 128 << 20 }
    }
}

/// A drawing that was opened.
#[derive(Debug)]
pub struct Opened {
    /// Layers, blocks and the entities of blocks and of the model space, interpreted.
    ///
    /// Every entity has a handle; [`Tags::known_record`] leads from it to the file, and
    /// [`Tags::own_handle`] says whether it stands in the file.
    pub document: CadDocument,
    /// The groups of the file; those of a DWG as it would be in binary DXF.
    pub tags: Tags,
    /// The format of the file.
    pub container: Container,
    /// The length of one unit.
    pub unit: LengthUnit,
    /// Warnings for the author.
    pub warnings: Vec<Diagnostic>,
}

/// A drawing that was checked, but not interpreted, for edits.
#[derive(Debug)]
pub struct Checked {
    /// The groups of the file; those of a DWG as it would be in binary DXF.
    pub tags: Tags,
    /// The format of the file.
    pub container: Container,
    /// Warnings for the author.
    pub warnings: Vec<Diagnostic>,
    /// Width and height of the box around the defining points.
    size: [f64; 2],
}

/// Opens a drawing.
///
/// # Errors
/// Every fault that was found, as diagnostics with the codes `D001` to `D019`; the span of a fault
/// is a range of [`crate::tags::excerpt_text`] of the same bytes.
pub fn open(bytes: Vec<u8>, options: &OpenOptions) -> Result<Opened, Vec<Diagnostic>> {
    let Checked { tags, container, mut warnings, size } = check(bytes, options)?;
    let stated = Stated {
        insunits: integer(&tags, "$INSUNITS"),
        measurement: integer(&tags, "$MEASUREMENT"),
    };
    let (unit, warning) = units::choose(stated, options.unit, size).map_err(|it| vec![it])?;
    warnings.extend(warning);
    let document = interpret(feed::feed(&tags)).map_err(|fault| vec![fault])?;
    Ok(Opened { document, tags, container, unit, warnings })
}

/// Finds the groups of a drawing and checks them.
///
/// # Errors
/// As those of [`open`], the units aside.
pub fn check(bytes: Vec<u8>, options: &OpenOptions) -> Result<Checked, Vec<Diagnostic>> {
    let fail = |fault: Diagnostic| vec![fault];
    if bytes.len() > options.largest_file {
        return Err(vec![too_large(bytes.len(), options.largest_file)]);
    }
    let container = recognise(&bytes).map_err(fail)?;
    let tags = match container {
        Container::Dwg(release) => {
            let binary = binary_dxf_of(bytes, release).map_err(fail)?;
            let container = recognise(&binary).map_err(fail)?;
            Tags::scan(binary, container)
        }
        _ => Tags::scan(bytes, container),
    }
    .map_err(fail)?;

    let mut warnings = Vec::new();
    if let Some(fault) = guard::ending(&tags) {
        if fault.is_error() {
            return Err(vec![fault]);
        }
        warnings.push(fault);
    }
    let [blocks, entities] = ["BLOCKS", "ENTITIES"].map(|name| feed::records(&tags, name));
    warnings.extend(blocks::check(&tags, &blocks, &entities).map_err(fail)?);
    let mut faults = Vec::new();
    for records in [&blocks, &entities] {
        faults.extend(guard::values(&tags, records));
        faults.extend(guard::counts(&tags, records));
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let size = guard::size(&tags, &entities);
    Ok(Checked { tags, container, warnings, size })
}

fn integer(tags: &Tags, variable: &str) -> Option<i64> {
    tags.header(variable).and_then(|idx| tags.integer(idx))
}

fn too_large(size: usize, limit: usize) -> Diagnostic {
    Diagnostic::error(
        codes::TOO_LARGE,
        format!("the drawing is {size} bytes long; at most {limit} are read"),
    )
    .help("save what belongs to the mechanism as a drawing of its own")
}

/// Interprets a checked drawing. A panic of the library is a fault of the file.
fn interpret(bytes: Vec<u8>) -> Result<CadDocument, Diagnostic> {
    let read = || DxfReader::from_reader(Cursor::new(bytes)).and_then(DxfReader::read);
    match catch_unwind(AssertUnwindSafe(read)) {
        Ok(Ok(document)) => Ok(document),
        Ok(Err(_)) | Err(_) => Err(unreadable("the drawing")),
    }
}

fn unreadable(what: &str) -> Diagnostic {
    Diagnostic::error(
        codes::UNREADABLE,
        format!("{what} cannot be read: its data contradict one another"),
    )
    .help("open it in a CAD program, let it check the drawing, and save it as DXF")
}

/// Reads a DWG drawing.
///
/// # Errors
/// `D008` for a damaged one.
pub fn read_dwg(bytes: Vec<u8>, release: &str) -> Result<CadDocument, Diagnostic> {
    /// The most that a DWG may unpack to; bytes.
    const MOST_UNPACKED: usize = 192 << 20;
    let options = DwgReadOptions::default().with_max_decompressed_bytes(MOST_UNPACKED);
    let read = || DwgReader::from_stream_with_options(Cursor::new(bytes), options).read();
    match catch_unwind(AssertUnwindSafe(read)) {
        Ok(Ok(mut document)) => {
            name_model_space(&mut document);
            Ok(document)
        }
        Ok(Err(_)) | Err(_) => Err(unreadable(&format!("the DWG drawing of {release}"))),
    }
}

/// Gives the block that the drawing says is its model space the name of one: converters call it `*U3`.
fn name_model_space(document: &mut CadDocument) {
    const NAME: &str = "*Model_Space";
    let handle = document.header.model_space_block_handle;
    let stated = document.block_records.iter().find(|block| block.handle == handle);
    let has_entities = |block: &BlockRecord| !block.entity_handles.is_empty();
    let Some(stated) = stated.filter(|it| !it.name.eq_ignore_ascii_case(NAME)).cloned() else {
        return;
    };
    // A block of that name that has entities is the model space, whatever else is said.
    if document.block_records.get(NAME).is_some_and(has_entities) {
        return;
    }
    document.block_records.remove(NAME);
    document.block_records.remove(&stated.name);
    // The name is free: nothing of it is left.
    let _ = document.block_records.add(BlockRecord { name: NAME.to_owned(), ..stated });
}

/// A DWG drawing as binary DXF.
fn binary_dxf_of(bytes: Vec<u8>, release: &str) -> Result<Vec<u8>, Diagnostic> {
    let document = read_dwg(bytes, release)?;
    let write = || DxfWriter::new_binary(&document).write_to_vec();
    match catch_unwind(AssertUnwindSafe(write)) {
        Ok(Ok(binary)) => Ok(binary),
        Ok(Err(_)) | Err(_) => Err(unreadable(&format!("the DWG drawing of {release}"))),
    }
}
