//! The closed outline of each body, and the gaps that are left in it.

use bksim_model::diagnostic::{Diagnostic, Severity};

use super::bodies::{Bodies, Body, GROUND};
use super::faults::Faults;
use super::snap::apart;
use super::source::Source;
use crate::drawing::{Drawing, Location, Shape};
use crate::geometry::{Curve, Point};
use crate::outline::{Chains, Outline, OutlineError, Stroke, chain, nest};

/// Finds the outline of every body, and reports the faults of those that are needed.
pub(super) fn close_outlines(source: Source<'_>, bodies: &mut Bodies, faults: &mut Faults<'_>) {
    let (drawing, tolerance) = (source.drawing, source.scale.tolerance);
    for (body_idx, body) in bodies.list.iter_mut().enumerate() {
        // The ground may be drawn in any way: it has no mass.
        let is_stated = body.value("mass").is_some() && body.value("inertia").is_some();
        let is_needed = body_idx != GROUND && !is_stated;
        match outline_of(drawing, body, tolerance) {
            Ok((chains, outline)) => {
                body.outline = outline;
                if is_needed {
                    report_gaps(drawing, body, chains, faults);
                }
            }
            Err(error) if is_needed => report(drawing, body, &error, Severity::Error, faults),
            Err(_) => (),
        }
    }
}

/// The chains of a body's curves, and the outline that the closed ones make.
fn outline_of(
    drawing: &Drawing,
    body: &Body,
    tolerance: f64,
) -> Result<(Chains, Option<Outline>), OutlineError> {
    // Hatches fill outlines that are drawn, too; alone, they are the outline.
    let is_hatch = |entity: usize| matches!(drawing.entities[entity].shape, Shape::Hatch(_));
    let has_lines = body.paths.iter().any(|&(_, entity)| !is_hatch(entity));
    let strokes: Vec<Stroke> = body
        .paths
        .iter()
        .filter(|(_, entity)| !(has_lines && is_hatch(*entity)))
        .map(|(path, entity)| Stroke { path: path.clone(), entity: *entity })
        .collect();
    let chains = chain(&strokes, tolerance)?;
    // A body without a closed chain has no outline, rather than an empty one.
    let outline = match chains.closed.as_slice() {
        [] => None,
        closed => Some(nest(closed, tolerance)?),
    };
    Ok((chains, outline))
}

/// Reports which gaps were closed and which could not be. Centre lines do no harm, nor does what ends
/// inside of the outline; anything else may be the outline itself, with a gap.
fn report_gaps(drawing: &Drawing, body: &mut Body, mut chains: Chains, faults: &mut Faults<'_>) {
    for snap in &chains.snaps {
        let location = &drawing.entities[snap.entities[0]].location;
        faults.add(snap.diagnostic().help(apart(snap.distance)), location);
    }
    chains.open.retain(|chain| {
        let is_line = matches!(chain.path.curves.as_slice(), [Curve::Segment { .. }]);
        let ends = [chain.path.start_point(), chain.path.end_point()];
        let outline = body.outline.as_ref();
        let is_inside = |end: &Point| outline.is_some_and(|it| it.outer_contains(*end));
        !is_line && !ends.iter().flatten().all(is_inside)
    });
    let is_weighed = body.value("mass").is_none();
    let severity = if is_weighed { Severity::Error } else { Severity::Warning };
    if let Some(open) = chains.open_error() {
        report(drawing, body, &open, severity, faults);
    }
}

/// Adds the fault of an outline with its body and its entities.
fn report(
    drawing: &Drawing,
    body: &mut Body,
    error: &OutlineError,
    severity: Severity,
    faults: &mut Faults<'_>,
) {
    /// More entities of one fault say nothing more.
    const MAX_SHOWN: usize = 4;
    let fault = error.diagnostic();
    let message = format!("body `{}`: {}", body.name, fault.message);
    let fault = Diagnostic { message, severity, ..fault };
    let fault = match severity {
        Severity::Error => fault,
        Severity::Warning => fault.note("what is open counts for nothing in the mass"),
    };
    let entities = error.entities();
    let locations = entities.iter().take(MAX_SHOWN).map(|&idx| &drawing.entities[idx].location);
    faults.add_at_all(fault, locations.collect::<Vec<&Location>>());
    body.has_bad_outline |= severity == Severity::Error;
}
