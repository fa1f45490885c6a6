//! Poses of all bodies as functions of the generalised coordinates, along the spanning tree.
//!
//! Source: Lê Hồng Lam and Đinh Văn Phong (2008), eq. (1.2): positions and rotation matrices are
//! chained from the ground outwards. Frames in names: `p_world_com` is a position in world axes.

mod absolute;
pub(crate) mod bending;
mod coordinates;

pub use absolute::AbsoluteAngle;

use std::collections::{HashMap, HashSet};

use bksim_expr::{Expr, Pool, SymbolId};

use crate::coordinate::turns_by_quaternion;
use crate::coordinate::{Coordinate, CoordinateKind, Owner};
use crate::joint::{self, OnCurve, Sides};
use crate::particle::particles;
use crate::pose::Pose;
use crate::quaternion::Quaternion;
use crate::spatial::{self, Rotation};
use crate::tree::{Branch, Tree};
use bksim_model::{
    Anchor, BodyId, CurveId, Joint, JointId, Model, MotionKind, PointId, Space, StateId, Vector,
    free_motion_names,
};

/// Four coordinates that are the quaternion of a body's turning against its parent in the tree.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Turning {
    /// The body that turns.
    pub body: BodyId,
    /// Index of the first of the coordinates.
    pub first: usize,
    /// Successor against predecessor.
    pub quaternion: Quaternion,
}

/// The purpose of the coordinates.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Form {
    /// To be integrated.
    Motion,
    /// Questions about positions alone.
    Positions,
    /// To find a start.
    Start,
}

/// Positions of all bodies as functions of the coordinates of one tree.
#[derive(Clone, Debug)]
pub struct Kinematics {
    /// In the order of the tree.
    pub coordinates: Vec<Coordinate>,
    /// The quaternions among them, in the order of the tree.
    pub turnings: Vec<Turning>,
    /// By body, the ground first.
    pub poses: Vec<Pose>,
    /// Index of the coordinate that each symbol of a value, or of a velocity, belongs to.
    of_value: HashMap<SymbolId, usize>,
    of_velocity: HashMap<SymbolId, usize>,
    /// Number of the first coordinate of each joint that has some.
    first_of_joint: HashMap<JointId, usize>,
    /// By number of the coordinate; empty but for reading.
    absolute: HashMap<usize, AbsoluteAngle>,
    /// By body, whether its orientation is that of its parent or of the ground, since nothing asks for it.
    particles: Vec<bool>,
    /// Names of parameters and coordinates.
    taken: HashSet<String>,
}

impl Kinematics {
    /// Kinematics ([`Kinematics::along`]) without the states, which have no part in positions.
    pub fn of_positions(model: &Model, tree: &Tree) -> Self {
        Self::chained(model, tree, Form::Positions)
    }

    /// Chains the poses along `tree`. Where a body turns about all axes and the author uses no angles of
    /// it, its coordinates are a quaternion.
    pub fn along(model: &Model, tree: &Tree) -> Self {
        Self::chained(model, tree, Form::Motion)
    }

    /// The shape that a start is looked for from: with a coordinate for each motion of a joint, but bodies
    /// that turn about all axes in the orientation that the start states.
    pub fn of_start(model: &Model, tree: &Tree) -> Self {
        Self::chained(model, tree, Form::Start)
    }

    fn chained(model: &Model, tree: &Tree, form: Form) -> Self {
        let pool = &model.pool;
        let ground = Pose {
            anchor_body: spatial::zero(pool),
            anchor_world: spatial::zero(pool),
            rotation: Rotation::default(),
            omega: spatial::zero(pool),
        };
        let mut kinematics = Self {
            coordinates: Vec::new(),
            turnings: Vec::new(),
            poses: vec![ground; model.bodies.len()],
            // Where masses have no part, everything turns.
            particles: match form {
                Form::Positions => vec![false; model.bodies.len()],
                Form::Motion | Form::Start => particles(model),
            },
            of_value: HashMap::new(),
            of_velocity: HashMap::new(),
            first_of_joint: HashMap::new(),
            absolute: HashMap::new(),
            taken: {
                let held = model.held.iter().map(|signal| &signal.name);
                model.parameters.iter().map(|p| &p.name).chain(held).cloned().collect()
            },
        };
        for &(body, branch) in &tree.branches {
            // Shapes come before their beam: another joint may carry it by its far end.
            for id in bending::shapes(model, body) {
                let joint = &model.joints[id.0];
                let kind = joint.kind.motions()[0].into();
                let owner = Owner::Joint(id, 0);
                kinematics.add_coordinate(model, joint.coordinate_name(0), kind, owner);
            }
            let pose = match branch {
                Branch::Free => kinematics.free_pose(model, body, form),
                Branch::Joint { joint, parent, reversed } => {
                    kinematics.tree_pose(model, body, joint, (parent, reversed), form)
                }
            };
            kinematics.poses[body.0] = pose;
        }
        for &id in &tree.cuts {
            let joint = &model.joints[id.0];
            if joint.kind.curve().is_some() {
                let motions = joint::motions(pool, joint);
                for idx in 0..motions.len() {
                    let name = joint.coordinate_name(idx);
                    let owner = Owner::Joint(id, idx);
                    kinematics.add_coordinate(model, name, CoordinateKind::Angle, owner);
                }
            }
        }
        if form == Form::Motion {
            for (idx, state) in model.states.iter().enumerate() {
                kinematics.add_state(model, state, StateId(idx));
            }
        }
        kinematics
    }

    /// The world position of a body's point; `None` is its centre of mass.
    pub fn position(&self, model: &Model, body: BodyId, point: Option<PointId>) -> Vector {
        let p_body = match point {
            Some(_) => self.in_body(model, Anchor { body, point }),
            None => model.bodies[body.0].com,
        };
        self.poses[body.0].position(&model.pool, &p_body)
    }

    /// The world position of an anchor; without a point, the origin of the body frame.
    pub fn anchor(&self, model: &Model, anchor: Anchor) -> Vector {
        self.poses[anchor.body.0].position(&model.pool, &self.in_body(model, anchor))
    }

    /// The pose of a body, turned into the frame of one of its points.
    pub(crate) fn frame(&self, model: &Model, anchor: Anchor) -> Pose {
        self.framed(model, anchor, &self.turned(model, anchor))
    }

    /// The pose of a body, turned into a frame of its own at an anchor.
    fn framed(&self, model: &Model, anchor: Anchor, r_body_from_frame: &Rotation) -> Pose {
        let (pool, pose) = (&model.pool, &self.poses[anchor.body.0]);
        let mut framed = pose.with_axes(pool, r_body_from_frame);
        let turning = self.turning(model, anchor, &pose.rotation);
        framed.omega = spatial::add(pool, &framed.omega, &turning);
        framed
    }

    /// The rotations r_body_from_frame of the frames that a joint has on its two bodies.
    fn orientations(&self, model: &Model, joint: &Joint) -> [Rotation; 2] {
        let pool = &model.pool;
        let [predecessor, successor] =
            [joint.predecessor, joint.successor].map(|anchor| self.turned(model, anchor));
        [predecessor, successor.then(pool, &spatial::turned(pool, &joint.alignment))]
    }

    /// The two sides of a joint.
    pub fn sides(&self, model: &Model, joint: &Joint) -> Sides {
        Sides {
            predecessor: self.frame(model, joint.predecessor),
            successor: self.framed(model, joint.successor, &self.orientations(model, joint)[1]),
            p_world_predecessor: self.anchor(model, joint.predecessor),
            p_world_successor: self.anchor(model, joint.successor),
            on_curve: joint.kind.curve().and_then(|curve| self.on_curve(model, joint, (0, curve))),
            on_second: {
                let second = joint.kind.second_curve();
                second.and_then(|curve| self.on_curve(model, joint, (1, curve)))
            },
        }
    }

    /// The place of a joint on the curve whose parameter is its coordinate of this number.
    fn on_curve(
        &self,
        model: &Model,
        joint: &Joint,
        (number, curve): (usize, CurveId),
    ) -> Option<OnCurve> {
        let id = model.joints.iter().position(|of| of.name == joint.name).map(JointId)?;
        let pool = &model.pool;
        let curve = &model.curves[curve.0];
        let parameter = self.coordinates.get(self.first_of_joint.get(&id)? + number)?.q;
        let parameter = pool.symbol_expr(parameter);
        let here = |e: Expr| pool.substitute(e, &[(curve.parameter, parameter)]);
        let by_parameter = |path: &Vector| path.map(|e| pool.diff(e, curve.parameter));
        let mut path = curve.position;
        let mut to_left = joint.kind.roller().unwrap_or(pool.zero());
        if !joint.kind.is_touch() && joint.kind.roller().is_none() {
            let roller = curve.cam.as_ref().and_then(|cam| cam.roller);
            if let Some((pitch, radius)) = curve.pitch(pool).zip(roller) {
                path = pitch;
                to_left = if joint.kind.lifts() == Some(false) { pool.neg(radius) } else { radius };
            }
        }
        // The centre of a roller is across the tangent.
        if let Some(distance) = joint.kind.roller() {
            let [x, y, _] = by_parameter(&path);
            let length = pool.sqrt(pool.add(pool.powi(x, 2), pool.powi(y, 2)));
            let left = [pool.neg(pool.div(y, length)), pool.div(x, length), pool.zero()];
            path = spatial::add(pool, &path, &spatial::scale(pool, distance, &left));
        }
        let arc = joint.kind.rolled_arcs().map(|arcs| here(arcs[number]));
        let [offset, tangent] = [path, by_parameter(&path)].map(|vector| vector.map(here));
        Some(OnCurve { offset, tangent, arc, left: to_left })
    }

    /// Lengths along the curves of a joint, as expressions of their parameters, at the place where it is.
    pub(crate) fn lengths_along(&self, model: &Model, id: JointId, arcs: [Expr; 2]) -> [Expr; 2] {
        let pool = &model.pool;
        let kind = &model.joints[id.0].kind;
        let curves = [kind.curve(), kind.second_curve()];
        let here = |number: usize| {
            let curve = &model.curves[curves[number]?.0];
            let at = self.coordinates.get(self.first_of_joint.get(&id)? + number)?.q;
            Some(pool.substitute(arcs[number], &[(curve.parameter, pool.symbol_expr(at))]))
        };
        [0, 1].map(|number| here(number).unwrap_or(pool.zero()))
    }

    /// The coordinates whose value or velocity occurs in some expressions, ascending.
    pub fn coordinates_in(&self, pool: &Pool, roots: &[Expr]) -> Vec<usize> {
        let symbols = roots.iter().flat_map(|&e| pool.symbols_of(e));
        let of = |symbol| self.of_value.get(&symbol).or_else(|| self.of_velocity.get(&symbol));
        let mut found: Vec<usize> = symbols.filter_map(|symbol| of(symbol).copied()).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Coordinates that are three angles in sequence, which have a pole where the second is ±90°.
    pub fn sequences(&self) -> Vec<[usize; 3]> {
        let owner = |i: usize| match self.coordinates[i] {
            Coordinate { kind: CoordinateKind::Angle, owner: Owner::Joint(joint, _), .. } => {
                Some((Some(joint), None))
            }
            Coordinate { kind: CoordinateKind::Angle, owner: Owner::Body(body, _), .. } => {
                Some((None, Some(body)))
            }
            _ => None,
        };
        let is_one = |i: &usize| owner(*i).is_some() && (1..3).all(|k| owner(i + k) == owner(*i));
        let firsts = (0..self.coordinates.len().saturating_sub(2)).filter(is_one);
        firsts.map(|i| [i, i + 1, i + 2]).collect()
    }

    /// d/dt of an expression of the coordinates and of time; velocities rest.
    pub fn rate(&self, model: &Model, e: Expr) -> Expr {
        let pool = &model.pool;
        let moving = self.coordinates_in(pool, &[e]).into_iter().map(|i| &self.coordinates[i]);
        let rates = moving.map(|c| (c.q, pool.symbol_expr(c.v)));
        pool.total_derivative(e, &rates.chain([(model.time, pool.one())]).collect::<Vec<_>>())
    }

    /// d/dt of an expression of the coordinates, the velocities and time.
    pub fn second_rate(&self, model: &Model, e: Expr) -> Expr {
        let pool = &model.pool;
        let moving = self.coordinates_in(pool, &[e]).into_iter().map(|i| &self.coordinates[i]);
        let rates = moving
            .flat_map(|c| [(c.q, pool.symbol_expr(c.v)), (c.v, pool.symbol_expr(c.a))])
            .chain([(model.time, pool.one())]);
        pool.total_derivative(e, &rates.collect::<Vec<_>>())
    }

    /// The positions of a joint's motions: its own coordinates in the tree, else what the poses show.
    pub fn joint_positions(&self, model: &Model, joint: JointId) -> Vec<Expr> {
        let mut own = Vec::new();
        if let Some(&first) = self.first_of_joint.get(&joint) {
            let is_own = |i: &usize| matches!(self.coordinates[*i].owner, Owner::Joint(id, _) if id == joint);
            let all = (first..self.coordinates.len()).take_while(is_own);
            own = all.map(|i| self.of_motion(&model.pool, i)).collect();
        }
        let joint = &model.joints[joint.0];
        if own.len() < joint.kind.motions().len() {
            // A quaternion stands in the place of the angles.
            let shown = joint::positions(&model.pool, joint, &self.sides(model, joint));
            own.extend(shown.into_iter().skip(own.len()));
        }
        own
    }

    /// True where a position of a joint is an angle that is no coordinate and is read within ±180°: it jumps there.
    pub fn is_within_turn(&self, model: &Model, joint: JointId, motion_idx: usize) -> bool {
        let own = |c: &Coordinate| matches!(c.owner, Owner::Joint(id, idx) if (id, idx) == (joint, motion_idx));
        let of = &model.joints[joint.0];
        of.kind.motions().get(motion_idx) == Some(&MotionKind::Rotation)
            && !self.coordinates.iter().any(own)
            && joint::angles_are_within_turn(&model.pool, of, &self.sides(model, of))
    }

    /// True where a joint has coordinates of its own.
    pub fn has_coordinates(&self, joint: JointId) -> bool {
        self.first_of_joint.contains_key(&joint)
    }

    /// Coordinates of a free body: its centre of mass, then its angle (planar), a quaternion or Cardan
    /// angles.
    fn free_pose(&mut self, model: &Model, body: BodyId, form: Form) -> Pose {
        let pool = &model.pool;
        let own = &model.bodies[body.0];
        let n_free = free_motion_names(model.space).len();
        let n_translations = if model.space == Space::Planar { 2 } else { 3 };
        let names_angles = own.coordinate_names.len() > n_translations;
        let has_quaternion = model.space == Space::Spatial && !names_angles;
        let mut anchor_world = spatial::zero(pool);
        let mut rotation = Rotation::default();
        let mut omega = spatial::zero(pool);
        let n_motions = if self.particles[body.0] { n_translations } else { n_free };
        for motion_idx in 0..n_motions {
            let name = own.coordinate_name(model.space, motion_idx);
            let is_translation = motion_idx < n_translations;
            if !is_translation {
                match form {
                    Form::Motion | Form::Positions if has_quaternion => {
                        (rotation, omega) = self.add_quaternion(model, &own.name, body);
                        break;
                    }
                    Form::Start if let Some(stated) = stated_orientation(model, body) => {
                        rotation = stated;
                        break;
                    }
                    _ => {}
                }
            }
            let kind = if is_translation { MotionKind::Translation } else { MotionKind::Rotation };
            let owner = Owner::Body(body, motion_idx);
            let (q, v) = self.add_coordinate(model, name, kind.into(), owner);
            if is_translation {
                anchor_world[motion_idx] = q;
                continue;
            }
            let mut axis = spatial::zero(pool);
            let axis_idx = if n_free == 3 { 2 } else { motion_idx - n_translations };
            axis[axis_idx] = pool.one();
            // The turn is about the axis as the turns before it have turned it.
            let axis_world = rotation.apply(pool, &axis);
            omega = spatial::add(pool, &omega, &spatial::scale(pool, v, &axis_world));
            rotation = rotation.then(pool, &Rotation::about(pool, &axis, q));
        }
        Pose { anchor_body: own.com, anchor_world, rotation, omega }
    }

    /// Pose of a body on `parent` in the tree, by a joint whose motions become coordinates.
    fn tree_pose(
        &mut self,
        model: &Model,
        body: BodyId,
        joint_id: JointId,
        (parent, reversed): (BodyId, bool),
        form: Form,
    ) -> Pose {
        let pool = &model.pool;
        let joint = &model.joints[joint_id.0];
        let parent_pose = &self.poses[parent.0];
        let [of_predecessor, of_successor] = self.orientations(model, joint);
        let (near, far, r_near, r_far) = if reversed {
            (joint.successor, joint.predecessor, of_successor, of_predecessor)
        } else {
            (joint.predecessor, joint.successor, of_predecessor, of_successor)
        };
        let p_world_near = parent_pose.position(pool, &self.in_body(model, near));
        let turning_near = self.turning(model, near, &parent_pose.rotation);
        let r_world_from_near = parent_pose.rotation.then(pool, &r_near);

        // The motion of the successor against the predecessor, one coordinate after the other.
        let mut rotation = joint::fixed_turn(pool, joint);
        let mut offset = spatial::zero(pool);
        let mut omega = spatial::zero(pool);
        let motions = joint::motions(pool, joint);
        for (motion_idx, motion) in motions.iter().enumerate() {
            if motion.kind == MotionKind::Rotation && self.particles[body.0] {
                break;
            }
            if motion.kind == MotionKind::Rotation && joint.kind.turns_freely() {
                match form {
                    Form::Motion | Form::Positions if turns_by_quaternion(model, joint_id) => {
                        (rotation, omega) = self.add_quaternion(model, &joint.name, body);
                        break;
                    }
                    Form::Start if let Some(stated) = stated_orientation(model, body) => {
                        let far = stated.then(pool, &r_far);
                        let turned = r_world_from_near.inverse(pool).then(pool, &far);
                        rotation = if reversed { turned.inverse(pool) } else { turned };
                        break;
                    }
                    _ => {}
                }
            }
            let name = joint.coordinate_name(motion_idx);
            let owner = Owner::Joint(joint_id, motion_idx);
            let (q, v) = self.add_coordinate(model, name, motion.kind.into(), owner);
            match motion.kind {
                MotionKind::Translation => {
                    let along = spatial::scale(pool, q, &motion.axis);
                    offset = spatial::add(pool, &offset, &along);
                }
                MotionKind::Rotation => {
                    if let Some(pitch) = motion.pitch {
                        let along = spatial::scale(pool, pool.mul(pitch, q), &motion.axis);
                        offset = spatial::add(pool, &offset, &along);
                    }
                    // The turns before it have turned its axis.
                    let axis = rotation.apply(pool, &motion.axis);
                    omega = spatial::add(pool, &omega, &spatial::scale(pool, v, &axis));
                    rotation = rotation.then(pool, &Rotation::about(pool, &motion.axis, q));
                }
            }
        }

        // Seen from the successor, the same motion runs backwards.
        let r_world_from_far = if reversed {
            r_world_from_near.then(pool, &rotation.inverse(pool))
        } else {
            r_world_from_near.then(pool, &rotation)
        };
        let r_world_from_body = r_world_from_far.then(pool, &r_far.inverse(pool));
        // Offset and relative angular velocity have their components in the predecessor's frame.
        let r_world_from_predecessor =
            if reversed { &r_world_from_far } else { &r_world_from_near };
        let offset_world = r_world_from_predecessor.apply(pool, &offset);
        let omega_world = r_world_from_predecessor.apply(pool, &omega);
        let omega_near = spatial::add(pool, &self.poses[parent.0].omega, &turning_near);
        let (anchor_world, omega) = if reversed {
            let back = spatial::sub(pool, &p_world_near, &offset_world);
            (back, spatial::sub(pool, &omega_near, &omega_world))
        } else {
            let out = spatial::add(pool, &p_world_near, &offset_world);
            (out, spatial::add(pool, &omega_near, &omega_world))
        };
        debug_assert_eq!(far.body, body);
        let turning_far = self.turning(model, far, &r_world_from_body);
        let omega = spatial::sub(pool, &omega, &turning_far);
        let anchor_body = self.in_body(model, far);
        Pose { anchor_body, anchor_world, rotation: r_world_from_body, omega }
    }
}

/// The orientation of a body that the start states or guesses, world from body.
fn stated_orientation(model: &Model, body: BodyId) -> Option<Rotation> {
    let stated = model.orientations.iter().find(|stated| stated.body == body)?;
    Some(spatial::turned(&model.pool, &stated.turns))
}
