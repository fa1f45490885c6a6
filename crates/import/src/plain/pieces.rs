//! The strokes of a drawing as lines, bows, circles and rings, with what is drawn twice or in parts made one.

use bksim_cad::geometry::vector::{along, between, cross, distance, dot, norm, scaled, sub};
use bksim_cad::geometry::{Curve, Path, Point};
use bksim_cad::read::{Dash, Sheet};

/// A straight line.
#[derive(Clone, Debug)]
pub(super) struct Line {
    pub(super) ends: [Point; 2],
    /// Strokes that it is made of.
    pub(super) from: Vec<usize>,
    /// Number of the polyline it belongs to, or its own.
    pub(super) chain: usize,
    pub(super) is_used: bool,
}

impl Line {
    pub(super) fn direction(&self) -> Point {
        unit(sub(self.ends[1], self.ends[0]))
    }

    pub(super) fn length(&self) -> f64 {
        distance(self.ends[0], self.ends[1])
    }

    pub(super) fn middle(&self) -> Point {
        between(self.ends[0], self.ends[1], 0.5)
    }

    /// Distance of a point from the line between its ends.
    pub(super) fn away(&self, p: Point) -> f64 {
        to_segment(p, self.ends)
    }
}

/// An open arc or curve.
#[derive(Clone, Debug)]
pub(super) struct Bow {
    pub(super) ends: [Point; 2],
    pub(super) points: Vec<Point>,
    /// Centre and radius of an arc.
    pub(super) circle: Option<(Point, f64)>,
    pub(super) from: usize,
    pub(super) is_used: bool,
}

/// A whole circle.
#[derive(Clone, Debug)]
pub(super) struct Circle {
    pub(super) centre: Point,
    pub(super) radius: f64,
    pub(super) dash: Dash,
    pub(super) from: usize,
}

/// A closed outline.
#[derive(Clone, Debug)]
pub(super) struct Ring {
    pub(super) points: Vec<Point>,
    pub(super) sides: Vec<[Point; 2]>,
    /// Centre, radius and ends of its arcs.
    pub(super) arcs: Vec<(Point, f64, [Point; 2])>,
    pub(super) from: Vec<usize>,
    pub(super) is_used: bool,
}

/// Pieces of a drawing.
#[derive(Clone, Default, Debug)]
pub(super) struct Pieces {
    pub(super) lines: Vec<Line>,
    pub(super) bows: Vec<Bow>,
    pub(super) circles: Vec<Circle>,
    pub(super) rings: Vec<Ring>,
    /// Lines in a centre line type.
    pub(super) axes: Vec<[Point; 2]>,
    /// Strokes in dashes, which are no part of the mechanism.
    pub(super) dashed: Vec<usize>,
    /// Usual radius of a pin: the unit of all that is small.
    pub(super) pin: f64,
    /// Largest distance of points that are meant to be one.
    pub(super) tolerance: f64,
    /// Largest such distance that was met.
    pub(super) miss: f64,
}

pub(super) fn unit(v: Point) -> Point {
    let length = norm(v);
    if length > 0.0 { scaled(v, 1.0 / length) } else { [1.0, 0.0] }
}

pub(super) fn turned(v: Point) -> Point {
    [-v[1], v[0]]
}

pub(super) fn to_segment(p: Point, [a, b]: [Point; 2]) -> f64 {
    let (line, offset) = (sub(b, a), sub(p, a));
    let square = dot(line, line);
    if square == 0.0 {
        return distance(p, a);
    }
    let share = (dot(offset, line) / square).clamp(0.0, 1.0);
    distance(p, along(a, share, line))
}

/// Sine of the angle between two directions, without sign.
pub(super) fn skew(u: Point, v: Point) -> f64 {
    cross(u, v).abs()
}

/// True if a point is inside of a polygon.
pub(super) fn is_inside(points: &[Point], p: Point) -> bool {
    let mut inside = false;
    for (a, b) in points.iter().zip(points.iter().cycle().skip(1)) {
        if (a[1] > p[1]) != (b[1] > p[1]) {
            let x = a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
            inside ^= p[0] < x;
        }
    }
    inside
}

/// Distance of a point from the border of a polygon.
pub(super) fn to_border(points: &[Point], p: Point) -> f64 {
    let sides = points.iter().zip(points.iter().cycle().skip(1));
    sides.map(|(a, b)| to_segment(p, [*a, *b])).fold(f64::INFINITY, f64::min)
}

pub(super) fn area(points: &[Point]) -> f64 {
    let sides = points.iter().zip(points.iter().cycle().skip(1));
    sides.map(|(a, b)| cross(*a, *b)).sum::<f64>() / 2.0
}

/// Middle of the points of a polygon, weighted by its sides.
pub(super) fn middle(points: &[Point]) -> Point {
    let mut sum = [0.0; 2];
    let mut total = 0.0;
    for (a, b) in points.iter().zip(points.iter().cycle().skip(1)) {
        let weight = distance(*a, *b);
        sum = along(sum, weight, between(*a, *b, 0.5));
        total += weight;
    }
    if total > 0.0 { scaled(sum, 1.0 / total) } else { points.first().copied().unwrap_or_default() }
}

impl Pieces {
    pub(super) fn of(sheet: &Sheet) -> Self {
        let mut pieces = Self::default();
        let mut seen: Vec<(Point, Point, f64, Dash)> = Vec::new();
        let size = extent(sheet);
        for (idx, stroke) in sheet.strokes.iter().enumerate() {
            let length = stroke.path.length();
            let (Some(start), Some(end)) = (stroke.path.start_point(), stroke.path.end_point())
            else {
                continue;
            };
            // Short of nothing, or drawn twice.
            let far = 1e-6 * size;
            let is_same = |(a, b, l, dash): &(Point, Point, f64, Dash)| {
                (l - length).abs() < far
                    && *dash == stroke.dash
                    && (distance(*a, start) < far && distance(*b, end) < far
                        || distance(*a, end) < far && distance(*b, start) < far)
            };
            if length < far || seen.iter().any(is_same) {
                continue;
            }
            seen.push((start, end, length, stroke.dash));
            pieces.add(&stroke.path, stroke.dash, idx);
        }
        pieces.measure(size);
        pieces.merge_circles();
        pieces
    }

    fn add(&mut self, path: &Path, dash: Dash, from: usize) {
        if let Some((centre, radius)) = as_circle(path) {
            self.circles.push(Circle { centre, radius, dash, from });
            return;
        }
        if dash != Dash::Solid {
            self.dashed.push(from);
            if dash == Dash::Centre {
                for curve in &path.curves {
                    if let Curve::Segment { from, to } = curve {
                        self.axes.push([*from, *to]);
                    }
                }
            }
            return;
        }
        let meets = path.start_point() == path.end_point();
        if (path.is_closed || meets) && (path.curves.len() > 2 || is_curved(path)) {
            self.rings.push(Ring::of(&path.curves, vec![from]));
            return;
        }
        let chain = from;
        for curve in &path.curves {
            match curve {
                Curve::Segment { from: a, to: b } => self.lines.push(Line {
                    ends: [*a, *b],
                    from: vec![from],
                    chain,
                    is_used: false,
                }),
                curve => self.bows.push(bow(curve, from)),
            }
        }
    }

    /// Takes the radius that most pins have as the measure of symbols.
    fn measure(&mut self, size: f64) {
        let solid = self.circles.iter().filter(|circle| circle.dash == Dash::Solid);
        let radii: Vec<(Point, f64)> = solid.map(|circle| (circle.centre, circle.radius)).collect();
        let count =
            |radius: f64| radii.iter().filter(|(_, r)| (r / radius - 1.0).abs() < 0.04).count();
        let best = radii
            .iter()
            .filter(|(_, radius)| *radius < 0.06 * size)
            .map(|(_, radius)| (count(*radius), *radius))
            .max_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        self.pin = best.map_or(size / 80.0, |(_, radius)| radius);
        self.tolerance = (0.3 * self.pin).max(0.002 * size).min(0.5 * self.pin);
    }

    /// Drops circles that are drawn twice with a small miss.
    fn merge_circles(&mut self) {
        let mut kept: Vec<Circle> = Vec::new();
        for circle in std::mem::take(&mut self.circles) {
            let is_same = |known: &Circle| {
                known.dash == circle.dash
                    && distance(known.centre, circle.centre) < self.tolerance
                    && (known.radius - circle.radius).abs() < 0.02 * known.radius
            };
            if !kept.iter().any(is_same) {
                kept.push(circle);
            }
        }
        self.circles = kept;
    }

    /// Joins lines that continue one another exactly where nothing else ends: strokes that an editor has cut.
    pub(super) fn join_cuts(&mut self, pins: &[Point]) {
        let near = 0.02 * self.tolerance;
        let mut idx = 0;
        while idx < self.lines.len() {
            let cut = [0, 1].into_iter().find_map(|end| {
                let at = self.lines[idx].ends[end];
                let meets = |line: &Line| (0..2).find(|&k| distance(line.ends[k], at) < near);
                let mut others =
                    (0..self.lines.len()).filter(|&k| k != idx && meets(&self.lines[k]).is_some());
                let (other, None) = (others.next()?, others.next()) else { return None };
                let far = meets(&self.lines[other])?;
                let is_straight = skew(self.lines[idx].direction(), self.lines[other].direction())
                    < 1e-3
                    && dot(
                        sub(self.lines[idx].ends[1 - end], at),
                        sub(self.lines[other].ends[1 - far], at),
                    ) < 0.0;
                let has_pin = pins.iter().any(|pin| distance(*pin, at) < 1.2 * self.pin);
                let has_bow =
                    self.bows.iter().any(|bow| bow.ends.iter().any(|p| distance(*p, at) < near));
                (is_straight && !has_pin && !has_bow).then_some((end, other, far))
            });
            let Some((end, other, far)) = cut else {
                idx += 1;
                continue;
            };
            let second = self.lines[other].clone();
            self.lines[idx].ends[end] = second.ends[1 - far];
            self.lines[idx].from.extend(second.from);
            self.lines.remove(other);
            idx = idx.saturating_sub(1);
        }
    }

    /// Joins lines that continue or repeat one another, unless a pin is where they meet.
    pub(super) fn merge_lines(&mut self, pins: &[Point]) {
        let mut idx = 0;
        while idx < self.lines.len() {
            let partner =
                (0..self.lines.len()).find(|&other| other != idx && self.is_one(idx, other, pins));
            let Some(other) = partner else {
                idx += 1;
                continue;
            };
            let second = self.lines[other].clone();
            let first = &self.lines[idx];
            let direction = first.direction();
            let place = |p: &Point| dot(sub(*p, first.ends[0]), direction);
            let mut all = [first.ends[0], first.ends[1], second.ends[0], second.ends[1]];
            all.sort_by(|a, b| place(a).total_cmp(&place(b)));
            let mut from = first.from.clone();
            from.extend(&second.from);
            let chain = first.chain;
            self.lines[idx] = Line { ends: [all[0], all[3]], from, chain, is_used: false };
            self.lines.remove(other);
            // What came before had no partner; the longer line looks for one among all.
            idx -= usize::from(other < idx);
        }
    }

    fn is_one(&self, idx: usize, other: usize, pins: &[Point]) -> bool {
        let (first, second) = (&self.lines[idx], &self.lines[other]);
        if first.is_used || second.is_used {
            return false;
        }
        let (long, short) =
            if first.length() >= second.length() { (first, second) } else { (second, first) };
        let direction = long.direction();
        let off = |p: Point| cross(direction, sub(p, long.ends[0])).abs();
        let near = 0.7 * self.tolerance;
        if skew(direction, short.direction()) > 0.12
            || off(short.ends[0]) > near
            || off(short.ends[1]) > near
        {
            return false;
        }
        let place = |p: Point| dot(sub(p, long.ends[0]), direction);
        let reach = long.length();
        let mut span = [place(short.ends[0]), place(short.ends[1])];
        span.sort_by(f64::total_cmp);
        let shares = |at: f64| span.iter().any(|s| (s - at).abs() <= self.tolerance);
        let overlap = span[1].min(reach) - span[0].max(0.0);
        if overlap > self.tolerance {
            // One line again in part: it has an end in common. Else it is another body's.
            return shares(0.0) || shares(reach);
        }
        let joint = if span[0] > 0.5 * reach { long.ends[1] } else { long.ends[0] };
        let has_pin = pins.iter().any(|pin| distance(*pin, joint) < 1.2 * self.pin);
        (shares(0.0) || shares(reach)) && !has_pin && skew(direction, short.direction()) < 0.03
    }

    pub(super) fn note_miss(&mut self, miss: f64) {
        if miss < self.tolerance {
            self.miss = self.miss.max(miss);
        }
    }
}

fn is_curved(path: &Path) -> bool {
    path.curves.iter().any(|curve| !matches!(curve, Curve::Segment { .. }))
}

fn bow(curve: &Curve, from: usize) -> Bow {
    let circle = match curve {
        Curve::Arc { centre, radius, .. } => Some((*centre, *radius)),
        _ => None,
    };
    Bow {
        ends: [curve.start_point(), curve.end_point()],
        points: sampled(curve),
        circle,
        from,
        is_used: false,
    }
}

/// Points along a curve, both ends included.
fn sampled(curve: &Curve) -> Vec<Point> {
    let n: u32 = match curve {
        Curve::Segment { .. } => 1,
        Curve::Spline(_) => 64,
        _ => 24,
    };
    (0..=n).map(|i| curve.point(f64::from(i) / f64::from(n))).collect()
}

/// Centre and radius of a path that is one whole circle.
fn as_circle(path: &Path) -> Option<(Point, f64)> {
    let mut common: Option<(Point, f64, f64)> = None;
    for curve in &path.curves {
        let Curve::Arc { centre, radius, sweep, .. } = curve else { return None };
        common = match common {
            None => Some((*centre, *radius, *sweep)),
            Some((c, r, s)) if distance(c, *centre) < 1e-3 * r && (r - radius).abs() < 1e-3 * r => {
                Some((c, r, s + sweep))
            }
            Some(_) => return None,
        };
    }
    common
        .filter(|(_, _, sweep)| (sweep.abs() - std::f64::consts::TAU).abs() < 1e-3)
        .map(|(centre, radius, _)| (centre, radius))
}

impl Ring {
    pub(super) fn of(curves: &[Curve], from: Vec<usize>) -> Self {
        let mut ring =
            Self { points: Vec::new(), sides: Vec::new(), arcs: Vec::new(), from, is_used: false };
        for curve in curves {
            let points = sampled(curve);
            ring.points.extend(&points[..points.len() - 1]);
            match curve {
                Curve::Segment { from, to } => ring.sides.push([*from, *to]),
                Curve::Arc { centre, radius, .. } => {
                    ring.arcs.push((*centre, *radius, [curve.start_point(), curve.end_point()]));
                }
                _ => {}
            }
        }
        ring.close_up();
        ring
    }

    /// A polyline that returns to its start repeats no corner; sides in line are one.
    fn close_up(&mut self) {
        let mut idx = 0;
        while self.sides.len() > 2 && idx < self.sides.len() {
            let next = (idx + 1) % self.sides.len();
            let [first, second] = [self.sides[idx], self.sides[next]];
            let length = distance(first[0], first[1]);
            let is_straight = skew(unit(sub(first[1], first[0])), unit(sub(second[1], second[0])))
                < 0.02
                && distance(first[1], second[0]) < 0.02 * length
                && dot(sub(first[1], first[0]), sub(second[1], second[0])) > 0.0;
            if is_straight {
                self.sides[idx] = [first[0], second[1]];
                self.sides.remove(next);
                idx = 0;
            } else {
                idx += 1;
            }
        }
    }
}

fn extent(sheet: &Sheet) -> f64 {
    use bksim_cad::geometry::Bounds;
    let all = sheet.strokes.iter().map(|stroke| stroke.path.bounds());
    all.fold(Bounds::EMPTY, Bounds::union).diagonal()
}
