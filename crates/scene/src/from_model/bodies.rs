//! Bodies: their outlines, or else links, discs and sliders.

use super::Sketch;
use super::rail::{SLOT, Slider};
use crate::geometry::{
    Plane, Point, across3, along3, circle, cross3, distance3, dot3, is_inside, length3,
    rounded_hull, sub3, unit3,
};
use crate::{Form, Role, Shape, Solid};

/// Half width of a link, radii of a pin.
const LINK: f64 = 1.8;
/// Half width of a link with a slot in it.
const SLOTTED: f64 = 2.6;
/// Half width of a thin rod.
const ROD: f64 = 0.8;
/// Half thickness of a plate in space.
const THICKNESS: f64 = 0.5;
/// Radius of a disc.
const DISC: f64 = 3.2;

impl Sketch<'_> {
    /// The shapes of a body that moves.
    pub(super) fn body(&self, body: usize) -> Vec<Shape> {
        let solids = self.solids(body);
        if !solids.is_empty() {
            return solids;
        }
        let outline = self.numbers.outline(body);
        if !outline.is_empty() {
            return self.outlined(body, &outline);
        }
        // What touches is drawn as it is stated.
        let has_outline = self
            .model()
            .contacts
            .iter()
            .flat_map(|pair| &pair.shapes)
            .any(|shape| shape.anchors()[0].body.0 == body && self.is_whole(shape));
        let mut shapes = if has_outline { Vec::new() } else { self.link(body) };
        shapes.extend(self.sliders(body));
        shapes
    }

    /// An outline with the slots in it; a slot that is partly outside is a line on top.
    fn outlined(&self, body: usize, outline: &[Vec<Point>]) -> Vec<Shape> {
        let mut rings = outline.to_vec();
        let mut lines = Vec::new();
        for (plane, ring) in self.slots(body) {
            let ring: Vec<Point> = ring.iter().map(|&p| Plane::XY.foot(plane.lift(p))).collect();
            if ring.iter().all(|&p| is_inside(p, outline)) {
                rings.push(ring);
            } else {
                let form = Form::Line { points: Plane::XY.lifted(&ring), is_closed: true };
                lines.push(Shape { body, role: Role::Guide, form });
            }
        }
        let plate = if self.is_planar() || rings.len() > outline.len() {
            vec![Shape::region(body, self.role_of(body), &Plane::XY, &rings)]
        } else {
            rings.iter().map(|ring| self.extruded(body, &Plane::XY, ring)).collect()
        };
        [plate, lines].concat()
    }

    /// A link through the points of a body: a plate, a rod or a star, a disc for a single point.
    fn link(&self, body: usize) -> Vec<Shape> {
        let com = self.com(body);
        let mut points = self.attached[body].clone();
        points.extend(self.named_points(body));
        for rail in self.rails_of(body) {
            points.extend(rail.covered().map(|position| rail.at(position)));
        }
        let Some(&first) = points.first().or(com.as_ref()) else { return Vec::new() };
        points.extend(com);
        if points.iter().all(|&p| distance3(p, first) < 0.5 * self.pin) {
            let is_drawn = self.is_slider(body) || self.is_wheel(body);
            return if is_drawn { Vec::new() } else { vec![self.disc(body, first)] };
        }
        let is_slotted = self.rails_of(body).any(|rail| rail.slider.is_none());
        let ends = self.ends_in_line(&points).filter(|_| !self.is_planar() && !is_slotted);
        let mut shapes = match (ends, self.plane_through(body, &points)) {
            (Some(ends), _) => vec![self.rod(body, ends)],
            (None, Some(plane)) => vec![self.plate(body, &plane, &points)],
            (None, None) => self.star(body, &points),
        };
        if let Some(com) = com.filter(|_| self.is_bob(body)) {
            shapes.push(self.disc(body, com));
        }
        shapes
    }

    /// A rounded plate around points in a plane, with slots.
    fn plate(&self, body: usize, plane: &Plane, points: &[[f64; 3]]) -> Shape {
        let slots = self.slots(body);
        let is_rod = self.rails_of(body).next().is_some() || !self.is_planar();
        let half = match (slots.is_empty(), is_rod) {
            _ if self.is_bob(body) => ROD,
            (false, _) => SLOTTED,
            (true, true) => 0.6 * LINK,
            (true, false) => LINK,
        };
        let points: Vec<Point> = points.iter().map(|&p| plane.foot(p)).collect();
        let mut rings = vec![rounded_hull(&points, half * self.pin)];
        if !self.is_planar() && slots.is_empty() {
            return self.extruded(body, plane, &rings[0]);
        }
        for (slot_plane, ring) in slots {
            rings.push(ring.iter().map(|&p| plane.foot(slot_plane.lift(p))).collect());
        }
        Shape::region(body, self.role_of(body), plane, &rings)
    }

    /// A plate over a ring in a plane, as thick to either side of it.
    fn extruded(&self, body: usize, plane: &Plane, ring: &[Point]) -> Shape {
        let half = THICKNESS * self.pin;
        let normal = cross3(plane.u, plane.v);
        let place = |[x, y, z]: [f64; 3]| along3(plane.lift([x, y]), z, normal);
        let form = Form::Solid(Solid::prism(ring, [-half, half], place));
        Shape { body, role: self.role_of(body), form }
    }

    /// Rods from the centroid to points that lie in no plane.
    fn star(&self, body: usize, points: &[[f64; 3]]) -> Vec<Shape> {
        let n = points.len() as f64;
        let middle: [f64; 3] =
            std::array::from_fn(|i| points.iter().map(|p| p[i]).sum::<f64>() / n);
        points.iter().map(|&p| self.rod(body, [middle, p])).collect()
    }

    fn rod(&self, body: usize, ends: [[f64; 3]; 2]) -> Shape {
        let form = Form::Rod { ends, radius: ROD * self.pin };
        Shape { body, role: self.role_of(body), form }
    }

    /// The outermost two of the points, if all lie on a line.
    fn ends_in_line(&self, points: &[[f64; 3]]) -> Option<[[f64; 3]; 2]> {
        let farthest = |from: [f64; 3]| {
            let far = |p: &[f64; 3]| distance3(*p, from);
            points.iter().copied().max_by(|a, b| far(a).total_cmp(&far(b)))
        };
        let first = farthest(*points.first()?)?;
        let last = farthest(first)?;
        let along = unit3(sub3(last, first))?;
        let off_line = |p: &[f64; 3]| length3(cross3(along, sub3(*p, first)));
        points.iter().all(|p| off_line(p) < 0.1 * self.pin).then_some([first, last])
    }

    /// A disc, in space a ball.
    fn disc(&self, body: usize, centre: [f64; 3]) -> Shape {
        let (role, radius) = (self.role_of(body), DISC * self.pin);
        if !self.is_planar() {
            return Shape { body, role, form: Form::Rod { ends: [centre; 2], radius } };
        }
        let plane = Plane { origin: centre, ..Plane::XY };
        Shape::region(body, role, &plane, &[circle([0.0; 2], radius)])
    }

    /// The sliders of a body: rectangles, in space boxes.
    fn sliders(&self, body: usize) -> Vec<Shape> {
        let mut shapes = Vec::new();
        for rail in self.rails.iter().flatten() {
            let Some(Slider { plane, .. }) = rail.slider.filter(|slider| slider.body == body)
            else {
                continue;
            };
            let [[a, b], [c, d]] = rail.extent;
            let role = self.role_of(body);
            if self.is_planar() {
                let ring = vec![[a, c], [b, c], [b, d], [a, d]];
                shapes.push(Shape::region(body, role, &plane, &[ring]));
                continue;
            }
            let form = Form::Solid(Solid::block(&plane, [[a, b], [c, d], [c, d]]));
            shapes.push(Shape { body, role, form });
        }
        shapes
    }

    /// The slots of a body: closed rings in their planes.
    pub(super) fn slots(&self, body: usize) -> Vec<(Plane, Vec<Point>)> {
        let slots = self.rails_of(body).filter(|rail| rail.slider.is_none());
        let ring = |rail: &super::Rail| {
            let [from, to] = rail.travel;
            let ends = [[from - 0.5 * self.pin, 0.0], [to + 0.5 * self.pin, 0.0]];
            (rail.plane, rounded_hull(&ends, SLOT * self.pin))
        };
        slots.map(ring).collect()
    }

    /// The plane that points of a body lie in, if there is one.
    pub(super) fn plane_through(&self, body: usize, points: &[[f64; 3]]) -> Option<Plane> {
        if self.is_planar() {
            return Some(Plane::XY);
        }
        let origin = *points.first()?;
        let farthest = |distance: &dyn Fn([f64; 3]) -> f64| {
            points.iter().copied().max_by(|&a, &b| distance(a).total_cmp(&distance(b)))
        };
        let far = farthest(&|p| distance3(p, origin))?;
        let u = unit3(sub3(far, origin)).unwrap_or([1.0, 0.0, 0.0]);
        // Points on a line leave a choice: take the plane that a joint turns them in.
        let off_line = |p: [f64; 3]| length3(cross3(u, sub3(p, origin)));
        let third = farthest(&off_line).filter(|&p| off_line(p) > 0.1 * self.pin);
        let normal = third.map_or(self.axis_of(body), |p| cross3(u, sub3(p, origin)));
        let plane = Plane { origin, u, v: across3(u, normal) };
        let normal = cross3(plane.u, plane.v);
        let is_flat = |p: &[f64; 3]| dot3(sub3(*p, origin), normal).abs() < self.pin;
        points.iter().all(is_flat).then_some(plane)
    }

    /// Axis of the first joint of a body.
    fn axis_of(&self, body: usize) -> [f64; 3] {
        let mut joints = self.model().joints.iter();
        let own = joints.find(|j| j.successor.body.0 == body || j.predecessor.body.0 == body);
        own.map_or([0.0, 0.0, 1.0], |joint| self.numbers.vector(&joint.axis))
    }

    /// The centre of mass of a body that has mass.
    pub(super) fn com(&self, body: usize) -> Option<[f64; 3]> {
        let of = &self.model().bodies[body];
        (self.numbers.value(of.mass) > 0.0).then(|| self.numbers.vector(&of.com))
    }

    /// True if a body is drawn as a point mass on a rod.
    pub(super) fn is_bob(&self, body: usize) -> bool {
        let of = &self.model().bodies[body];
        let mut moments = of.inertia.moments.iter();
        of.inertia.about.is_none()
            && of.outline.is_empty()
            && !self.is_slider(body)
            && moments.all(|&moment| self.numbers.value(moment) == 0.0)
    }

    /// Positions of the named points of a body, in its frame.
    fn named_points(&self, body: usize) -> impl Iterator<Item = [f64; 3]> {
        let points = self.model().bodies[body].points.iter();
        points.map(|point| self.numbers.vector(&point.position))
    }
}
