//! Kinematics in the angles of the bodies against the ground.
//!
//! ```text
//! θ_b = s q_i + rest(q before i),  s = ±1     q_i = s (θ_b − rest)
//! ```
//!
//! along the tree of a planar mechanism, body by body. For reading: what is solved keeps the angles of the joints.

use bksim_expr::{Expr, Pool, SymbolId};
use bksim_model::{BodyId, Model, Space};

use super::{Kinematics, bending};
use crate::coordinate::{Coordinate, CoordinateKind, Owner};
use crate::pose::Pose;
use crate::spatial::{self, Rotation};
use crate::tree::{Branch, Tree};

/// The angle of a body against the ground in the place of the angle of its joint.
#[derive(Clone, Debug)]
pub struct AbsoluteAngle {
    /// The body.
    pub body: BodyId,
    /// Angle of the body and its rate, by the joints' coordinates.
    pub by_joints: [Expr; 2],
    /// Angle of the joint, by those of the bodies.
    pub(super) of_joint: Expr,
}

impl Kinematics {
    /// The angle of a body that the i-th coordinate is in the place of that of its joint.
    pub fn absolute_angle(&self, i: usize) -> Option<&AbsoluteAngle> {
        self.absolute.get(&i)
    }

    /// The motion of a joint whose coordinate is the i-th.
    pub(crate) fn of_motion(&self, pool: &Pool, i: usize) -> Expr {
        let own = || pool.symbol_expr(self.coordinates[i].q);
        self.absolute.get(&i).map_or_else(own, |angle| angle.of_joint)
    }

    /// Kinematics with the angle of each body in the place of that of the joint on which it turns; `None` in
    /// space, and where bodies bend.
    pub(crate) fn in_absolute_angles(&self, model: &Model, tree: &Tree) -> Option<Self> {
        if model.space != Space::Planar || bending::are_there(model) {
            return None;
        }
        let (pool, z) = (&model.pool, spatial::z_axis(&model.pool));
        let mut found = self.clone();
        let mut images: Vec<(SymbolId, Expr)> = Vec::new();
        for &(body, branch) in &tree.branches {
            let Branch::Joint { joint, .. } = branch else { continue };
            let angle = self.poses[body.0].rotation.angle_about(pool, &z)?;
            let slope = |c: &Coordinate| pool.as_number(pool.diff(angle, c.q));
            let turns = |c: &Coordinate| {
                matches!(c.owner, Owner::Joint(id, _) if id == joint)
                    && slope(c).is_some_and(|slope| slope.magnitude().is_one())
            };
            let Some(i) = self.coordinates.iter().position(turns) else { continue };
            let own = &self.coordinates[i];
            let is_named = !model.joints[joint.0].coordinate_names.is_empty();
            if is_named && angle == pool.symbol_expr(own.q) {
                continue;
            }
            // q, v and a of the joint by those of the body.
            let rate = self.rate(model, angle);
            let levels = [angle, rate, self.second_rate(model, rate)];
            let symbols = found.rename_as_angle_of(model, body, i);
            let sign = pool.number(slope(own)?);
            for ((level, joint_symbol), symbol) in
                levels.into_iter().zip([own.q, own.v, own.a]).zip(symbols)
            {
                let moving = pool.mul(sign, pool.symbol_expr(joint_symbol));
                let rest = pool.substitute(pool.sub(level, moving), &images);
                let image = pool.mul(sign, pool.sub(pool.symbol_expr(symbol), rest));
                images.push((joint_symbol, image));
            }
            let of_joint = images[images.len() - 3].1;
            let angle = AbsoluteAngle { body, by_joints: [angle, rate], of_joint };
            found.absolute.insert(i, angle);
        }
        let all = |vector: &[Expr; 3]| {
            let images = pool.substitute_all(vector, &images);
            [0, 1, 2].map(|k| pool.simplify(images[k]))
        };
        for (pose, own) in found.poses.iter_mut().zip(&self.poses) {
            let angle = own.rotation.angle_about(pool, &z)?;
            let image = pool.substitute(angle, &images);
            let rotation = if image == angle {
                own.rotation.clone()
            } else {
                Rotation::about(pool, &z, image)
            };
            *pose = Pose {
                anchor_body: all(&own.anchor_body),
                anchor_world: all(&own.anchor_world),
                rotation,
                omega: all(&own.omega),
            };
        }
        Some(found)
    }

    /// Gives the i-th coordinate the name of the angle of a body; returns its symbols.
    fn rename_as_angle_of(&mut self, model: &Model, body: BodyId, i: usize) -> [SymbolId; 3] {
        let name = self.unused_name(format!("{}_angle", model.bodies[body.0].name));
        let names = ["", "_dot", "_ddot"].map(|suffix| format!("{name}{suffix}"));
        let symbol = |name: &String| {
            model.pool.symbol_id(model.pool.symbol(name)).expect("a symbol was just made")
        };
        let [q, v, a] = [&names[0], &names[1], &names[2]].map(symbol);
        self.of_value.insert(q, i);
        self.of_velocity.insert(v, i);
        let [name, rate_name, second_rate_name] = names;
        let owner = self.coordinates[i].owner;
        let kind = CoordinateKind::Angle;
        self.coordinates[i] =
            Coordinate { name, rate_name, second_rate_name, q, v, a, kind, owner };
        [q, v, a]
    }
}
