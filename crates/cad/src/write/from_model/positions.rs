//! Positions of bodies, points and joints in the drawing, at the start of the model.

use std::collections::HashMap;

use bksim_expr::{Expr, SymbolId};
use bksim_model::diagnostic::Diagnostic;
use bksim_model::{Anchor, Axis, BodyId, JointId, Measure, Model};
use bksim_sim::pose::PlanarPose;

use super::{ModelSource, Unwritten};
use crate::codes;
use crate::geometry::Point;
use crate::write::UNITS;

/// Numbers of a model and positions of its bodies.
#[derive(Debug)]
pub(super) struct Positions<'a> {
    model: &'a Model,
    poses: &'a [PlanarPose],
    parameters: HashMap<SymbolId, f64>,
    /// Drawing units in a metre.
    per_metre: f64,
    /// Points that stand for the origins of bodies, where joints and loads use them.
    origins: HashMap<BodyId, String>,
}

impl<'a> Positions<'a> {
    pub(super) fn new(source: &ModelSource<'a>) -> Result<Self, Unwritten> {
        let model = source.model;
        // An unknown unit is refused by the canvas.
        let unit = UNITS.iter().find(|(name, ..)| *name == source.unit);
        let metres = unit.map_or(1.0, |&(_, _, metres, _)| metres);
        let parameters = model.parameters.iter().map(|p| (p.symbol, p.value)).collect();
        let per_metre = if metres < 1.0 { (1.0 / metres).round() } else { 1.0 / metres };
        // An inch is no whole part of a metre.
        let per_metre =
            if (per_metre * metres - 1.0).abs() < 1e-12 { per_metre } else { 1.0 / metres };
        let origins = HashMap::new();
        let mut positions = Self { model, poses: source.poses, parameters, per_metre, origins };
        positions.name_origins();
        let finite = positions
            .poses
            .iter()
            .all(|p| p.origin.iter().chain([&p.angle]).all(|number| number.is_finite()));
        if !finite || positions.poses.len() != model.bodies.len() {
            let message = "the bodies have no finite places at the start";
            return Err(Diagnostic::error(codes::UNDRAWABLE, message).into());
        }
        Ok(positions)
    }

    /// The origin of a body that something is fastened to gets a name, unless a point is there.
    fn name_origins(&mut self) {
        for (id, body) in self.model.bodies.iter().enumerate() {
            let is_free = |name: &str| !body.points.iter().any(|point| point.name == name);
            let mut name = "origin".to_owned();
            while !is_free(&name) {
                name.push('_');
            }
            self.origins.insert(BodyId(id), name);
        }
    }

    /// The name of the point that stands for a body's origin.
    pub(super) fn origin_name(&self, body: BodyId) -> &str {
        self.origins.get(&body).map_or("origin", String::as_str)
    }

    /// The name of a point.
    pub(super) fn point_name(&self, anchor: Anchor) -> String {
        match anchor.point {
            Some(point) => self.model.bodies[anchor.body.0].points[point.0].name.clone(),
            None => self.origin_name(anchor.body).to_owned(),
        }
    }

    /// A number of the model; `None` when it depends on the motion or on time.
    pub(super) fn number(&self, e: Expr) -> Option<f64> {
        let value = |symbol| self.parameters.get(&symbol).copied();
        self.model.pool.evaluate(e, &value).ok().filter(|number| number.is_finite())
    }

    /// The x and y of a vector of the model.
    pub(super) fn vector(&self, [x, y]: [Expr; 2]) -> Option<Point> {
        Some([self.number(x)?, self.number(y)?])
    }

    pub(super) fn pose(&self, body: BodyId) -> PlanarPose {
        self.poses[body.0]
    }

    /// A point of the world, m, in drawing units.
    pub(super) fn drawn(&self, [x, y]: Point) -> Point {
        [self.per_metre * x, self.per_metre * y]
    }

    /// A point in the frame of a body, in the drawing.
    pub(super) fn on_body(&self, body: BodyId, at: Point) -> Point {
        self.drawn(self.pose(body).place(at))
    }

    /// A point of a body in its frame, m.
    pub(super) fn in_body(&self, anchor: Anchor) -> Option<Point> {
        match anchor.point {
            Some(point) => {
                let [x, y, _] = self.model.bodies[anchor.body.0].points[point.0].position;
                self.vector([x, y])
            }
            None => Some([0.0, 0.0]),
        }
    }

    /// A point of a body in the drawing.
    pub(super) fn anchor(&self, anchor: Anchor) -> Result<Point, Unwritten> {
        let at = self.in_body(anchor).ok_or_else(|| not_finite(&self.point_name(anchor)))?;
        Ok(self.on_body(anchor.body, at))
    }

    /// Where a joint is, and a point along its axis; a slider is drawn where the second body is.
    pub(super) fn joint(&self, joint: JointId) -> Result<[Point; 2], Unwritten> {
        let joint = &self.model.joints[joint.0];
        let [x, y, _] = joint.axis;
        let (axis, at, turned) = if joint.kind.is_slide() || joint.kind.is_slot() {
            let axis = self.vector([x, y]).ok_or_else(|| not_finite(&joint.name))?;
            (axis, self.anchor(joint.successor)?, self.pose(joint.predecessor.body).angle)
        } else {
            ([1.0, 0.0], self.anchor(joint.predecessor)?, 0.0)
        };
        let (sin, cos) = turned.sin_cos();
        let along = [cos * axis[0] - sin * axis[1], sin * axis[0] + cos * axis[1]];
        Ok([at, [at[0] + along[0], at[1] + along[1]]])
    }

    /// The value of a measure of position at the start, SI; an angle by as many turns as `near` has.
    pub(super) fn found(&self, measure: Measure, near: f64) -> Option<f64> {
        const TURN: f64 = std::f64::consts::TAU;
        let wound = |angle: f64| angle + TURN * ((near - angle) / TURN).round();
        match measure {
            Measure::BodyAngle(body) => Some(wound(self.pose(body).angle)),
            Measure::JointPosition(id, motion_idx) => {
                let joint = &self.model.joints[id.0];
                let [first, second] = [joint.predecessor, joint.successor];
                let poses = [first, second].map(|anchor| self.pose(anchor.body));
                if joint.kind.curve().is_some() {
                    // The places of bodies do not tell the parameter of a curve.
                    return None;
                }
                if !joint.kind.slides(motion_idx) {
                    return Some(wound(poses[1].angle - poses[0].angle));
                }
                let from = poses[0].place(self.in_body(first)?);
                let to = poses[1].place(self.in_body(second)?);
                if joint.kind.is_cylinder() {
                    return Some((to[0] - from[0]).hypot(to[1] - from[1]));
                }
                let [x, y] = self.vector([joint.axis[0], joint.axis[1]])?;
                let (sin, cos) = poses[0].angle.sin_cos();
                let along = [cos * x - sin * y, sin * x + cos * y];
                Some((to[0] - from[0]) * along[0] + (to[1] - from[1]) * along[1])
            }
            Measure::PointPosition(body, None, axis) => {
                let [x, y, _] = self.model.bodies[body.0].com;
                let at = self.pose(body).place(self.vector([x, y])?);
                Some(if axis == Axis::X { at[0] } else { at[1] })
            }
            _ => None,
        }
    }

    /// Lower left and upper right corner of all points, joints and outlines.
    pub(super) fn extent(&self) -> [Point; 2] {
        let mut extent = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        let mut reach = |at: Point| {
            for i in 0..2 {
                extent[0][i] = extent[0][i].min(at[i]);
                extent[1][i] = extent[1][i].max(at[i]);
            }
        };
        for (id, body) in self.model.bodies.iter().enumerate() {
            let points = body.points.iter().map(|p| [p.position[0], p.position[1]]);
            let corners = body.outline.iter().flatten().copied();
            let all = points.chain(corners).filter_map(|p| self.vector(p));
            all.for_each(|at| reach(self.on_body(BodyId(id), at)));
            if id > 0 {
                reach(self.on_body(BodyId(id), [0.0, 0.0]));
            }
        }
        if extent[0][0] <= extent[1][0] { extent } else { [[0.0; 2]; 2] }
    }

    /// A size at which symbols are seen and do not cover the mechanism.
    pub(super) fn symbol_size(&self) -> f64 {
        let [low, high] = self.extent();
        let diagonal = (high[0] - low[0]).hypot(high[1] - low[1]);
        if diagonal > 0.0 { diagonal / 25.0 } else { 0.1 * self.per_metre }
    }
}

fn not_finite(name: &str) -> Unwritten {
    let message = format!("`{name}` has no finite place at the start");
    Diagnostic::error(codes::UNDRAWABLE, message).into()
}
