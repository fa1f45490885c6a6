//! From the bytes of a drawing to the text of a model, in one call.

use bksim_model::diagnostic::Diagnostic;

use crate::attach::attachments;
use crate::attachment::Attachment;
use crate::codes;
use crate::compose::{ComposeOptions, Composition, compose};
use crate::drawing::{Drawing, LengthUnit};
use crate::excerpt::Excerpts;
use crate::open::{OpenOptions, open};
use crate::read::read;
use crate::tags::excerpt_text;

/// What the caller says of a drawing.
#[derive(Clone, Copy, Debug, Default)]
pub struct ModelOptions<'a> {
    /// The text of the model file beside the drawing; it must be TOML.
    pub side: Option<&'a str>,
    /// What one unit of the drawing is, unless the drawing says so.
    pub unit: Option<LengthUnit>,
    /// The snapping tolerance, drawing units.
    pub tolerance: Option<f64>,
    /// Density and thickness of bodies that state none, as texts of a model file.
    pub plate: [Option<&'a str>; 2],
}

/// A drawing as it was read.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// Its entities.
    pub drawing: Drawing,
    /// What is attached to them.
    pub attachments: Vec<Attachment>,
    /// The file as text, for excerpts; empty for a binary file.
    pub text: String,
    /// What is wrong with what is attached, and warnings of the file.
    pub diagnostics: Vec<Diagnostic>,
}

/// A drawing that was refused: every fault, with spans of the text.
#[derive(Clone, Debug)]
pub struct Refused {
    /// The file as text, for excerpts; empty for a binary file.
    pub text: String,
    /// At least one is an error.
    pub diagnostics: Vec<Diagnostic>,
}

/// Reads a drawing and what is attached to it.
///
/// # Errors
/// [`Refused`] when it is no drawing that can be read.
pub fn sheet(bytes: Vec<u8>, unit: Option<LengthUnit>) -> Result<Sheet, Refused> {
    let text = excerpt_text(&bytes);
    let opened = match open(bytes, &OpenOptions { unit, ..OpenOptions::default() }) {
        Ok(opened) => opened,
        Err(diagnostics) => return Err(Refused { text, diagnostics }),
    };
    let drawing = read(&opened.document, opened.unit, &opened.tags);
    let excerpts = Excerpts::new(&text);
    let (attachments, faults) = attachments(&drawing, &excerpts);
    let mut diagnostics = opened.warnings;
    diagnostics.extend(faults);
    Ok(Sheet { drawing, attachments, text, diagnostics })
}

impl Sheet {
    /// The model of the drawing. Its diagnostics are those of the drawing and of composing.
    pub fn compose(&self, options: ModelOptions<'_>) -> Composition {
        let excerpts = Excerpts::new(&self.text);
        let ModelOptions { side, tolerance, plate, .. } = options;
        let options = ComposeOptions { side, tolerance, plate };
        let mut composition = compose(&self.drawing, &self.attachments, &excerpts, options);
        let mut diagnostics = self.diagnostics.clone();
        diagnostics.append(&mut composition.diagnostics);
        if composition.bodies.is_empty() && diagnostics.iter().all(|fault| !fault.is_error()) {
            let message = format!(
                "nothing in the drawing is a body: {} entities were read",
                self.drawing.entities.len()
            );
            let help = "put the shape of each body on a layer of its own, BK_BODY_name, or insert \
                        BK_BODY from `bksim cad template` inside of it";
            diagnostics.push(Diagnostic::error(codes::NO_BODIES, message).help(help));
        }
        if diagnostics.iter().any(Diagnostic::is_error) {
            composition.text.clear();
        }
        composition.diagnostics = diagnostics;
        composition
    }
}
