//! Cams: a disc about a pin of the ground that is not in its middle, or a curved outline, against which a face or a roller of
//! another body rests.

use bksim_cad::geometry::Point;
use bksim_cad::geometry::vector::{along, distance, dot, sub};
use bksim_cad::read::Dash;

use super::bodies::{Body, Look};
use super::joint::{Joint, Kind, On, Scene};
use super::model::Writing;
use super::pieces::{area, to_border, to_segment, turned, unit};
use crate::draft::{self, Draft, Table, list, number};

/// Fewest points of an outline that is curved.
const FEWEST_POINTS: usize = 24;

/// Bodies that are eccentric discs: circles with one pin, that of the ground, away from their centres.
pub(super) fn add_discs(scene: &mut Scene<'_>) {
    let pieces = scene.pieces;
    let near = 1.5 * pieces.tolerance;
    for circle in pieces.circles.iter().filter(|circle| circle.dash == Dash::Solid) {
        let inside: Vec<usize> = (0..scene.pins.len())
            .filter(|&idx| distance(scene.pins[idx].at, circle.centre) < circle.radius - near)
            .collect();
        let [pin] = inside[..] else { continue };
        let off = distance(scene.pins[pin].at, circle.centre);
        let is_known = scene.bodies.all.iter().any(|body| body.from.contains(&circle.from));
        let is_large = circle.radius > 3.2 * pieces.pin;
        let is_lone = !scene.bodies.all.iter().any(|body| body.pins.contains(&pin));
        if !is_known && is_large && is_lone && scene.is_fixed[pin] && off > near {
            let mut body = Body::new(Look::Wheel, vec![circle.from]);
            body.wheel = Some((circle.centre, vec![circle.radius]));
            body.pins.insert(pin);
            scene.bodies.all.push(body);
        }
    }
}

/// Outline of a cam as points, counter-clockwise.
pub(super) fn outline(body: &Body) -> Vec<Point> {
    match &body.wheel {
        Some((centre, radii)) => (0..180)
            .map(|k| {
                let angle = f64::from(k) * std::f64::consts::TAU / 180.0;
                along(*centre, radii[0], bksim_cad::geometry::vector::direction(angle))
            })
            .collect(),
        None => body.border.clone(),
    }
}

/// Contacts of cams with what follows them.
pub(super) fn cams(scene: &Scene<'_>, joints: &[Joint]) -> Vec<Joint> {
    let mut found = Vec::new();
    for (cam, body) in scene.bodies.all.iter().enumerate() {
        let turns = |joint: &Joint| {
            joint.kind == Kind::Pin
                && joint.on.len() == 2
                && joint.on == [On::Ground, On::Body(cam)]
        };
        let Some(axis) = joints.iter().find(|joint| turns(joint)) else { continue };
        let is_alone = body.pins.len() == 1;
        let is_curved = match &body.wheel {
            Some((centre, _)) => distance(*centre, axis.at) > 1.5 * scene.pieces.tolerance,
            None => body.border.len() >= FEWEST_POINTS && body.look == Look::Plate,
        };
        let meshes = joints.iter().any(|joint| {
            matches!(joint.kind, Kind::Gear { .. } | Kind::Rack { .. })
                && joint.on.contains(&On::Body(cam))
        });
        if !is_alone || !is_curved || meshes {
            continue;
        }
        let points = outline(body);
        let others = (0..scene.bodies.all.len()).filter(|&other| other != cam);
        for follower in others {
            // Only what is guided or swings on the ground follows.
            let is_held = joints.iter().any(|joint| {
                joint.on.contains(&On::Ground) && joint.on.contains(&On::Body(follower))
            });
            if is_held && let Some(joint) = contact(scene, (cam, &points), follower) {
                found.push(joint);
                break;
            }
        }
    }
    found
}

/// The contact of an outline with a roller or a face of a body.
fn contact(scene: &Scene<'_>, (cam, points): (usize, &[Point]), follower: usize) -> Option<Joint> {
    let near = 1.5 * scene.pieces.tolerance;
    let body = &scene.bodies.all[follower];
    let mut from = scene.bodies.all[cam].from.clone();
    let on = vec![On::Body(cam), On::Body(follower)];
    for pin in &body.pins {
        let pin = &scene.pins[*pin];
        let away = to_border(points, pin.at);
        let roller = pin.radii.iter().find(|radius| (away - **radius).abs() < near);
        if let Some(radius) = roller {
            let nearest = points
                .iter()
                .min_by(|a, b| distance(**a, pin.at).total_cmp(&distance(**b, pin.at)))?;
            let normal = unit(sub(pin.at, *nearest));
            from.extend(pin.from.clone());
            let kind = Kind::Cam { normal, roller: Some(*radius) };
            return Some(Joint::new(kind, along(pin.at, -radius, normal), on, from));
        }
    }
    for [a, b] in &body.segments {
        let direction = unit(sub(*b, *a));
        let normal = turned(direction);
        let heights = points.iter().map(|p| dot(sub(*p, *a), normal));
        let (low, high) =
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        // The outline is on one side of the face and touches it.
        let touches = if high.abs() < near {
            1.0
        } else if low.abs() < near {
            -1.0
        } else {
            continue;
        };
        let foot = points.iter().max_by(|p, q| {
            let of = |p: &Point| touches * dot(sub(*p, *a), normal);
            of(p).total_cmp(&of(q))
        })?;
        if to_segment(*foot, [*a, *b]) < near {
            let at = along(*foot, -dot(sub(*foot, *a), normal), normal);
            return Some(Joint::new(Kind::Cam { normal, roller: None }, at, on, from));
        }
    }
    None
}

impl Writing<'_> {
    /// The outline as a curve, and what touches it.
    pub(super) fn cam(
        &self,
        draft: &mut Draft,
        joint: &Joint,
        (normal, roller): (Point, Option<f64>),
        origins: &[Point],
    ) {
        let On::Body(idx) = joint.on[0] else { return };
        let (body, origin) = (&self.found.bodies.all[idx], origins[idx]);
        let curve = format!("{}_outline", body.name);
        let table = if let Some((centre, radii)) = &body.wheel {
            let [x, y, _] = self.point(origin, *centre);
            let radius = number(self.metres(radii[0]));
            let formula = |at: f64, name: &str| {
                draft::quoted(&format!("{} m + {radius} m*{name}(p)", number(at)))
            };
            let formula = format!("[{}, {}]", formula(x, "cos"), formula(y, "sin"));
            Table::plain(curve.clone()).text("type", "formula").key("formula", formula)
        } else {
            // Begins and ends where the follower is not.
            let mut points = outline(body);
            if area(&points) < 0.0 {
                points.reverse();
            }
            let away = |k: &usize| distance(points[*k], joint.at);
            let far = (0..points.len()).max_by(|a, b| away(a).total_cmp(&away(b)));
            points.rotate_left(far.unwrap_or_default());
            points.extend(points.first().copied());
            let corners: Vec<String> =
                points.iter().map(|p| list(&self.point(origin, *p)[..2])).collect();
            let points = format!("[{}]", corners.join(", "));
            Table::plain(curve.clone()).text("type", "points").key("points", points)
        };
        draft.curves.push(table);
        let cam = body.name.clone();
        let place = self.place(draft, joint.on[1], &joint.name, joint.centre(), origins);
        let kind = if roller.is_some() { "point-on-curve" } else { "line-on-curve" };
        let mut table =
            Table::new(joint.name.clone(), kind).between(&cam, &place).text("curve", &curve);
        match roller {
            Some(radius) => {
                table = table.number("radius", self.metres(radius)).text("side", "right");
            }
            None => table = table.key("axis", list(&[-normal[1], normal[0]])),
        }
        draft.joints.push(table);
    }
}
