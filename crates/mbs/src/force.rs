//! Force laws: every load as the wrenches it puts on bodies and, when conservative, its potential.
//!
//! A load is conservative here when its law depends on parameters and positions alone in the way
//! the law itself says (gravity, springs). Everything else enters as generalised force.

use bksim_expr::{Expr, Pool, SymbolId};

use crate::joint;
use crate::kinematics::Kinematics;
use crate::spatial;
use bksim_model::MotionKind;
use bksim_model::{Anchor, BodyId, GROUND, JointId, LoadKind, Model, Vector};

/// A force and a moment on one body, world axes.
#[derive(Clone, Debug)]
pub struct Wrench {
    /// The body that it acts on.
    pub body: BodyId,
    /// N.
    pub force: Vector,
    /// Where the force acts, m.
    pub at: Vector,
    /// N m, beside the moment of the force.
    pub moment: Vector,
}

/// What one load does.
#[derive(Clone, Debug, Default)]
pub struct Action {
    /// V, J, when the load has one.
    pub potential: Option<Expr>,
    /// The wrenches that −∂V/∂q already stands for in the equations of motion.
    pub conservative: Vec<Wrench>,
    /// All other wrenches; they enter as generalised forces.
    pub applied: Vec<Wrench>,
}

impl Action {
    fn new(potential: Option<Expr>, elastic: Vec<Wrench>, viscous: Vec<Wrench>) -> Self {
        match potential {
            Some(_) => Self { potential, conservative: elastic, applied: viscous },
            None => Self { applied: [elastic, viscous].concat(), ..Self::default() },
        }
    }
}

/// The action of one load; `signals` says what each signal symbol stands for.
pub fn action(
    model: &Model,
    kinematics: &Kinematics,
    signals: &[(SymbolId, Expr)],
    kind: &LoadKind,
) -> Action {
    let law = Law { model, pool: &model.pool, kinematics, signals };
    match kind {
        LoadKind::Gravity { acceleration } => law.gravity(acceleration),
        LoadKind::Force { on, vector, follows_body } => law.force(*on, vector, *follows_body),
        LoadKind::ForceBetween { a, b, value } => law.force_between(*a, *b, *value),
        LoadKind::Torque { on, from, vector } => law.torque(*on, *from, vector),
        LoadKind::Spring { a, b, stiffness, length, damping } => {
            law.spring(*a, *b, *stiffness, *length, *damping)
        }
        LoadKind::Torsion { joint, stiffness, angle, damping } => {
            law.torsion(*joint, *stiffness, *angle, *damping)
        }
        // Rows with multipliers of their own: see `switch`.
        LoadKind::Stop { .. } | LoadKind::Friction { .. } => Action::default(),
    }
}

struct Law<'a> {
    model: &'a Model,
    pool: &'a Pool,
    kinematics: &'a Kinematics,
    signals: &'a [(SymbolId, Expr)],
}

impl Law<'_> {
    /// V = −Σ m g · r_c.
    fn gravity(&self, acceleration: &Vector) -> Action {
        let pool = self.pool;
        let constant = acceleration.iter().all(|&g| self.is_constant(g));
        let acceleration = &acceleration.map(|g| self.resolved(g));
        let mut wrenches = Vec::new();
        let mut potential = Vec::new();
        for body_idx in 1..self.model.bodies.len() {
            let body = BodyId(body_idx);
            let mass = self.model.bodies[body_idx].mass;
            if pool.is_zero(mass) {
                continue;
            }
            let at = self.kinematics.place(self.model, body, None);
            let height = pool.neg(spatial::dot(pool, acceleration, &at));
            potential.push(pool.mul(mass, height));
            let force = spatial::scale(pool, mass, acceleration);
            wrenches.push(Wrench { body, force, at, moment: spatial::zero(pool) });
        }
        Action::new(constant.then(|| pool.sum(potential)), wrenches, Vec::new())
    }

    fn force(&self, on: Anchor, vector: &Vector, follows_body: bool) -> Action {
        let rotation = &self.kinematics.poses[on.body.0].rotation;
        let vector = vector.map(|component| self.resolved(component));
        let force = if follows_body { rotation.apply(self.pool, &vector) } else { vector };
        let at = self.kinematics.anchor(self.model, on);
        let moment = spatial::zero(self.pool);
        let wrench = Wrench { body: on.body, force, at, moment };
        Action { applied: vec![wrench], ..Action::default() }
    }

    fn torque(&self, on: BodyId, from: BodyId, vector: &Vector) -> Action {
        let vector = &vector.map(|component| self.resolved(component));
        let zero = spatial::zero(self.pool);
        let wrench = |body, moment| Wrench { body, force: zero, at: zero, moment };
        let mut wrenches = vec![wrench(on, *vector)];
        if from != GROUND {
            wrenches.push(wrench(from, spatial::neg(self.pool, vector)));
        }
        Action { applied: wrenches, ..Action::default() }
    }

    fn force_between(&self, a: Anchor, b: Anchor, value: Expr) -> Action {
        let (_, direction) = self.line(a, b);
        let applied = self.push_apart(a, b, self.resolved(value), &direction);
        Action { applied, ..Action::default() }
    }

    /// V = ½ k (l − l₀)²; the damper pulls with −c l′.
    fn spring(&self, a: Anchor, b: Anchor, stiffness: Expr, length: Expr, damping: Expr) -> Action {
        let pool = self.pool;
        let has_potential =
            !pool.is_zero(stiffness) && self.is_constant(stiffness) && self.is_constant(length);
        let [stiffness, length, damping] = [stiffness, length, damping].map(|e| self.resolved(e));
        let (distance, direction) = self.line(a, b);
        let stretch = pool.sub(distance, length);
        let elastic = pool.neg(pool.mul(stiffness, stretch));
        let viscous = pool.neg(pool.mul(damping, self.kinematics.rate(self.model, distance)));
        let pair = |value| {
            if pool.is_zero(value) {
                return Vec::new();
            }
            self.push_apart(a, b, value, &direction)
        };
        let potential = has_potential.then(|| self.half_square(stiffness, stretch));
        Action::new(potential, pair(elastic), pair(viscous))
    }

    /// V = ½ k (θ − θ₀)² about the joint's rotation.
    fn torsion(&self, joint_id: JointId, stiffness: Expr, angle: Expr, damping: Expr) -> Action {
        let pool = self.pool;
        let joint = &self.model.joints[joint_id.0];
        let motions = joint::motions(pool, joint);
        let Some(motion_idx) = motions.iter().position(|m| m.kind == MotionKind::Rotation) else {
            return Action::default();
        };
        let has_potential =
            !pool.is_zero(stiffness) && self.is_constant(stiffness) && self.is_constant(angle);
        let [stiffness, angle, damping] = [stiffness, angle, damping].map(|e| self.resolved(e));
        let position = self.kinematics.joint_positions(self.model, joint_id)[motion_idx];
        let twist = pool.sub(position, angle);
        let elastic = pool.neg(pool.mul(stiffness, twist));
        let viscous = pool.neg(pool.mul(damping, self.kinematics.rate(self.model, position)));
        let sides = self.kinematics.sides(self.model, joint);
        let (_, axis) = joint::effort(pool, motions[motion_idx], &sides);
        let back = spatial::neg(pool, &axis);
        let zero = spatial::zero(pool);
        let turn = |body, torque, axis: &Vector| {
            let moment = spatial::scale(pool, torque, axis);
            Wrench { body, force: zero, at: zero, moment }
        };
        let pair = |torque| {
            if pool.is_zero(torque) {
                return Vec::new();
            }
            vec![
                turn(joint.successor.body, torque, &axis),
                turn(joint.predecessor.body, torque, &back),
            ]
        };
        let potential = has_potential.then(|| self.half_square(stiffness, twist));
        Action::new(potential, pair(elastic), pair(viscous))
    }

    /// Distance of two points and the unit vector from the first to the second.
    fn line(&self, a: Anchor, b: Anchor) -> (Expr, Vector) {
        let pool = self.pool;
        let p_a = self.kinematics.anchor(self.model, a);
        let p_b = self.kinematics.anchor(self.model, b);
        let d = spatial::sub(pool, &p_b, &p_a);
        let distance = pool.sqrt(pool.simplify(spatial::dot(pool, &d, &d)));
        (distance, spatial::scale(pool, pool.div(pool.one(), distance), &d))
    }

    fn push_apart(&self, a: Anchor, b: Anchor, value: Expr, direction: &Vector) -> Vec<Wrench> {
        let pool = self.pool;
        let end = |anchor: Anchor, force| Wrench {
            body: anchor.body,
            force,
            at: self.kinematics.anchor(self.model, anchor),
            moment: spatial::zero(pool),
        };
        let force = spatial::scale(pool, value, direction);
        vec![end(a, spatial::neg(pool, &force)), end(b, force)]
    }

    fn half_square(&self, factor: Expr, e: Expr) -> Expr {
        let pool = self.pool;
        pool.product([pool.rational(1, 2), factor, pool.powi(e, 2)])
    }

    /// The expression with its signals replaced by what they measure.
    fn resolved(&self, e: Expr) -> Expr {
        self.pool.substitute(e, self.signals)
    }

    /// Depends on parameters only: neither on time nor on a signal.
    fn is_constant(&self, e: Expr) -> bool {
        let pool = self.pool;
        !pool.depends_on(e, self.model.time)
            && !self.model.signals.iter().any(|signal| pool.depends_on(e, signal.symbol))
    }
}
