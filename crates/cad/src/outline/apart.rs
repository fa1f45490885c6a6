//! Chaining of a whole drawing: what is drawn twice is taken once, and where ends meet in more than one
//! way, the strokes that hang together with them are left to themselves.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use super::boxes::BoxTree;
use super::{Chain, Chains, OutlineError, Stroke, chain};
use crate::geometry::vector::{distance, sub};
use crate::geometry::{Bounds, Curve, Path, Point};

/// A stroke that lies on another one.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Doubled {
    /// The index of the stroke that is taken.
    pub kept: usize,
    /// The index of the one on top of it.
    pub copy: usize,
}

/// The chains of strokes some of which may be drawn twice, or meet in more than one way.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Apart {
    /// Of all strokes that hang together in one way; their entities are those of the strokes.
    pub chains: Chains,
    /// Strokes that were left out: another one covers them.
    pub doubled: Vec<Doubled>,
    /// Where ends meet in more than one way, and the box around all that hangs together there.
    pub ambiguous: Vec<(OutlineError, Bounds)>,
}

/// Chains strokes; none refuses the others.
pub fn chain_apart(strokes: &[Stroke], tolerance: f64) -> Apart {
    if let Ok(chains) = chain(strokes, tolerance) {
        return Apart { chains, ..Apart::default() };
    }
    let doubled = doubled(strokes, tolerance);
    let is_copy: Vec<bool> = {
        let mut is_copy = vec![false; strokes.len()];
        for it in &doubled {
            is_copy[it.copy] = true;
        }
        is_copy
    };
    let mut apart = Apart { doubled, ..Apart::default() };
    let mut found: Vec<(usize, bool, Chain)> = Vec::new();
    for group in groups(strokes, &is_copy, tolerance) {
        let own: Vec<Stroke> = group.iter().map(|&idx| strokes[idx].clone()).collect();
        match chain(&own, tolerance) {
            Ok(chains) => {
                found.extend(chains.closed.into_iter().map(|it| (group[0], true, it)));
                found.extend(chains.open.into_iter().map(|it| (group[0], false, it)));
                apart.chains.snaps.extend(chains.snaps);
            }
            Err(error) => {
                let bounds =
                    own.iter().map(|it| it.path.bounds()).fold(Bounds::EMPTY, Bounds::union);
                apart.ambiguous.push((error, bounds));
                // What is closed by itself still counts.
                let closed = group.iter().filter(|&&idx| strokes[idx].path.is_closed);
                found.extend(closed.map(|&idx| {
                    let Stroke { path, entity } = strokes[idx].clone();
                    (idx, true, Chain { path, entities: vec![entity] })
                }));
            }
        }
    }
    found.sort_by_key(|(rank, ..)| *rank);
    for (_, is_closed, chain) in found {
        if is_closed { apart.chains.closed.push(chain) } else { apart.chains.open.push(chain) }
    }
    apart
}

/// The strokes that lie on another stroke over their whole length; closed ones only on one that is the same.
pub fn doubled(strokes: &[Stroke], tolerance: f64) -> Vec<Doubled> {
    let boxes: Vec<Bounds> = strokes.iter().map(|stroke| stroke.path.bounds()).collect();
    let is_sound: Vec<bool> = strokes.iter().map(|stroke| stroke.path.check().is_ok()).collect();
    let sound = (0..strokes.len()).filter(|&idx| is_sound[idx]);
    let (lines, others): (Vec<usize>, Vec<usize>) =
        sound.partition(|&idx| straight(&strokes[idx]).is_some());
    let lines = Lines::of(strokes, lines);
    let tree = BoxTree::anywhere(&others.iter().map(|&idx| boxes[idx]).collect::<Vec<_>>());
    let mut found: Vec<Doubled> = Vec::new();
    let mut is_copy = vec![false; strokes.len()];
    for copy in 0..strokes.len() {
        let path = &strokes[copy].path;
        if boxes[copy].diagonal() <= tolerance || !is_sound[copy] {
            continue;
        }
        let samples = samples(path);
        // Most boxes that meet cannot hold a stroke on which all of this one is.
        let own = Bounds::of(samples.iter().copied());
        let mut near = Vec::new();
        lines.along(&samples, tolerance, |idx| {
            let around = boxes[idx].grown(tolerance);
            near.extend((around.contains(own.min) && around.contains(own.max)).then_some(idx));
        });
        tree.covering(&own, tolerance, |k| near.push(others[k]));
        near.sort_unstable();
        let is_covered = |kept: &usize| {
            let other = &strokes[*kept].path;
            if path.is_closed && !(*kept < copy && is_near(&boxes[*kept], &boxes[copy], tolerance))
            {
                return false;
            }
            *kept != copy
                && !is_copy[*kept]
                && is_along(other, &samples, tolerance)
                // Of two that are equal, the later one is the copy.
                && if path.is_closed {
                    other.is_closed && lies_on(other, path, tolerance)
                } else {
                    *kept < copy || !lies_on(other, path, tolerance)
                }
        };
        if let Some(kept) = near.into_iter().find(is_covered) {
            is_copy[copy] = true;
            found.push(Doubled { kept, copy });
        }
    }
    found
}

/// Both ends of a stroke that is one straight line.
fn straight(stroke: &Stroke) -> Option<[Point; 2]> {
    match stroke.path.curves[..] {
        [Curve::Segment { from, to }] if from != to => Some([from, to]),
        _ => None,
    }
}

/// Straight strokes by direction and place, so that few are asked however many cross: (θ, ρ) of the line
/// `−x sin θ + y cos θ = ρ` about the centre of them all, with θ from 0 to π.
struct Lines {
    tree: BoxTree,
    strokes: Vec<usize>,
    centre: Point,
    reach: f64,
}

impl Lines {
    /// The strokes with these indices, all straight.
    fn of(all: &[Stroke], strokes: Vec<usize>) -> Self {
        let ends: Vec<[Point; 2]> = strokes.iter().filter_map(|&idx| straight(&all[idx])).collect();
        let around = Bounds::of(ends.as_flattened().iter().copied());
        let mut lines = Self {
            tree: BoxTree::in_order(&[]),
            strokes,
            centre: around.centre(),
            reach: around.diagonal(),
        };
        let boxes: Vec<Bounds> = ends.iter().map(|&ends| Bounds::of([lines.place(ends)])).collect();
        lines.tree = BoxTree::anywhere(&boxes);
        lines
    }

    /// θ and ρ of the line through two points.
    fn place(&self, [from, to]: [Point; 2]) -> Point {
        let [x, y] = sub(to, from);
        let angle = y.atan2(x);
        let angle = if angle < 0.0 { angle + PI } else { angle };
        let [x, y] = sub(from, self.centre);
        [angle, y * angle.cos() - x * angle.sin()]
    }

    /// Calls `visit` with every stroke on whose line all of these points may be, within a tolerance.
    fn along(&self, points: &[Point], tolerance: f64, mut visit: impl FnMut(usize)) {
        const ROUNDING: f64 = 1e-12;
        let Some(&first) = points.first() else { return };
        let away = |point: &&Point| distance(first, **point);
        let Some(&last) = points.iter().max_by(|a, b| away(a).total_cmp(&away(b))) else { return };
        // A line within the tolerance of both ends turns by no more than this about either.
        let turn = (2.0 * tolerance / distance(first, last)).min(1.0).asin() + ROUNDING;
        let shift = tolerance + (turn + ROUNDING) * (self.reach + distance(first, self.centre));
        let [angle, offset] = self.place([first, last]);
        // The same line has another angle and sign half a turn on.
        for [angle, offset] in [[angle, offset], [angle + PI, -offset], [angle - PI, -offset]] {
            let [low, high] = [-1.0, 1.0].map(|side| [angle + side * turn, offset + side * shift]);
            self.tree.meeting(&Bounds::of([low, high]), |k| visit(self.strokes[k]));
        }
    }
}

/// True if two boxes are the same, but for twice the tolerance on each side.
fn is_near(a: &Bounds, b: &Bounds, tolerance: f64) -> bool {
    let [a, b] = [a, b].map(|it| [it.min, it.max]);
    a.as_flattened().iter().zip(b.as_flattened()).all(|(x, y)| (x - y).abs() <= 2.0 * tolerance)
}

fn lies_on(path: &Path, other: &Path, tolerance: f64) -> bool {
    is_along(other, &samples(path), tolerance)
}

/// True if all points are within `tolerance` of a path.
fn is_along(path: &Path, points: &[Point], tolerance: f64) -> bool {
    points.iter().all(|at| path.distance_within(*at, 2.0 * tolerance) <= tolerance)
}

/// Points along a path; a line or an arc that has five points with another one is the same.
fn samples(path: &Path) -> Vec<Point> {
    const STEPS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
    let on = |curve: &Curve| STEPS.map(|t| curve.point(t));
    path.curves.iter().flat_map(on).collect()
}

/// The strokes that hang together by their ends, without the copies; each group in its order.
fn groups(strokes: &[Stroke], is_copy: &[bool], tolerance: f64) -> Vec<Vec<usize>> {
    let ends: Vec<(usize, Point)> = (0..strokes.len())
        .filter(|&idx| !is_copy[idx] && strokes[idx].path.check().is_ok())
        .flat_map(|idx| {
            let path = &strokes[idx].path;
            [path.start_point(), path.end_point()].into_iter().flatten().map(move |at| (idx, at))
        })
        .collect();
    let boxes: Vec<Bounds> = ends.iter().map(|(_, at)| Bounds::of([*at])).collect();
    let tree = BoxTree::anywhere(&boxes);
    // Each points to an earlier one of its group, the first one to itself.
    let mut leader: Vec<usize> = (0..strokes.len()).collect();
    for (idx, at) in &ends {
        tree.meeting(&Bounds::of([*at]).grown(tolerance), |k| {
            if distance(ends[k].1, *at) <= tolerance {
                let [a, b] = [first_of(&leader, *idx), first_of(&leader, ends[k].0)];
                leader[a.max(b)] = a.min(b);
            }
        });
    }
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (idx, _) in ends.iter().step_by(2) {
        groups.entry(first_of(&leader, *idx)).or_default().push(*idx);
    }
    groups.into_values().collect()
}

fn first_of(leader: &[usize], mut idx: usize) -> usize {
    while leader[idx] != idx {
        idx = leader[idx];
    }
    idx
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(from: Point, to: Point) -> Stroke {
        Stroke { path: Path::of(Curve::Segment { from, to }), entity: 0 }
    }

    /// A square by four lines, with more strokes next to them.
    fn square(more: Vec<Stroke>) -> Vec<Stroke> {
        let corners = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0], [0.0, 0.0]];
        let mut strokes: Vec<Stroke> =
            corners.windows(2).map(|pair| line(pair[0], pair[1])).collect();
        strokes.extend(more);
        for (idx, stroke) in strokes.iter_mut().enumerate() {
            stroke.entity = idx;
        }
        strokes
    }

    #[test]
    fn copies_and_parts_of_lines_are_left_out() {
        let more = [
            line([10.0, 0.0], [0.0, 0.0]),
            line([10.0, 3.0], [10.0, 10.0]),
            line([0.0, 0.0], [-5.0, 0.0]),
        ];
        let apart = chain_apart(&square(more[..2].to_vec()), 1e-6);
        let expected = [Doubled { kept: 0, copy: 4 }, Doubled { kept: 1, copy: 5 }];
        assert_eq!(apart.doubled, expected);
        assert_eq!((apart.chains.closed.len(), apart.chains.open.len()), (1, 0));
        assert_eq!(apart.ambiguous, []);
        // A line on from a corner is no copy, but makes the corner ambiguous.
        let apart = chain_apart(&square(more[2..].to_vec()), 1e-6);
        assert_eq!((apart.doubled.len(), apart.ambiguous.len()), (0, 1));
    }

    #[test]
    fn a_corner_that_is_ambiguous_leaves_the_rest_of_the_drawing_alone() {
        let mut strokes = square(vec![line([0.0, 0.0], [-5.0, 0.0])]);
        let apart: Vec<Stroke> = square(Vec::new())
            .into_iter()
            .map(|stroke| {
                let shift = crate::geometry::Affine::translation([50.0, 0.0]);
                Stroke { path: stroke.path.transformed(&shift), entity: stroke.entity + 10 }
            })
            .collect();
        strokes.extend(apart);
        let apart = chain_apart(&strokes, 1e-6);
        assert_eq!(apart.chains.closed.len(), 1);
        assert_eq!(apart.chains.closed[0].entities, [10, 11, 12, 13]);
    }
}
