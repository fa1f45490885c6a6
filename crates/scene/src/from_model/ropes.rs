//! Ropes: the pulleys that have no shape of their own, the rope around each, and its spans.

use bksim_model::{Rope, RopeNode};
use bksim_sim::belt::span_between;

use super::Sketch;
use super::wheels::{fine_circle, position_on};
use crate::geometry::{Plane, arc};
use crate::{Attached, Form, Role, Shape, Span, SpanKind};

/// A rope where the start puts what it goes over.
struct Laid<'a> {
    /// The nodes that the rope is in touch with.
    touched: Vec<&'a RopeNode>,
    /// Centres and radii in the world, m; radii below zero where the rope turns right.
    nodes: Vec<([f64; 2], f64)>,
    /// Where each span leaves one and meets the next.
    spans: Vec<[[f64; 2]; 2]>,
}

impl Sketch<'_> {
    /// Discs of pulleys, and the rope around each.
    pub(super) fn ropes(&self) -> Vec<Shape> {
        let mut shapes = Vec::new();
        for rope in &self.model().ropes {
            for node in &rope.nodes {
                let at = self.numbers.attached(node.center);
                let radius = self.numbers.value(node.radius).abs();
                if radius > 0.0 && !self.has_own_shape(at.body) {
                    let plane = Plane { origin: at.position, ..Plane::XY };
                    let role = self.role_of(at.body);
                    shapes.push(Shape::region(at.body, role, &plane, &[fine_circle(radius)]));
                }
            }
            let Some(laid) = self.laid_rope(rope) else { continue };
            for (k, pair) in laid.spans.windows(2).enumerate() {
                let (center, radius) = laid.nodes[k + 1];
                if radius == 0.0 {
                    continue;
                }
                let angle = |[x, y]: [f64; 2]| (y - center[1]).atan2(x - center[0]);
                let (from, to) = (angle(pair[0][1]), angle(pair[1][0]));
                let turn = (radius.signum() * (to - from)).rem_euclid(std::f64::consts::TAU);
                let points = arc(center, radius.abs(), from, from + radius.signum() * turn);
                shapes.extend(self.on_carrier(laid.touched[k + 1], &points));
            }
        }
        shapes
    }

    /// The spans of ropes.
    pub(super) fn rope_spans(&self) -> Vec<Span> {
        let mut spans = Vec::new();
        for rope in &self.model().ropes {
            let Some(laid) = self.laid_rope(rope) else { continue };
            for (k, touching) in laid.spans.iter().enumerate() {
                let end = |node: usize, [x, y]: [f64; 2]| {
                    let body = self.carrier_of(laid.touched[node]);
                    let pose = self.numbers.first_pose(body)?;
                    Some(Attached { body, position: position_on(pose, [x, y, 0.0]) })
                };
                if let (Some(from), Some(to)) = (end(k, touching[0]), end(k + 1, touching[1])) {
                    let name = rope.name.clone();
                    spans.push(Span { name, ends: [from, to], kind: SpanKind::Link });
                }
            }
        }
        spans
    }

    /// A line of the rope, which stays with what carries the pulley.
    fn on_carrier(&self, node: &RopeNode, points: &[[f64; 2]]) -> Option<Shape> {
        let body = self.carrier_of(node);
        let pose = self.numbers.first_pose(body)?;
        let points = points.iter().map(|&[x, y]| position_on(pose, [x, y, 0.0])).collect();
        Some(Shape { body, role: Role::Link, form: Form::Line { points, is_closed: false } })
    }

    /// The body in which a pulley turns, so that the rope's places on it do not turn with it; its own body without a pin.
    fn carrier_of(&self, node: &RopeNode) -> usize {
        let is_round = self.numbers.value(node.radius) != 0.0;
        let pin = self.model().joints.iter().find(|joint| {
            let ends = [joint.predecessor, joint.successor];
            is_round && joint.kind.is_pin() && ends.iter().any(|end| end.body == node.center.body)
        });
        pin.map_or(node.center.body.0, |joint| {
            let [a, b] = [joint.predecessor.body, joint.successor.body];
            if a == node.center.body { b.0 } else { a.0 }
        })
    }

    /// A rope at the first instant, if that is known and its spans have a way.
    fn laid_rope<'a>(&self, rope: &'a Rope) -> Option<Laid<'a>> {
        let node = |node: &RopeNode| {
            let at = self.numbers.attached(node.center);
            let [x, y, _] = self.numbers.first_pose(at.body)?.place(at.position);
            Some(([x, y], self.numbers.value(node.radius)))
        };
        let all = rope.nodes.iter().map(node).collect::<Option<Vec<_>>>()?;
        // What the rope may leave it touches where it is bent around it; neighbours are always touched.
        let touches = |k: usize| {
            if !rope.nodes[k].leaves {
                return Some(true);
            }
            let [from, to] = [[k - 1, k], [k, k + 1]].map(|[a, b]| span_between(all[a], all[b]));
            let ([ax, ay], [bx, by]) = (from?.direction, to?.direction);
            let cross = ax * by - ay * bx;
            Some(if rope.nodes[k].is_left { cross >= 0.0 } else { cross <= 0.0 })
        };
        let kept = (0..all.len()).map(|k| Some(touches(k)?.then_some(k)));
        let kept: Vec<usize> = kept.collect::<Option<Vec<_>>>()?.into_iter().flatten().collect();
        let nodes: Vec<_> = kept.iter().map(|&k| all[k]).collect();
        let touched = kept.into_iter().map(|k| &rope.nodes[k]).collect();
        let span = |pair: &[([f64; 2], f64)]| Some(span_between(pair[0], pair[1])?.touching);
        let spans = nodes.windows(2).map(span).collect::<Option<Vec<_>>>()?;
        Some(Laid { touched, nodes, spans })
    }
}
