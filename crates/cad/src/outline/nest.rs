//! Nesting: which loops are inside which, and so which are holes.
//!
//! A loop inside an odd number of others is a hole; one inside a hole is material again.

use super::border::Border;
use super::boxes::BoxTree;
use super::contact::{self, Contacts};
use super::{Chain, Loop, Outline, OutlineError};
use crate::geometry::{Bounds, signed_area};

/// A loop with less area than this part of its diagonal squared has none.
const FLAT: f64 = 1e-12;

/// Sets closed chains into each other.
///
/// # Errors
/// [`OutlineError::Crossing`] and [`OutlineError::Coincident`] for loops that meet in more than
/// touching, [`OutlineError::NoArea`] for a loop without area or when there is no loop at all,
/// [`OutlineError::Curve`] for numbers that make no curve.
/// Loops that reach less than `tolerance` into each other, or less than a millionth of the whole,
/// count as touching.
pub fn nest(closed: &[Chain], tolerance: f64) -> Result<Outline, OutlineError> {
    nest_with_depths(closed, tolerance).map(|(outline, _)| outline)
}

/// The outline, and inside how many others each of its loops is.
pub(super) fn nest_with_depths(
    closed: &[Chain],
    tolerance: f64,
) -> Result<(Outline, Vec<usize>), OutlineError> {
    for chain in closed {
        let entity = chain.entities.first().copied().unwrap_or(0);
        chain.path.check().map_err(|reason| OutlineError::Curve { reason, entity })?;
    }
    let borders: Vec<Border> = closed.iter().map(|chain| Border::of(&chain.path)).collect();
    let areas: Vec<f64> = closed.iter().map(|chain| signed_area(&chain.path)).collect();
    let is_flat = |i: &usize| {
        let size = borders[*i].bounds.diagonal();
        areas[*i].is_nan() || areas[*i].abs() <= FLAT * size * size
    };
    let met = |meeting: contact::Meeting| {
        let [a, b] = meeting.loops.map(|i| closed[i].entities.first().copied().unwrap_or(0));
        meeting.error([a, b])
    };
    if let Some(i) = (0..closed.len()).find(is_flat) {
        // Areas of either sense may add up to none: then it is the crossing that is wrong.
        let meeting = contact::contacts(&borders, tolerance).err().map(met);
        if let Some(crossing @ OutlineError::Crossing { .. }) = meeting {
            return Err(crossing);
        }
        let (at, entities) = (borders[i].start(), closed[i].entities.clone());
        return Err(OutlineError::NoArea { at, entities });
    }
    if closed.is_empty() {
        return Err(OutlineError::NoArea { at: [0.0; 2], entities: Vec::new() });
    }
    let contacts = contact::contacts(&borders, tolerance).map_err(met)?;

    let depths = depths(&borders, &contacts);
    let parts = closed.iter().zip(&areas).zip(&depths);
    let loops = parts.map(|((chain, area), depth)| {
        let is_hole = depth % 2 == 1;
        // Material to the left all the way.
        let runs_well = (*area > 0.0) != is_hole;
        let mut entities = chain.entities.clone();
        let path = if runs_well {
            chain.path.clone()
        } else {
            entities.reverse();
            chain.path.reversed()
        };
        Loop { path, is_hole, entities }
    });
    Ok((Outline { loops: loops.collect() }, depths))
}

/// Inside how many others each loop is.
fn depths(borders: &[Border], contacts: &Contacts) -> Vec<usize> {
    let boxes: Vec<Bounds> = borders.iter().map(|border| border.bounds).collect();
    let tree = BoxTree::anywhere(&boxes);
    let depth = |i: usize| {
        let mut depth = 0;
        tree.meeting(&boxes[i], |k| {
            // Of loops that touch, the contacts know which is inside.
            let is_inside = || match contacts.is_inside(i, k) {
                Some(is_inside) => is_inside,
                None => borders[k].contains(borders[i].start()),
            };
            depth += usize::from(k != i && is_inside());
        });
        depth
    };
    (0..borders.len()).map(depth).collect()
}
