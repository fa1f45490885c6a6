//! Closures of dyads and single parts.
//!
//! ```text
//! RRR   circles of radii a, b at the distance d     c = (a² + d² − b²)/(2 a d)
//! RRP   a circle of radius a and a line h away      c = h/a
//! RPR   a guide k next to pins at the distance d     c = k/d
//! |c| < 1: two closures     |c| > 1: none
//! PRP   two lines                                   one closure, unless they are parallel
//! RPP   a line at a given angle and a line          the same
//! ```

use super::place::{Place, dot, heading, left, length, less, turned};
use super::structure::{Pair, Structure};

/// The ways in which a group closes.
pub(super) struct Closure {
    /// 1 − |c|, below zero where nothing closes; the sine between lines.
    pub(super) margin: f64,
    /// Parts with their places.
    pub(super) ways: Vec<Vec<(usize, Place)>>,
}

type Way<'a> = &'a [Option<Place>];

/// The pairs of a dyad in letters.
pub(super) fn kind(pairs: [Pair; 3]) -> &'static str {
    use Pair::{Pin, Slide};
    match pairs {
        [Pin(_), Pin(_), Pin(_)] => "RRR",
        [Pin(_), Pin(_), Slide(_)] => "RRP",
        [Pin(_), Slide(_), Pin(_)] => "RPR",
        [Slide(_), Pin(_), Slide(_)] => "PRP",
        [Pin(_), Slide(_), Slide(_)] => "RPP",
        _ => "",
    }
}

/// True for the dyads that [`closures`] knows; each is found from one of its ends.
pub(super) fn is_known(pairs: [Pair; 3]) -> bool {
    !kind(pairs).is_empty()
}

/// The place of a part with a held angle on a pin.
pub(super) fn turned_on(
    structure: &Structure,
    part: usize,
    pin: usize,
    angle: f64,
    way: Way<'_>,
) -> Option<Vec<(usize, Place)>> {
    let at = structure.standing_pin(pin, way)?;
    Some(vec![(part, Place::bringing(structure.point(pin, part), at, angle))])
}

/// The place of a part on two pairs, as far as these go; none where they do not place it.
pub(super) fn single(
    structure: &Structure,
    part: usize,
    pairs: [Pair; 2],
    way: Way<'_>,
) -> Option<Vec<(usize, Place)>> {
    let place = match pairs {
        [Pair::Pin(a), Pair::Pin(b)] => {
            let [p, q] = [structure.standing_pin(a, way)?, structure.standing_pin(b, way)?];
            let [own_p, own_q] = [structure.point(a, part), structure.point(b, part)];
            let angle = heading(less(q, p)) - heading(less(own_q, own_p));
            Place::bringing(own_p, p, angle)
        }
        [Pair::Pin(pin), Pair::Slide(slide)] | [Pair::Slide(slide), Pair::Pin(pin)] => {
            let angle = way[structure.other(slide, part)]?.angle;
            let at = structure.standing_pin(pin, way)?;
            Place::bringing(structure.point(pin, part), at, angle)
        }
        [Pair::Slide(a), Pair::Slide(b)] => {
            let lines = [line(structure, a, part, way)?, line(structure, b, part, way)?];
            let (_, at) = crossing(lines);
            Place { at, angle: way[structure.other(a, part)]?.angle }
        }
    };
    Some(vec![(part, place)])
}

/// Where the shift of a part may be that slides on one that stands: a point, and a direction.
fn line(structure: &Structure, slide: usize, part: usize, way: Way<'_>) -> Option<[[f64; 2]; 2]> {
    let by = way[structure.other(slide, part)]?;
    Some([by.at, turned(structure.slides[slide].axis, by.angle)])
}

/// Where two lines cross, and the sine of the angle between them.
fn crossing([[p, e], [q, f]]: [[[f64; 2]; 2]; 2]) -> (f64, [f64; 2]) {
    let sine = dot(left(e), f);
    let along = dot(less(p, q), left(e)) / sine;
    (sine.abs(), [q[0] + along * f[0], q[1] + along * f[1]])
}

/// All closures of a dyad; none where its pairs are of no known kind.
pub(super) fn closures(
    structure: &Structure,
    [first, second]: [usize; 2],
    pairs: [Pair; 3],
    way: Way<'_>,
) -> Option<Closure> {
    let point = |pin: usize, part: usize| structure.point(pin, part);
    match pairs {
        [Pair::Pin(a), Pair::Pin(x), Pair::Pin(b)] => {
            let [p, q] = [structure.standing_pin(a, way)?, structure.standing_pin(b, way)?];
            let of_first = less(point(x, first), point(a, first));
            let of_second = less(point(x, second), point(b, second));
            let line = less(q, p);
            let (r, s, d) = (length(of_first), length(of_second), length(line));
            let c = (r * r + d * d - s * s) / (2.0 * r * d);
            let closure = |sign: f64| {
                let angle = heading(line) + sign * c.clamp(-1.0, 1.0).acos();
                let at = [p[0] + r * angle.cos(), p[1] + r * angle.sin()];
                let turn = heading(less(at, q)) - heading(of_second);
                vec![
                    (first, Place::bringing(point(a, first), p, angle - heading(of_first))),
                    (second, Place::bringing(point(b, second), q, turn)),
                ]
            };
            Some(two(c, closure))
        }
        [Pair::Pin(a), Pair::Pin(x), Pair::Slide(slide)] => {
            let p = structure.standing_pin(a, way)?;
            let by = way[structure.other(slide, second)]?;
            let of_first = less(point(x, first), point(a, first));
            let e = turned(structure.slides[slide].axis, by.angle);
            let foot = by.apply(point(x, second));
            let w = less(p, foot);
            let (r, aside) = (length(of_first), dot(w, left(e)));
            let closure = |sign: f64| {
                let along = dot(w, e) + sign * (r * r - aside * aside).max(0.0).sqrt();
                let at = [foot[0] + along * e[0], foot[1] + along * e[1]];
                let angle = heading(less(at, p)) - heading(of_first);
                vec![
                    (first, Place::bringing(point(a, first), p, angle)),
                    (second, Place::bringing(point(x, second), at, by.angle)),
                ]
            };
            Some(two(aside / r, closure))
        }
        [Pair::Pin(a), Pair::Slide(slide), Pair::Pin(b)] => {
            let [p, q] = [structure.standing_pin(a, way)?, structure.standing_pin(b, way)?];
            let [own_p, own_q] = [point(a, first), point(b, second)];
            // Both turn alike, and the way between them is along the axis.
            let normal = left(structure.slides[slide].axis);
            let line = less(q, p);
            let c = dot(normal, less(own_q, own_p)) / length(line);
            let closure = |sign: f64| {
                let turn = sign * c.clamp(-1.0, 1.0).acos();
                let angle = heading(line) - heading(normal) + turn;
                vec![
                    (first, Place::bringing(own_p, p, angle)),
                    (second, Place::bringing(own_q, q, angle)),
                ]
            };
            Some(two(c, closure))
        }
        [Pair::Slide(s), Pair::Pin(x), Pair::Slide(t)] => {
            // Lines of the pin, by either guide.
            let by = way[structure.other(s, first)]?;
            let on = way[structure.other(t, second)]?;
            let direction =
                |slide: usize, of: &Place| turned(structure.slides[slide].axis, of.angle);
            let lines = [
                [by.apply(point(x, first)), direction(s, &by)],
                [on.apply(point(x, second)), direction(t, &on)],
            ];
            let (margin, at) = crossing(lines);
            let place = |part, of: &Place| (part, Place::bringing(point(x, part), at, of.angle));
            Some(Closure { margin, ways: vec![vec![place(first, &by), place(second, &on)]] })
        }
        [Pair::Pin(a), Pair::Slide(s), Pair::Slide(t)] => {
            let by = way[structure.other(t, second)]?;
            let p = structure.standing_pin(a, way)?;
            let place = Place::bringing(point(a, first), p, by.angle);
            let own = [place.at, turned(structure.slides[s].axis, by.angle)];
            let (margin, at) = crossing([own, line(structure, t, second, way)?]);
            let second = (second, Place { at, angle: by.angle });
            Some(Closure { margin, ways: vec![vec![(first, place), second]] })
        }
        _ => None,
    }
}

/// Two closures where |c| < 1.
fn two(c: f64, closure: impl Fn(f64) -> Vec<(usize, Place)>) -> Closure {
    let margin = 1.0 - c.abs();
    let ways = if margin > 0.0 { vec![closure(1.0), closure(-1.0)] } else { Vec::new() };
    Closure { margin, ways }
}
