//! Outlines around inserts of `BK_BODY`: a body without geometry of its own takes the smallest
//! outline around its insert that nobody else has.

use std::collections::{BTreeMap, BTreeSet};

use bksim_model::diagnostic::{Diagnostic, Severity};

use super::bodies::{Bodies, Body};
use super::faults::Faults;
use super::near::{self, NearLoop};
use super::outlines::{add_doubled, report};
use super::source::Source;
use crate::codes;
use crate::drawing::{Drawing, Shape};
use crate::excerpt::short;
use crate::geometry::vector::distance;
use crate::geometry::{Curve, Path, Point, signed_area};
use crate::outline::{Apart, Chain, Outline, OutlineError, Snap, Stroke, chain_apart, surrounding};

/// Gives the outlines around inserts to their bodies; inserts are by body.
pub(super) fn take_enclosing_outlines(
    source: Source<'_>,
    bodies: &mut Bodies,
    inserts: &BTreeMap<usize, Point>,
    faults: &mut Faults<'_>,
) {
    let mut waiting: Vec<(usize, Point)> = inserts
        .iter()
        .filter(|&(&body_idx, _)| bodies.list[body_idx].paths.is_empty())
        .map(|(&body_idx, &at)| (body_idx, at))
        .collect();
    if waiting.is_empty() {
        return;
    }
    let (drawing, tolerance) = (source.drawing, source.scale.tolerance);
    let strokes = free_strokes(source, bodies);
    let Apart { chains, doubled, ambiguous } = chain_apart(&strokes, tolerance);
    let mut free = FreeChains { drawing, tolerance, chains: chains.closed };

    // An outline with a gap is none: what lies around it is another body's, or the sheet's.
    for (waiting_idx, near) in near_loops(&free, &chains.open, &waiting).into_iter().rev() {
        let (body_idx, _) = waiting.remove(waiting_idx);
        report_near(drawing, &mut bodies.list[body_idx], &near, faults);
    }

    // The smallest outlines first, so that a block in a slot is not taken for an island of the slotted
    // link.
    while let Some((waiting_idx, found)) = free.smallest(&waiting) {
        let (body_idx, _) = waiting.remove(waiting_idx);
        free.take(&found);
        let entities = found.entities();
        for &entity_idx in &entities {
            bodies.own(body_idx, entity_idx, drawing);
        }
        for it in &doubled {
            let pair = [it.kept, it.copy].map(|idx| strokes[idx].entity);
            if entities.contains(&pair[0]) {
                add_doubled(drawing, pair, faults);
            }
        }
    }

    // Ends that meet in more than one way, around what is left.
    for (body_idx, at) in waiting {
        let body = &mut bodies.list[body_idx];
        let is_stated = body.value("mass").is_some() && body.value("inertia").is_some();
        let severity = if is_stated { Severity::Warning } else { Severity::Error };
        for (error, bounds) in ambiguous.iter().filter(|(_, bounds)| bounds.contains(at)) {
            report(drawing, body, error, severity, faults);
            body.lost = Some(*bounds).filter(|_| severity == Severity::Error);
        }
    }
}

/// The curves that belong to nobody.
fn free_strokes(source: Source<'_>, bodies: &Bodies) -> Vec<Stroke> {
    let entities = source.drawing.entities.iter().enumerate();
    let free = entities.filter(|(entity_idx, entity)| {
        bodies.owner(*entity_idx).is_none() && !is_own_layer(&entity.location.layer)
    });
    free.flat_map(|(entity_idx, entity)| {
        let paths: &[Path] = match &entity.shape {
            Shape::Path(path) => std::slice::from_ref(path),
            Shape::Paths(paths) => paths,
            _ => &[],
        };
        paths.iter().map(move |path| Stroke { path: path.clone(), entity: entity_idx })
    })
    .collect()
}

/// Closed chains that surround an insert and would be its outline if a gap in them were closed, each
/// with the index of the insert.
fn near_loops(
    free: &FreeChains<'_>,
    open: &[Chain],
    waiting: &[(usize, Point)],
) -> Vec<(usize, NearLoop)> {
    let loops = near::loops(open, free.tolerance);
    let around = |(waiting_idx, &(_, at)): (usize, &(usize, Point))| {
        let is_other = |near: &&NearLoop| {
            let mut others = waiting.iter().map(|(_, other)| *other).filter(|other| *other != at);
            others.any(|other| near.chain.path.winding(other) != 0)
        };
        let near = loops.iter().find(|near| near.chain.path.winding(at) != 0 && !is_other(near))?;
        // A closed outline within it is the one that is meant, unless it is the hole of a pin.
        let size = |chain: &Chain| signed_area(&chain.path).abs();
        let inner = free.border(at, &[]).filter(|border| size(border) < size(&near.chain));
        let is_hole = |chain: &&Chain| free.is_pin(chain, at);
        inner.is_none_or(|it| is_hole(&it)).then(|| (waiting_idx, near.clone()))
    };
    waiting.iter().enumerate().filter_map(around).collect()
}

/// Adds the fault of an outline that a gap leaves open.
fn report_near(drawing: &Drawing, body: &mut Body, near: &NearLoop, faults: &mut Faults<'_>) {
    let is_stated = body.value("mass").is_some() && body.value("inertia").is_some();
    let severity = if is_stated { Severity::Warning } else { Severity::Error };
    let widest = near.gaps.iter().map(|gap| gap.distance).fold(0.0, f64::max);
    let gaps: Vec<String> = near.gaps.iter().map(Snap::words).collect();
    let message = format!("the outline around body `{}` has {}", body.name, gaps.join(" and "));
    let fault = Diagnostic { severity, ..Diagnostic::error(codes::OPEN_OUTLINE, message) };
    let help =
        format!("close it in the drawing, or allow it: `--tolerance {}`", short(widest * 1.1));
    let entities: BTreeSet<usize> = near.gaps.iter().flat_map(|gap| gap.entities).collect();
    let locations = entities.into_iter().map(|idx| &drawing.entities[idx].location);
    faults.add_at_all(fault.help(help), locations.collect::<Vec<_>>());
    body.has_bad_outline |= severity == Severity::Error;
    body.lost = Some(near.chain.path.bounds()).filter(|_| severity == Severity::Error);
}

/// True if a layer is one of ours, so that its geometry is no outline of anybody.
fn is_own_layer(layer: &str) -> bool {
    layer.get(..3).is_some_and(|head| head.eq_ignore_ascii_case("BK_"))
}

/// Closed chains that are no body's yet.
struct FreeChains<'a> {
    drawing: &'a Drawing,
    tolerance: f64,
    chains: Vec<Chain>,
}

impl FreeChains<'_> {
    /// Of the outlines around waiting inserts the smallest, and the index of the insert it is around.
    fn smallest(&self, waiting: &[(usize, Point)]) -> Option<(usize, Outline)> {
        let around = |(waiting_idx, &(_, at)): (usize, &(usize, Point))| {
            let others = waiting.iter().map(|(_, other)| *other).filter(|other| *other != at);
            Some((waiting_idx, self.outline_around(at, &others.collect::<Vec<_>>())?))
        };
        let size = |outline: &Outline| outline.bounds().diagonal();
        let found = waiting.iter().enumerate().filter_map(around);
        found.min_by(|a, b| size(&a.1).total_cmp(&size(&b.1)))
    }

    /// Outlines belong to one body; the hole of a pin, drawn once, goes through all its links.
    fn take(&mut self, outline: &Outline) {
        let outer = outline.loops.iter().filter(|part| !part.is_hole);
        let taken: Vec<usize> = outer.flat_map(|part| part.entities.iter().copied()).collect();
        self.chains.retain(|chain| chain.entities.iter().all(|entity| !taken.contains(entity)));
    }

    /// The smallest outline around a point with its holes. Links are drawn over one another: what
    /// crosses an outline belongs to another body.
    fn outline_around(&self, at: Point, others: &[Point]) -> Option<Outline> {
        let border = self.border(at, others)?;
        // A block of the author's own is a part by itself: its outlines are no holes of others.
        let is_block =
            |entity: &usize| matches!(self.drawing.entities[*entity].shape, Shape::Paths(_));
        let is_own = |chain: &Chain| chain.entities == border.entities;
        let is_apart = |chain: &&Chain| is_own(chain) || !chain.entities.iter().any(is_block);
        let mut chains: Vec<Chain> = self.chains.iter().filter(is_apart).cloned().collect();

        // Without the chains that cross, one after the other, until none is left that does.
        loop {
            let border_idx = chains.iter().position(|chain| chain.path == border.path)?;
            let crossing = match Outline::inside(&chains, border_idx, self.tolerance) {
                Ok(found) => return Some(found),
                // The hole of a pin is drawn once for each of its links: one of them is this body's.
                Err(OutlineError::Coincident { entities: [_, second], .. }) => vec![second],
                Err(error) => error.entities(),
            };
            let n_before = chains.len();
            chains.retain(|chain| {
                is_own(chain) || chain.entities.iter().all(|entity| !crossing.contains(entity))
            });
            if chains.len() == n_before {
                return None;
            }
        }
    }

    /// The smallest closed chain around an insert; where it stands on a pin, in the middle of the
    /// hole, the one around that. A chain that surrounds other bodies, too, is the border of the sheet.
    fn border(&self, at: Point, others: &[Point]) -> Option<&Chain> {
        let around: Vec<&Chain> = surrounding(&self.chains, at)
            .into_iter()
            .map(|chain_idx| &self.chains[chain_idx])
            .collect();
        let is_pin = |chain: &Chain| self.is_pin(chain, at);
        let is_sheet = |chain: &Chain| others.iter().any(|other| chain.path.winding(*other) != 0);
        let beyond = around.iter().find(|chain| !is_pin(chain)).filter(|chain| !is_sheet(chain));
        // A disc that turns about its middle has circles only: its rim is the largest.
        let rim = around.iter().take_while(|chain| is_pin(chain)).last();
        beyond.or(rim).or(around.first()).copied()
    }

    /// True if a chain is a circle about a point.
    fn is_pin(&self, chain: &Chain, at: Point) -> bool {
        match chain.path.curves.as_slice() {
            [Curve::Arc { centre, .. }] => distance(*centre, at) <= self.tolerance,
            _ => false,
        }
    }
}
