//! The ground: supports of pins, guides, walls; hatched, as ISO 3952 draws the frame.

use std::f64::consts::FRAC_PI_4;

use super::Sketch;
use super::looks::{Look, Symbol};
use super::rail::{Rail, SLOT};
use crate::geometry::{
    Plane, Point, add, along3, block, direction, distance, distance3, left, scaled, sub, unit,
};
use crate::{Attached, Form, Role, Shape, Solid};

/// Height and half width of the triangle under a pin, radii of a pin.
const TRIANGLE: [f64; 2] = [4.0, 2.6];
/// Half length of the line under it.
const BASE: f64 = 4.0;
/// Length and spacing of the strokes of a hatching.
const STROKE: [f64; 2] = [1.9, 1.35];

impl Sketch<'_> {
    /// The ground: its outline, and a symbol at each point that it holds.
    pub(super) fn ground(&self) -> Vec<Shape> {
        let mut shapes = Vec::new();
        let outline = self.numbers.outline(0);
        if !outline.is_empty() {
            shapes.push(Shape::region(0, Role::Ground, &Plane::XY, &outline));
        }
        shapes.extend(self.solids(0));
        for rail in self.rails_of(0) {
            shapes.extend(self.guide(rail));
        }
        let mut marked: Vec<[f64; 3]> = Vec::new();
        for Held { at, symbol, up, size } in self.held_by_ground() {
            // One symbol a point, and none where the outline already shows the ground.
            let is_drawn = outline.iter().any(|ring| is_within(at, ring, 2.0 * self.pin));
            let is_marked = marked.iter().any(|&other| distance3(other, at) < 0.5 * self.pin);
            if is_drawn || is_marked {
                continue;
            }
            marked.push(at);
            shapes.extend(match symbol {
                _ if !self.is_planar() => self.pyramid(at),
                Symbol::Support => self.support([at[0], at[1]], up, size),
                Symbol::Wall => self.wall([at[0], at[1]], up),
            });
        }
        shapes.extend(self.sleeves());
        shapes
    }

    /// Points where the ground holds a joint or a spring.
    fn held_by_ground(&self) -> Vec<Held> {
        let mut held = Vec::new();
        let mut hold = |anchors: [_; 2], symbol| {
            let [a, b] = anchors.map(|anchor| self.numbers.attached(anchor));
            for (ground, other) in [(a, b), (b, a)] {
                if ground.body == 0 && other.body != 0 {
                    let up = match symbol {
                        Symbol::Support => self.free_side(ground, other),
                        Symbol::Wall => self.mean_direction(ground, other),
                    };
                    // A support is large enough to show beyond the outline of its body.
                    let edge = self.numbers.edge_distance(other).unwrap_or(0.0);
                    let size = (2.0 * edge / (TRIANGLE[0] * self.pin)).clamp(1.0, 4.0);
                    held.push(Held { at: ground.position, symbol, up, size });
                }
            }
        };
        for joint in &self.model().joints {
            let ends = [joint.predecessor, joint.successor];
            if let Some(symbol) = Look::of(joint.kind).on_ground {
                hold(ends, symbol);
            }
        }
        for load in &self.model().loads {
            if let (Some(ends), Some(_)) = (load.kind.ends(), load.kind.spring()) {
                hold(ends, Symbol::Wall);
            }
        }
        held
    }

    /// Up or down: the side where a body held at `ground` is more of the time; a support stands on
    /// the other one.
    pub(super) fn free_side(&self, ground: Attached, other: Attached) -> Point {
        // Its far end, or its centre of mass.
        let points = self.attached[other.body].iter().copied().chain(self.com(other.body));
        let far = |p: &[f64; 3]| distance3(*p, other.position);
        let end = points.max_by(|a, b| far(a).total_cmp(&far(b))).filter(|end| far(end) > self.pin);
        let Some(position) = end else { return [0.0, 1.0] };
        let (mut n_below, mut n_above) = (0, 0);
        for [x, y, _] in self.numbers.vectors(ground, Attached { body: other.body, position }) {
            let [_, slope] = unit([x, y]);
            n_below += usize::from(slope < -0.7);
            n_above += usize::from(slope > 0.7);
        }
        [0.0, if n_below > n_above { -1.0 } else { 1.0 }]
    }

    /// The mean direction from one point to another over the motion.
    fn mean_direction(&self, from: Attached, to: Attached) -> Point {
        let directions = self.numbers.vectors(from, to).map(|[x, y, _]| unit([x, y]));
        let [x, y] = directions.fold([0.0; 2], add);
        if x.hypot(y) > 0.0 { unit([x, y]) } else { [0.0, 1.0] }
    }

    /// The triangle that bears a pin, on a hatched line.
    fn support(&self, at: Point, up: Point, size: f64) -> Vec<Shape> {
        let [height, half] = TRIANGLE.map(|x| x * size * self.pin);
        let foot = add(at, scaled(-height, up));
        let side = scaled(half, left(up));
        let triangle = vec![at, add(foot, side), add(foot, scaled(-1.0, side))];
        let base = scaled(BASE * size * self.pin, left(up));
        let mut shapes = self.hatched(&Plane::XY, add(foot, base), add(foot, scaled(-1.0, base)));
        shapes.push(Shape::region(0, Role::Ground, &Plane::XY, &[triangle]));
        shapes
    }

    /// The support in space: four legs on a plate.
    fn pyramid(&self, at: [f64; 3]) -> Vec<Shape> {
        let [height, half] = TRIANGLE.map(|x| x * self.pin);
        let plate = Plane { origin: along3(at, -height, [0.0, 0.0, 1.0]), ..Plane::XY };
        let ring = block([0.0; 2], [1.0, 0.0], [half, half]);
        let leg = |&corner: &Point| Shape {
            body: 0,
            role: Role::Ground,
            form: Form::Line { points: vec![at, plate.lift(corner)], is_closed: false },
        };
        let legs: Vec<Shape> = ring.iter().map(leg).collect();
        [vec![Shape::region(0, Role::Ground, &plate, &[ring])], legs].concat()
    }

    /// A short line, hatched on the far side of `up`.
    fn wall(&self, at: Point, up: Point) -> Vec<Shape> {
        let side = scaled(BASE * self.pin, left(up));
        self.hatched(&Plane::XY, add(at, side), add(at, scaled(-1.0, side)))
    }

    /// A line of the ground hatched on its right.
    fn hatched(&self, plane: &Plane, from: Point, to: Point) -> Vec<Shape> {
        self.hatched_on(0, plane, from, to)
    }

    /// A line hatched on its right.
    pub(super) fn hatched_on(
        &self,
        body: usize,
        plane: &Plane,
        from: Point,
        to: Point,
    ) -> Vec<Shape> {
        let [length, step] = STROKE.map(|x| x * self.pin);
        let along = unit(sub(to, from));
        let [cos, sin] = direction(FRAC_PI_4);
        let stroke = scaled(-length, add(scaled(sin, left(along)), scaled(cos, along)));
        let whole = distance(from, to);
        let n = n_strokes(whole / step);
        let mut shapes = vec![Shape::line(body, Role::Guide, plane, &[from, to])];
        for i in 0..n {
            let foot = add(from, scaled(whole * (i as f64 + 0.75) / n as f64, along));
            shapes.push(Shape::line(body, Role::Hatching, plane, &[foot, add(foot, stroke)]));
        }
        shapes
    }

    /// Two parallel lines, hatched outside.
    fn guide(&self, rail: &Rail) -> Vec<Shape> {
        let [from, to] = rail.covered();
        let (from, to) = (from - 1.5 * self.pin, to + 1.5 * self.pin);
        let [_, [right, left]] = rail.extent;
        let lines = [([from, right], [to, right]), ([to, left], [from, left])];
        let line = |(a, b): (Point, Point)| {
            if self.is_planar() {
                self.hatched(&rail.plane, a, b)
            } else {
                vec![Shape::line(0, Role::Guide, &rail.plane, &[a, b])]
            }
        };
        lines.into_iter().flat_map(line).collect()
    }

    /// Blocks of the ground that the rails of other bodies slide through.
    fn sleeves(&self) -> Vec<Shape> {
        let mut shapes = Vec::new();
        let sliders = self.rails.iter().flatten().filter_map(|rail| rail.slider);
        for slider in sliders.filter(|slider| slider.body == 0) {
            let half = [4.2, SLOT + 0.8].map(|x| x * self.pin);
            let [from, to] = [[-half[0], -half[1]], [half[0], -half[1]]];
            if !self.is_planar() {
                let [a, b] = half;
                let form = Form::Solid(Solid::block(&slider.plane, [[-a, a], [-b, b], [-b, b]]));
                shapes.push(Shape { body: 0, role: Role::Ground, form });
                continue;
            }
            shapes.extend(self.hatched(&slider.plane, from, to));
            let ring = block([0.0; 2], [1.0, 0.0], half);
            shapes.push(Shape::region(0, Role::Ground, &slider.plane, &[ring]));
        }
        shapes
    }
}

/// A point of the ground that holds a joint or a spring.
struct Held {
    at: [f64; 3],
    symbol: Symbol,
    /// Unit vector towards the body that is held, in the plane.
    up: Point,
    /// Factor on the usual size of the symbol.
    size: f64,
}

/// Number of strokes of a hatching: at least two.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "2 to 400")]
fn n_strokes(x: f64) -> usize {
    x.round().clamp(2.0, 400.0) as usize
}

/// True if a point is within `margin` of the box around a ring.
fn is_within(p: [f64; 3], ring: &[Point], margin: f64) -> bool {
    (0..2).all(|i| {
        let range = super::numbers::range(ring.iter().map(|q| q[i]));
        range.is_some_and(|[low, high]| p[i] > low - margin && p[i] < high + margin)
    })
}
