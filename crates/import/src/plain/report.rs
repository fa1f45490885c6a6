//! Report of what was found, as the caller has it.

use bksim_cad::drawing::Location;
use bksim_cad::geometry::Point;

use super::bodies::Body;
use super::joint::{Joint, Kind, On};
use super::naming::Named;
use super::pieces::{is_inside, to_segment};
use super::questions::{Asked, handle_of};
use super::{Element, Found, FoundBody, FoundJoint};

pub(super) fn found_bodies(found: &Found, named: &Named) -> Vec<FoundBody> {
    let all = found.bodies.all.iter().zip(&named.labels);
    all.map(|(body, label)| FoundBody {
        name: body.name.clone(),
        label: label.clone(),
        drawn_as: body.look.name(),
        handles: handles(found, &body.from),
    })
    .collect()
}

pub(super) fn handles(found: &Found, from: &[usize]) -> Vec<u64> {
    let mut all: Vec<u64> = from.iter().filter_map(|&idx| handle_of(found, &[idx])).collect();
    all.sort_unstable();
    all.dedup();
    all
}

pub(super) fn body_name(found: &Found, on: On) -> String {
    match on {
        On::Ground => "ground".to_owned(),
        On::Body(idx) => found.bodies.all[idx].name.clone(),
    }
}

pub(super) fn found_joint(found: &Found, joint: &Joint, is_asked: bool) -> FoundJoint {
    let (axis, ratio, radius) = match &joint.kind {
        Kind::Pin | Kind::Cam { .. } => (None, None, None),
        Kind::Slide { axis } | Kind::Slot { axis } => (Some(*axis), None, None),
        Kind::Gear { ratio, .. } => (None, Some(*ratio), None),
        Kind::Rack { radius, axis } => (Some(*axis), None, Some(*radius)),
    };
    FoundJoint {
        name: joint.name.clone(),
        kind: joint.kind.name(),
        at: joint.at,
        bodies: joint.on.iter().map(|on| body_name(found, *on)).collect(),
        axis,
        ratio,
        radius,
        is_asked,
        handles: handles(found, &joint.from),
    }
}

/// Springs between what their ends are on, and masses in texts.
pub(super) fn elements(found: &Found, named: &Named, asked: &Asked) -> Vec<Element> {
    let mut all = Vec::new();
    for (spring, name) in found.springs.iter().zip(&named.springs) {
        all.push(Element {
            name: name.clone(),
            kind: "spring",
            ends: spring.ends.to_vec(),
            bodies: spring.ends.iter().map(|end| body_name(found, holder(found, *end))).collect(),
            mass: None,
        });
    }
    for (pin, body, mass) in &asked.masses {
        all.push(Element {
            name: format!("mass_on_{}", found.bodies.all[*body].name),
            kind: "mass",
            ends: vec![found.pins[*pin].at],
            bodies: vec![found.bodies.all[*body].name.clone()],
            mass: Some(*mass),
        });
    }
    all
}

/// The body at a point: the ground where that is, a pin's, else the nearest outline or line.
fn holder(found: &Found, p: Point) -> On {
    let near = 1.5 * found.pieces.tolerance;
    if found.bases.iter().any(|base| to_segment(p, base.ends) < near) {
        return On::Ground;
    }
    let away = |body: &Body| {
        let inside = !body.border.is_empty() && is_inside(&body.border, p);
        if inside { 0.0 } else { body.away(p) }
    };
    let all = (0..found.bodies.all.len()).map(|idx| (away(&found.bodies.all[idx]), idx));
    match all.min_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((away, idx)) if away < 3.0 * found.pieces.pin => On::Body(idx),
        _ => On::Ground,
    }
}

/// Entities that are drawn and no part of the mechanism.
pub(super) fn left_out(found: &Found) -> Vec<(String, Vec<Location>)> {
    let mut all: Vec<(String, Vec<Location>)> = Vec::new();
    let of = |from: &[usize]| {
        let mut known: Vec<Location> = Vec::new();
        for &idx in from {
            let location = &found.sheet.strokes[idx].location;
            if !known.contains(location) {
                known.push(location.clone());
            }
        }
        known
    };
    let mut put = |what: &str, places: Vec<Location>| {
        if !places.is_empty() {
            all.push((what.to_owned(), places));
        }
    };
    put("frame and title block", of(&found.notes.frame));
    put("dimensions drawn as lines", of(&found.notes.dimensions));
    put("lines in dashes or a centre line type", of(&found.pieces.dashed));
    let known: std::collections::BTreeSet<usize> = found
        .bodies
        .all
        .iter()
        .flat_map(|body| &body.from)
        .chain(found.joints.iter().flat_map(|joint| &joint.from))
        .copied()
        .collect();
    let circles = found.pieces.circles.iter().map(|circle| circle.from);
    let loose: Vec<usize> = circles.filter(|from| !known.contains(from)).collect();
    let loose: Vec<usize> = loose
        .into_iter()
        .filter(|from| !found.pins.iter().any(|pin| pin.from.contains(from)))
        .collect();
    put("circles that are no pin and no wheel: paths and marks", of(&loose));
    let rings =
        found.pieces.rings.iter().filter(|ring| ring.from.iter().all(|from| !known.contains(from)));
    let rings: Vec<usize> = rings
        .flat_map(|ring| ring.from.clone())
        .filter(|from| !found.notes.frame.contains(from))
        .collect();
    put("outlines that are joined to nothing", of(&rings));
    let unread = found.sheet.unread.clone();
    put("entities of kinds that are not read", unread);
    all
}
