//! Force laws: every load as the wrenches it puts on bodies and, when conservative, its potential.
//!
//! A load is conservative here when its law depends on parameters and positions alone in the way
//! the law itself says (gravity, springs). Everything else enters as generalised force.
//!
//! Each law has a file with one function, `action`; the table [`action`] leads from a load to it.

mod context;
mod force_between;
mod gravity;
mod joint_effort;
mod joint_spring;
mod point_force;
mod spring;
mod torque;

use std::ops::Range;

use bksim_expr::{Expr, Pool, SymbolId};

use crate::joint::JointWrench;
use crate::kinematics::Kinematics;
use crate::kinematics::bending;
use crate::spatial;
use bksim_model::{BodyId, JointId, LinePart, Load, LoadKind, Model, Vector};

use context::Context;

/// A force and a moment on one body, world axes.
#[derive(Clone, Debug)]
pub struct Wrench {
    /// The body that it acts on.
    pub body: BodyId,
    /// N.
    pub force: Vector,
    /// World position of the point at which the force acts, m.
    pub at: Vector,
    /// N m, in addition to the moment of the force.
    pub moment: Vector,
}

impl Wrench {
    /// The wrench of a joint whose joint point is `at`, on one of its bodies.
    pub(crate) fn at_joint(body: BodyId, at: Vector, wrench: &JointWrench) -> Self {
        Self { body, force: wrench.force, at, moment: wrench.moment }
    }

    /// A wrench through a joint: on its successor, and its opposite on the predecessor, both at the
    /// successor's joint point.
    pub(crate) fn through_joint(
        model: &Model,
        kinematics: &Kinematics,
        joint: JointId,
        wrench: &JointWrench,
    ) -> Vec<Self> {
        let joint = &model.joints[joint.0];
        let at = kinematics.anchor(model, joint.successor);
        let opposite = wrench.reversed(&model.pool);
        let [predecessor, successor] = bending::bearers(model, joint);
        vec![Self::at_joint(successor, at, wrench), Self::at_joint(predecessor, at, &opposite)]
    }

    /// Wrenches of both bodies, each at the joint point of its own body, as generalised forces of loads need it.
    pub(crate) fn within_joint(
        model: &Model,
        kinematics: &Kinematics,
        joint: JointId,
        wrench: &JointWrench,
    ) -> Vec<Self> {
        let pool = &model.pool;
        let joint = &model.joints[joint.0];
        let [from, to] =
            [joint.predecessor, joint.successor].map(|end| kinematics.anchor(model, end));
        let mut opposite = wrench.reversed(pool);
        let arm = spatial::sub(pool, &to, &from);
        let turning = spatial::cross(pool, &arm, &opposite.force);
        opposite.moment = spatial::add(pool, &opposite.moment, &turning);
        let [predecessor, successor] = bending::bearers(model, joint);
        vec![Self::at_joint(successor, to, wrench), Self::at_joint(predecessor, from, &opposite)]
    }

    /// `factor` times the wrench.
    pub(crate) fn scaled(&self, pool: &Pool, factor: Expr) -> Self {
        let scaled = |part: &Vector| spatial::scale(pool, factor, part);
        Self { force: scaled(&self.force), moment: scaled(&self.moment), ..self.clone() }
    }
}

/// The efforts of loads on the parameters of curves, each with the joint that follows it and the
/// number of its motion.
pub(crate) fn efforts_on_curves(
    model: &Model,
    kinematics: &Kinematics,
    signals: &[(SymbolId, Expr)],
) -> Vec<(JointId, usize, Expr)> {
    let loads = model.loads.iter();
    loads.filter_map(|load| effort_on_curve(model, kinematics, signals, load)).collect()
}

/// That of one load.
pub(crate) fn effort_on_curve(
    model: &Model,
    kinematics: &Kinematics,
    signals: &[(SymbolId, Expr)],
    load: &Load,
) -> Option<(JointId, usize, Expr)> {
    let context = &Context { model, pool: &model.pool, kinematics, signals };
    let spring = joint_spring::effort_on_curve(context, load);
    spring.or_else(|| joint_effort::effort_on_curve(context, load))
}

/// A force that pushes two points apart.
///
/// Its power is value · (distance)′, so its generalised force is value · ∂(distance)/∂q: products of the same few
/// factors for every coordinate.
#[derive(Clone, Copy, Debug)]
pub struct AlongLine {
    /// Distance of the points, m.
    pub distance: Expr,
    /// Force on each away from the other, N.
    pub value: Expr,
}

/// The effect of one load.
#[derive(Clone, Debug, Default)]
pub struct Action {
    /// V, J, when the load has one.
    pub potential: Option<Expr>,
    /// The acceleration, m/s², of the uniform field that has this potential, when it is one.
    pub field: Option<Vector>,
    /// The wrenches that −∂V/∂q already stands for in the equations of motion.
    pub conservative: Vec<Wrench>,
    /// All other wrenches; they enter as generalised forces.
    pub applied: Vec<Wrench>,
    /// The force that these others are together, if it pushes two points apart.
    pub line: Option<AlongLine>,
}

impl Action {
    /// A load without a potential.
    fn of_applied(applied: Vec<Wrench>) -> Self {
        Self { applied, ..Self::default() }
    }

    /// An elastic part, which has the potential if there is one, and a viscous part.
    fn of_parts(potential: Option<Expr>, elastic: Vec<Wrench>, viscous: Vec<Wrench>) -> Self {
        match potential {
            Some(_) => {
                Self { potential, conservative: elastic, applied: viscous, ..Self::default() }
            }
            None => Self::of_applied([elastic, viscous].concat()),
        }
    }
}

/// A quantity of a spring, damper or force between two points; `None` of other loads. `signals` as in [`action`].
pub(crate) fn part_of_line(
    model: &Model,
    kinematics: &Kinematics,
    signals: &[(SymbolId, Expr)],
    kind: &LoadKind,
    part: LinePart,
) -> Option<Expr> {
    let pool = &model.pool;
    let context = &Context { model, pool, kinematics, signals };
    let (distance, _) = context.line(kind.ends()?);
    let rate = || kinematics.rate(model, distance);
    Some(match (part, kind.spring()) {
        (LinePart::Length, _) => distance,
        (LinePart::Rate, _) => rate(),
        (LinePart::Force, Some(law)) => {
            let [stiffness, length, damping] = law.map(|e| context.resolved(e));
            let elastic = pool.mul(stiffness, pool.sub(distance, length));
            if pool.is_zero(damping) {
                return Some(elastic);
            }
            pool.add(elastic, pool.mul(damping, rate()))
        }
        (LinePart::Force, None) => pool.neg(context.resolved(kind.stated_effort()?)),
    })
}

/// The effects of all loads of a model.
#[derive(Clone, Debug)]
pub struct Loads {
    /// The acceleration, m/s², of the uniform fields that have a potential.
    pub field: Vector,
    /// The terms of V, J.
    pub potentials: Vec<Expr>,
    /// The terms of V, J, that belong to no uniform field.
    pub without_field: Vec<Expr>,
    /// The wrenches that −∂V/∂q stands for.
    pub conservative: Vec<Wrench>,
    /// All other wrenches.
    pub applied: Vec<Wrench>,
    /// Forces along lines, each with the range of its wrenches among the applied ones.
    pub lines: Vec<(Range<usize>, AlongLine)>,
}

impl Loads {
    /// The effects of all loads of `model`; `signals` as in [`action`].
    pub fn of(model: &Model, kinematics: &Kinematics, signals: &[(SymbolId, Expr)]) -> Self {
        let pool = &model.pool;
        let mut loads = Self {
            field: spatial::zero(pool),
            potentials: Vec::new(),
            without_field: Vec::new(),
            conservative: Vec::new(),
            applied: Vec::new(),
            lines: Vec::new(),
        };
        for load in &model.loads {
            let Action { potential, field, conservative, applied, line } =
                action(model, kinematics, signals, &load.kind);
            loads.potentials.extend(potential);
            match field {
                Some(acceleration) => loads.field = spatial::add(pool, &loads.field, &acceleration),
                None => loads.without_field.extend(potential),
            }
            loads.conservative.extend(conservative);
            let first = loads.applied.len();
            loads.applied.extend(applied);
            loads.lines.extend(line.map(|line| (first..loads.applied.len(), line)));
        }
        loads
    }
}

/// The action of one load; `signals` holds the expression that each signal symbol stands for.
pub fn action(
    model: &Model,
    kinematics: &Kinematics,
    signals: &[(SymbolId, Expr)],
    kind: &LoadKind,
) -> Action {
    let context = &Context { model, pool: &model.pool, kinematics, signals };
    match kind {
        LoadKind::Gravity { acceleration } => gravity::action(context, acceleration),
        LoadKind::Force { on, vector, follows_body } => {
            point_force::action(context, *on, vector, *follows_body)
        }
        LoadKind::ForceBetween { a, b, value } => force_between::action(context, *a, *b, *value),
        LoadKind::Torque { on, from, vector } => torque::action(context, *on, *from, vector),
        LoadKind::Spring { a, b, stiffness, length, damping } => {
            spring::action(context, [*a, *b], *stiffness, *length, *damping)
        }
        LoadKind::Effort { joint, motion_idx, value } => {
            joint_effort::action(context, (*joint, *motion_idx), *value)
        }
        LoadKind::JointSpring { joint, motion_idx, stiffness, unloaded, damping } => {
            joint_spring::action(context, (*joint, *motion_idx), *stiffness, *unloaded, *damping)
        }
        // Rows with multipliers of their own: see `contact`. Teeth that give: see `mesh`.
        LoadKind::Stop { .. }
        | LoadKind::Mesh { .. }
        | LoadKind::Rope { .. }
        | LoadKind::Touch { .. }
        | LoadKind::Rub { .. }
        | LoadKind::Flank { .. }
        | LoadKind::Capstan { .. }
        | LoadKind::Friction { .. } => Action::default(),
    }
}

/// The terms of Σ F · ∂v/∂q̇_i + M · ∂ω/∂q̇_i, by coordinate, with the velocity of the body where the force acts,
/// which need not be a point of it.
pub(crate) fn powers(
    model: &Model,
    kinematics: &Kinematics,
    wrenches: &[Wrench],
) -> Vec<Vec<Expr>> {
    let pool = &model.pool;
    let mut powers = vec![Vec::new(); kinematics.coordinates.len()];
    for wrench in wrenches {
        let pose = &kinematics.poses[wrench.body.0];
        let arm = spatial::sub(pool, &wrench.at, &pose.anchor_world);
        for i in kinematics.coordinates_in(pool, &[pose.anchor_world, pose.omega].concat()) {
            let coordinate = &kinematics.coordinates[i];
            let turn = pose.omega.map(|component| pool.diff(component, coordinate.v));
            let anchor = pose.anchor_world.map(|component| pool.diff(component, coordinate.q));
            let at = spatial::add(pool, &anchor, &spatial::cross(pool, &turn, &arm));
            powers[i].push(pool.add(
                spatial::dot(pool, &wrench.force, &at),
                spatial::dot(pool, &wrench.moment, &turn),
            ));
        }
    }
    powers
}
