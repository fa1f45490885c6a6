//! The outlines of bodies, and which outline an insert stands in.

use bksim_mbs::diagnostic::{Diagnostic, Severity};

use super::Composer;
use crate::drawing::Shape;
use crate::geometry::vector::distance;
use crate::geometry::{Curve, Path, Point};
use crate::outline::{Chain, Chains, Outline, OutlineError, Stroke, chain, nest, surrounding};

impl Composer<'_> {
    /// An insert of `BK_BODY` takes the smallest outline around it that nobody else has.
    pub(super) fn gather_enclosed(&mut self) {
        let mut waiting: Vec<(usize, Point)> = self
            .insert_points
            .iter()
            .filter(|&(&part_idx, _)| self.parts[part_idx].paths.is_empty())
            .map(|(&part_idx, &at)| (part_idx, at))
            .collect();
        if waiting.is_empty() {
            return;
        }
        let mut free = self.free_chains();
        // The smallest outlines first, so that a block in a slot is not taken for an island of the
        // slotted link.
        while let Some((waiting_idx, found)) = self.smallest(&free, &waiting) {
            let (part_idx, _) = waiting.remove(waiting_idx);
            // Outlines belong to one body; the hole of a pin, drawn once, goes through all its links.
            let outer = found.loops.iter().filter(|part| !part.is_hole);
            let taken: Vec<usize> = outer.flat_map(|part| part.entities.iter().copied()).collect();
            free.retain(|chain| chain.entities.iter().all(|entity| !taken.contains(entity)));
            for entity_idx in found.entities() {
                self.own(part_idx, entity_idx);
            }
        }
    }

    /// Closed chains of entities that belong to nobody.
    fn free_chains(&self) -> Vec<Chain> {
        let strokes: Vec<Stroke> = self
            .drawing
            .entities
            .iter()
            .enumerate()
            .filter(|(entity_idx, entity)| {
                self.owners[*entity_idx].is_none() && !is_ours(&entity.location.layer)
            })
            .flat_map(|(entity, known)| {
                let paths: &[Path] = match &known.shape {
                    Shape::Path(path) => std::slice::from_ref(path),
                    Shape::Paths(paths) => paths,
                    _ => &[],
                };
                paths.iter().map(move |path| Stroke { path: path.clone(), entity })
            })
            .collect();
        if let Ok(chains) = chain(&strokes, self.tolerance) {
            return chains.closed;
        }
        // Somewhere in the drawing three lines meet: what is closed by itself still counts.
        let closed = strokes.into_iter().filter(|stroke| stroke.path.is_closed);
        closed.map(|stroke| Chain { path: stroke.path, entities: vec![stroke.entity] }).collect()
    }

    /// Of the outlines around waiting inserts the smallest, and which insert it is around.
    fn smallest(&self, free: &[Chain], waiting: &[(usize, Point)]) -> Option<(usize, Outline)> {
        let around = |(waiting_idx, (_, at)): (usize, &(usize, Point))| {
            let others = waiting.iter().map(|(_, other)| *other).filter(|other| other != at);
            Some((waiting_idx, self.around_insert(free, *at, &others.collect::<Vec<_>>())?))
        };
        let size = |outline: &Outline| outline.bounds().diagonal();
        let found = waiting.iter().enumerate().filter_map(around);
        found.min_by(|a, b| size(&a.1).total_cmp(&size(&b.1)))
    }

    /// The smallest outline around a point with its holes. Links are drawn over one another: what
    /// crosses an outline belongs to another body.
    fn around_insert(&self, free: &[Chain], at: Point, others: &[Point]) -> Option<Outline> {
        let border = self.border(free, at, others)?;
        // A block of the author's own is a part by itself: its outlines are no holes of others.
        let is_block =
            |entity: &usize| matches!(self.drawing.entities[*entity].shape, Shape::Paths(_));
        let is_own = |chain: &Chain| chain.entities == border.entities;
        let is_apart = |chain: &&Chain| is_own(chain) || !chain.entities.iter().any(is_block);
        let mut chains: Vec<Chain> = free.iter().filter(is_apart).cloned().collect();
        loop {
            let border_idx = chains.iter().position(|chain| chain.path == border.path)?;
            let crossing = match Outline::inside(&chains, border_idx, self.tolerance) {
                Ok(found) => return Some(found),
                // The hole of a pin is drawn once for each of its links: one of them is this body's.
                Err(OutlineError::Coincident { entities: [_, twin], .. }) => vec![twin],
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
    /// hole, the one around that. What surrounds other bodies, too, is the border of the sheet.
    fn border<'c>(&self, free: &'c [Chain], at: Point, others: &[Point]) -> Option<&'c Chain> {
        let around: Vec<&Chain> =
            surrounding(free, at).into_iter().map(|chain_idx| &free[chain_idx]).collect();
        let is_pin = |chain: &Chain| match chain.path.curves.as_slice() {
            [Curve::Arc { centre, .. }] => distance(*centre, at) <= self.tolerance,
            _ => false,
        };
        let is_sheet = |chain: &Chain| others.iter().any(|other| chain.path.winding(*other) != 0);
        let beyond = around.iter().find(|chain| !is_pin(chain)).filter(|chain| !is_sheet(chain));
        // A disc that turns about its middle has circles only: its rim is the largest.
        let rim = around.iter().take_while(|chain| is_pin(chain)).last();
        beyond.or(rim).or(around.first()).copied()
    }

    /// The closed outline of a part, and what is left open.
    pub(super) fn close_outline(&mut self, part_idx: usize) {
        let part = &self.parts[part_idx];
        // Hatches fill outlines that are drawn, too; alone, they are the outline.
        let is_hatch =
            |entity: usize| matches!(self.drawing.entities[entity].shape, Shape::Hatch(_));
        let has_lines = part.paths.iter().any(|&(_, entity)| !is_hatch(entity));
        let strokes: Vec<Stroke> = part
            .paths
            .iter()
            .filter(|(_, entity)| !(has_lines && is_hatch(*entity)))
            .map(|(path, entity)| Stroke { path: path.clone(), entity: *entity })
            .collect();
        // The ground may be drawn in any way: it has no mass.
        let is_needed =
            part_idx > 0 && !(part.value("mass").is_some() && part.value("inertia").is_some());
        let found = chain(&strokes, self.tolerance).and_then(|chains| {
            let outline = nest(&chains.closed, self.tolerance);
            // A body without a closed chain has no outline, rather than an empty one.
            if chains.closed.is_empty() { Ok((chains, None)) } else { Ok((chains, Some(outline?))) }
        });
        self.parts[part_idx].outline = match found {
            Ok((chains, outline)) => {
                if is_needed {
                    self.report_gaps(part_idx, chains, outline.as_ref());
                }
                outline
            }
            Err(error) => {
                if is_needed {
                    self.outline_fault(part_idx, &error, Severity::Error);
                }
                None
            }
        };
    }

    /// Says which gaps were closed and which could not be. Centre lines do no harm, nor does what
    /// ends inside of the outline; anything else may be the outline itself, with a gap.
    fn report_gaps(&mut self, part_idx: usize, mut chains: Chains, outline: Option<&Outline>) {
        for snap in &chains.snaps {
            let location = self.drawing.entities[snap.entities[0]].location.clone();
            self.fault(snap.diagnostic().help(apart(snap.distance)), &location);
        }
        chains.open.retain(|chain| {
            let is_line = matches!(chain.path.curves.as_slice(), [Curve::Segment { .. }]);
            let ends = [chain.path.start_point(), chain.path.end_point()];
            let is_inside = |end: &Point| outline.is_some_and(|it| it.outer_contains(*end));
            !is_line && !ends.iter().flatten().all(is_inside)
        });
        let is_weighed = self.parts[part_idx].value("mass").is_none();
        let severity = if is_weighed { Severity::Error } else { Severity::Warning };
        if let Some(open) = chains.open_error() {
            self.outline_fault(part_idx, &open, severity);
        }
    }

    fn outline_fault(&mut self, part_idx: usize, error: &OutlineError, severity: Severity) {
        let name = &self.parts[part_idx].name;
        let fault = error.diagnostic();
        let is_error = severity == Severity::Error;
        let message = format!("body `{name}`: {}", fault.message);
        let fault = Diagnostic { message, severity, ..fault };
        let fault = match severity {
            Severity::Error => fault,
            Severity::Warning => fault.note("what is open counts for nothing in the mass"),
        };
        let entities = error.entities();
        let locations: Vec<_> =
            entities.iter().take(4).map(|&e| self.drawing.entities[e].location.clone()).collect();
        let fault =
            locations.iter().fold(fault, |fault, location| self.excerpts.at(fault, location, ""));
        self.faults.push(fault);
        self.parts[part_idx].has_bad_outline |= is_error;
    }

    /// Whether a feature is a centre of a part, not a corner of its outline.
    pub(super) fn is_centre(&self, part_idx: usize, feature: Point) -> bool {
        let mut curves = self.parts[part_idx].paths.iter().flat_map(|(path, _)| &path.curves);
        curves.any(|curve| {
            matches!(curve, Curve::Arc { centre, .. } if distance(*centre, feature) <= self.step)
        })
    }
}

/// How to keep two points apart.
pub(super) fn apart(distance: f64) -> String {
    let less = crate::excerpt::short(distance * 0.9);
    format!("draw them at one point; `--tolerance {less}` would keep them apart")
}

/// Whether a layer is one of ours, so that its geometry is no outline of anybody.
fn is_ours(layer: &str) -> bool {
    layer.get(..3).is_some_and(|head| head.eq_ignore_ascii_case("BK_"))
}
