//! Bodies: their outlines, or links, discs and sliders in their place.

use super::rail::SLOT;
use super::{Sketch, flat};
use crate::geometry::{Point, add, block, circle, distance, left, rounded_hull, scaled};
use crate::{Role, Shape};

/// Half width of a link, radii of a pin.
const LINK: f64 = 1.8;
/// Half width of a link with a slot in it.
const SLOTTED: f64 = 2.6;
/// Half width of a thin rod.
const ROD: f64 = 0.7;
/// Radius of a point mass.
const BOB: f64 = 3.2;

impl Sketch<'_> {
    /// The shapes of a body that moves.
    pub(super) fn body(&self, body: usize) -> Vec<Shape> {
        let role = self.role_of(body);
        let outline = self.numbers.outline(body);
        if !outline.is_empty() {
            let mut shapes = vec![Shape::region(body, role, &outline)];
            shapes.extend(self.slots(body).iter().map(|ring| Shape::slot(body, ring)));
            return shapes;
        }
        let mut shapes: Vec<Shape> = self.link(body).into_iter().collect();
        shapes.extend(self.blocks(body));
        shapes
    }

    /// What joins the points of a body.
    fn link(&self, body: usize) -> Option<Shape> {
        let role = self.role_of(body);
        let com = self.com(body);
        let mut points: Vec<Point> = self.attached[body].iter().copied().map(flat).collect();
        points.extend(self.named_points(body));
        for rail in self.rails_of(body) {
            points.extend(rail.covered().map(|position| rail.at(position)));
        }
        let is_one_place =
            |points: &[Point]| points.iter().all(|&p| distance(p, points[0]) < 0.5 * self.pin);
        if points.is_empty() || (is_one_place(&points) && self.is_point_mass(body)) {
            return self.bob(body, points.first().copied());
        }
        points.extend(com);
        if is_one_place(&points) {
            let has_block = self.is_block(body);
            let disc = circle(points[0], BOB * self.pin);
            return (!has_block).then(|| Shape::region(body, role, &[disc]));
        }
        let slots = self.slots(body);
        let half = match (slots.is_empty(), self.rails_of(body).next()) {
            (false, _) => SLOTTED,
            (true, Some(_)) => 0.5 * LINK,
            (true, None) => LINK,
        };
        let mut rings = vec![rounded_hull(&points, half * self.pin)];
        rings.extend(slots);
        Some(Shape::region(body, role, &rings))
    }

    /// A point mass, on a rod if it is away from what holds it.
    fn bob(&self, body: usize, held: Option<Point>) -> Option<Shape> {
        let role = self.role_of(body);
        let centre = self.com(body).or(held)?;
        let disc = circle(centre, BOB * self.pin);
        let Some(held) = held.filter(|&held| distance(held, centre) > BOB * self.pin) else {
            return Some(Shape::region(body, role, &[disc]));
        };
        Some(Shape::region(body, role, &[lollipop(held, centre, ROD * self.pin, BOB * self.pin)]))
    }

    /// The sliders of a body.
    fn blocks(&self, body: usize) -> impl Iterator<Item = Shape> {
        let role = self.role_of(body);
        self.blocks_of(body).filter_map(move |rail| {
            let [[a, b], [c, d]] = rail.room;
            let along = rail.block_along;
            let middle = add(scaled(0.5 * (a + b), along), scaled(0.5 * (c + d), left(along)));
            let centre = add(flat(rail.block?.position), middle);
            let half = [0.5 * (b - a), 0.5 * (d - c)];
            Some(Shape::region(body, role, &[block(centre, along, half)]))
        })
    }

    /// The slots of a body, closed rings.
    pub(super) fn slots(&self, body: usize) -> Vec<Vec<Point>> {
        let slots = self.rails_of(body).filter(|rail| rail.block.is_none());
        let ring = |rail: &super::Rail| {
            let ends = [rail.travel[0] - 0.5 * self.pin, rail.travel[1] + 0.5 * self.pin];
            rounded_hull(&ends.map(|position| rail.at(position)), SLOT * self.pin)
        };
        slots.map(ring).collect()
    }

    /// The centre of mass of a body that has mass.
    pub(super) fn com(&self, body: usize) -> Option<Point> {
        let of = &self.model().bodies[body];
        (self.numbers.value(of.mass) > 0.0).then(|| flat(self.numbers.vector(&of.com)))
    }

    fn is_point_mass(&self, body: usize) -> bool {
        let inertia = &self.model().bodies[body].inertia;
        let mut moments = inertia.moments.iter();
        inertia.about.is_none() && moments.all(|&moment| self.numbers.value(moment) == 0.0)
    }

    fn named_points(&self, body: usize) -> impl Iterator<Item = Point> {
        let points = self.model().bodies[body].points.iter();
        points.map(|point| flat(self.numbers.vector(&point.position)))
    }
}

impl Shape {
    /// A slot in a body that is drawn: what is behind it does not show.
    fn slot(body: usize, ring: &[Point]) -> Self {
        Self::region(body, Role::Pin, &[ring.to_vec()])
    }
}

/// A disc at the end of a rod, in one ring.
fn lollipop(held: Point, centre: Point, rod: f64, disc: f64) -> Vec<Point> {
    use crate::geometry::{arc, sub};
    let [x, y] = sub(held, centre);
    let towards = y.atan2(x);
    let half = (rod / disc).asin();
    let around = std::f64::consts::TAU - half;
    let mut ring = arc(centre, disc, towards + half, towards + around);
    let quarter = std::f64::consts::FRAC_PI_2;
    ring.extend(arc(held, rod, towards - quarter, towards + quarter));
    ring
}
