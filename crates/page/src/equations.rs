//! The equations as MathML, which browsers typeset themselves.

use bksim::Mechanism;
use bksim::mbs::equations::page::{Page, Style, Subject};
use bksim::mbs::equations::{ReadingForm, proof};
use bksim::model::message::counted;

/// Largest number of coordinates of a mechanism whose equations are readable on a page.
const MAX_COORDINATES: usize = 60;

/// The sections of the equations, and of the model.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct Equations {
    /// Heading and HTML of formulas and of the meanings of their names.
    pub formulas: Vec<(String, String)>,
    /// Heading and HTML of bodies, joints and parameters.
    pub tables: Vec<(String, String)>,
    /// A remark on lines that are left out.
    pub remark: Option<String>,
}

/// The sections of a mechanism, each of at most `bytes` bytes of formulas.
pub(crate) fn sections(mechanism: &Mechanism, bytes: usize) -> Equations {
    let Mechanism { model, system, compiled, .. } = mechanism;
    let n_coordinates = system.coordinates().len();
    if n_coordinates > MAX_COORDINATES {
        let remark = format!(
            "The equations of {n_coordinates} coordinates are too long for a page; \
             `bksim equations` writes them."
        );
        return Equations { remark: Some(remark), ..Equations::default() };
    }
    let form = ReadingForm::grouped(model, system);
    let proof = proof(model, system, &form);
    let (coordinates, multipliers) = (&compiled.coordinates, &compiled.multipliers);
    let subject = Subject { model, system, coordinates, multipliers, form: &form, proof: &proof };
    let mut equations = Equations::default();
    let mut n_lines = 0;
    for section in Page::new(&subject, Style::MathMl).excerpts(bytes) {
        n_lines += section.n_left_out;
        let is_table = ["Bodies", "Joints", "Parameters"].contains(&section.title.as_str());
        let sections = if is_table { &mut equations.tables } else { &mut equations.formulas };
        sections.push((section.title, section.html));
    }
    equations.remark = (n_lines > 0).then(|| {
        let lines = counted(n_lines, "line of the equations is", "lines of the equations are");
        format!("{lines} left out; `bksim equations` writes them all.")
    });
    equations
}
