//! Stops: hatched lines where a motion ends.

use bksim_expr::Expr;
use bksim_model::Joint;

use super::Sketch;
use super::rail::Rail;
use super::turns::is_rotation;
use crate::Shape;
use crate::geometry::{Plane, Point, add, direction, left, length, scaled, sub3, unit};

/// Where the line of a stop begins and ends, from the joint that it limits, radii of a pin.
const REACH: [f64; 2] = [4.5, 9.5];
/// Half width of the link that hits it.
const LINK: f64 = 1.8;
/// Overhang of the line of a stop over the slider that hits it.
const BEYOND: f64 = 0.8;

impl Sketch<'_> {
    /// The stops of all joints.
    pub(super) fn stops(&self) -> Vec<Shape> {
        let mut shapes = Vec::new();
        for load in &self.model().loads {
            let (Some((joint_id, motion_idx)), Some([min, max])) =
                (load.kind.joint_motion(), load.kind.limits())
            else {
                continue;
            };
            let joint = &self.model().joints[joint_id.0];
            // The side of each limit where the motion ends.
            for (limit, sign) in [(min, -1.0), (max, 1.0)] {
                // One that moves, or is held, has no place of its own.
                let limit = limit.filter(|&limit| !self.is_moving(limit));
                let Some(limit) = limit.map(|limit| self.numbers.value(limit)) else { continue };
                shapes.extend(match &self.rails[joint_id.0] {
                    _ if is_rotation(joint, motion_idx) => self.turn_stop(joint, limit, sign),
                    Some(rail) => self.rail_stop(rail, limit, sign),
                    None => Vec::new(),
                });
            }
        }
        shapes
    }

    fn is_moving(&self, limit: Expr) -> bool {
        let model = self.model();
        let held = model.held.iter().map(|signal| signal.held);
        let mut all = held.chain(model.signals.iter().map(|signal| signal.symbol));
        all.any(|symbol| model.pool.depends_on(limit, symbol))
    }

    /// A line across a rail, at the edge of the slider in its limit position.
    fn rail_stop(&self, rail: &Rail, limit: f64, sign: f64) -> Vec<Shape> {
        let [[low, high], [right, left]] = rail.extent;
        let x = limit + if sign > 0.0 { high } else { low };
        let beyond = BEYOND * self.pin;
        let ends = [[x, right - beyond], [x, left + beyond]];
        let [from, to] = if sign > 0.0 { ends } else { [ends[1], ends[0]] };
        self.hatched_on(rail.body, &rail.plane, from, to)
    }

    /// A line along the edge of the second body of a joint, turned to its limit angle.
    fn turn_stop(&self, joint: &Joint, limit: f64, sign: f64) -> Vec<Shape> {
        let (at, plane) = self.holder(joint);
        let other = self.numbers.attached(joint.successor);
        // Its far end, or its centre of mass; planes of a joint lie alike in both its bodies.
        let points = self.attached[other.body].iter().copied().chain(self.com(other.body));
        let arms = points
            .map(|p| sub3(p, other.position))
            .map(|arm| Plane { origin: [0.0; 3], ..plane }.foot(arm));
        let far = arms.max_by(|a, b| length(*a).total_cmp(&length(*b)));
        let far = far.filter(|arm| length(*arm) > self.pin).unwrap_or([1.0, 0.0]);
        let turned = |[x, y]: Point, [cos, sin]: Point| [cos * x - sin * y, sin * x + cos * y];
        let along = unit(turned(far, direction(limit)));
        let aside = scaled(sign * LINK * self.pin, left(along));
        let [inner, outer] = REACH.map(|r| add(scaled(r * self.pin, along), aside));
        let [from, to] = if sign > 0.0 { [outer, inner] } else { [inner, outer] };
        self.hatched_on(at.body, &plane, from, to)
    }
}
