//! Symbols by which pins are fixed to the ground: legs, arches and triangles.

use bksim_cad::geometry::Point;
use bksim_cad::geometry::vector::{cross, distance, sub};

use super::hatching::Base;
use super::pieces::{Line, Pieces, Ring, to_segment, unit};

/// Pins that stand on the ground by legs, arches or triangles; takes those away.
pub(super) fn stands(pieces: &mut Pieces, bases: &[Base], pins: &[(Point, f64)]) -> Vec<bool> {
    let near = pieces.tolerance;
    let mut is_fixed = vec![false; pins.len()];
    let before: Vec<bool> = pieces.lines.iter().map(|line| line.is_used).collect();
    let on_base = |p: Point| bases.iter().any(|base| to_segment(p, base.ends) < 1.2 * near);
    let at_pin = |p: Point, other: Point| {
        pins.iter().position(|(pin, radius)| {
            distance(*pin, p) < near
                || distance(*pin, p) < 1.1 * radius + near && to_line(*pin, [p, other]) < near
        })
    };
    for idx in 0..pieces.lines.len() {
        if pieces.lines[idx].is_used {
            continue;
        }
        let ends = pieces.lines[idx].ends;
        for (foot, head) in [(ends[0], ends[1]), (ends[1], ends[0])] {
            if !on_base(foot) || on_base(head) || at_pin(foot, head).is_some() {
                continue;
            }
            if let Some(pin) = at_pin(head, foot) {
                is_fixed[pin] = true;
                pieces.lines[idx].is_used = true;
            }
        }
    }
    two_legs(pieces, bases, pins, &mut is_fixed);
    // An arch about a pin stands on two legs; the end of a bar may touch the ground with one of its sides.
    for idx in 0..pieces.bows.len() {
        let bow = &pieces.bows[idx];
        let Some((centre, radius)) = bow.circle else { continue };
        let pin = pins.iter().position(|(pin, _)| distance(*pin, centre) < 1.2 * near);
        let (Some(pin), true) = (pin, radius < 5.0 * pieces.pin) else { continue };
        let legs = bow.ends.map(|end| {
            let stands = |line: &Line| {
                let base_at = |p: Point, foot: Point| {
                    let is_under = |base: &Base| to_segment(foot, base.ends) < 1.2 * near;
                    if distance(p, end) < 1.5 * near {
                        bases.iter().position(is_under)
                    } else {
                        None
                    }
                };
                let is_short = !line.is_used && line.length() < 5.0 * radius;
                let [a, b] = line.ends;
                if is_short { base_at(a, b).or(base_at(b, a)) } else { None }
            };
            let all = (0..pieces.lines.len()).filter_map(|k| Some((k, stands(&pieces.lines[k])?)));
            all.collect::<Vec<(usize, usize)>>()
        });
        let [left, right] = &legs;
        if left.iter().any(|(_, base)| right.iter().any(|(_, other)| other == base)) {
            is_fixed[pin] = true;
            pieces.bows[idx].is_used = true;
            legs.iter().flatten().for_each(|&(leg, _)| pieces.lines[leg].is_used = true);
        }
    }
    // What repeats a leg in part is no body.
    let taken =
        pieces.lines.iter().zip(&before).filter(|(line, was_used)| line.is_used && !**was_used);
    let legs: Vec<[Point; 2]> = taken.map(|(line, _)| line.ends).collect();
    for line in pieces.lines.iter_mut().filter(|line| !line.is_used) {
        let repeats =
            |leg: &[Point; 2]| line.ends.iter().all(|p| to_segment(*p, *leg) < 0.7 * near);
        line.is_used = line.length() < 12.0 * pieces.pin && legs.iter().any(repeats);
    }
    stand_symbols(pieces, bases, pins, &mut is_fixed);
    is_fixed
}

/// Pins whose circle two short legs on one base meet at one point of; takes the legs away.
fn two_legs(pieces: &mut Pieces, bases: &[Base], pins: &[(Point, f64)], is_fixed: &mut [bool]) {
    let near = pieces.tolerance;
    let base_at = |p: Point| bases.iter().position(|base| to_segment(p, base.ends) < 1.2 * near);
    for (pin, &(centre, radius)) in pins.iter().enumerate() {
        let is_on_rim = |p: Point| (distance(p, centre) - radius).abs() < near;
        let leg = |(idx, line): (usize, &Line)| {
            let [a, b] = line.ends;
            let [head, foot] = if is_on_rim(a) { [a, b] } else { [b, a] };
            let is_leg = !line.is_used && is_on_rim(head) && line.length() < 12.0 * radius;
            Some((idx, head, base_at(foot)?)).filter(|_| is_leg && base_at(head).is_none())
        };
        let legs: Vec<_> = pieces.lines.iter().enumerate().filter_map(leg).collect();
        let meets = |(idx, head, base): &(usize, Point, usize)| {
            let other = |(own, at, on): &(usize, Point, usize)| {
                own != idx && on == base && distance(*at, *head) < near
            };
            legs.iter().any(other)
        };
        for (idx, ..) in legs.iter().filter(|leg| meets(leg)) {
            is_fixed[pin] = true;
            pieces.lines[*idx].is_used = true;
        }
    }
}

/// Pins at a corner, or under the arch, of symbols that are one closed line; takes those away.
pub(super) fn stand_symbols(
    pieces: &mut Pieces,
    bases: &[Base],
    pins: &[(Point, f64)],
    is_fixed: &mut [bool],
) {
    let near = pieces.tolerance;
    for ring in pieces.rings.iter_mut().filter(|ring| !ring.is_used) {
        if let Some(pin) = pin_of_symbol(ring, bases, pins, near) {
            is_fixed[pin] = true;
            ring.is_used = true;
        }
    }
}

fn to_line(p: Point, [a, b]: [Point; 2]) -> f64 {
    cross(unit(sub(b, a)), sub(p, a)).abs()
}

/// The pin at the corner of a small triangle, or under an arch, on the ground.
fn pin_of_symbol(ring: &Ring, bases: &[Base], pins: &[(Point, f64)], near: f64) -> Option<usize> {
    let is_on = |side: &[Point; 2]| {
        let stands = |base: &Base| side.iter().all(|p| to_segment(*p, base.ends) < 1.2 * near);
        bases.iter().any(stands)
    };
    let size = ring.sides.iter().map(|side| distance(side[0], side[1])).fold(0.0, f64::max);
    let is_small = |radius: f64| size < 12.0 * radius;
    match (ring.sides.len(), ring.arcs.as_slice()) {
        (3, []) => {
            // A corner is in the middle of the pin or on its circle.
            let corner = |(pin, radius): (Point, f64)| {
                let far = ring.sides.iter().map(|side| distance(side[0], pin));
                let mut far = far;
                far.any(|far| far < 1.5 * near || (far - radius).abs() < near)
            };
            let at: Vec<usize> = (0..pins.len()).filter(|&idx| corner(pins[idx])).collect();
            match at[..] {
                [pin] if is_small(pins[pin].1) => Some(pin),
                _ => None,
            }
        }
        (3, [(centre, _, _)]) if ring.sides.iter().any(is_on) => {
            pins.iter().position(|(pin, _)| distance(*pin, *centre) < 1.5 * near)
        }
        _ => None,
    }
}
