//! Measures as expressions of coordinates, velocities and, for accelerations, of these; reactions as their symbols.

use bksim_expr::Expr;

use crate::coordinate::{Coordinate, Owner};
use crate::coupling;
use crate::inertia::angular_momentum;
use crate::joint;
use crate::kinematics::Kinematics;
use crate::spatial::{self, z_axis};
use bksim_model::{Axis, BodyId, Frame, Measure, Model, Vector};

impl Kinematics {
    /// A measure as an expression of coordinates and velocities; of accelerations too, if it is one.
    pub fn measure(&self, model: &Model, measure: Measure) -> Expr {
        let pool = &model.pool;
        match measure {
            Measure::JointPosition(joint, motion_idx) => {
                self.joint_positions(model, joint)[motion_idx]
            }
            Measure::PointPosition(body, point, axis) => {
                self.position(model, body, point)[axis_idx(axis)]
            }
            Measure::BodyAngle(body) => {
                let rotation = &self.poses[body.0].rotation;
                let z = z_axis(pool);
                rotation.angle_about(pool, &z).unwrap_or_else(|| {
                    let x_world = rotation.apply(pool, &[pool.one(), pool.zero(), pool.zero()]);
                    pool.atan2(x_world[1], x_world[0])
                })
            }
            Measure::JointVelocity(joint, motion_idx) => {
                let position = self.measure(model, Measure::JointPosition(joint, motion_idx));
                self.rate(model, position)
            }
            Measure::JointAcceleration(joint, motion_idx) => {
                let velocity = self.measure(model, Measure::JointVelocity(joint, motion_idx));
                self.second_rate(model, velocity)
            }
            Measure::PointVelocity(body, point, axis) => {
                let position = self.measure(model, Measure::PointPosition(body, point, axis));
                self.rate(model, position)
            }
            Measure::Turn(body, against, joint) => {
                coupling::turn(model, self, body, against, joint)
                    .unwrap_or_else(|| self.joint_positions(model, joint)[0])
            }
            Measure::BodyRate(body) => self.poses[body.0].omega[2],
            Measure::CardanAngle(body, idx) => {
                let is_own = |c: &&Coordinate| c.owner == Owner::Body(body, 3 + idx);
                match self.coordinates.iter().find(is_own) {
                    Some(own) => pool.symbol_expr(own.q),
                    None => joint::cardan_angles(pool, &self.poses[body.0].rotation)[idx],
                }
            }
            Measure::CardanRate(body, idx) => {
                let angle = self.measure(model, Measure::CardanAngle(body, idx));
                self.rate(model, angle)
            }
            Measure::RollPitchYaw(body, axis) => self.roll_pitch_yaw(model, body, axis),
            Measure::Quaternion(body, part) => {
                let quaternion = self.poses[body.0].rotation.quaternion(pool);
                let length = pool.sqrt(quaternion.square(pool));
                pool.div(quaternion.0[part], length)
            }
            Measure::DirectionCosine(body, of_ground, of_body) => {
                let axis = spatial::axes(pool)[axis_idx(of_body)];
                self.poses[body.0].rotation.apply(pool, &axis)[axis_idx(of_ground)]
            }
            Measure::AngularVelocity(body, frame, axis) => {
                let pose = &self.poses[body.0];
                let omega = match frame {
                    Frame::World => pose.omega,
                    Frame::Body => pose.rotation.apply_inverse(pool, &pose.omega),
                };
                omega[axis_idx(axis)]
            }
            Measure::AngularAcceleration(body, frame, axis) => {
                let pose = &self.poses[body.0];
                let alpha = pose.omega.map(|part| self.second_rate(model, part));
                let alpha = match frame {
                    Frame::World => alpha,
                    Frame::Body => pose.rotation.apply_inverse(pool, &alpha),
                };
                alpha[axis_idx(axis)]
            }
            Measure::PointAcceleration(body, point, axis) => {
                let velocity = self.measure(model, Measure::PointVelocity(body, point, axis));
                self.second_rate(model, velocity)
            }
            // Known once there are multipliers: see `SymbolicSystem::reaction_values` and `reaction::reported`.
            Measure::Reaction(..)
            | Measure::Resultant(..)
            | Measure::Effort(_)
            | Measure::Force(_)
            | Measure::Contact(..)
            | Measure::Line(..)
            | Measure::Moment(_) => {
                let own = model.signals.iter().find(|signal| signal.measure == measure);
                own.map_or(pool.zero(), |signal| pool.symbol_expr(signal.symbol))
            }
            Measure::State(id) => {
                let own = self.coordinates.iter().find(|c| c.owner == Owner::State(id));
                own.map_or(pool.zero(), |c| pool.symbol_expr(c.v))
            }
            Measure::Momentum(body, axis) => {
                let all = bodies(model, body).map(|body| self.momentum(model, body));
                pool.sum(all.map(|momentum| momentum[axis_idx(axis)]).collect::<Vec<_>>())
            }
            Measure::AngularMomentum(body, axis) => {
                let of = |id: BodyId| {
                    let own = angular_momentum(model, &self.poses[id.0], id)[axis_idx(axis)];
                    if body.is_some() {
                        return own;
                    }
                    // About the origin.
                    let at = self.position(model, id, None);
                    let of_com = spatial::cross(pool, &at, &self.momentum(model, id));
                    pool.add(own, of_com[axis_idx(axis)])
                };
                pool.sum(bodies(model, body).map(of).collect::<Vec<_>>())
            }
        }
    }

    /// m v of the centre of mass.
    fn momentum(&self, model: &Model, body: BodyId) -> Vector {
        let velocity = self.position(model, body, None).map(|e| self.rate(model, e));
        spatial::scale(&model.pool, model.bodies[body.0].mass, &velocity)
    }

    /// Rz(yaw) Ry(pitch) Rx(roll) = R, with the pitch within ±90°.
    fn roll_pitch_yaw(&self, model: &Model, body: BodyId, axis: Axis) -> Expr {
        let pool = &model.pool;
        let rotation = &self.poses[body.0].rotation;
        let [x, _, z] = spatial::axes(pool);
        // The first column, and the last row.
        let column = rotation.apply(pool, &x);
        let row = rotation.apply_inverse(pool, &z);
        match axis {
            Axis::X => pool.atan2(row[1], row[2]),
            Axis::Y => {
                let level = pool.sqrt(pool.add(pool.powi(column[0], 2), pool.powi(column[1], 2)));
                pool.atan2(pool.neg(column[2]), level)
            }
            Axis::Z => pool.atan2(column[1], column[0]),
        }
    }
}

/// One body, or all but the ground.
fn bodies(model: &Model, body: Option<BodyId>) -> impl Iterator<Item = BodyId> {
    let range = body.map_or(1..model.bodies.len(), |BodyId(body)| body..body + 1);
    range.map(BodyId)
}

fn axis_idx(axis: Axis) -> usize {
    match axis {
        Axis::X => 0,
        Axis::Y => 1,
        Axis::Z => 2,
    }
}
