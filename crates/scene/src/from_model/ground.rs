//! What does not move: supports of pins, guides, walls; hatched, as ISO 3952 draws the frame.

use std::f64::consts::FRAC_PI_4;

use bksim_mbs::model::{JointKind, LoadKind};

use super::rail::{Rail, SLOT};
use super::{Sketch, flat};
use crate::geometry::{Point, add, direction, distance, dot, left, scaled, unit};
use crate::{Attached, Role, Shape};

/// Height and half width of the triangle under a pin, radii of a pin.
const TRIANGLE: [f64; 2] = [4.0, 2.6];
/// Half length of the line under it.
const BASE: f64 = 4.0;
/// Length and distance of the strokes of a hatching.
const STROKE: [f64; 2] = [1.9, 1.35];

impl Sketch<'_> {
    /// The ground: its outline, and a symbol wherever something is held by it.
    pub(super) fn ground(&self) -> Vec<Shape> {
        let mut shapes = Vec::new();
        let outline = self.numbers.outline(0);
        if !outline.is_empty() {
            shapes.push(Shape::region(0, Role::Ground, &outline));
        }
        for rail in self.rails_of(0) {
            shapes.extend(self.guide(rail));
        }
        let mut held: Vec<Point> = Vec::new();
        for (at, symbol, away) in self.held_by_ground() {
            // Symbols stand where nothing is drawn, and once.
            let is_drawn = outline.iter().any(|ring| is_within(at, ring, 2.0 * self.pin));
            let is_known = held.iter().any(|&other| distance(other, at) < 0.5 * self.pin);
            if !is_drawn && !is_known {
                held.push(at);
                shapes.extend(match symbol {
                    Symbol::Support => self.support(at, away),
                    Symbol::Wall => self.wall(at, away),
                });
            }
        }
        shapes.extend(self.sleeves());
        shapes
    }

    /// Places where the ground holds something, and where that is: a unit vector away from it.
    fn held_by_ground(&self) -> Vec<(Point, Symbol, Point)> {
        let (model, numbers) = (self.model(), &self.numbers);
        let mut held = Vec::new();
        let mut hold = |ends: [Attached; 2], symbol, is_free: bool| {
            for [ground, other] in [ends, [ends[1], ends[0]]] {
                if ground.body == 0 && other.body != 0 {
                    let away = if is_free {
                        self.free_side(ground, other)
                    } else {
                        self.mean_way(ground, other)
                    };
                    held.push((flat(ground.position), symbol, away));
                }
            }
        };
        for joint in &model.joints {
            let ends = [joint.predecessor, joint.successor].map(|anchor| numbers.attached(anchor));
            match joint.kind {
                JointKind::Revolute | JointKind::Link { .. } => hold(ends, Symbol::Support, true),
                JointKind::Weld { .. } => hold(ends, Symbol::Wall, true),
                JointKind::Prismatic { .. } | JointKind::PinInSlot => (),
            }
        }
        for load in &model.loads {
            if let LoadKind::Spring { a, b, .. } = load.kind {
                hold([a, b].map(|anchor| numbers.attached(anchor)), Symbol::Wall, false);
            }
        }
        held
    }

    /// Up or down: the side that a body held at `ground` is on more of the time; a support stands
    /// on the other one.
    fn free_side(&self, ground: Attached, other: Attached) -> Point {
        // Its far end, or its centre of mass.
        let points = &self.attached[other.body];
        let far = |p: &&[f64; 3]| distance(flat(**p), flat(other.position));
        let end = points.iter().max_by(|a, b| far(a).total_cmp(&far(b)));
        let end = end.filter(|end| far(end) > self.pin).copied();
        let com = self.com(other.body).map(|[x, y]| [x, y, 0.0]);
        let Some(position) = end.or(com) else { return [0.0, 1.0] };
        let ways = self.numbers.ways(ground, Attached { body: other.body, position });
        let below: i64 = ways
            .map(|way| unit(flat(way))[1])
            .map(|y| {
                if y < -0.7 {
                    1
                } else if y > 0.7 {
                    -1
                } else {
                    0
                }
            })
            .sum();
        [0.0, if below > 0 { -1.0 } else { 1.0 }]
    }

    /// From one point to another on average.
    fn mean_way(&self, from: Attached, to: Attached) -> Point {
        let ways = self.numbers.ways(from, to).map(|way| unit(flat(way)));
        let [x, y] = ways.fold([0.0; 2], add);
        if x.hypot(y) > 0.0 { unit([x, y]) } else { [0.0, 1.0] }
    }

    /// The triangle that bears a pin, on a hatched line.
    fn support(&self, at: Point, up: Point) -> Vec<Shape> {
        let [height, half] = TRIANGLE.map(|x| x * self.pin);
        let foot = add(at, scaled(-height, up));
        let side = scaled(half, left(up));
        let triangle = vec![at, add(foot, side), add(foot, scaled(-1.0, side))];
        let mut shapes = self.wall(foot, up);
        shapes.push(Shape::region(0, Role::Ground, &[triangle]));
        shapes
    }

    /// A short line, hatched on the far side of `up`.
    fn wall(&self, at: Point, up: Point) -> Vec<Shape> {
        let side = scaled(BASE * self.pin, left(up));
        self.hatched(add(at, side), add(at, scaled(-1.0, side)))
    }

    /// A line hatched on its left.
    fn hatched(&self, from: Point, to: Point) -> Vec<Shape> {
        let [length, step] = STROKE.map(|x| x * self.pin);
        let along = unit([to[0] - from[0], to[1] - from[1]]);
        let stroke = {
            let [across, back] = [left(along), scaled(-1.0, along)];
            let [cos, sin] = direction(FRAC_PI_4);
            scaled(length, add(scaled(sin, across), scaled(cos, back)))
        };
        let whole = distance(from, to);
        let n = whole_number(whole / step);
        let mut shapes = vec![Shape::line(0, Role::Ground, &[from, to])];
        for i in 0..n {
            let foot = add(from, scaled(whole * (i as f64 + 0.75) / n as f64, along));
            shapes.push(Shape::line(0, Role::Hatching, &[foot, add(foot, stroke)]));
        }
        shapes
    }

    /// Two parallel lines, hatched outside.
    fn guide(&self, rail: &Rail) -> Vec<Shape> {
        let [from, to] = rail.covered();
        let (from, to) = (from - 1.5 * self.pin, to + 1.5 * self.pin);
        let [_, [right, left]] = rail.room;
        let mut shapes = self.hatched(rail.beside(from, left), rail.beside(to, left));
        shapes.extend(self.hatched(rail.beside(to, right), rail.beside(from, right)));
        shapes
    }

    /// Blocks of the ground that something else slides through.
    fn sleeves(&self) -> Vec<Shape> {
        let mut shapes = Vec::new();
        for rail in self.blocks_of(0) {
            let Some(block) = rail.block else { continue };
            let half = [4.2, SLOT + 0.8].map(|x| x * self.pin);
            let ring = crate::geometry::block(flat(block.position), rail.block_along, half);
            let under = add(flat(block.position), scaled(-half[1], left(rail.block_along)));
            shapes.extend(self.wall(under, left(rail.block_along)));
            shapes.push(Shape::region(0, Role::Ground, &[ring]));
        }
        shapes
    }
}

/// How the ground holds something.
#[derive(Clone, Copy)]
enum Symbol {
    /// By a pin.
    Support,
    /// Fast.
    Wall,
}

/// Strokes of a hatching: two at least.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "2 to 400")]
fn whole_number(x: f64) -> usize {
    x.round().clamp(2.0, 400.0) as usize
}

/// Whether a point is in the box around a ring, or this near.
fn is_within(p: Point, ring: &[Point], margin: f64) -> bool {
    [[1.0, 0.0], [0.0, 1.0]].into_iter().all(|axis| {
        let values = ring.iter().map(|&q| dot(q, axis));
        let range = super::numbers::range(values);
        let x = dot(p, axis);
        range.is_some_and(|[low, high]| x > low - margin && x < high + margin)
    })
}
