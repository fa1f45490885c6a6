//! From the bytes of a drawing to the text of a model, in one call.

use bksim_model::diagnostic::Diagnostic;
use bksim_model::message::counted;

use crate::attach::attachments;
use crate::attachment::Attachment;
use crate::codes;
use crate::compose::{ComposeOptions, Composition, compose};
use crate::drawing::{Drawing, Entity, LengthUnit};
use crate::excerpt::Excerpts;
use crate::open::{OpenOptions, open};
use crate::read::read;
use crate::tags::excerpt_text;
use crate::unread::{is_of_shapes, kinds, unknown_layers, unread};

/// Options of reading and composing a drawing.
#[derive(Clone, Copy, Debug, Default)]
pub struct ModelOptions<'a> {
    /// The text of the sidecar, the model file next to the drawing; it must be TOML.
    pub sidecar: Option<&'a str>,
    /// The length of one unit of a drawing that does not state it.
    pub unit: Option<LengthUnit>,
    /// The snapping tolerance, drawing units.
    pub tolerance: Option<f64>,
    /// Density and thickness of bodies that state none, as texts of a model file.
    pub plate: [Option<&'a str>; 2],
    /// True if positions alone are asked for: bodies need no masses then.
    pub is_geometry: bool,
}

/// A drawing as it was read.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// Entities of the sheet.
    pub drawing: Drawing,
    /// The attachments of these.
    pub attachments: Vec<Attachment>,
    /// Layers that are off or frozen.
    pub hidden_layers: Vec<String>,
    /// The file as text, for excerpts; empty for a binary file.
    pub text: String,
    /// Faults of attachments, and warnings of the file.
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

/// Reads a drawing and its attachments.
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
    diagnostics.extend(unread(&drawing, &excerpts));
    diagnostics.extend(faults);
    let layers = opened.document.layers.iter();
    let hidden = layers.filter(|layer| layer.is_off() || layer.is_frozen());
    let hidden_layers = hidden.map(|layer| layer.name.clone()).collect();
    Ok(Sheet { drawing, attachments, hidden_layers, text, diagnostics })
}

impl Sheet {
    /// The model of the drawing. Its diagnostics are those of the drawing and of composing.
    pub fn compose(&self, options: ModelOptions<'_>) -> Composition {
        let excerpts = Excerpts::new(&self.text);
        let ModelOptions { sidecar, tolerance, plate, is_geometry, .. } = options;
        let options = ComposeOptions { sidecar, tolerance, plate, is_geometry };
        let mut composition = compose(&self.drawing, &self.attachments, &excerpts, options);
        let mut diagnostics = self.diagnostics.clone();
        // Whatever else is left out where a shape is looked for.
        let is_meant = |entity: &Entity| is_of_shapes(&entity.location.layer);
        diagnostics.extend(kinds(&self.drawing, &excerpts, is_meant));
        diagnostics.extend(unknown_layers(&self.drawing, &excerpts));
        diagnostics.append(&mut composition.diagnostics);
        if composition.bodies.is_empty() && diagnostics.iter().all(|fault| !fault.is_error()) {
            let message = format!(
                "nothing in the drawing is a body: {} read",
                counted(self.drawing.entities.len(), "entity was", "entities were")
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
