//! Classical straight-line linkages of a wanted size, with the length and the deviation of their lines.

use serde::Deserialize;

use super::four_bar::{FourBar, distance, side};
use super::function::largest;
use super::{DesignError, Point, Synthesis, none, optional};
use crate::codes;
use crate::spec::Written;

#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct Wish {
    /// `hoeken`, `chebyshev`, `roberts`, `watt`, `evans`, or `given`; all but the last unless given.
    linkage: Option<String>,
    /// Half the range: angle of the crank (Hoeken, Evans), of the left arm (Watt), or place along the line (Chebyshev) of the
    /// proportions; the side over the half ground of Roberts.
    range: Option<Written>,
    /// Of `given`: the four-bar, its coupler point, and the first and last angle of its crank.
    crank: Option<Written>,
    coupler: Option<Written>,
    rocker: Option<Written>,
    ground: Option<Written>,
    point: Option<[Written; 2]>,
    angles: Option<[Written; 2]>,
    #[serde(default)]
    crossed: bool,
    /// Wanted length of the line.
    length: Option<Written>,
}

/// The classical proportions, one of crank or half ground.
struct Line {
    name: &'static str,
    range: f64,
    /// The pose at a place along the range, −1 to 1.
    pose: Box<dyn Fn(f64) -> Option<FourBar>>,
    /// The coordinate across the line; across the chord if there is none.
    across: Option<usize>,
}

/// The pin at given distances from two points, to the left of the line between them.
pub(super) fn pin(a: Point, ra: f64, b: Point, rb: f64) -> Option<Point> {
    let l = distance(a, b);
    let x = (ra * ra - rb * rb + l * l) / (2.0 * l);
    let square = ra * ra - x * x;
    if square < -1e-12 {
        return None;
    }
    let y = square.max(0.0).sqrt();
    let e = [(b[0] - a[0]) / l, (b[1] - a[1]) / l];
    Some([a[0] + x * e[0] - y * e[1], a[1] + x * e[1] + y * e[0]])
}

/// A point of the coupler, by its places along and to the left of it.
pub(super) fn on_coupler(b: Point, c: Point, along: f64, left: f64) -> Point {
    let l = distance(b, c);
    let e = [(c[0] - b[0]) / l, (c[1] - b[1]) / l];
    [b[0] + along * e[0] - left * e[1], b[1] + along * e[1] + left * e[0]]
}

fn hoeken(range: f64) -> Line {
    let pose = move |s: f64| {
        let angle = std::f64::consts::PI + s * range;
        let (a, d) = ([0.0, 0.0], [2.0, 0.0]);
        let b = [angle.cos(), angle.sin()];
        let c = pin(d, 2.5, b, 2.5).filter(|c| c[1] > 0.0).or_else(|| pin(b, 2.5, d, 2.5))?;
        Some(FourBar { pivots: [a, d], pins: [b, c], point: Some(on_coupler(b, c, 5.0, 0.0)) })
    };
    Line { name: "hoeken", range, pose: Box::new(pose), across: Some(1) }
}

/// A root of a monotone function between two places.
fn bisected(f: &dyn Fn(f64) -> Option<f64>, mut low: f64, mut high: f64) -> Option<f64> {
    let sign = f(low)?.signum();
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if f(middle)?.signum() == sign { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}

/// The left half of a symmetric motion is the mirror image of the right one.
fn symmetric(
    right: impl Fn(f64) -> Option<FourBar> + 'static,
) -> Box<dyn Fn(f64) -> Option<FourBar>> {
    Box::new(move |s: f64| {
        if s >= 0.0 {
            return right(s);
        }
        let bar = right(-s)?;
        let mirrored = |[x, y]: Point| [-x, y];
        let [left, right] = bar.pins;
        Some(FourBar {
            pivots: bar.pivots,
            pins: [mirrored(right), mirrored(left)],
            point: bar.point.map(mirrored),
        })
    })
}

/// The first pose, as the left crank leans to the right from `middle` on, in which the point has gone so far.
fn at_place(at: &dyn Fn(f64) -> Option<FourBar>, middle: f64, place: f64) -> Option<FourBar> {
    if place == 0.0 {
        return at(middle);
    }
    let off = |angle: f64| at(angle).and_then(|bar| bar.point).map(|p| p[0] - place);
    let mut last = middle;
    for k in 1..=800 {
        let end = middle - 0.002 * f64::from(k);
        match off(end) {
            Some(off) if off < 0.0 => last = end,
            Some(_) => return at(bisected(&off, end, last)?),
            None => {
                // The linkage is stretched between here and the last pose: go as far as it does.
                let (mut open, mut closed) = (end, last);
                for _ in 0..100 {
                    let middle = 0.5 * (open + closed);
                    if at(middle).is_some() { closed = middle } else { open = middle }
                }
                let reached = off(closed)?;
                let is_end = reached < 0.0 && reached > -1e-6 * place.abs();
                return if is_end { at(closed) } else { at(bisected(&off, closed, last)?) };
            }
        }
    }
    None
}

fn chebyshev(range: f64) -> Line {
    let at = |angle: f64| {
        let (a, d) = ([-2.0, 0.0], [2.0, 0.0]);
        let b = [a[0] + 5.0 * angle.cos(), 5.0 * angle.sin()];
        // Crossed: the pin of the right crank is on the left.
        let c = pin(d, 5.0, b, 2.0)?;
        Some(FourBar { pivots: [a, d], pins: [b, c], point: Some(on_coupler(b, c, 1.0, 0.0)) })
    };
    let middle = (3.0f64 / 5.0).acos();
    let pose = symmetric(move |s| at_place(&at, middle, s * range));
    Line { name: "chebyshev", range, pose, across: Some(1) }
}

fn roberts(r: f64) -> Line {
    let height = (r * r - 0.25).sqrt();
    let at = move |angle: f64| {
        let (a, d) = ([-1.0, 0.0], [1.0, 0.0]);
        let b = [a[0] + r * angle.cos(), r * angle.sin()];
        let c = pin(b, 1.0, d, r)?;
        Some(FourBar { pivots: [a, d], pins: [b, c], point: Some(on_coupler(b, c, 0.5, -height)) })
    };
    let pose = symmetric(move |s| at_place(&at, (0.5 / r).acos(), s));
    Line { name: "roberts", range: r, pose, across: Some(1) }
}

fn watt(range: f64) -> Line {
    let pose = move |s: f64| {
        let (a, d) = ([-1.5, 0.5], [1.5, -0.5]);
        let b = [a[0] + 1.5 * (s * range).cos(), a[1] + 1.5 * (s * range).sin()];
        // The pin that the middle pose, (0, −0.5), leads to.
        let off = |c: &Point| distance(*c, [0.0, -0.5]);
        let both = [pin(b, 1.0, d, 1.5), pin(d, 1.5, b, 1.0)].into_iter().flatten();
        let c = both.min_by(|x, y| off(x).total_cmp(&off(y)))?;
        Some(FourBar { pivots: [a, d], pins: [b, c], point: Some(on_coupler(b, c, 0.5, 0.0)) })
    };
    Line { name: "watt", range, pose: Box::new(pose), across: Some(0) }
}

/// Evans' grasshopper: the crank carries the middle of the coupler, one end of which a long rocker guides nearly straight,
/// so that the other one goes nearly straight across.
fn evans(range: f64) -> Line {
    const ROCKER: f64 = 4.0;
    let pose = move |s: f64| {
        let (a, d) = ([0.0, 0.0], [1.0 + range.cos(), ROCKER]);
        let angle = s * range;
        let b = [angle.cos(), angle.sin()];
        let near = [2.0 * angle.cos(), 0.0];
        let both = [pin(b, 1.0, d, ROCKER), pin(d, ROCKER, b, 1.0)].into_iter().flatten();
        let c = both.min_by(|x, y| distance(*x, near).total_cmp(&distance(*y, near)))?;
        Some(FourBar { pivots: [a, d], pins: [b, c], point: Some(on_coupler(b, c, -1.0, 0.0)) })
    };
    Line { name: "evans", range, pose: Box::new(pose), across: Some(0) }
}

/// A four-bar with a part of its coupler curve.
fn given(wish: &Wish) -> Result<Line, DesignError> {
    let need = |value: &Option<Written>| {
        optional(value.as_ref())?.ok_or_else(|| {
            let message = "the four-bar is not given";
            let help = "write `crank`, `coupler`, `rocker`, `ground`, `point = [x, y]` in the coupler's frame, and `angles = [from, to]` of the crank";
            DesignError::fault(codes::BAD_QUESTION, message, help)
        })
    };
    let lengths = [need(&wish.crank)?, need(&wish.coupler)?, need(&wish.rocker)?];
    let ground = need(&wish.ground)?;
    let two = |pair: &Option<[Written; 2]>| -> Result<Point, DesignError> {
        let [first, last] = pair.clone().map_or([None, None], |pair| pair.map(Some));
        Ok([need(&first)?, need(&last)?])
    };
    let (point, [from, to]) = (two(&wish.point)?, two(&wish.angles)?);
    let crossed = wish.crossed;
    let pose = move |s: f64| {
        let [crank, coupler, rocker] = lengths;
        let angle = 0.5 * (from + to) + 0.5 * s * (to - from);
        let (a, d) = ([0.0, 0.0], [ground, 0.0]);
        let b = [crank * angle.cos(), crank * angle.sin()];
        let c = if crossed { pin(d, rocker, b, coupler) } else { pin(b, coupler, d, rocker) }?;
        let p = on_coupler(b, c, point[0], point[1]);
        Some(FourBar { pivots: [a, d], pins: [b, c], point: Some(p) })
    };
    Ok(Line { name: "given", range: 0.5 * (to - from), pose: Box::new(pose), across: None })
}

pub(super) fn solve(wish: &Wish) -> Result<Synthesis, DesignError> {
    let range = optional(wish.range.as_ref())?;
    let deg = f64::to_radians;
    let all: Vec<Line> = match wish.linkage.as_deref() {
        Some("hoeken") => vec![hoeken(range.unwrap_or(deg(90.0)))],
        Some("chebyshev") => vec![chebyshev(range.unwrap_or(2.0))],
        Some("roberts") => vec![roberts(range.unwrap_or(1.2))],
        Some("watt") => vec![watt(range.unwrap_or(deg(20.0)))],
        Some("evans") => vec![evans(range.unwrap_or(deg(30.0)))],
        Some("given") => vec![given(wish)?],
        None => {
            vec![hoeken(deg(90.0)), chebyshev(2.0), roberts(1.2), watt(deg(20.0)), evans(deg(30.0))]
        }
        Some(other) => {
            let message = format!("`{other}` is no straight-line linkage");
            let help = "write `hoeken`, `chebyshev`, `roberts`, `watt`, `evans` or `given`";
            return Err(DesignError::fault(codes::BAD_QUESTION, message, help));
        }
    };
    let wanted = optional(wish.length.as_ref())?;
    let mut candidates = Vec::new();
    for line in all {
        let point = |s: f64| (line.pose)(s).and_then(|bar| bar.point);
        let Some((first, last)) = point(-1.0).zip(point(1.0)) else { continue };
        let length = distance(first, last);
        let scale = wanted.map_or(1.0, |wanted| wanted / length);
        // Offsets to the left of the chord, where no coordinate is across.
        let off = |p: Point| match line.across {
            Some(axis) => p[axis],
            None => side(first, last, p) / length,
        };
        let across = |s: f64| point(s).map_or(f64::NAN, off);
        let (most, _) = largest(&across, [-1.0, 1.0]);
        let (least, _) = largest(&|s| -across(s), [-1.0, 1.0]);
        let scaled = |p: Point| p.map(|x| x * scale);
        let Some(bar) = (line.pose)(0.0) else { continue };
        let bar = FourBar {
            pivots: bar.pivots.map(scaled),
            pins: bar.pins.map(scaled),
            point: bar.point.map(scaled),
        };
        let mut candidate = bar.candidate(line.name);
        let numbers = [
            ("range", line.range),
            ("length", length * scale),
            ("largest", most * scale),
            ("least", -least * scale),
            ("span", (most + least) * scale),
            ("deviation_over_length", (most + least) / length),
        ];
        for (name, value) in numbers {
            candidate.numbers.insert(name.to_owned(), value);
        }
        let upright = side(bar.pins[0], bar.pivots[1], bar.pins[1]) > 0.0;
        candidate.checks.insert("open".to_owned(), upright);
        candidates.push(candidate);
    }
    if candidates.is_empty() {
        return Err(none("the linkage does not reach that far", "give a smaller `range`"));
    }
    let of = |c: &super::Candidate| c.numbers["deviation_over_length"];
    candidates.sort_by(|a, b| of(a).total_cmp(&of(b)));
    Ok(Synthesis { task: "straight_line".to_owned(), candidates, ..Synthesis::default() })
}
