//! Everything that is found wrong with a drawing, or looks wrong, each with its place and its cure.
//!
//! The findings of composing the model come first; then those that it need not care about, but a person should see:
//! entities drawn twice, outlines with gaps, layers that are not shown or have nearly the name of one that
//! means something, and entities of kinds that are not read.

mod layers;
mod marks;
mod strokes;

use std::collections::{BTreeMap, BTreeSet};

use bksim_model::diagnostic::{Diagnostic, Severity};

pub use crate::kind::DOCTOR_LAYER;
pub use marks::marks;

use crate::codes;
use crate::drawing::{Entity, LengthUnit};
use crate::excerpt::{Excerpts, Place, places};
use crate::model::{ModelOptions, Refused, Sheet, sheet};
use crate::units;
use crate::unread::{is_of_shapes, kinds};

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
    /// True if the drawing cannot be solved as it is.
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
    // On layers of shapes they have been said.
    let is_elsewhere = |entity: &Entity| !is_of_shapes(&entity.location.layer);
    more.extend(kinds(&sheet.drawing, &excerpts, is_elsewhere));
    let mut said = Said::default();
    for fault in &faults {
        said.add(fault);
    }
    for fault in more {
        if !said.has(&fault) {
            said.add(&fault);
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

/// The faults that have been found, each with its code and its places as texts.
#[derive(Default)]
struct Said {
    all: Vec<Vec<String>>,
    /// By code and place: the faults there.
    by_place: BTreeMap<(&'static str, String), Vec<usize>>,
    codes: BTreeSet<&'static str>,
}

impl Said {
    fn words(fault: &Diagnostic) -> Vec<String> {
        places(fault).iter().map(|place| format!("{place:?}")).collect()
    }

    fn add(&mut self, fault: &Diagnostic) {
        let (words, idx) = (Self::words(fault), self.all.len());
        for place in &words {
            self.by_place.entry((fault.code.0, place.clone())).or_default().push(idx);
        }
        self.codes.insert(fault.code.0);
        self.all.push(words);
    }

    /// True if a fault of this code is about all of its places.
    fn has(&self, fault: &Diagnostic) -> bool {
        let words = Self::words(fault);
        let Some(first) = words.first() else { return self.codes.contains(fault.code.0) };
        let known = self.by_place.get(&(fault.code.0, first.clone()));
        let is_about_all = |idx: &usize| words.iter().all(|place| self.all[*idx].contains(place));
        known.is_some_and(|known| known.iter().any(is_about_all))
    }
}

/// Errors first; else in the order in which they were found.
fn sorted(faults: Vec<Diagnostic>) -> Vec<Finding> {
    let finding = |fault: Diagnostic| Finding { places: places(&fault), fault };
    let mut findings: Vec<Finding> = faults.into_iter().map(finding).collect();
    findings.sort_by_key(|finding| finding.fault.severity != Severity::Error);
    findings
}
