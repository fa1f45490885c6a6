//! The closed outline of each body, and the gaps that are left in it.

use bksim_model::diagnostic::{Diagnostic, Severity};

use super::bodies::{Bodies, Body, GROUND};
use super::faults::Faults;
use super::snap::apart;
use super::source::Source;
use crate::codes;
use crate::drawing::{Drawing, Location, Shape};
use crate::excerpt::short;
use crate::geometry::vector::along;
use crate::geometry::{Bounds, Curve, Path, Point};
use crate::outline::{Chains, Outline, OutlineError, Stroke, chain, doubled, nest};

/// A gap wider than this part of the size of its body or loop was not meant to be closed.
pub(super) const WIDEST_GAP: f64 = 0.05;

/// Finds the outline of every body, and reports the faults of those that are needed.
pub(super) fn close_outlines(source: Source<'_>, bodies: &mut Bodies, faults: &mut Faults<'_>) {
    let (drawing, tolerance) = (source.drawing, source.scale.tolerance);
    for (body_idx, body) in bodies.list.iter_mut().enumerate() {
        // The ground may be drawn in any way: it has no mass.
        let is_stated = body.value("mass").is_some() && body.value("inertia").is_some();
        let is_needed = body_idx != GROUND && !is_stated;
        match outline_of(drawing, body, tolerance) {
            Ok(Drawn { chains, outline, doubled }) => {
                body.outline = outline;
                for pair in doubled {
                    add_doubled(drawing, pair, faults);
                }
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
fn outline_of(drawing: &Drawing, body: &Body, tolerance: f64) -> Result<Drawn, OutlineError> {
    // Hatches fill outlines that are drawn, too; alone, they are the outline.
    let is_fill = |entity: usize| matches!(drawing.entities[entity].shape, Shape::Hatch(_));
    if body.paths.iter().all(|&(_, entity)| is_fill(entity)) {
        return taken_once(&strokes(body, |_| true), tolerance);
    }
    let drawn = taken_once(&strokes(body, |&(_, entity)| !is_fill(entity)), tolerance)?;
    // Areas of three or four corners are outlines of their own, unless they fill one that is drawn; so are hatches, whose
    // borders need not follow the lines, where no part of them is in what is drawn.
    let is_more = |(path, entity): &(Path, usize)| {
        let is_hatch = drawing.entities[*entity].location.kind == "HATCH";
        is_fill(*entity)
            && match &drawn.outline {
                Some(outline) if is_hatch => is_apart_from(outline, path, tolerance),
                Some(outline) => !is_filled_by(outline, path, tolerance),
                None => !is_hatch,
            }
    };
    if !body.paths.iter().any(is_more) {
        return Ok(drawn);
    }
    taken_once(&strokes(body, |it| !is_fill(it.1) || is_more(it)), tolerance)
}

/// The curves of a body that are chosen.
fn strokes(body: &Body, is_meant: impl Fn(&(Path, usize)) -> bool) -> Vec<Stroke> {
    let meant = body.paths.iter().filter(|it| is_meant(it));
    meant.map(|(path, entity)| Stroke { path: path.clone(), entity: *entity }).collect()
}

/// True if an area of straight edges fills an outline or a part of it: its corners are in the material or on
/// the border, and its middle is in the material or a hole.
fn is_filled_by(outline: &Outline, area: &Path, tolerance: f64) -> bool {
    let corners: Vec<Point> = area.curves.iter().map(Curve::start_point).collect();
    let share = 1.0 / corners.len() as f64;
    let middle = corners.iter().fold([0.0; 2], |sum, corner| along(sum, share, *corner));
    let is_near = |at: Point| outline.distance(at) <= tolerance;
    corners.iter().all(|corner| is_near(*corner) || outline.contains(*corner))
        && (is_near(middle) || outline.outer_contains(middle))
}

/// True if no corner of the border of a filled area is in an outline, in a hole of it, or on its border.
fn is_apart_from(outline: &Outline, area: &Path, tolerance: f64) -> bool {
    let mut corners = area.curves.iter().map(Curve::start_point);
    corners.all(|at| !outline.outer_contains(at) && outline.distance(at) > tolerance)
}

/// The outline that strokes make; what is drawn twice is taken once.
fn taken_once(strokes: &[Stroke], tolerance: f64) -> Result<Drawn, OutlineError> {
    let error = match chained(strokes, tolerance) {
        Ok((chains, outline)) => return Ok(Drawn { chains, outline, doubled: Vec::new() }),
        Err(error) => error,
    };
    // Ends that meet in more than one way, and loops on top of each other, may be what is drawn twice.
    let may_be_doubled =
        matches!(error, OutlineError::Ambiguous { .. } | OutlineError::Coincident { .. });
    let doubled = if may_be_doubled { doubled(strokes, tolerance) } else { Vec::new() };
    if doubled.is_empty() {
        return Err(error);
    }
    let mut is_copy = vec![false; strokes.len()];
    for it in &doubled {
        is_copy[it.copy] = true;
    }
    let kept = strokes.iter().zip(&is_copy).filter(|(_, is_copy)| !**is_copy);
    let kept: Vec<Stroke> = kept.map(|(stroke, _)| stroke.clone()).collect();
    let (chains, outline) = chained(&kept, tolerance)?;
    let pairs = doubled.iter().map(|it| [it.kept, it.copy].map(|idx| strokes[idx].entity));
    let mut doubled: Vec<[usize; 2]> = pairs.filter(|[kept, copy]| kept != copy).collect();
    doubled.dedup();
    Ok(Drawn { chains, outline, doubled })
}

/// The chains of strokes, and the outline that the closed ones make; without a closed chain there is none, rather
/// than an empty one.
fn chained(strokes: &[Stroke], tolerance: f64) -> Result<(Chains, Option<Outline>), OutlineError> {
    let chains = chain(strokes, tolerance)?;
    let outline = match chains.closed.as_slice() {
        [] => None,
        closed => Some(nest(closed, tolerance)?),
    };
    Ok((chains, outline))
}

/// The outlines that the curves of a body make.
struct Drawn {
    chains: Chains,
    outline: Option<Outline>,
    /// Entities that are taken, each with one on top of it that is not.
    doubled: Vec<[usize; 2]>,
}

/// Warns that an entity lies on another one of the same body.
pub(super) fn add_doubled(drawing: &Drawing, [kept, copy]: [usize; 2], faults: &mut Faults<'_>) {
    let [kept, copy] = [kept, copy].map(|idx| &drawing.entities[idx].location);
    let message = format!("a {} lies on a {} and is passed over", copy.kind, kept.kind);
    let help = "delete it (`OVERKILL` in most CAD programs)";
    let warning = Diagnostic::warning(codes::DOUBLED, message).help(help);
    faults.add_pair(warning, [copy, kept]);
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
        let help = tolerance_that_closes(body, &open);
        report_with(drawing, body, &open, (severity, help), faults);
    }
}

/// The help that names the tolerance under which all gaps close, where they are small.
fn tolerance_that_closes(body: &Body, open: &OutlineError) -> Option<String> {
    let OutlineError::Open { ends } = open else { return None };
    let bounds =
        body.paths.iter().map(|(path, _)| path.bounds()).fold(Bounds::EMPTY, Bounds::union);
    let gaps = ends.iter().map(|end| end.gap.unwrap_or(f64::INFINITY));
    let widest = gaps.fold(0.0, f64::max);
    (widest <= WIDEST_GAP * bounds.diagonal()).then(|| {
        let tolerance = short(widest * 1.1);
        format!("close the gaps in the drawing, or allow them: `--tolerance {tolerance}`")
    })
}

/// Adds the fault of an outline with its body and its entities.
pub(super) fn report(
    drawing: &Drawing,
    body: &mut Body,
    error: &OutlineError,
    severity: Severity,
    faults: &mut Faults<'_>,
) {
    report_with(drawing, body, error, (severity, None), faults);
}

fn report_with(
    drawing: &Drawing,
    body: &mut Body,
    error: &OutlineError,
    (severity, help): (Severity, Option<String>),
    faults: &mut Faults<'_>,
) {
    /// More entities of one fault say nothing more.
    const MAX_SHOWN: usize = 4;
    let fault = error.diagnostic();
    let message = format!("body `{}`: {}", body.name, fault.message);
    let fault = Diagnostic { message, severity, help: help.or(fault.help.clone()), ..fault };
    let fault = match severity {
        Severity::Error => fault,
        Severity::Warning => fault.note("what is open counts for nothing in the mass"),
    };
    let entities = error.entities();
    let locations = entities.iter().take(MAX_SHOWN).map(|&idx| &drawing.entities[idx].location);
    faults.add_at_all(fault, locations.collect::<Vec<&Location>>());
    body.has_bad_outline |= severity == Severity::Error;
}
