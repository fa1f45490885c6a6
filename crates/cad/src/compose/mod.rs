//! From the attachments of a drawing to the text of a model.
//!
//! ```text
//! layers, records, inserts → bodies → joints → frames → masses → sections → text of a model
//!                  gather     connect   frames   weigh   sections   draft, sidecar
//! ```
//!
//! Every stage is a function of what the stages before it returned; [`compose`] calls them in this
//! order. The sidecar, a model file next to the drawing, is merged over what the drawing says. Every
//! value of the text keeps its location, so that whatever is found wrong with it later is shown where
//! its author wrote it.

mod bodies;
mod choose_frames;
mod connect;
mod draft;
mod enclosed;
mod faults;
mod frame;
mod gather;
mod marks;
mod names;
mod origins;
mod outlines;
mod partners;
mod points;
mod report;
mod sections;
mod sidecar;
mod snap;
mod source;
mod twice;
mod units;
mod weigh;

use std::ops::Range;

use bksim_model::diagnostic::Diagnostic;

pub use frame::Frame;
pub use origins::Origin;
pub use report::{BodyReport, JointReport, MassSource, Snap};
pub use sidecar::{DRAWING_KEY, named_drawing};
pub use source::RELATIVE_TOLERANCE;

use crate::attachment::Attachment;
use crate::drawing::Drawing;
use crate::excerpt::Excerpts;
use choose_frames::choose_frames;
use connect::{Connected, connect};
use draft::Draft;
use faults::Faults;

use gather::{Gathered, gather};
use origins::Origins;
use sections::Mechanism;
use sidecar::Sidecar;
use source::{Scale, Source};
use twice::stated_twice;
use units::BareUnits;
use weigh::{Plate, weigh};

/// Options of composing.
#[derive(Clone, Copy, Debug, Default)]
pub struct ComposeOptions<'a> {
    /// The text of the sidecar, the model file next to the drawing; it must be TOML.
    pub sidecar: Option<&'a str>,
    /// The snapping tolerance, drawing units; [`RELATIVE_TOLERANCE`] of the diagonal unless given.
    pub tolerance: Option<f64>,
    /// Density and thickness of bodies that state none, as texts of a model file.
    pub plate: [Option<&'a str>; 2],
}

/// A model that came out of a drawing.
#[derive(Clone, Debug)]
pub struct Composition {
    /// The text of the model, complete by itself; empty when there was an error.
    pub text: String,
    /// Bodies, in the order of the drawing.
    pub bodies: Vec<BodyReport>,
    /// Joints, in the order of the drawing.
    pub joints: Vec<JointReport>,
    /// Points that were taken as one.
    pub snaps: Vec<Snap>,
    /// The snapping tolerance, drawing units.
    pub tolerance: f64,
    /// Errors and warnings; spans are those of the drawing's text.
    pub diagnostics: Vec<Diagnostic>,
    origins: Origins,
}

impl Composition {
    /// The origin of a range of the text.
    pub fn origin(&self, span: &Range<usize>) -> Origin {
        self.origins.find(span)
    }
}

/// Composes the model of a drawing.
pub fn compose(
    drawing: &Drawing,
    attachments: &[Attachment],
    excerpts: &Excerpts<'_>,
    options: ComposeOptions<'_>,
) -> Composition {
    let sidecar_text = options.sidecar.unwrap_or_default();
    let sidecar = Sidecar::new(sidecar_text);
    let scale = Scale::of(drawing.extent, options.tolerance);
    let source = Source { drawing, attachments, scale };
    let mut faults = Faults::new(excerpts);

    stated_twice(source, &sidecar, &mut faults);

    // The mechanism: bodies, the joints where they meet, and the frames that follow from these.
    let Gathered { bodies, mut points } = gather(source, &sidecar, &mut faults);
    let Connected { connections, snaps } = connect(source, &bodies, &mut points, &mut faults);
    let frames = choose_frames(&bodies, &connections, scale.tolerance);
    let units = BareUnits::of(source, &sidecar);
    let mechanism = Mechanism {
        source,
        bodies: &bodies,
        connections: &connections,
        frames: &frames,
        units: &units,
    };

    // The sections of the text. Loads may put points onto bodies, so bodies come after them; faults
    // keep the order of the calls.
    let top = sections::top(source);
    let parameters = sections::parameters(source, &mut faults);
    let plate = Plate { unit: drawing.unit, units: &units, default: options.plate };
    let weights = weigh(&bodies, &frames, plate, &mut faults);
    let (joints, joint_reports) = sections::joints(&mechanism);
    let loads = sections::loads(&mechanism, &mut points, &mut faults);
    let drives = sections::drives(&mechanism, &mut faults);
    let (body_sections, body_reports) = sections::bodies(&mechanism, &points, weights);
    let starts = sections::starts(&mechanism, &body_reports, &mut faults);
    let solve = sections::solve(source);

    // The text, in the order of a model file; a drawing with errors has none.
    let draft =
        Draft::joined([top, parameters, body_sections, joints, loads, drives, starts, solve]);
    let (text, origins) = if faults.has_error() {
        (String::new(), Origins::default())
    } else {
        let text = sidecar.merged(&draft.document, &body_reports);
        let origins = Origins::new(&text, sidecar_text, draft.locations);
        (text, origins)
    };
    Composition {
        text,
        bodies: body_reports,
        joints: joint_reports,
        snaps,
        tolerance: scale.tolerance,
        diagnostics: faults.into_list(),
        origins,
    }
}
