//! Ground: lines with short strokes on one side, and hatched pieces.

use bksim_cad::geometry::vector::{along, between, cross, distance, dot, sub};
use bksim_cad::geometry::{Path, Point};
use bksim_cad::read::Sheet;

use super::pieces::{Pieces, is_inside, skew, to_border, to_segment, turned, unit};

/// A border of the ground.
#[derive(Clone, Debug)]
pub(super) struct Base {
    pub(super) ends: [Point; 2],
    /// Away from the ground.
    pub(super) free: Point,
    pub(super) from: Vec<usize>,
}

impl Base {
    pub(super) fn direction(&self) -> Point {
        unit(sub(self.ends[1], self.ends[0]))
    }

    pub(super) fn length(&self) -> f64 {
        distance(self.ends[0], self.ends[1])
    }

    /// Place along the base, and height above it.
    pub(super) fn place(&self, p: Point) -> [f64; 2] {
        let offset = sub(p, self.ends[0]);
        [dot(offset, self.direction()), dot(offset, self.free)]
    }
}

/// A hatched or filled area around pins: a plate.
#[derive(Clone, Debug)]
pub(super) struct Plate {
    pub(super) points: Vec<Point>,
}

/// A ring that stands still: hatched between two circles, or outside of one.
#[derive(Clone, Debug)]
pub(super) struct GroundRing {
    pub(super) centre: Point,
    /// Least and largest radius of what is drawn of it.
    pub(super) reach: [f64; 2],
}

/// Rings of the ground; takes the strokes about them away.
pub(super) fn rings(sheet: &Sheet, pieces: &mut Pieces) -> Vec<GroundRing> {
    let mut found = Vec::new();
    for fill in sheet.fills.iter().filter(|fill| fill.has_pattern) {
        let round: Vec<(Point, f64)> =
            fill.borders.iter().filter_map(|border| as_circle(border, pieces)).collect();
        if let [(centre, first), (other, second)] = round[..]
            && distance(centre, other) < pieces.tolerance
        {
            found.push(GroundRing { centre, reach: [first.min(second), first.max(second)] });
        }
    }
    let large = pieces.circles.iter().filter(|circle| circle.radius > 6.0 * pieces.pin);
    let large: Vec<(Point, f64)> = large.map(|circle| (circle.centre, circle.radius)).collect();
    let near = pieces.tolerance;
    for (centre, radius) in large {
        let height = |p: Point| distance(p, centre) - radius;
        let is_mark = |line: &super::pieces::Line| {
            let [low, high] = {
                let [a, b] = line.ends.map(height);
                [a.min(b), a.max(b)]
            };
            !line.is_used && low.abs() < near && high > near && high < 5.0 * pieces.pin
        };
        let marks: Vec<usize> =
            (0..pieces.lines.len()).filter(|&idx| is_mark(&pieces.lines[idx])).collect();
        let away = |idx: &usize| {
            let [a, b] = pieces.lines[*idx].ends.map(height);
            a.max(b)
        };
        let thick = marks.iter().map(away).fold(0.0, f64::max);
        if marks.len() < FEWEST_MARKS {
            continue;
        }
        for idx in marks {
            pieces.lines[idx].is_used = true;
        }
        found.push(GroundRing { centre, reach: [radius, radius + thick] });
    }
    found
}

/// Fewest strokes that make a circle a hatched one.
const FEWEST_MARKS: usize = 8;

/// Centre and radius of a border that is a circle.
fn as_circle(border: &Path, pieces: &Pieces) -> Option<(Point, f64)> {
    let bounds = border.bounds();
    let centre = between(bounds.min, bounds.max, 0.5);
    let points = border.flattened(0.02 * pieces.pin);
    let radius = 0.5 * (bounds.max[0] - bounds.min[0]);
    let is_round = points.len() >= FEWEST_MARKS
        && points.iter().all(|p| (distance(*p, centre) - radius).abs() < 0.5 * pieces.tolerance);
    is_round.then_some((centre, radius))
}

/// Finds all borders of the ground, and takes their lines and strokes away.
pub(super) fn bases(sheet: &Sheet, pieces: &mut Pieces, pins: &[Point]) -> (Vec<Base>, Vec<Plate>) {
    let mut bases = Vec::new();
    for series in series(pieces) {
        if let Some(base) = base_of(pieces, &series) {
            for mark in series {
                pieces.lines[mark].is_used = true;
            }
            bases.push(base);
        }
    }
    let mut plates = Vec::new();
    for fill in &sheet.fills {
        for border in &fill.borders {
            let points = border.flattened(0.02 * pieces.pin);
            let size = border.bounds().diagonal();
            if size < 3.0 * pieces.pin || points.len() < 3 {
                continue;
            }
            let on_border = |pin: &Point| to_border(&points, *pin) < 1.5 * pieces.tolerance;
            let holds = |pin: &Point| is_inside(&points, *pin) || on_border(pin);
            let held: Vec<Point> = pins.iter().copied().filter(holds).collect();
            // A hatched piece with one pin at its edge is a bearing.
            let is_bearing = fill.has_pattern && matches!(held[..], [pin] if on_border(&pin));
            let is_ring = fill.has_pattern
                && fill.borders.len() == 2
                && fill.borders.iter().all(|border| as_circle(border, pieces).is_some());
            if is_ring {
                continue;
            }
            if !held.is_empty() && !is_bearing {
                plates.push(Plate { points });
            } else if fill.has_pattern {
                bases.extend(bases_of_fill(pieces, &points));
            }
        }
    }
    (bases, plates)
}

/// Series of short parallel strokes of one length whose ends are in line at one distance.
fn series(pieces: &Pieces) -> Vec<Vec<usize>> {
    let short: Vec<usize> = (0..pieces.lines.len())
        .filter(|&idx| !pieces.lines[idx].is_used && pieces.lines[idx].length() < 5.0 * pieces.pin)
        .collect();
    let near = 0.3 * pieces.tolerance;
    let mut taken = vec![false; pieces.lines.len()];
    let mut found = Vec::new();
    let mut budget: usize = 20_000_000;
    for (n, &i) in short.iter().enumerate() {
        for &k in &short[n + 1..] {
            if taken[i] || taken[k] {
                continue;
            }
            let (first, second) = (&pieces.lines[i], &pieces.lines[k]);
            let (Some(step), length) = (step(first.ends, second.ends, near), first.length()) else {
                continue;
            };
            let pitch = dot(step, step).sqrt();
            // Strokes of a hatching are not in line and closer than a few of their lengths.
            if pitch < near || pitch > 3.0 * length || skew(unit(step), first.direction()) < 0.25 {
                continue;
            }
            // Series of real drawings are found long before.
            budget = budget.saturating_sub(short.len());
            if budget == 0 {
                return found;
            }
            let mut all = vec![i];
            for sign in [1.0, -1.0] {
                for count in 1..400 {
                    let by = sign * f64::from(count);
                    let wanted = first.ends.map(|end| along(end, by, step));
                    let fits = |&idx: &usize| {
                        let ends = pieces.lines[idx].ends;
                        let off = near * (1.0 + 0.2 * f64::from(count));
                        !taken[idx]
                            && !all.contains(&idx)
                            && (distance(ends[0], wanted[0]) < off
                                && distance(ends[1], wanted[1]) < off
                                || distance(ends[1], wanted[0]) < off
                                    && distance(ends[0], wanted[1]) < off)
                    };
                    match short.iter().copied().find(fits) {
                        Some(idx) => all.push(idx),
                        None => break,
                    }
                }
            }
            if all.len() >= 3 && is_close(pieces, &all) {
                for &idx in &all {
                    taken[idx] = true;
                }
                found.push(all);
            }
        }
    }
    found
}

/// The way from one stroke to another that is as long and parallel.
fn step(first: [Point; 2], second: [Point; 2], near: f64) -> Option<Point> {
    let direct = [sub(second[0], first[0]), sub(second[1], first[1])];
    let crossed = [sub(second[1], first[0]), sub(second[0], first[1])];
    [direct, crossed].into_iter().find(|[a, b]| distance(*a, *b) < near).map(|[a, _]| a)
}

/// True if the strokes of a series are as close as those of a hatching.
fn is_close(pieces: &Pieces, all: &[usize]) -> bool {
    let start = pieces.lines[all[0]].ends[0];
    let places = all.iter().map(|&idx| distance(pieces.lines[idx].ends[0], start));
    let pitch = places.filter(|place| *place > 0.0).fold(f64::INFINITY, f64::min);
    pitch < 12.0 * pieces.pin
}

/// The line on which the strokes of a series stand.
fn base_of(pieces: &mut Pieces, series: &[usize]) -> Option<Base> {
    let marks: Vec<[Point; 2]> = {
        // All in one sense, as the first.
        let d = pieces.lines[series[0]].direction();
        let ends = series.iter().map(|&idx| pieces.lines[idx].ends);
        ends.map(|[a, b]| if dot(sub(b, a), d) > 0.0 { [a, b] } else { [b, a] }).collect()
    };
    let far = marks
        .iter()
        .max_by(|p, q| distance(p[0], marks[0][0]).total_cmp(&distance(q[0], marks[0][0])))?;
    let direction = unit(sub(far[0], marks[0][0]));
    let mut best: Option<(f64, Base, Vec<usize>)> = None;
    for side in [0, 1] {
        let origin = marks[0][side];
        let places: Vec<f64> =
            marks.iter().map(|mark| dot(sub(mark[side], origin), direction)).collect();
        let low = places.iter().copied().fold(f64::INFINITY, f64::min);
        let high = places.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let pitch = (high - low) / (marks.len() as f64 - 1.0);
        let candidates: Vec<usize> = (0..pieces.lines.len())
            .filter(|idx| {
                let line = &pieces.lines[*idx];
                let on = |p: Point| cross(direction, sub(p, origin)).abs() < 0.8 * pieces.tolerance;
                let at = line.ends.map(|p| dot(sub(p, origin), direction));
                let inside = |x: f64| {
                    x > low - 1.6 * pitch - pieces.tolerance
                        && x < high + 1.6 * pitch + pieces.tolerance
                };
                !line.is_used
                    && !series.contains(idx)
                    && line.ends.iter().all(|p| on(*p))
                    && at.iter().all(|x| inside(*x))
            })
            .collect();
        let span = |idx: usize| {
            let mut at = pieces.lines[idx].ends.map(|p| dot(sub(p, origin), direction));
            at.sort_by(f64::total_cmp);
            at
        };
        let candidates = border_lines(candidates, span, pieces.tolerance);
        let covered: f64 = candidates.iter().map(|&idx| pieces.lines[idx].length()).sum();
        if covered < 0.4 * (high - low) {
            continue;
        }
        let mut ends = [along(origin, low, direction), along(origin, high, direction)];
        for &idx in &candidates {
            for p in pieces.lines[idx].ends {
                let x = dot(sub(p, origin), direction);
                let line = ends.map(|end| dot(sub(end, origin), direction));
                if x < line[0] {
                    ends[0] = along(origin, x, direction);
                }
                if x > line[1] {
                    ends[1] = along(origin, x, direction);
                }
            }
        }
        let into = sub(marks[0][1 - side], marks[0][side]);
        let across = turned(direction);
        let free = if dot(across, into) < 0.0 { across } else { [-across[0], -across[1]] };
        let from = candidates.iter().flat_map(|&idx| pieces.lines[idx].from.clone());
        let from =
            from.chain(series.iter().flat_map(|&idx| pieces.lines[idx].from.clone())).collect();
        let base = Base { ends, free, from };
        if best.as_ref().is_none_or(|(known, _, _)| covered > *known) {
            best = Some((covered, base, candidates));
        }
    }
    let (_, base, lines) = best?;
    for idx in lines {
        pieces.lines[idx].is_used = true;
    }
    Some(base)
}

/// Of lines along a hatching those that are its border: the longest ones that continue each other, and what repeats
/// them from an end. Others lie on it: sides of a block that slides.
fn border_lines(mut lines: Vec<usize>, span: impl Fn(usize) -> [f64; 2], near: f64) -> Vec<usize> {
    let length = |idx: usize| span(idx)[1] - span(idx)[0];
    lines.sort_by(|&a, &b| length(b).total_cmp(&length(a)));
    let mut kept: Vec<usize> = Vec::new();
    for idx in lines {
        let [from, to] = span(idx);
        let overlaps =
            |known: &&usize| span(**known)[1].min(to) - span(**known)[0].max(from) > near;
        let shares = |known: &usize| {
            let [start, end] = span(*known);
            (start - from).abs() < near || (end - to).abs() < near
        };
        let over: Vec<usize> = kept.iter().filter(overlaps).copied().collect();
        if over.is_empty() || over.iter().any(shares) {
            kept.push(idx);
        }
    }
    kept
}

fn bases_of_fill(pieces: &mut Pieces, points: &[Point]) -> Vec<Base> {
    let mut all = Vec::new();
    let n = points.len();
    for k in 0..n {
        let ends = [points[k], points[(k + 1) % n]];
        if distance(ends[0], ends[1]) < pieces.pin {
            continue;
        }
        let direction = unit(sub(ends[1], ends[0]));
        let across = turned(direction);
        let middle = along(ends[0], 0.5 * distance(ends[0], ends[1]), direction);
        let is_out = !is_inside(points, along(middle, 0.1 * pieces.pin, across));
        let free = if is_out { across } else { [-across[0], -across[1]] };
        let mut from = Vec::new();
        let near = 0.9 * pieces.tolerance;
        for line in pieces.lines.iter_mut().filter(|line| !line.is_used) {
            if line.ends.iter().all(|p| to_segment(*p, ends) < near) {
                line.is_used = true;
                from.extend(line.from.clone());
            }
        }
        all.push((from.is_empty(), Base { ends, free, from }));
    }
    // An outline about the hatching is its border.
    let near = 0.9 * pieces.tolerance;
    for ring in pieces.rings.iter_mut().filter(|ring| !ring.is_used) {
        let is_border = ring.points.iter().all(|p| to_border(points, *p) < near)
            && points.iter().all(|p| to_border(&ring.points, *p) < near);
        if is_border {
            ring.is_used = true;
            for (is_bare, base) in &mut all {
                *is_bare = false;
                base.from.extend(ring.from.clone());
            }
        }
    }
    // Edges that are drawn are the borders; without any, all are.
    let has_drawn = all.iter().any(|(is_bare, _)| !is_bare);
    all.into_iter().filter(|(is_bare, _)| !has_drawn || !is_bare).map(|(_, base)| base).collect()
}
