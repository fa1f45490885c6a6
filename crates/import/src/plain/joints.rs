//! Joints between the bodies of a drawing.

use std::collections::BTreeSet;

use bksim_cad::geometry::Point;
use bksim_cad::geometry::vector::{along, between, distance, dot, sub};

use super::bodies::{Bodies, Body, Look};
use super::cams::{add_discs, cams};
use super::hatching::Base;
use super::joint::{Joint, Kind, On, Scene};
use super::pieces::{Pieces, is_inside, skew, to_segment, unit};

/// Finds all joints. Pins of one body alone are left for questions.
pub(super) fn joints(scene: &mut Scene<'_>) -> Vec<Joint> {
    let mut all = Vec::new();
    let slots = in_slots(scene);
    let on_bars = blocks_on_bars(scene);
    let slides = slides(scene);
    fix_near(scene, &slides);
    add_discs(scene);
    on_wheels(scene, &slots);
    let held =
        slides.iter().chain(&slots).chain(&on_bars).flat_map(|joint| joint.on.clone()).collect();
    drop_stubs(scene, &held, &slots);
    all.extend(slides);
    all.extend(pinned(scene));
    all.extend(slots);
    all.extend(on_bars);
    all.extend(gears(scene));
    all.extend(cams(scene, &all));
    all
}

fn members(bodies: &Bodies, pin: usize) -> Vec<usize> {
    (0..bodies.all.len()).filter(|&idx| bodies.all[idx].pins.contains(&pin)).collect()
}

/// Pins in slots: they do not turn in the body with the slot.
fn in_slots(scene: &mut Scene<'_>) -> Vec<Joint> {
    let mut found = Vec::new();
    let near = 1.2 * scene.pieces.tolerance;
    for slot in scene.bodies.slots.clone() {
        for (idx, pin) in scene.pins.iter().enumerate() {
            let fits = pin.radii.iter().any(|radius| (0.6..1.12).contains(&(radius / slot.half)));
            if !fits || to_segment(pin.at, slot.ends) > near {
                continue;
            }
            scene.bodies.all[slot.body].pins.remove(&idx);
            let mut holders: Vec<On> =
                members(scene.bodies, idx).into_iter().map(On::Body).collect();
            if scene.is_fixed[idx] {
                holders.insert(0, On::Ground);
            }
            // The body that has further pins holds this one; a stroke across it does not.
            let n_pins = |on: &&On| match on {
                On::Ground => usize::MAX,
                On::Body(body) => scene.bodies.all[*body].pins.len(),
            };
            let Some(first) = holders.iter().rev().max_by_key(n_pins) else { continue };
            let axis = oriented(unit(sub(slot.ends[1], slot.ends[0])));
            let from = pin.from.iter().chain(&slot.from).copied().collect();
            found.push(Joint::new(
                Kind::Slot { axis },
                pin.at,
                vec![*first, On::Body(slot.body)],
                from,
            ));
        }
    }
    found
}

/// Blocks through which a bar of another body runs.
fn blocks_on_bars(scene: &mut Scene<'_>) -> Vec<Joint> {
    let mut found = Vec::new();
    let near = 1.2 * scene.pieces.tolerance;
    for block in 0..scene.bodies.all.len() {
        if scene.bodies.all[block].look != Look::Block {
            continue;
        }
        let border = scene.bodies.all[block].border.clone();
        let Some(pin) = scene.bodies.all[block]
            .pins
            .iter()
            .copied()
            .find(|pin| is_inside(&border, scene.pins[*pin].at))
        else {
            continue;
        };
        let at = scene.pins[pin].at;
        let sides = scene.bodies.all[block].segments.clone();
        for bar in 0..scene.bodies.all.len() {
            let candidate = &scene.bodies.all[bar];
            if bar == block || !matches!(candidate.look, Look::Lines | Look::Bar) {
                continue;
            }
            let runs = candidate.segments.iter().find(|[a, b]| {
                let d = unit(sub(*b, *a));
                let is_even = sides.iter().any(|side| skew(d, unit(sub(side[1], side[0]))) < 0.03);
                to_segment(at, [*a, *b]) < near
                    && !is_inside(&border, *a)
                    && !is_inside(&border, *b)
                    && is_even
            });
            if let Some([a, b]) = runs {
                let axis = oriented(unit(sub(*b, *a)));
                let from = scene.bodies.all[block].from.clone();
                scene.bodies.all[bar].pins.remove(&pin);
                found.push(Joint::new(
                    Kind::Slide { axis },
                    at,
                    vec![On::Body(bar), On::Body(block)],
                    from,
                ));
            }
        }
    }
    found
}

/// To the right, or upwards where it is upright.
pub(super) fn oriented(axis: Point) -> Point {
    let clean = axis.map(|x| if x.abs() < 1e-12 { 0.0 } else { x });
    let is_back = clean[0] < -1e-9 || clean[0].abs() <= 1e-9 && clean[1] < 0.0;
    if is_back { [-clean[0], -clean[1]].map(|x| x + 0.0) } else { clean }
}

/// The share of a segment along a base that overlaps it, against the shorter one.
fn overlap(base: &Base, [a, b]: [Point; 2]) -> f64 {
    let mut span = [base.place(a)[0], base.place(b)[0]];
    span.sort_by(f64::total_cmp);
    let common = span[1].min(base.length()) - span[0].max(0.0);
    common / (span[1] - span[0]).min(base.length()).max(f64::MIN_POSITIVE)
}

/// Heights above a base of the straight edges of a body along it.
fn heights(body: &Body, base: &Base) -> Vec<f64> {
    let direction = base.direction();
    let along_base = body.segments.iter().filter(|segment| {
        skew(direction, unit(sub(segment[1], segment[0]))) < 0.05 && overlap(base, **segment) > 0.5
    });
    along_base.map(|[a, b]| 0.5 * (base.place(*a)[1] + base.place(*b)[1])).collect()
}

/// Bodies in guides: between two borders of the ground that face each other, or on one.
fn slides(scene: &mut Scene<'_>) -> Vec<Joint> {
    let mut found: Vec<Joint> = Vec::new();
    let tolerance = scene.pieces.tolerance;
    let mut is_guide = vec![false; scene.bases.len()];
    for i in 0..scene.bases.len() {
        for k in i + 1..scene.bases.len() {
            let (first, second) = (&scene.bases[i], &scene.bases[k]);
            let gap = first.place(between(second.ends[0], second.ends[1], 0.5))[1];
            let faces = skew(first.direction(), second.direction()) < 0.03
                && dot(first.free, second.free) < -0.9;
            if !faces
                || gap < tolerance
                || gap > 30.0 * scene.pieces.pin
                || overlap(first, second.ends) < 0.5
            {
                continue;
            }
            let middle = |at: Point| {
                let [along_first, height] = first.place(at);
                let centred = along(at, 0.5 * gap - height, first.free);
                (centred, along_first)
            };
            let clearance = (0.22 * gap).max(1.3 * tolerance);
            let touches = |body: &Body| {
                let below = heights(body, first);
                let above = heights(body, second);
                let fits = |h: &f64| (-1.2 * tolerance..clearance).contains(h);
                below.iter().any(fits) && above.iter().any(fits)
            };
            let mut held: Vec<usize> = (0..scene.bodies.all.len())
                .filter(|&idx| touches(&scene.bodies.all[idx]))
                .collect();
            // A rod that is one line runs in the middle and out of the guides.
            if held.is_empty() {
                let runs = |body: &Body| {
                    body.look == Look::Lines
                        && body.segments.iter().any(|[a, b]| {
                            let places = [first.place(*a), first.place(*b)];
                            let is_out = places.iter().any(|p| p[0] < 0.0 || p[0] > first.length());
                            skew(first.direction(), unit(sub(*b, *a))) < 0.03
                                && overlap(first, [*a, *b]) > 0.7
                                && is_out
                                && places.iter().all(|p| {
                                    (p[1] - 0.5 * gap).abs() < (0.2 * gap).min(2.0 * tolerance)
                                })
                        })
                };
                held = (0..scene.bodies.all.len())
                    .filter(|&idx| runs(&scene.bodies.all[idx]))
                    .collect();
            }
            for &body in &held {
                (is_guide[i], is_guide[k]) = (true, true);
                let inner = scene.bodies.all[body].pins.iter().map(|pin| scene.pins[*pin].at);
                let inner =
                    inner.map(&middle).find(|(_, place)| (0.0..first.length()).contains(place));
                let at = inner.map_or_else(
                    || middle(between(first.ends[0], first.ends[1], 0.5)).0,
                    |(at, _)| at,
                );
                let from = first.from.iter().chain(&second.from).copied().collect();
                let axis = oriented(first.direction());
                // Guides in several pieces hold a body once.
                let is_known = found.iter().any(|joint| {
                    let is_along = |known: Point| skew(known, axis) < 0.03;
                    joint.on.contains(&On::Body(body))
                        && matches!(joint.kind, Kind::Slide { axis: known } if is_along(known))
                });
                if !is_known {
                    let on = vec![On::Ground, On::Body(body)];
                    found.push(Joint::new(Kind::Slide { axis }, at, on, from));
                }
            }
        }
    }
    for (i, base) in scene.bases.iter().enumerate().filter(|(i, _)| !is_guide[*i]) {
        for body in 0..scene.bodies.all.len() {
            let it = &scene.bodies.all[body];
            let is_known = found.iter().any(|joint| joint.on.contains(&On::Body(body)));
            let is_rack = has_pitch_line(scene.pieces, it);
            let lies = it.segments.iter().any(|[a, b]| {
                let heights = [base.place(*a)[1], base.place(*b)[1]];
                overlap(base, [*a, *b]) > 0.9
                    && heights.iter().all(|h| h.abs() < 1.2 * tolerance)
                    && base.length() > if is_rack { 1.0 } else { 1.3 } * distance(*a, *b)
            });
            // A plate that stands on the ground by its arch was taken as a bearing before.
            let is_slider = matches!(it.look, Look::Block | Look::Plate) && !it.border.is_empty();
            if is_slider && lies && !is_known && (is_rack || !it.pins.is_empty()) {
                let axis = oriented(base.direction());
                let on_it = between(base.ends[0], base.ends[1], 0.5);
                let at = it.pins.first().map_or(on_it, |pin| scene.pins[*pin].at);
                found.push(Joint::new(
                    Kind::Slide { axis },
                    at,
                    vec![On::Ground, On::Body(body)],
                    scene.bases[i].from.clone(),
                ));
            }
        }
    }
    found
}

/// Pins right on a hatched piece, unless what holds them slides along it.
fn fix_near(scene: &mut Scene<'_>, slides: &[Joint]) {
    let sliding: BTreeSet<On> =
        slides.iter().flat_map(|joint| joint.on.clone()).filter(|on| *on != On::Ground).collect();
    for (idx, pin) in scene.pins.iter().enumerate() {
        let slides =
            members(scene.bodies, idx).into_iter().any(|body| sliding.contains(&On::Body(body)));
        let is_near = scene.bases.iter().any(|base| {
            let [place, height] = base.place(pin.at);
            (0.0..base.length()).contains(&place)
                && (-0.5 * pin.radii[0]..2.2 * pin.radii[0]).contains(&height)
        });
        scene.is_fixed[idx] |= is_near && !slides;
    }
}

/// Lines that end nowhere at a pin that joins others already are marks, and no bodies.
fn drop_stubs(scene: &mut Scene<'_>, held: &BTreeSet<On>, slots: &[Joint]) {
    for body in 0..scene.bodies.all.len() {
        let it = &scene.bodies.all[body];
        let [pin] = it.pins.iter().copied().collect::<Vec<_>>()[..] else { continue };
        let holders = members(scene.bodies, pin).len() + usize::from(scene.is_fixed[pin]);
        let at = scene.pins[pin].at;
        let in_slot = slots.iter().any(|joint| distance(joint.at, at) < scene.pieces.tolerance);
        let holders = holders + usize::from(in_slot);
        let has_slot = held.contains(&On::Body(body));
        if it.look == Look::Lines && holders > 2 && !has_slot {
            scene.bodies.all[body].pins.clear();
        }
    }
}

/// A pin within a wheel that only one other body has is on the wheel.
fn on_wheels(scene: &mut Scene<'_>, slots: &[Joint]) {
    for (idx, pin) in scene.pins.iter().enumerate() {
        let in_slot = slots.iter().any(|joint| distance(joint.at, pin.at) < scene.pieces.tolerance);
        let holders = members(scene.bodies, idx).len() + usize::from(scene.is_fixed[idx]);
        if holders > 1 || scene.is_fixed[idx] || in_slot && holders > 0 {
            continue;
        }
        let holds = |body: &Body| {
            body.wheel.as_ref().is_some_and(|(centre, radii)| {
                distance(*centre, pin.at) < radii.iter().copied().fold(0.0, f64::max)
            }) && !body.pins.contains(&idx)
        };
        let wheels: Vec<usize> =
            (0..scene.bodies.all.len()).filter(|&k| holds(&scene.bodies.all[k])).collect();
        if let [wheel] = wheels[..]
            && holders == 1
        {
            scene.bodies.all[wheel].pins.insert(idx);
        }
    }
}

fn pinned(scene: &Scene<'_>) -> Vec<Joint> {
    let mut found = Vec::new();
    for (idx, pin) in scene.pins.iter().enumerate() {
        // What carries wheels first: their angles are measured against it.
        let mut held = members(scene.bodies, idx);
        held.sort_by_key(|&body| scene.bodies.all[body].look == Look::Wheel);
        let mut on: Vec<On> = held.into_iter().map(On::Body).collect();
        if scene.is_fixed[idx] {
            on.insert(0, On::Ground);
        }
        if on.len() > 1 {
            found.push(Joint::new(Kind::Pin, pin.at, on, pin.from.clone()));
        }
    }
    found
}

fn gears(scene: &Scene<'_>) -> Vec<Joint> {
    let mut found = Vec::new();
    let near = 1.5 * scene.pieces.tolerance;
    let moving = scene
        .bodies
        .all
        .iter()
        .enumerate()
        .filter_map(|(idx, body)| body.wheel.as_ref().map(|wheel| (idx, wheel)))
        .flat_map(|(idx, (centre, radii))| {
            radii.iter().map(move |radius| (On::Body(idx), *centre, *radius))
        });
    let still = scene.bodies.rings.iter().map(|(centre, radius, _)| (On::Ground, *centre, *radius));
    let wheels: Vec<(On, Point, f64)> = still.chain(moving).collect();
    for (n, &(first, a, ra)) in wheels.iter().enumerate() {
        for &(second, b, rb) in &wheels[n + 1..] {
            let d = distance(a, b);
            let u = unit(sub(b, a));
            let is_outer = (d - ra - rb).abs() < near;
            let is_inner = d > near && (d - (ra - rb).abs()).abs() < near;
            if first == second || !is_outer && !is_inner {
                continue;
            }
            let at = if is_outer || ra > rb { along(a, ra, u) } else { along(a, -ra, u) };
            let ratio = if is_outer { -ra / rb } else { ra / rb };
            let kind = Kind::Gear { ratio, radii: [ra, rb], is_internal: !is_outer };
            let from = [first, second].into_iter().flat_map(|on| strokes(scene, on)).collect();
            found.push(Joint::new(kind, at, vec![first, second], from));
        }
        for axis in &scene.pieces.axes {
            let d = unit(sub(axis[1], axis[0]));
            if (to_segment(a, *axis) - ra).abs() > near || distance(axis[0], axis[1]) < 0.8 * ra {
                continue;
            }
            let foot = along(axis[0], dot(sub(a, axis[0]), d), d);
            // The rack has an edge along its pitch line.
            let rack = (0..scene.bodies.all.len()).find(|&k| {
                On::Body(k) != first
                    && scene.bodies.all[k].segments.iter().any(|[p, q]| {
                        skew(d, unit(sub(*q, *p))) < 0.03
                            && to_segment(foot, [*p, *q]) < 5.0 * scene.pieces.pin
                            && distance(*p, *q) > 0.8 * ra
                    })
            });
            if let (Some(rack), On::Body(_)) = (rack, first) {
                let kind = Kind::Rack { radius: ra, axis: oriented(d) };
                let from = strokes(scene, first);
                found.push(Joint::new(kind, foot, vec![first, On::Body(rack)], from));
            }
        }
    }
    found
}

/// Strokes of a body, or of the toothed rings of the ground.
fn strokes(scene: &Scene<'_>, on: On) -> Vec<usize> {
    match on {
        On::Body(idx) => scene.bodies.all[idx].from.clone(),
        On::Ground => scene.bodies.rings.iter().map(|(.., from)| *from).collect(),
    }
}

/// True if an edge of a body is a centre line: the pitch line of a rack.
fn has_pitch_line(pieces: &Pieces, body: &Body) -> bool {
    let near = 5.0 * pieces.pin;
    let is_along = |axis: &[Point; 2], [a, b]: [Point; 2]| {
        skew(unit(sub(axis[1], axis[0])), unit(sub(b, a))) < 0.03
            && [a, b].iter().all(|p| to_segment(*p, *axis) < near)
    };
    pieces.axes.iter().any(|axis| body.segments.iter().any(|segment| is_along(axis, *segment)))
}
