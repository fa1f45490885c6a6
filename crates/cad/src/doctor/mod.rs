//! Everything that is found wrong with a drawing, or looks wrong, each with its place and its cure.
//!
//! The findings of composing the model come first; then those that it need not care about, but a person should see:
//! entities drawn twice, outlines with gaps, layers that are not shown or have nearly the name of one that
//! means something, and entities of kinds that are not read.

mod layers;
mod marks;
mod strokes;

use bksim_model::diagnostic::{Diagnostic, Severity};

pub use crate::kind::DOCTOR_LAYER;
pub use marks::marks;

use crate::codes;
use crate::drawing::{LengthUnit, Shape};
use crate::excerpt::{Excerpts, Place, places};
use crate::model::{ModelOptions, Refused, Sheet, sheet};
use crate::units;

/// Something that is wrong with a drawing.
#[derive(Clone, PartialEq, Debug)]
pub struct Finding {
    /// The fault or warning, with its code, words and cure.
    pub fault: Diagnostic,
    /// The entities it is about, the first one first; empty where it is about the whole drawing.
    pub places: Vec<Place>,
}

/// The findings of a drawing.
#[derive(Clone, Debug)]
pub struct Report {
    /// The file as text, for excerpts; empty for a binary file.
    pub text: String,
    /// The length of one unit, as it was read; `None` of a drawing that could not be.
    pub unit: Option<LengthUnit>,
    /// Corners of the box around all geometry.
    pub extent: [[f64; 2]; 2],
    /// Errors first, then warnings.
    pub findings: Vec<Finding>,
}

impl Report {
    /// Whether the drawing cannot be solved as it is.
    pub fn has_error(&self) -> bool {
        self.findings.iter().any(|finding| finding.fault.is_error())
    }
}

/// Examines a drawing. Nothing refuses it: what cannot be read is a finding, too.
pub fn examine(bytes: Vec<u8>, options: ModelOptions<'_>) -> Report {
    let mut faults = Vec::new();
    let read = match sheet(bytes.clone(), options.unit) {
        // Without units the rest can be examined nevertheless, as if in millimetres.
        Err(refused) if is_without_units(&refused) => {
            faults.extend(refused.diagnostics);
            sheet(bytes, units::by_name("mm"))
        }
        read => read,
    };
    match read {
        Ok(sheet) => examined(&sheet, options, faults),
        Err(Refused { text, diagnostics }) => {
            faults.extend(diagnostics);
            let findings = sorted(faults);
            Report { text, unit: None, extent: [[0.0; 2]; 2], findings }
        }
    }
}

fn is_without_units(refused: &Refused) -> bool {
    matches!(refused.diagnostics.as_slice(), [only] if only.code == codes::NO_UNITS)
}

fn examined(sheet: &Sheet, options: ModelOptions<'_>, mut faults: Vec<Diagnostic>) -> Report {
    let composition = sheet.compose(options);
    faults.extend(composition.diagnostics);

    // What was not said yet of the drawing as it stands.
    let excerpts = Excerpts::new(&sheet.text);
    let mut more = strokes::twice(&sheet.drawing, composition.tolerance, &excerpts);
    more.extend(strokes::gaps(&sheet.drawing, composition.tolerance, &excerpts));
    more.extend(layers::hidden(sheet, &excerpts));
    more.extend(layers::unknown(&sheet.drawing, &excerpts));
    more.extend(unread_kinds(sheet, &excerpts));
    for fault in more {
        let said = places(&fault);
        let is_said = |known: &Diagnostic| {
            known.code == fault.code && said.iter().all(|place| places(known).contains(place))
        };
        if !faults.iter().any(is_said) {
            faults.push(fault);
        }
    }
    Report {
        text: sheet.text.clone(),
        unit: Some(sheet.drawing.unit),
        extent: sheet.drawing.extent,
        findings: sorted(faults),
    }
}

/// Errors first; else in the order in which they were found.
fn sorted(faults: Vec<Diagnostic>) -> Vec<Finding> {
    let finding = |fault: Diagnostic| Finding { places: places(&fault), fault };
    let mut findings: Vec<Finding> = faults.into_iter().map(finding).collect();
    findings.sort_by_key(|finding| finding.fault.severity != Severity::Error);
    findings
}

/// Kinds that are for reading only, and show nothing of a mechanism.
const HARMLESS: [&str; 12] = [
    "DIMENSION",
    "LEADER",
    "MULTILEADER",
    "MLEADER",
    "TEXT",
    "MTEXT",
    "ATTDEF",
    "VIEWPORT",
    "TOLERANCE",
    "IMAGE",
    "WIPEOUT",
    "SEQEND",
];

/// One warning for each kind of entity that is not read, with the first of them.
fn unread_kinds(sheet: &Sheet, excerpts: &Excerpts<'_>) -> Vec<Diagnostic> {
    let unread = sheet.drawing.entities.iter().filter(|it| it.shape == Shape::Other);
    let mut kinds: Vec<(&str, usize, &crate::drawing::Location)> = Vec::new();
    for entity in unread {
        let kind = entity.location.kind.as_str();
        let is_harmless = HARMLESS.iter().any(|known| kind.to_uppercase().contains(known));
        match kinds.iter_mut().find(|(known, ..)| *known == kind) {
            _ if is_harmless => (),
            Some((_, count, _)) => *count += 1,
            None => kinds.push((kind, 1, &entity.location)),
        }
    }
    kinds
        .into_iter()
        .map(|(kind, count, first)| {
            let what = if count == 1 { "entity" } else { "entities" };
            let message = format!("{count} {what} of the kind {kind} cannot be read as geometry");
            let help = "explode what belongs to the mechanism into lines, arcs and polylines";
            excerpts.at(Diagnostic::warning(codes::UNREAD_KIND, message).help(help), first, "")
        })
        .collect()
}
