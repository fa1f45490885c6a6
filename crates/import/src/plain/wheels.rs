//! Wheels, by their circles.

use std::collections::BTreeSet;

use bksim_cad::geometry::Point;
use bksim_cad::geometry::vector::distance;
use bksim_cad::read::Dash;

use super::bodies::{Bodies, Body, Look, Pin};
use super::hatching::GroundRing;
use super::pieces::{Circle, Pieces, to_segment};

/// Wheels: pitch circles that touch, and large circles about pins.
///
/// A wheel at one of the pins `held` turns with the link that has this pin, too.
pub(super) fn add_wheels(
    found: &mut Bodies,
    pieces: &Pieces,
    (pins, held): (&[Pin], &[usize]),
    ground: &[GroundRing],
) {
    let near = 1.5 * pieces.tolerance;
    let pin_of = |centre: Point| pins.iter().position(|pin| distance(pin.at, centre) < near);
    let large: Vec<_> =
        pieces.circles.iter().filter(|circle| circle.radius >= 3.2 * pieces.pin).collect();
    let touches = |a: Point, ra: f64, b: Point, rb: f64| {
        let d = distance(a, b);
        (d - ra - rb).abs() < near || d > near && (d - (ra - rb).abs()).abs() < near
    };
    let pitch: Vec<_> =
        large.iter().filter(|c| c.dash == Dash::Centre && pin_of(c.centre).is_some()).collect();
    let meshes = |circle: &Circle| {
        pitch.iter().any(|other| {
            other.from != circle.from
                && touches(circle.centre, circle.radius, other.centre, other.radius)
        })
    };
    let rack = |circle: &Circle| {
        pieces.axes.iter().any(|axis| {
            distance(axis[0], axis[1]) > 0.8 * circle.radius
                && (to_segment(circle.centre, *axis) - circle.radius).abs() < near
        })
    };
    for circle in &pitch {
        if !meshes(circle) && !rack(circle) {
            continue;
        }
        let still = ground.iter().find(|ring| {
            let [least, most] = ring.reach;
            distance(ring.centre, circle.centre) < near
                && circle.radius > 0.8 * least
                && circle.radius < most + near
        });
        if still.is_some() {
            found.rings.push((circle.centre, circle.radius, circle.from));
            continue;
        }
        let mut from = vec![circle.from];
        for other in large.iter().filter(|other| other.dash == Dash::Solid) {
            let is_teeth = (other.radius / circle.radius - 1.0).abs() < 0.25;
            if distance(other.centre, circle.centre) < near && is_teeth {
                from.push(other.from);
            }
        }
        // Circles about one centre are one wheel, unless a wheel between them meshes with both: a ring and its sun.
        let is_apart = |radius: f64| {
            pitch.iter().any(|other| {
                touches(other.centre, other.radius, circle.centre, radius)
                    && touches(other.centre, other.radius, circle.centre, circle.radius)
            })
        };
        let same = found.all.iter_mut().find(|body| {
            let wheel = body.wheel.as_ref();
            wheel.is_some_and(|(centre, radii)| {
                distance(*centre, circle.centre) < near
                    && !radii.iter().any(|radius| is_apart(*radius))
            })
        });
        if let Some(Body { wheel: Some((_, radii)), from: own, .. }) = same {
            radii.push(circle.radius);
            own.extend(from);
            continue;
        }
        let pin = pin_of(circle.centre);
        let link = pin.filter(|pin| held.contains(pin)).and_then(|pin| link_at(found, pin));
        if let Some(link) = link {
            found.all[link].wheel = Some((circle.centre, vec![circle.radius]));
            found.all[link].from.extend(from);
            continue;
        }
        let mut body = Body::new(Look::Wheel, from);
        body.wheel = Some((circle.centre, vec![circle.radius]));
        body.pins.extend(pin);
        found.all.push(body);
    }
    let known: BTreeSet<usize> = found.all.iter().flat_map(|body| body.from.clone()).collect();
    for circle in large.iter().filter(|c| c.dash == Dash::Solid && !known.contains(&c.from)) {
        // A circle through a pin is its path.
        let is_path =
            pins.iter().any(|pin| (distance(pin.at, circle.centre) - circle.radius).abs() < near);
        let inside: Vec<usize> = (0..pins.len())
            .filter(|&idx| distance(pins[idx].at, circle.centre) < circle.radius)
            .collect();
        let is_disc = pin_of(circle.centre).is_some() || inside.len() > 1;
        let is_plain = circle.radius < 14.0 * pieces.pin || pin_of(circle.centre).is_some();
        let is_ground = ground.iter().any(|ring| {
            distance(ring.centre, circle.centre) < near
                && ring.reach.iter().any(|reach| (reach - circle.radius).abs() < near)
        });
        if is_path || is_ground || inside.is_empty() || !is_disc || !is_plain {
            continue;
        }
        let mut body = Body::new(Look::Wheel, vec![circle.from]);
        body.wheel = Some((circle.centre, vec![circle.radius]));
        body.pins.extend(pin_of(circle.centre));
        found.all.push(body);
    }
}

/// The only body but wheels that has a pin.
fn link_at(found: &Bodies, pin: usize) -> Option<usize> {
    let has = |idx: &usize| {
        let body = &found.all[*idx];
        body.look != Look::Wheel && body.wheel.is_none() && body.pins.contains(&pin)
    };
    let mut all = (0..found.all.len()).filter(has);
    all.next().filter(|_| all.next().is_none())
}

/// Pins about which a wheel may turn with the link that has them, or on its own: the wheel has no other pin, and the link
/// carries no other wheel, which would be locked then.
pub(super) fn doubtful(found: &Bodies) -> Vec<usize> {
    let wheels = found.all.iter().filter(|body| body.look == Look::Wheel && body.pins.len() == 1);
    let pins = wheels.filter_map(|body| body.pins.first().copied());
    let carries = |link: usize, pin: usize| {
        let others = found.all[link].pins.iter().filter(|other| **other != pin);
        others.clone().any(|other| {
            found.all.iter().any(|body| body.wheel.is_some() && body.pins.contains(other))
        })
    };
    let is_doubtful = |pin: &usize| link_at(found, *pin).is_some_and(|link| !carries(link, *pin));
    let mut all: Vec<usize> = pins.filter(is_doubtful).collect();
    all.sort_unstable();
    all.dedup();
    all
}
