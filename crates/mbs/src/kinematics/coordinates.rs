//! New coordinates of the spanning tree: their names, symbols and order.

use std::collections::HashSet;

use bksim_expr::{Expr, Pool, SymbolId};

use super::{Kinematics, Turning};
use crate::coordinate::{Coordinate, CoordinateKind, Owner};
use crate::quaternion::Quaternion;
use crate::spatial::{self, Rotation};
use bksim_model::{BodyId, JointId, Model, State, StateId, Vector};

impl Kinematics {
    /// The axis of a joint in world axes.
    pub(crate) fn axis_of(&self, model: &Model, joint: JointId) -> Vector {
        let joint = &model.joints[joint.0];
        self.sides(model, joint).predecessor.rotation.apply(&model.pool, &joint.axis)
    }

    /// The rotation by four new coordinates of `body`, and its angular velocity in outer axes.
    pub(super) fn add_quaternion(
        &mut self,
        model: &Model,
        name: &str,
        body: BodyId,
    ) -> (Rotation, Vector) {
        let pool = &model.pool;
        let first = self.coordinates.len();
        let parts: [(Expr, Expr); 4] = std::array::from_fn(|part| {
            let name = format!("{name}_e{part}");
            let owner = Owner::Quaternion(body, part);
            self.add_coordinate(model, name, CoordinateKind::Quaternion, owner)
        });
        let quaternion = Quaternion(parts.map(|(q, _)| q));
        self.turnings.push(Turning { body, first, quaternion });
        let rates = quaternion.to_outer_rate(pool, &parts.map(|(_, v)| v));
        let omega = spatial::scale(pool, quaternion.scale(pool), &rates);
        (Rotation::by(pool, quaternion), omega)
    }

    /// Adds a coordinate of a motion: its position and velocity.
    pub(super) fn add_coordinate(
        &mut self,
        model: &Model,
        name: String,
        kind: CoordinateKind,
        owner: Owner,
    ) -> (Expr, Expr) {
        let pool = &model.pool;
        // Shapes of a beam are there before their joints.
        if let Owner::Joint(joint, _) = owner
            && self.first_of_joint.contains_key(&joint)
            && let Some(known) = self.coordinates.iter().find(|c| c.owner == owner)
        {
            return (pool.symbol_expr(known.q), pool.symbol_expr(known.v));
        }
        let name = self.unused_name(name);
        let names = ["", "_dot", "_ddot"].map(|suffix| format!("{name}{suffix}"));
        let [q, v] = self.push_coordinate(pool, names, kind, owner);
        (pool.symbol_expr(q), pool.symbol_expr(v))
    }

    /// Adds the coordinate whose velocity is a state: so that it is integrated with the motion, its rate stands
    /// where others have a force, and one where they have a mass.
    pub(super) fn add_state(&mut self, model: &Model, state: &State, id: StateId) {
        let taken: HashSet<String> = self
            .coordinates
            .iter()
            .flat_map(|c| [&c.name, &c.rate_name, &c.second_rate_name].map(String::clone))
            .chain(self.taken.iter().cloned())
            .collect();
        let names_of =
            |own: &str| [format!("{own}_integral"), own.to_owned(), format!("{own}_dot")];
        let mut own = state.name.clone();
        while names_of(&own).iter().any(|name| taken.contains(name)) {
            own.push('_');
        }
        let names = names_of(&own);
        self.push_coordinate(&model.pool, names, CoordinateKind::Integral, Owner::State(id));
    }

    fn push_coordinate(
        &mut self,
        pool: &Pool,
        [name, rate_name, second_rate_name]: [String; 3],
        kind: CoordinateKind,
        owner: Owner,
    ) -> [SymbolId; 2] {
        let symbol =
            |name: &str| pool.symbol_id(pool.symbol(name)).expect("a symbol was just made");
        let [q, v, a] = [&name, &rate_name, &second_rate_name].map(|name| symbol(name));
        let position = self.coordinates.len();
        self.of_value.insert(q, position);
        self.of_velocity.insert(v, position);
        if let Owner::Joint(joint, _) = owner {
            self.first_of_joint.entry(joint).or_insert(position);
        }
        self.coordinates.push(Coordinate {
            name,
            rate_name,
            second_rate_name,
            q,
            v,
            a,
            kind,
            owner,
        });
        [q, v]
    }

    /// A joint and a body may bear one name; their coordinates must not.
    pub(super) fn unused_name(&mut self, mut name: String) -> String {
        while !self.taken.insert(name.clone()) {
            name.push('_');
        }
        name
    }
}
