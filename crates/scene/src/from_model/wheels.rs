//! Gears, the wheels of belts, racks, and belts: circles with teeth, and the line around two circles.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use bksim_mbs::belt::ends;
use bksim_model::{CouplingKind, Rack, Wheels};
use bksim_sim::pose::Pose;

use super::Sketch;
use crate::geometry::{Plane, Point, across3, along3, arc, cross3, direction, dot3, sub3};
use crate::{Form, Role, Shape, Solid};

/// Height of a tooth above the pitch circle, and its depth below it, in modules: DIN 867.
const ADDENDUM: f64 = 1.0;
const DEDENDUM: f64 = 1.25;
/// Half width of a tooth at its tip, on the pitch circle and at its foot, in pitches.
const TIP: f64 = 0.1;
const FOOT: f64 = 0.36;
/// Width of the rim of a ring, in modules.
const RIM: f64 = 4.0;
/// Teeth are drawn between these numbers; others are only counted.
const MOST_TEETH: f64 = 400.0;
const FEWEST_TEETH: f64 = 4.0;
/// Teeth of the smaller wheel where only the radii are known.
const USUAL_TEETH: f64 = 20.0;
/// Half thickness of a wheel in space, radii of a pin.
const THICKNESS: f64 = 1.2;
/// Teeth of a rack to either side of the pitch point where its travel is not known.
const RACK: f64 = 8.0;

/// A wheel as it is drawn: its circle in its own frame.
#[derive(Clone, Copy)]
struct Drawn {
    body: usize,
    /// Through the centre; angles count from u.
    plane: Plane,
    radius: f64,
    n_teeth: f64,
    /// Angle of the middle of a tooth.
    tooth: f64,
    /// Teeth point inwards.
    is_ring: bool,
}

impl Sketch<'_> {
    /// The shapes of wheels, racks and belts, those in the back first.
    pub(super) fn wheels(&self) -> Vec<Shape> {
        let mut drawn: HashMap<usize, Drawn> = HashMap::new();
        let mut shapes = Vec::new();
        for coupling in self.model().all_couplings() {
            match &coupling.kind {
                CouplingKind::Gear(wheels) => {
                    for gear in self.gears(wheels, &drawn) {
                        if let std::collections::hash_map::Entry::Vacant(free) =
                            drawn.entry(gear.body)
                        {
                            free.insert(gear);
                            shapes.extend(self.gear(&gear));
                        }
                    }
                }
                CouplingKind::Rack(rack) => shapes.extend(self.rack(rack, &mut drawn)),
                CouplingKind::Belt(wheels) => shapes.extend(self.belt(wheels)),
                CouplingKind::Relation
                | CouplingKind::Rate
                | CouplingKind::Screw
                | CouplingKind::Strand(..)
                | CouplingKind::Rope(..) => {}
            }
        }
        shapes
    }

    /// Pitch radii of two wheels, and the direction from the first centre to the second in the frame of the
    /// carrier; `None` where the centres coincide or are not known.
    fn radii(&self, wheels: &Wheels) -> Option<([f64; 2], f64)> {
        let ratio = self.numbers.value(wheels.ratio);
        let [from, to] = wheels.wheels.map(|wheel| self.numbers.attached(wheel));
        let pose = self.numbers.first_pose(wheels.carrier.0)?;
        let line = self.numbers.vectors(from, to).next()?;
        let plane = self.plane_of(wheels, wheels.carrier.0);
        let in_plane = [dot3(line, pose.turn(plane.u)), dot3(line, pose.turn(plane.v))];
        let distance = in_plane[0].hypot(in_plane[1]);
        let stated = wheels.radii.map(|[first, second]| {
            let first = wheels.worm.map_or(first, |worm| worm.radius);
            [first, second].map(|radius| self.numbers.value(radius).abs())
        });
        let radii = stated.unwrap_or_else(|| {
            let second = distance / (1.0 - ratio).abs();
            [second * ratio.abs(), second]
        });
        let is_drawn = radii.iter().all(|radius| radius.is_finite() && *radius > 0.0);
        (is_drawn && distance > 0.0).then(|| (radii, in_plane[1].atan2(in_plane[0])))
    }

    /// The plane across the axis of the first wheel, in the frame of a body: angles of all wheels count from
    /// directions that are parallel before any motion.
    fn plane_of(&self, wheels: &Wheels, body: usize) -> Plane {
        if self.is_planar() {
            return Plane::XY;
        }
        let joint = &self.model().joints[wheels.axes[0].0];
        let ends = [joint.predecessor.body.0, joint.successor.body.0];
        let axis = self.numbers.axis(joint, if ends.contains(&body) { body } else { ends[0] });
        let u = across3(axis, [0.6, 0.48, 0.64]);
        Plane { origin: [0.0; 3], u, v: cross3(axis, u) }
    }

    /// The two gears of a pair, their teeth in each other's gaps where neither of them, or one, was drawn before.
    fn gears(&self, wheels: &Wheels, before: &HashMap<usize, Drawn>) -> Vec<Drawn> {
        let Some((radii, line)) = self.radii(wheels) else { return Vec::new() };
        let ratio = self.numbers.value(wheels.ratio);
        let teeth = wheels.teeth.map_or_else(
            || radii.map(|radius| (USUAL_TEETH * radius / radii[0].min(radii[1])).round()),
            |teeth| teeth.map(|teeth| self.numbers.value(teeth)),
        );
        // The pitch point as both centres see it: outside between them, inside beyond that of the pinion.
        let is_internal = ratio > 0.0;
        let is_ring = [0, 1].map(|i: usize| is_internal && radii[i] > radii[1 - i]);
        let towards = match (is_internal, is_ring[1]) {
            (false, _) => [line, line + PI],
            (true, true) => [line + PI; 2],
            (true, false) => [line; 2],
        };
        let bodies = wheels.wheels.map(|wheel| wheel.body.0);
        let known = bodies.map(|body| before.get(&body).map(|gear| gear.tooth));
        // A tooth of one is at the pitch point when a gap of the other is.
        let gap = |of: usize| TAU * 0.5 / teeth[of];
        let phase = self.numbers.value(wheels.phase);
        let tooth = match known {
            [None, Some(second)] => {
                let turned = (towards[1] - (second + gap(1)) - phase) / ratio;
                [towards[0] - turned, second]
            }
            [first, second] => {
                let first = first.unwrap_or(towards[0]);
                let other = towards[1] - ratio * (towards[0] - first) - phase + gap(1);
                [first, second.unwrap_or(other)]
            }
        };
        let gear = |i: usize| {
            let at = self.numbers.attached(wheels.wheels[i]);
            let plane = Plane { origin: at.position, ..self.plane_of(wheels, at.body) };
            let is_ring = is_ring[i];
            let (radius, n_teeth, tooth) = (radii[i], teeth[i], tooth[i]);
            Drawn { body: at.body, plane, radius, n_teeth, tooth, is_ring }
        };
        [0, 1].map(gear).to_vec()
    }

    /// A gear with its teeth, a ring with teeth inside; nothing where the author drew the body.
    fn gear(&self, gear: &Drawn) -> Option<Shape> {
        if self.has_own_shape(gear.body) {
            return None;
        }
        let module = 2.0 * gear.radius / gear.n_teeth;
        let countable = (FEWEST_TEETH..=MOST_TEETH).contains(&gear.n_teeth);
        let toothed = if countable { teeth(gear) } else { fine_circle(gear.radius) };
        let rim = if countable { RIM * module } else { 0.1 * gear.radius };
        let role = self.role_of(gear.body);
        if self.is_planar() {
            let mut rings = vec![toothed];
            if gear.is_ring {
                rings.push(fine_circle(gear.radius + rim));
            }
            return Some(Shape::region(gear.body, role, &gear.plane, &rings));
        }
        let normal = cross3(gear.plane.u, gear.plane.v);
        let half = THICKNESS * self.pin;
        let place = |[x, y, z]: [f64; 3]| along3(gear.plane.lift([x, y]), z, normal);
        let form = Form::Solid(Solid::prism(&toothed, [-half, half], place));
        Some(Shape { body: gear.body, role, form })
    }

    /// True where the author drew a body.
    pub(super) fn has_own_shape(&self, body: usize) -> bool {
        !self.model().bodies[body].solids.is_empty() || !self.numbers.outline(body).is_empty()
    }

    /// A toothed bar on the rack, and the pinion if it was not drawn before; neither where the author drew the body.
    fn rack(&self, rack: &Rack, drawn: &mut HashMap<usize, Drawn>) -> Vec<Shape> {
        let joints = rack.joints.map(|joint| &self.model().joints[joint.0]);
        let reach = self.numbers.value(rack.radius);
        let radius = reach.abs();
        let [pinion, bar] = rack.bodies.map(|body| body.0);
        let ends = joints.map(|joint| [joint.predecessor, joint.successor]);
        let center = ends[0].into_iter().find(|end| end.body.0 == pinion);
        let (Some(center), true) = (center, radius > 0.0) else { return Vec::new() };
        let center = self.numbers.attached(center);
        let n_teeth = rack.teeth.map_or(USUAL_TEETH, |teeth| self.numbers.value(teeth));
        let module = 2.0 * radius / n_teeth;

        // The frame of the bar, along its travel; the pitch point at the start lies across from the centre.
        let along = self.numbers.axis(joints[1], bar);
        let (Some(pose), Some(other)) =
            (self.numbers.first_pose(bar), self.numbers.first_pose(pinion))
        else {
            return Vec::new();
        };
        let axis = other.turn(self.numbers.axis(joints[0], pinion));
        let travel = pose.turn(along);
        let arm = cross3(travel, axis);
        let place = other.place(center.position);
        let pitch_point = position_on(pose, along3(place, reach, arm));
        let out = turned_back(pose, arm.map(|part| part * reach.signum()));
        let plane = Plane { origin: pitch_point, u: along, v: out };
        let [low, high] = self.numbers.travel(rack.joints[1].0, RACK * PI * module);
        let start = self.numbers.first_travel(rack.joints[1].0).unwrap_or(0.5 * (low + high));
        let is_second = joints[1].successor.body.0 == bar;
        let [back, ahead] =
            if is_second { [start - high, start - low] } else { [low - start, high - start] };
        let pitch = PI * module;
        let n = |x: f64| (x / pitch).clamp(-MOST_TEETH, MOST_TEETH);
        let (first, last) = (n(back).floor() - 2.0, n(ahead).ceil() + 2.0);
        let mut ring: Vec<Point> = Vec::new();
        let mut k = first;
        // A gap is at the pitch point, teeth towards the pinion.
        while k <= last {
            for (x, y) in [(-FOOT, DEDENDUM), (-TIP, -ADDENDUM), (TIP, -ADDENDUM), (FOOT, DEDENDUM)]
            {
                ring.push([(k + 0.5 + x) * pitch, y * module]);
            }
            k += 1.0;
        }
        let far = RIM * module;
        ring.extend([[(last + 1.0) * pitch, far], [first * pitch, far]]);
        let role = self.role_of(bar);
        let bar_shape = if self.has_own_shape(bar) {
            None
        } else if self.is_planar() {
            Some(Shape::region(bar, role, &plane, &[ring]))
        } else {
            let half = THICKNESS * self.pin;
            let normal = cross3(plane.u, plane.v);
            let lift = |[x, y, z]: [f64; 3]| along3(plane.lift([x, y]), z, normal);
            let form = Form::Solid(Solid::prism(&ring, [-half, half], lift));
            Some(Shape { body: bar, role, form })
        };
        let mut shapes: Vec<Shape> = bar_shape.into_iter().collect();
        if let std::collections::hash_map::Entry::Vacant(free) = drawn.entry(pinion) {
            let u = if self.is_planar() {
                [1.0, 0.0, 0.0]
            } else {
                across3(self.numbers.axis(joints[0], pinion), along)
            };
            let own_axis = if self.is_planar() {
                [0.0, 0.0, 1.0]
            } else {
                self.numbers.axis(joints[0], pinion)
            };
            let plane = Plane { origin: center.position, u, v: cross3(own_axis, u) };
            // A tooth points to the pitch point.
            let to_point = turned_back(other, arm.map(|part| part * reach.signum()));
            let tooth = dot3(to_point, plane.v).atan2(dot3(to_point, plane.u));
            let gear = Drawn { body: pinion, plane, radius, n_teeth, tooth, is_ring: false };
            free.insert(gear);
            shapes.extend(self.gear(&gear));
        }
        shapes
    }

    /// Two wheels and the belt around them, which is drawn on the carrier.
    fn belt(&self, wheels: &Wheels) -> Vec<Shape> {
        let Some((radii, line)) = self.radii(wheels) else { return Vec::new() };
        let carrier = wheels.carrier.0;
        let Some(pose) = self.numbers.first_pose(carrier) else { return Vec::new() };
        let plane = self.plane_of(wheels, carrier);
        let ends = wheels.wheels.map(|wheel| self.numbers.attached(wheel));
        let mut shapes = Vec::new();
        for (end, radius) in ends.iter().zip(radii) {
            let own = self.plane_of(wheels, end.body);
            if self.has_own_shape(end.body) {
                continue;
            }
            let plane = Plane { origin: end.position, ..own };
            let role = self.role_of(end.body);
            if self.is_planar() {
                shapes.push(Shape::region(end.body, role, &plane, &[fine_circle(radius)]));
            } else {
                let normal = cross3(plane.u, plane.v);
                let half = THICKNESS * self.pin;
                let place = |[x, y, z]: [f64; 3]| along3(plane.lift([x, y]), z, normal);
                let form = Form::Solid(Solid::prism(&fine_circle(radius), [-half, half], place));
                shapes.push(Shape { body: end.body, role, form });
            }
        }
        // The first centre in the frame of the carrier, and the way around both circles.
        let Some(first) = self.numbers.first_pose(ends[0].body) else { return shapes };
        let origin = position_on(pose, first.place(ends[0].position));
        let plane = Plane { origin, ..plane };
        let Some(vector) = self.numbers.vectors(ends[0], ends[1]).next() else { return shapes };
        let distance = dot3(sub3(vector, [0.0; 3]), vector).sqrt();
        let is_crossed = self.numbers.value(wheels.ratio) < 0.0;
        let second = if is_crossed { radii[0] + radii[1] } else { radii[0] - radii[1] };
        if distance <= second.abs() {
            return shapes;
        }
        // Radii to the tangent points make this angle with the line of centres.
        let lean = (second / distance).acos();
        let mut points = arc([0.0; 2], radii[0], line + lean, line + TAU - lean);
        let center = [distance * line.cos(), distance * line.sin()];
        let other = if is_crossed {
            arc(center, radii[1], line + PI - lean, line - PI + lean)
        } else {
            arc(center, radii[1], line - lean, line + lean)
        };
        points.extend(other);
        let form = Form::Line { points: plane.lifted(&points), is_closed: true };
        shapes.push(Shape { body: carrier, role: Role::Link, form });
        shapes
    }

    /// True where a body is a wheel, so that it needs no disc.
    pub(super) fn is_wheel(&self, body: usize) -> bool {
        let model = self.model();
        let mut belted = model.belts.iter().flat_map(|belt| &belt.wheels);
        if belted.any(|wheel| ends(model, wheel)[0].body.0 == body) {
            return true;
        }
        let mut pulleys = model.ropes.iter().flat_map(|rope| &rope.nodes);
        if pulleys.any(|node| node.center.body.0 == body && self.numbers.value(node.radius) != 0.0)
        {
            return true;
        }
        model.all_couplings().any(|coupling| match &coupling.kind {
            CouplingKind::Gear(wheels) | CouplingKind::Belt(wheels) => {
                wheels.wheels.iter().any(|wheel| wheel.body.0 == body)
            }
            CouplingKind::Rack(rack) => rack.bodies[0].0 == body,
            CouplingKind::Relation
            | CouplingKind::Rate
            | CouplingKind::Screw
            | CouplingKind::Strand(..)
            | CouplingKind::Rope(..) => false,
        })
    }
}

/// A vector of the world in the axes of a body.
pub(super) fn turned_back(pose: &Pose, v: [f64; 3]) -> [f64; 3] {
    let rows = pose.r_world_from_body;
    std::array::from_fn(|i| (0..3).map(|k| rows[k][i] * v[k]).sum())
}

/// A point of the world in the frame of a body.
pub(super) fn position_on(pose: &Pose, p: [f64; 3]) -> [f64; 3] {
    turned_back(pose, sub3(p, pose.origin))
}

/// A circle that looks round at the size of a wheel.
pub(super) fn fine_circle(radius: f64) -> Vec<Point> {
    let point = |k: u16| direction(TAU * f64::from(k) / 180.0).map(|x| radius * x);
    (0..180).map(point).collect()
}

/// The outline of the teeth of a gear.
fn teeth(gear: &Drawn) -> Vec<Point> {
    let module = 2.0 * gear.radius / gear.n_teeth;
    let pitch = TAU / gear.n_teeth;
    // Teeth of a ring point inwards.
    let side = if gear.is_ring { -module } else { module };
    let [tip, foot] = [gear.radius + ADDENDUM * side, gear.radius - DEDENDUM * side];
    let mut ring = Vec::new();
    let mut k = 0.0;
    while k < gear.n_teeth {
        let middle = gear.tooth + k * pitch;
        for (offset, radius) in [(-FOOT, foot), (-TIP, tip), (TIP, tip), (FOOT, foot)] {
            let [x, y] = direction(middle + offset * pitch);
            ring.push([radius * x, radius * y]);
        }
        k += 1.0;
    }
    ring
}
