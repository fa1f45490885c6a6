//! Warnings of a run about its start: that it is a singular pose, or one in which branches cross.
//!
//! A run may stand in such a pose for as long as nothing moves it, and its multipliers are finite; that nothing holds it there is
//! only seen in the poses around it.

use bksim_mbs::constraint::Source;
use bksim_model::Model;
use bksim_model::diagnostic::{Diagnostic, Span};
use bksim_sim::Mechanism;
use bksim_sim::start::Start;
use nalgebra::DVector;

use crate::around::{Around, Way, around};
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
/// cross (S027); of one that moves, that it follows none of these (S034).
pub fn diagnose_singular_start(mechanism: &Mechanism, start: &Start) -> Vec<Diagnostic> {
    let is_passing = start.passes_singular_pose();
    if start.not_unique_rows().is_empty() && !is_passing || start.q.len() > MOST {
        return Vec::new();
    }
    // A mechanism that cannot be compiled has faults of its own.
    found(mechanism, start, is_passing).unwrap_or_default()
}

/// Rates along a branch have this cosine with it, and more.
const ALONG: f64 = 0.9999;

/// The warnings of a start; of one that is passing a singular pose, drives let go, that its rates are those of no branch (S034).
fn found(
    mechanism: &Mechanism,
    start: &Start,
    is_passing: bool,
) -> Result<Vec<Diagnostic>, AnalysisError> {
    let (model, system) = (&mechanism.model, mechanism.system.integrated());
    let parameters = start.parameters_with_modes(&mechanism.parameters);
    let size = if start.longest_link > 0.0 { start.longest_link } else { 1.0 };
    let is_held = |row: &usize| match system.constraints[*row].source {
        Source::Drive(_) => !is_passing,
        source => !source.is_contact() || !start.inactive_rows().contains(row),
    };
    let kept: Vec<usize> = (0..system.constraints.len()).filter(is_held).collect();
    let numbers = (parameters.as_slice(), size, Clock::Held);
    let mut rows = Rows::compile(model, system, &[], &kept, numbers)?;
    let x = rows.scaled(&start.q);
    let rates = DVector::from_vec(rows.scaled(&start.v));
    let mut path = Path::of_all(&mut rows, (Law { t: start.t, ..Law::default() }, false));
    let z = path.unknowns(&x);
    // A motion that passes over along one of the branches has chosen it.
    let follows = |ways: &[Way]| {
        let along = |way: &Way| way.tangent.dot(&rates).abs() >= ALONG * rates.norm();
        is_passing && ways.iter().any(along)
    };
    let no_path = match around(&mut path, &z) {
        Around::Nowhere(directions) if !is_passing => NoPath::Nowhere(directions),
        Around::Crossing(ways) if ways.len() > 1 && !follows(&ways) => NoPath::Crossing(ways),
        _ => return Ok(Vec::new()),
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
    let (code, message, help) = if is_passing {
        let message = format!("{message}, and the start has the rates of none of them");
        let help = "state the rate of another joint in `[initial]` as one of the branches has it, or begin a little aside";
        (codes::RATES_OFF_BRANCHES, message, help)
    } else {
        let help = "begin a little aside, on the branch that is meant, so that the run keeps to it";
        (codes::BRANCHES_AT_START, message, help)
    };
    let label = if is_passing { "" } else { label };
    let warning = Diagnostic::warning(code, message).at(span, label);
    let line = |(k, way)| format!("branch {}: {}", k + 1, in_words(way));
    let notes = ways.iter().enumerate().map(line);
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
