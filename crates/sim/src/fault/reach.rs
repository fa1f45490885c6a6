//! Reach: how far apart the parts of a loop can hold its joints, from lengths alone.
//!
//! ```text
//! ℓᵢ ≤ Σⱼ≠ᵢ Lⱼ        least length of one part, greatest lengths of all others
//! ```
//!
//! A part is what moves as one between two joints that turn: a body, a link, or bodies whose joint
//! between them is held. A loop that violates the inequality cannot close in any position.

use bksim_expr::Expr;
use bksim_model::message::listed;
use bksim_model::{Anchor, BodyId, GROUND, Joint, JointId, Model};

use crate::mobility::loop_through;

/// Part of a loop between two joints that turn.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Span {
    /// Bodies of the span, or the link that it is.
    pub(super) names: Vec<String>,
    /// Joints that are held within it.
    pub(super) held: Vec<JointId>,
    /// Least and greatest distance of its ends, m; without bound where something slides.
    pub(super) least: f64,
    pub(super) most: f64,
}

/// A loop whose parts cannot meet.
pub(super) struct Short {
    pub(super) around: Vec<JointId>,
    pub(super) spans: Vec<Span>,
    /// The part that is too long.
    pub(super) long: usize,
    /// The length that all others together lack, m.
    pub(super) gap: f64,
}

/// The loop that lacks most, of those through `first` and through all joints of a small mechanism;
/// `held` gives the positions of joints that are held.
pub(super) fn shortest_loop(
    model: &Model,
    first: Option<JointId>,
    held: &dyn Fn(JointId) -> Option<f64>,
) -> Option<Short> {
    const MOST_JOINTS: usize = 300;
    const ROUNDING: f64 = 1e-9;
    let all = if model.joints.len() <= MOST_JOINTS { model.joints.len() } else { 0 };
    let mut worst: Option<Short> = None;
    for joint in first.into_iter().chain((0..all).map(JointId)) {
        let around = loop_through(model, joint);
        let Some(spans) = spans(model, &around, held) else { continue };
        for long in 0..spans.len() {
            let (_, most) = reach_of_others(&spans, long);
            let gap = spans[long].least - most;
            let is_worse = worst.as_ref().is_none_or(|worst| gap > worst.gap * (1.0 + ROUNDING));
            if gap > ROUNDING * spans[long].least && is_worse {
                worst = Some(Short { around: around.clone(), spans: spans.clone(), long, gap });
            }
        }
    }
    worst
}

/// Least and greatest distance that all parts but one can bridge.
pub(super) fn reach_of_others(spans: &[Span], one: usize) -> (f64, f64) {
    let others = || spans.iter().enumerate().filter(|(i, _)| *i != one).map(|(_, span)| span);
    let most: f64 = others().map(|span| span.most).sum();
    let excess = |span: &Span| {
        let rest = most - span.most;
        if rest.is_finite() { span.least - rest } else { 0.0 }
    };
    (others().map(excess).fold(0.0, f64::max), most)
}

/// The parts of a loop; `None` when nothing turns in it.
pub(super) fn spans(
    model: &Model,
    around: &[JointId],
    held: &dyn Fn(JointId) -> Option<f64>,
) -> Option<Vec<Span>> {
    let n = around.len();
    let joint = |k: usize| &model.joints[around[k % n].0];
    // The body after each joint.
    let mut bodies = vec![joint(0).successor.body];
    for k in 1..n {
        bodies.push(far(joint(k), bodies[k - 1]));
    }
    let turns = |k: usize| {
        let kind = joint(k).kind;
        kind.kept_angle().is_none() && !(kind.is_pin() && held(around[k % n]).is_some())
    };
    // Lengths bound what frames that are parallel can reach.
    if around.iter().any(|id| !bounds(model, &model.joints[id.0])) {
        return None;
    }
    let first = (0..n).find(|&k| n > 1 && turns(k))?;

    // Once around, from a joint that turns to itself.
    let mut spans = Vec::new();
    let mut chain = Chain::default();
    for k in first..first + n {
        let (here, body) = (joint(k), bodies[k % n]);
        if let Some(length) = here.kind.link_length() {
            spans.push(link(model, here, length));
        }
        chain.leave_slot(model, here, body);
        chain.along(model, body, here, joint(k + 1));
        let next = around[(k + 1) % n];
        if turns(k + 1) {
            chain.enter_slot(model, joint(k + 1), body);
            spans.push(std::mem::take(&mut chain).span());
        } else {
            chain.cross(model, next, body, held(next));
        }
    }
    Some(spans)
}

/// True if a joint is of a kind that lengths alone can judge, between frames as their bodies have them.
fn bounds(model: &Model, joint: &Joint) -> bool {
    let is_plain = |anchor: Anchor| {
        let points = &model.bodies[anchor.body.0].points;
        anchor.point.is_none_or(|point| points[point.0].orientation.is_empty())
    };
    let kind = joint.kind;
    let is_guided = kind.is_slide() || kind.is_slot();
    (kind.points_coincide() || is_guided || kind.link_length().is_some())
        && joint.alignment.is_empty()
        && is_plain(joint.predecessor)
        && is_plain(joint.successor)
}

/// The link as a part.
fn link(model: &Model, joint: &Joint, length: Expr) -> Span {
    let length = value(model, length);
    let names = vec![joint.name.clone()];
    Span { names, held: Vec::new(), least: length, most: length }
}

/// Vector from the first end of a part to where its assembly has come, in the frame of the last body.
#[derive(Default)]
struct Chain {
    names: Vec<String>,
    held: Vec<JointId>,
    vector: [f64; 3],
    /// Directions along which it is free.
    slides: Vec<[f64; 3]>,
}

impl Chain {
    /// From one joint of a body to the next.
    fn along(&mut self, model: &Model, body: BodyId, from: &Joint, to: &Joint) {
        let name = if body == GROUND { "ground" } else { &model.bodies[body.0].name };
        self.names.push(name.to_owned());
        let [a, b] = [from, to].map(|joint| point(model, on(joint, body)));
        self.vector = [0, 1, 2].map(|i| self.vector[i] + b[i] - a[i]);
    }

    /// Over a joint that does not turn, out of `body`.
    fn cross(&mut self, model: &Model, id: JointId, body: BodyId, held: Option<f64>) {
        let joint = &model.joints[id.0];
        let axis = unit(joint.axis.map(|e| value(model, e)));
        let (turn_axis, angle, offset) = match joint.kind.kept_angle() {
            Some(angle) => {
                ([0.0, 0.0, 1.0], value(model, angle), joint.kind.is_slide().then_some(held))
            }
            None if joint.kind.is_pin() => (axis, held.unwrap_or(0.0), None),
            None => return,
        };
        if held.is_some() {
            self.held.push(id);
        }
        let is_forward = joint.predecessor.body == body;
        let move_along = |vector: [f64; 3], sign: f64| match offset {
            Some(Some(s)) => [0, 1, 2].map(|i| vector[i] + sign * s * axis[i]),
            _ => vector,
        };
        // The slide is in the frame of the first body.
        if is_forward {
            self.vector = move_along(self.vector, 1.0);
            self.slides.extend((offset == Some(None)).then_some(axis));
        }
        let sense = if is_forward { -angle } else { angle };
        self.vector = turned(self.vector, turn_axis, sense);
        self.slides.iter_mut().for_each(|slide| *slide = turned(*slide, turn_axis, sense));
        if !is_forward {
            self.vector = move_along(self.vector, -1.0);
            self.slides.extend((offset == Some(None)).then_some(axis));
        }
    }

    /// Into a slot of `body`, whose pin may be anywhere along it.
    fn enter_slot(&mut self, model: &Model, joint: &Joint, body: BodyId) {
        if joint.kind.is_slot() && joint.predecessor.body == body {
            self.slides.push(unit(joint.axis.map(|e| value(model, e))));
        }
    }

    /// Out of a slot, to the body that has it.
    fn leave_slot(&mut self, model: &Model, joint: &Joint, body: BodyId) {
        self.enter_slot(model, joint, body);
    }

    fn span(self) -> Span {
        let Self { names, held, vector, slides } = self;
        let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (least, most) = match slides.as_slice() {
            [] => (length(vector), length(vector)),
            [slide] => {
                let along: f64 = (0..3).map(|i| vector[i] * slide[i]).sum();
                (length([0, 1, 2].map(|i| vector[i] - along * slide[i])), f64::INFINITY)
            }
            _ => (0.0, f64::INFINITY),
        };
        Span { names, held, least, most }
    }
}

/// "`a`", or "`a` and `b`": the bodies of a part.
pub(super) fn in_words(span: &Span) -> String {
    let names: Vec<&str> = span.names.iter().map(String::as_str).collect();
    listed(&names)
}

/// The longest part of the loop through a joint, m; one metre where nothing has a length.
pub(super) fn longest_in_loop(model: &Model, joint: JointId) -> f64 {
    let spans = spans(model, &loop_through(model, joint), &|_| None).unwrap_or_default();
    let longest = spans.iter().map(|span| span.least).fold(0.0, f64::max);
    if longest > 0.0 { longest } else { 1.0 }
}

/// The other body of a joint.
fn far(joint: &Joint, body: BodyId) -> BodyId {
    if joint.predecessor.body == body { joint.successor.body } else { joint.predecessor.body }
}

/// The side of a joint on a body.
fn on(joint: &Joint, body: BodyId) -> Anchor {
    if joint.predecessor.body == body { joint.predecessor } else { joint.successor }
}

/// A point in the frame of its body, m.
pub(super) fn point(model: &Model, anchor: Anchor) -> [f64; 3] {
    match anchor.point {
        None => [0.0; 3],
        Some(point) => {
            model.bodies[anchor.body.0].points[point.0].position.map(|e| value(model, e))
        }
    }
}

/// The value of an expression of parameters.
pub(super) fn value(model: &Model, e: Expr) -> f64 {
    let parameter = |symbol| model.parameters.iter().find(|p| p.symbol == symbol).map(|p| p.value);
    // Lengths that change with time, as they are at the start.
    let at_start = |symbol| (symbol == model.time).then_some(model.solve.t_start);
    let of = |symbol| parameter(symbol).or_else(|| at_start(symbol));
    model.pool.evaluate(e, &of).unwrap_or(f64::NAN)
}

/// A vector by its length.
pub(super) fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}

/// A vector turned about a unit axis, by Rodrigues' formula.
fn turned(v: [f64; 3], axis: [f64; 3], angle: f64) -> [f64; 3] {
    let (sin, cos) = angle.sin_cos();
    let along: f64 = (0..3).map(|i| axis[i] * v[i]).sum();
    let cross = |i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        axis[j] * v[k] - axis[k] * v[j]
    };
    [0, 1, 2].map(|i| v[i] * cos + cross(i) * sin + axis[i] * along * (1.0 - cos))
}
