//! Outlines around inserts of `BK_BODY`: a body without geometry of its own takes the smallest
//! outline around its insert that nobody else has.

use std::collections::BTreeMap;

use super::bodies::Bodies;
use super::source::Source;
use crate::drawing::{Drawing, Shape};
use crate::geometry::vector::distance;
use crate::geometry::{Curve, Path, Point};
use crate::outline::{Chain, Outline, OutlineError, Stroke, chain, surrounding};

/// Gives the outlines around inserts to their bodies; inserts are by body.
pub(super) fn take_enclosing_outlines(
    source: Source<'_>,
    bodies: &mut Bodies,
    inserts: &BTreeMap<usize, Point>,
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
    let mut free = FreeChains { drawing, tolerance, chains: free_chains(source, bodies) };

    // The smallest outlines first, so that a block in a slot is not taken for an island of the slotted
    // link.
    while let Some((waiting_idx, found)) = free.smallest(&waiting) {
        let (body_idx, _) = waiting.remove(waiting_idx);
        free.take(&found);
        for entity_idx in found.entities() {
            bodies.own(body_idx, entity_idx, drawing);
        }
    }
}

/// Closed chains of entities that belong to nobody.
fn free_chains(source: Source<'_>, bodies: &Bodies) -> Vec<Chain> {
    let entities = source.drawing.entities.iter().enumerate();
    let free = entities.filter(|(entity_idx, entity)| {
        bodies.owner(*entity_idx).is_none() && !is_own_layer(&entity.location.layer)
    });
    let strokes: Vec<Stroke> = free
        .flat_map(|(entity_idx, entity)| {
            let paths: &[Path] = match &entity.shape {
                Shape::Path(path) => std::slice::from_ref(path),
                Shape::Paths(paths) => paths,
                _ => &[],
            };
            paths.iter().map(move |path| Stroke { path: path.clone(), entity: entity_idx })
        })
        .collect();
    if let Ok(chains) = chain(&strokes, source.scale.tolerance) {
        return chains.closed;
    }
    // Somewhere in the drawing three lines meet: what is closed by itself still counts.
    let closed = strokes.into_iter().filter(|stroke| stroke.path.is_closed);
    closed.map(|stroke| Chain { path: stroke.path, entities: vec![stroke.entity] }).collect()
}

/// Whether a layer is one of ours, so that its geometry is no outline of anybody.
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
}
