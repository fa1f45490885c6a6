//! Warnings of a run about its start: that it is a singular pose, or one in which branches cross.
//!
//! A run may stand in such a pose for as long as nothing moves it, and its multipliers are finite; that nothing holds it there is
//! only seen in the poses around it.

use bksim_model::Model;
use bksim_model::diagnostic::{Diagnostic, Span};
use bksim_sim::Mechanism;
use bksim_sim::start::Start;

use crate::around::{Around, around};
use crate::codes;
use crate::error::AnalysisError;
use crate::path::{Law, NoPath, Path};
use crate::quantity::pose_quantities;
use crate::rows::{Clock, Rows};
use crate::scalar::Scalars;
use crate::way_rates::{ASIDE, in_words};
use crate::ways::Named;

/// Most coordinates of a mechanism whose start is looked at: the decompositions are dense.
const MOST: usize = 200;

/// Warnings that the start is a singular pose, drives held: one that yields but goes nowhere (S026), or one in which branches
/// cross (S027).
pub fn diagnose_singular_start(mechanism: &Mechanism, start: &Start) -> Vec<Diagnostic> {
    if start.not_unique_rows().is_empty() || start.q.len() > MOST {
        return Vec::new();
    }
    // A mechanism that cannot be compiled has faults of its own.
    found(mechanism, start).unwrap_or_default()
}

fn found(mechanism: &Mechanism, start: &Start) -> Result<Vec<Diagnostic>, AnalysisError> {
    let (model, system) = (&mechanism.model, mechanism.system.integrated());
    let parameters = start.parameters_with_modes(&mechanism.parameters);
    let size = if start.longest_link > 0.0 { start.longest_link } else { 1.0 };
    let is_held = |row: &usize| {
        !system.constraints[*row].source.is_contact() || !start.inactive_rows().contains(row)
    };
    let kept: Vec<usize> = (0..system.constraints.len()).filter(is_held).collect();
    let numbers = (parameters.as_slice(), size, Clock::Held);
    let mut rows = Rows::compile(model, system, &[], &kept, numbers)?;
    let x = rows.scaled(&start.q);
    let mut path = Path::of_all(&mut rows, (Law { t: start.t, ..Law::default() }, false));
    let z = path.unknowns(&x);
    let no_path = match around(&mut path, &z) {
        Around::Nowhere(directions) => NoPath::Nowhere(directions),
        Around::Crossing(ways) if ways.len() > 1 => NoPath::Crossing(ways),
        Around::Crossing(_) | Around::Regular(_) => return Ok(Vec::new()),
    };
    let quantities = pose_quantities(model, system);
    let functions: Vec<_> = quantities.iter().map(|quantity| quantity.value).collect();
    let scalars = Scalars::compile(model, system, &functions, &parameters)?;
    let mut named = Named::of((model, system), &quantities, scalars, (size, start.t));
    let other = |n_free| AnalysisError::NotOneMotion { n_free };
    let fault = named.fault(no_path, &start.q, ASIDE, other);
    let message = fault.to_string();
    let (span, label) = place(model);
    let AnalysisError::BranchPoint { ways, .. } = fault else {
        let help = "begin in another pose, or change a length or the value of a drive: no finite forces hold it here";
        let warning = Diagnostic::warning(codes::SINGULAR_START, message);
        return Ok(vec![warning.at(span, label).help(help)]);
    };
    let warning = Diagnostic::warning(codes::BRANCHES_AT_START, message).at(span, label);
    let line = |(k, way)| format!("branch {}: {}", k + 1, in_words(way));
    let notes = ways.iter().enumerate().map(line);
    let help = "begin a little aside, on the branch that is meant, so that the run keeps to it";
    Ok(vec![notes.fold(warning, Diagnostic::note).help(help)])
}

/// The drive or joint that a start is about.
fn place(model: &Model) -> (Span, &'static str) {
    match (model.drives.first(), model.joints.first()) {
        (Some(drive), _) => (drive.span.clone(), "with the drives held"),
        (None, Some(joint)) => (joint.span.clone(), "one of the joints"),
        _ => (0..0, ""),
    }
}
