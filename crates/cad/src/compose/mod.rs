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
mod lengths;
mod marks;
mod names;
mod near;
mod origins;
mod outlines;
mod partners;
mod points;
mod report;
mod sections;
mod sidecar;
mod snap;
mod source;
mod spelling;
mod twice;
mod units;
mod weigh;

use std::ops::Range;

use bksim_model::diagnostic::Diagnostic;
use toml_edit::{DocumentMut, Item};

pub use frame::Frame;
pub use origins::Origin;
pub use report::{BodyReport, JointReport, JointSnap, MassSource};
pub use sidecar::{DRAWING_KEY, named_drawing};
pub use source::RELATIVE_TOLERANCE;

use crate::attachment::Attachment;
use crate::codes;
use crate::drawing::Drawing;
use crate::excerpt::Excerpts;
use choose_frames::choose_frames;
use connect::{Connected, connect};
use draft::Draft;
use faults::Faults;

use gather::{Gathered, gather};
use lengths::{Skeleton, lengths};
use origins::Origins;
use sections::Mechanism;
use sidecar::Sidecar;
use source::{Scale, Source};
use spelling::Spellings;
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
    /// True if positions alone are asked for: bodies need no masses then.
    pub is_geometry: bool,
}

/// A model that came out of a drawing.
#[derive(Clone, Debug)]
pub struct Composition {
    /// The text of the model, complete by itself; empty when there was an error.
    pub text: String,
    /// The text of a model of the bodies that have masses, each by itself, with the parameters: their numbers can be
    /// had from it whatever is wrong with the joints.
    pub weighed: String,
    /// Bodies, in the order of the drawing.
    pub bodies: Vec<BodyReport>,
    /// Joints, in the order of the drawing.
    pub joints: Vec<JointReport>,
    /// Points that were taken as one.
    pub snaps: Vec<JointSnap>,
    /// The snapping tolerance, drawing units.
    pub tolerance: f64,
    /// Errors and warnings; spans are those of the drawing's text.
    pub diagnostics: Vec<Diagnostic>,
    origins: Origins,
    spellings: Spellings,
}

impl Composition {
    /// The name that the model has for a name of the drawing.
    pub fn model_name<'n>(&'n self, name: &'n str) -> &'n str {
        self.spellings.name(name)
    }

    /// A message about the model in the words of the drawing.
    pub fn drawn_words(&self, message: &str) -> String {
        self.spellings.drawn(message)
    }

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
    let mut parameters = sections::parameters(source, &mut faults);
    let skeleton = Skeleton { source, points: &points, frames: &frames, connections: &connections };
    let lengths = lengths(&skeleton, &mut parameters, &mut faults);
    let mechanism = Mechanism {
        lengths: &lengths,
        source,
        bodies: &bodies,
        connections: &connections,
        frames: &frames,
        units: &units,
    };

    // The sections of the text. Loads may put points onto bodies, so bodies come after them; faults
    // keep the order of the calls.
    let top = sections::top(source);
    let plate = Plate {
        unit: drawing.unit,
        units: &units,
        default: options.plate,
        needs_masses: !options.is_geometry,
    };
    let weights = weigh(&bodies, &frames, plate, &mut faults);
    let (joints, joint_reports) = sections::joints(&mechanism);
    let loads = sections::loads(&mechanism, &mut points, &mut faults);
    let drives = sections::drives(&mechanism, &mut faults);
    let (body_sections, body_reports) = sections::bodies(&mechanism, &points, weights);
    let starts = sections::starts(&mechanism, &body_reports, &mut faults);
    let solve = sections::solve(source);
    let mut named = sections::named(&mechanism, &mut faults);
    sections::put_drawn_curves(&mechanism, &mut named, &mut faults);
    let io = sections::io(source);

    // The text, in the order of a model file; a drawing with errors has none.
    let mut draft = Draft::joined([
        top,
        parameters,
        body_sections,
        joints,
        named,
        loads,
        drives,
        starts,
        solve,
        io,
    ]);
    let spellings = Spellings::of(&draft.document);
    report_spellings(&spellings, &draft, &mut faults);
    let weighed = weighed(&draft, &body_reports, &spellings);
    let (text, origins) = if faults.has_error() {
        (String::new(), Origins::default())
    } else {
        spellings.spell(&mut draft.document);
        let text = sidecar.merged(&draft.document, &body_reports, &spellings);
        let origins = Origins::new(&text, sidecar_text, draft.locations, &spellings);
        (text, origins)
    };
    Composition {
        text,
        weighed,
        bodies: body_reports,
        joints: joint_reports,
        snaps,
        tolerance: scale.tolerance,
        diagnostics: faults.into_list(),
        origins,
        spellings,
    }
}

/// The loops that small gaps leave open, each with its gaps and the entities at their ends.
pub(crate) fn near_loops(
    open: &[crate::outline::Chain],
    tolerance: f64,
) -> Vec<(Vec<crate::outline::Snap>, Vec<usize>)> {
    let loops = near::loops(open, tolerance).into_iter();
    let ends = |gaps: &[crate::outline::Snap]| {
        let mut entities: Vec<usize> = gaps.iter().flat_map(|gap| gap.entities).collect();
        entities.sort_unstable();
        entities.dedup();
        entities
    };
    loops.map(|near| (near.gaps.clone(), ends(&near.gaps))).collect()
}

/// The bodies that have masses, free of joints, and the parameters.
fn weighed(draft: &Draft, reports: &[BodyReport], spellings: &Spellings) -> String {
    let mut document = DocumentMut::new();
    for section in ["parameters", "bodies"] {
        if let Some(item) = draft.document.get(section) {
            document.insert(section, item.clone());
        }
    }
    if let Some(bodies) = document.get_mut("bodies").and_then(Item::as_table_like_mut) {
        for report in reports.iter().filter(|report| report.source == MassSource::Missing) {
            bodies.remove(&report.name);
        }
        for (_, body) in bodies.iter_mut() {
            let Some(body) = body.as_table_like_mut() else { continue };
            for key in ["coordinates", "outline"] {
                body.remove(key);
            }
            body.insert("free", toml_edit::value(true));
        }
    }
    spellings.spell(&mut document);
    document.to_string()
}

/// Says once which names the model spells otherwise than the drawing.
fn report_spellings(spellings: &Spellings, draft: &Draft, faults: &mut Faults<'_>) {
    let pairs: Vec<String> =
        spellings.pairs().map(|(name, spelling)| format!("`{name}` is `{spelling}`")).collect();
    let found = spellings.pairs().find_map(|(name, _)| {
        let mut locations = draft.locations.iter();
        let (_, at) = locations.find(|(path, _)| path.iter().any(|part| part == name))?;
        Some((name, at))
    });
    let (false, Some((name, at))) = (pairs.is_empty(), found) else { return };
    let message = format!("equations and logs spell names otherwise: {}", pairs.join(", "));
    let help =
        "names of the letters a–z, digits and `_` that do not start with a digit stay as they are";
    let warning = Diagnostic::warning(codes::RENAMED, message).help(help);
    faults.add_labelled(warning, at, &format!("`{name}`"));
}
