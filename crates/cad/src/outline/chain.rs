//! Chaining: open paths are joined end to end until they close.

use super::boxes::BoxTree;
use super::error::position;
use super::{OpenEnd, OutlineError, Stroke};
use crate::codes;
use crate::excerpt::short;
use crate::geometry::vector::distance;
use crate::geometry::{Bounds, Curve, Path, Point};
use bksim_model::diagnostic::Diagnostic;

/// Gaps below this, relative to the largest coordinate, are rounding and not worth a word.
const ROUNDING: f64 = 1e-12;

/// A gap that was closed by a straight line.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Snap {
    /// The end of one path.
    pub from: Point,
    /// The end of the other.
    pub to: Point,
    /// Between the two.
    pub distance: f64,
    /// The entities of the two paths; the same one twice when a path closes itself.
    pub entities: [usize; 2],
}

impl Snap {
    /// Warning without locations: the drawing has a gap that was bridged.
    pub fn diagnostic(&self) -> Diagnostic {
        Diagnostic::warning(codes::SNAPPED, format!("{} was closed", self.words()))
    }

    /// `a gap of 0.1 units from (10, 0) to (10.1, 0)`.
    pub fn words(&self) -> String {
        let [from, to] = [self.from, self.to].map(|end| position(&end));
        format!("a gap of {} units from {from} to {to}", short(self.distance))
    }
}

/// Strokes joined to one path.
#[derive(Clone, PartialEq, Debug)]
pub struct Chain {
    /// Curves of the chain, with a line over every gap that was snapped.
    pub path: Path,
    /// The entities it is made of, in the order of the path.
    pub entities: Vec<usize>,
}

/// The paths that strokes make.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Chains {
    /// In the order of their first strokes.
    pub closed: Vec<Chain>,
    /// In the order of their first strokes.
    pub open: Vec<Chain>,
    /// All gaps that were closed, in the order of the chains.
    pub snaps: Vec<Snap>,
}

impl Chains {
    /// The error of the ends that meet no other; `None` when all chains are closed.
    pub fn open_error(&self) -> Option<OutlineError> {
        let ends = self.open.iter().flat_map(|chain| {
            let first = chain.path.start_point().zip(chain.entities.first());
            let last = chain.path.end_point().zip(chain.entities.last());
            [first, last].into_iter().flatten()
        });
        let ends: Vec<(Point, usize)> = ends.map(|(at, entity)| (at, *entity)).collect();
        let boxes: Vec<Bounds> = ends.iter().map(|(at, _)| Bounds::of([*at])).collect();
        let tree = BoxTree::anywhere(&boxes);
        let gap = |i: usize| {
            let to = |k: usize| if k == i { f64::INFINITY } else { distance(ends[i].0, ends[k].0) };
            Some(tree.nearest(ends[i].0, to)).filter(|gap| gap.is_finite())
        };
        let open = ends.iter().enumerate();
        let ends: Vec<OpenEnd> =
            open.map(|(i, &(at, entity))| OpenEnd { at, entity, gap: gap(i) }).collect();
        (!ends.is_empty()).then_some(OutlineError::Open { ends })
    }
}

/// Joins strokes whose ends are within `tolerance` of each other, drawing units.
///
/// Closed paths stay by themselves. Paths smaller than the tolerance are left out: they would have
/// both ends at every neighbour's end. Gaps beyond rounding are bridged by a line and listed.
///
/// # Errors
/// [`OutlineError::Ambiguous`] where three ends meet, [`OutlineError::Curve`] for numbers that make
/// no curve.
pub fn chain(strokes: &[Stroke], tolerance: f64) -> Result<Chains, OutlineError> {
    for stroke in strokes {
        let entity = stroke.entity;
        stroke.path.check().map_err(|reason| OutlineError::Curve { reason, entity })?;
    }
    let boxes: Vec<Bounds> = strokes.iter().map(|stroke| stroke.path.bounds()).collect();
    let extent = boxes.iter().copied().fold(Bounds::EMPTY, Bounds::union);
    let rounding = ROUNDING * extent.magnitude();
    let tolerance = tolerance.max(rounding);

    let ends: Vec<[Point; 2]> = strokes.iter().map(|stroke| ends(&stroke.path)).collect();
    let stands_alone =
        |i: usize| strokes[i].path.is_closed && distance(ends[i][0], ends[i][1]) <= tolerance;
    let joins = |i: usize| !stands_alone(i) && boxes[i].diagonal() > tolerance;
    let mut partner = partners(strokes, &ends, joins, tolerance)?;
    for i in (0..strokes.len()).filter(|i| stands_alone(*i)) {
        (partner[2 * i], partner[2 * i + 1]) = (Some(2 * i + 1), Some(2 * i));
    }

    let walk = Walk { strokes, ends: &ends, partner: &partner, rounding };
    let mut found: Vec<(usize, bool, Chain)> = Vec::new();
    let mut snaps: Vec<(usize, Vec<Snap>)> = Vec::new();
    let mut is_used = vec![false; strokes.len()];
    // Chains with an open end first, from that end; what is left then goes round.
    let opens = (0..2 * strokes.len()).filter(|end| joins(end / 2) && partner[*end].is_none());
    let rounds = (0..strokes.len()).filter(|i| joins(*i) || stands_alone(*i)).map(|i| 2 * i);
    for first in opens.chain(rounds) {
        if is_used[first / 2] {
            continue;
        }
        let (chain, steps, bridged) = walk.starting_at(first);
        for &i in &steps {
            is_used[i] = true;
        }
        let rank = steps.into_iter().fold(first / 2, usize::min);
        found.push((rank, chain.path.is_closed, chain));
        snaps.push((rank, bridged));
    }
    found.sort_by_key(|(rank, ..)| *rank);
    snaps.sort_by_key(|(rank, _)| *rank);
    let (closed, open): (Vec<_>, Vec<_>) = found.into_iter().partition(|(_, closed, _)| *closed);
    let chains = |list: Vec<(usize, bool, Chain)>| list.into_iter().map(|(.., c)| c).collect();
    Ok(Chains {
        closed: chains(closed),
        open: chains(open),
        snaps: snaps.into_iter().flat_map(|(_, bridged)| bridged).collect(),
    })
}

fn ends(path: &Path) -> [Point; 2] {
    [path.start_point(), path.end_point()].map(|end| end.unwrap_or([f64::NAN; 2]))
}

/// The end that each end is joined to; end `2i` is where stroke i begins, `2i + 1` where it ends.
fn partners(
    strokes: &[Stroke],
    ends: &[[Point; 2]],
    joins: impl Fn(usize) -> bool,
    tolerance: f64,
) -> Result<Vec<Option<usize>>, OutlineError> {
    let listed: Vec<usize> = (0..2 * ends.len()).filter(|end| joins(end / 2)).collect();
    let at = |end: usize| ends[end / 2][end % 2];
    let boxes: Vec<Bounds> = listed.iter().map(|end| Bounds::of([at(*end)])).collect();
    let tree = BoxTree::anywhere(&boxes);
    let mut partner = vec![None; 2 * ends.len()];
    for &end in &listed {
        let mut near = Vec::new();
        tree.meeting(&Bounds::of([at(end)]).grown(tolerance), |k| {
            if listed[k] != end && distance(at(listed[k]), at(end)) <= tolerance {
                near.push(listed[k]);
            }
        });
        if near.len() > 1 {
            near.push(end);
            near.sort_unstable();
            let entities = near.iter().map(|end| strokes[end / 2].entity).collect();
            return Err(OutlineError::Ambiguous { at: at(end), entities });
        }
        partner[end] = near.first().copied();
    }
    Ok(partner)
}

/// Follows partners from stroke to stroke.
struct Walk<'a> {
    strokes: &'a [Stroke],
    ends: &'a [[Point; 2]],
    partner: &'a [Option<usize>],
    rounding: f64,
}

impl Walk<'_> {
    /// The chain that begins with the end `first`, its strokes and its snaps.
    fn starting_at(&self, first: usize) -> (Chain, Vec<usize>, Vec<Snap>) {
        let (mut steps, mut entities, mut snaps) = (Vec::new(), Vec::new(), Vec::new());
        let mut path = Path::default();
        let mut entry = first;
        loop {
            // Through the stroke, from the end it is entered at to the other one.
            let stroke = &self.strokes[entry / 2];
            if entry.is_multiple_of(2) {
                path.curves.extend(stroke.path.curves.iter().cloned());
            } else {
                path.curves.extend(stroke.path.curves.iter().rev().map(Curve::reversed));
            }
            steps.push(entry / 2);
            entities.push(stroke.entity);

            // Over the gap to the next one.
            let exit = entry ^ 1;
            let Some(next) = self.partner[exit] else { break };
            self.bridge(exit, next, &mut path, &mut snaps);
            if next == first {
                path.is_closed = true;
                break;
            }
            entry = next;
        }
        entities.dedup();
        (Chain { path, entities }, steps, snaps)
    }

    fn bridge(&self, exit: usize, next: usize, path: &mut Path, snaps: &mut Vec<Snap>) {
        let [from, to] = [exit, next].map(|end| self.ends[end / 2][end % 2]);
        let gap = distance(from, to);
        if gap > self.rounding {
            path.curves.push(Curve::Segment { from, to });
            let entities = [exit, next].map(|end| self.strokes[end / 2].entity);
            snaps.push(Snap { from, to, distance: gap, entities });
        }
    }
}
