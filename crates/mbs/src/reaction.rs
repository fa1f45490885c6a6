//! Joint reactions by Newton and Euler: the wrench of each joint's predecessor on its successor.
//!
//! A cut joint's reaction is read off its multipliers. A tree joint carries what its body needs
//! beyond all other wrenches on it, found from the leaves of the tree inwards:
//!
//! ```text
//! F = m r̈_c − Σ F_k,      M_c = d/dt (A I′ Aᵀ ω) − Σ M_k − Σ (r_k − r_c) × F_k
//! ```
//!
//! Drive efforts and the loads inside a joint are not part of its reaction, so the moment of a
//! revolute about its own axis is zero: a check that costs nothing. A cylinder transmits nothing else, so
//! its reaction is the whole force along it.

use bksim_expr::{Expr, Pool, SymbolId};

use crate::constraint::{Constraint, Source};
use crate::contact::slip_wrenches;
use crate::folding::short;
use crate::force::{self, Wrench};
use crate::inertia::angular_momentum;
use crate::joint::JointWrench;
use crate::kinematics::Kinematics;
use crate::kinematics::bending;
use crate::recursion::{self, BodyAcceleration};
use crate::rope;
use crate::rubbing::component_axis;
use crate::signal::signal_values;
use crate::spatial;
use crate::system::{Derivation, SymbolicSystem};
use crate::touch;
use crate::tree::{Branch, Tree};
use bksim_model::{BodyId, Frame, JointId, LoadId, Measure, Model, Signal, Vector};

/// Reaction on the successor of a joint at its joint point, world axes.
#[derive(Clone, Debug)]
pub struct Reaction {
    /// The joint.
    pub joint: JointId,
    /// N, an expression of t, q, v, a, λ.
    pub force: Vector,
    /// N m about the successor's joint point.
    pub moment: Vector,
}

impl Reaction {
    fn add(&mut self, pool: &Pool, wrench: &Wrench) {
        self.force = spatial::add(pool, &self.force, &wrench.force);
        self.moment = spatial::add(pool, &self.moment, &wrench.moment);
    }

    /// One of fx, fy, fz, mx, my, mz, along the axes of a frame.
    pub fn component(
        &self,
        model: &Model,
        kinematics: &Kinematics,
        frame: Frame,
        k: usize,
    ) -> Expr {
        let vector = if k < 3 { &self.force } else { &self.moment };
        let axis = component_axis(model, kinematics, (self.joint, frame), k % 3);
        spatial::dot(&model.pool, vector, &axis)
    }
}

/// The reactions of all joints, in file order.
pub fn reactions(model: &Model, system: &SymbolicSystem) -> Vec<Reaction> {
    let pool = &model.pool;
    let accelerations = match system.derivation {
        Derivation::Lagrange => None,
        Derivation::Recursion => {
            Some(recursion::body_accelerations(model, &system.tree, &system.kinematics))
        }
    };
    let wrenches = wrenches_by_body(model, system);
    let mut balance = Balance { model, pool, system, accelerations, wrenches };
    let nothing = |joint_idx| Reaction {
        joint: JointId(joint_idx),
        force: spatial::zero(pool),
        moment: spatial::zero(pool),
    };
    let mut reactions: Vec<Reaction> = (0..model.joints.len()).map(nothing).collect();

    // Cut joints, couplings, drives and contacts: each row's wrenches times its multiplier.
    for constraint in &system.constraints {
        let lambda = pool.symbol_expr(constraint.lambda);
        for (idx, wrench) in constraint.wrenches.iter().enumerate() {
            let wrench = wrench.scaled(pool, lambda);
            // The first is that on the joint's successor.
            if idx == 0
                && let Some(joint) = bearing(model, constraint.source)
            {
                reactions[joint.0].add(pool, &wrench);
            }
            balance.wrenches[wrench.body.0].push(wrench);
        }
    }

    // Forces along cylinders by friction that slides, springs and stated efforts.
    for contact in &system.contacts {
        let row = &system.constraints[contact.row];
        let Some(joint) = bearing(model, row.source) else { continue };
        let of_contact = slip_wrenches(model, std::slice::from_ref(contact), &system.constraints);
        of_contact.first().into_iter().for_each(|wrench| reactions[joint.0].add(pool, wrench));
    }
    let signals = signal_values(model, &system.kinematics);
    for load in &model.loads {
        let Some((joint, _)) = load.kind.joint_motion() else { continue };
        let action = force::action(model, &system.kinematics, &signals, &load.kind);
        let wrenches = [action.conservative, action.applied].concat().into_iter();
        let [_, on] = bending::bearers(model, &model.joints[joint.0]);
        if model.joints[joint.0].kind.is_cylinder() {
            wrenches.filter(|w| w.body == on).for_each(|w| reactions[joint.0].add(pool, &w));
        }
    }

    // Tree joints, leaves first; the cross-sections of a beam after all that hangs on them.
    for &(body, branch) in &leaves_first(model, &system.tree) {
        if let Branch::Joint { joint, reversed, .. } = branch {
            let missing = balance.missing_wrench(body, joint);
            // The body is the successor unless the joint is passed backwards.
            let wrench = if reversed { missing.reversed(pool) } else { missing };
            balance.pass_through(joint, &wrench);
            let JointWrench { force, moment } = wrench;
            reactions[joint.0] = Reaction { joint, force, moment };
        }
    }
    reactions
}

/// The branches of a tree, each after those that put wrenches on its body: what hangs on a cross-section of a beam before the
/// part that holds that section, and this before the beam itself.
fn leaves_first(model: &Model, tree: &Tree) -> Vec<(BodyId, Branch)> {
    let beam_of = |body: BodyId, branch: Branch| match branch {
        Branch::Joint { joint, .. } => {
            let root = model.joints[joint.0].predecessor.body;
            let beam = model.bodies[root.0].flexible.as_ref();
            beam.is_some_and(|beam| beam.has_part(body)).then_some(root)
        }
        Branch::Free => None,
    };
    let (mut sorted, mut waiting) = (Vec::new(), Vec::new());
    for &(body, branch) in tree.branches.iter().rev() {
        if beam_of(body, branch).is_some() {
            waiting.push((body, branch));
            continue;
        }
        let is_own = |of: &(BodyId, Branch)| beam_of(of.0, of.1) == Some(body);
        sorted.extend(waiting.iter().copied().filter(is_own));
        waiting.retain(|of| !is_own(of));
        sorted.push((body, branch));
    }
    sorted.extend(waiting);
    sorted
}

/// The symbols that stand for reactions and efforts of drives in named signals, with their values from the
/// reactions of all joints: expressions of t, q, v, a, λ.
pub fn reported(
    model: &Model,
    system: &SymbolicSystem,
    reactions: &[Reaction],
) -> Vec<(SymbolId, Expr)> {
    let value = |signal: &Signal| match signal.measure {
        Measure::Reaction(joint, frame, k) => {
            let component = reactions[joint.0].component(model, &system.kinematics, frame, k);
            Some(short(&model.pool, component))
        }
        measure => reported_force(model, system, measure),
    };
    let values = model.signals.iter().filter_map(|signal| Some((signal.symbol, value(signal)?)));
    values.collect()
}

/// An effort, a force of a coupling, or a quantity of a contact or of a load between two points as an expression of
/// t, q, v, λ; `None` of other measures.
pub fn reported_force(model: &Model, system: &SymbolicSystem, measure: Measure) -> Option<Expr> {
    let pool = &model.pool;
    match measure {
        Measure::Effort(drive) => {
            let row = system.constraints.iter().find(|row| row.source == Source::Drive(drive));
            Some(row.map_or(pool.zero(), |row| pool.symbol_expr(row.lambda)))
        }
        Measure::Force(idx) | Measure::Moment(idx) => {
            let name = &model.force_names[idx];
            let elastic = || {
                let mut sections = model.ropes.iter().flat_map(|rope| &rope.sections);
                let pull = sections.find(|section| section.name == *name)?.pull?;
                Some(pool.substitute(pull, &signal_values(model, &system.kinematics)))
            };
            Some(force_of(model, system, name).or_else(elastic).unwrap_or(pool.zero()))
        }
        Measure::Contact(contact, of) => {
            Some(touch::part(model, &system.kinematics, &system.constraints, contact, of))
        }
        Measure::Line(idx, of) => {
            let load = model.loads.iter().find(|load| load.name == model.line_names[idx])?;
            let signals = signal_values(model, &system.kinematics);
            force::part_of_line(model, &system.kinematics, &signals, &load.kind, of)
        }
        _ => None,
    }
}

/// The force of a coupling, a slack rope or teeth with play by its name, as multipliers; of both flanks together that
/// which turns the second forward.
pub fn force_of(model: &Model, system: &SymbolicSystem, name: &str) -> Option<Expr> {
    let pool = &model.pool;
    let part = |row: &Constraint| {
        let lambda = pool.symbol_expr(row.lambda);
        match row.source {
            Source::Coupling(id) => (model.couplings[id.0].name == name).then_some(lambda),
            Source::Stop(id) => {
                let load = &model.loads[id.0];
                let is_own = load.is_coupling() && load.name == name;
                match load.teeth().zip(load.kind.is_back_flank()) {
                    Some((teeth, is_back)) if teeth.name == name => {
                        let is_forward = is_back == teeth.kind.is_reversed();
                        Some(if is_forward { lambda } else { pool.neg(lambda) })
                    }
                    _ => is_own.then_some(lambda),
                }
            }
            _ => None,
        }
    };
    // The pull of a rope before a place at which it rubs.
    let mut loads = model.loads.iter().enumerate();
    if let Some((id, _)) = loads.find(|(_, of)| of.is_capstan() && of.name == name) {
        let [before, _] = rope::pulls(model, &system.constraints, LoadId(id));
        return Some(pool.substitute(before, &signal_values(model, &system.kinematics)));
    }
    let parts: Vec<Expr> = system.constraints.iter().filter_map(part).collect();
    (!parts.is_empty()).then(|| pool.sum(parts))
}

/// The joint whose reaction the multiplier of a row is part of.
fn bearing(model: &Model, source: Source) -> Option<JointId> {
    match source {
        Source::Joint(joint) => Some(joint),
        other => {
            let joint = other.joint(model)?;
            (model.joints[joint.0].kind.is_cylinder()).then_some(joint)
        }
    }
}

struct Balance<'a> {
    model: &'a Model,
    pool: &'a Pool,
    system: &'a SymbolicSystem,
    /// Of all bodies, where the recursion has them; else they are derived from positions.
    accelerations: Option<Vec<BodyAcceleration>>,
    wrenches: Vec<Vec<Wrench>>,
}

impl Balance<'_> {
    /// Adds a wrench through a joint on both of its bodies.
    fn pass_through(&mut self, joint: JointId, wrench: &JointWrench) {
        let kinematics = &self.system.kinematics;
        for wrench in Wrench::through_joint(self.model, kinematics, joint, wrench) {
            self.wrenches[wrench.body.0].push(wrench);
        }
    }

    /// The wrench at the successor's point of `joint` that `body` still needs.
    fn missing_wrench(&self, body: BodyId, joint: JointId) -> JointWrench {
        let (model, pool, kinematics) = (self.model, self.pool, &self.system.kinematics);
        let p_com = kinematics.position(model, body, None);
        let BodyAcceleration { com, angular_momentum_rate } = self.acceleration(body, &p_com);
        let mut force = spatial::scale(pool, model.bodies[body.0].mass, &com);
        let mut moment = angular_momentum_rate;
        for wrench in &self.wrenches[body.0] {
            let arm = spatial::sub(pool, &wrench.at, &p_com);
            let turning = spatial::cross(pool, &arm, &wrench.force);
            force = spatial::sub(pool, &force, &wrench.force);
            moment = spatial::sub(pool, &moment, &wrench.moment);
            moment = spatial::sub(pool, &moment, &turning);
        }
        let p_joint = kinematics.anchor(model, model.joints[joint.0].successor);
        let arm = spatial::sub(pool, &p_joint, &p_com);
        let moment = spatial::sub(pool, &moment, &spatial::cross(pool, &arm, &force));
        JointWrench { force, moment }
    }

    /// The accelerations of a body whose centre of mass is at `p_com`.
    fn acceleration(&self, body: BodyId, p_com: &Vector) -> BodyAcceleration {
        match &self.accelerations {
            Some(accelerations) => accelerations[body.0].clone(),
            None => acceleration(self.model, self.system, body, p_com),
        }
    }
}

/// The accelerations of a body whose centre of mass is at `p_com`, derived from positions.
pub(crate) fn acceleration(
    model: &Model,
    system: &SymbolicSystem,
    body: BodyId,
    p_com: &Vector,
) -> BodyAcceleration {
    let kinematics = &system.kinematics;
    let twice = |e| kinematics.second_rate(model, kinematics.rate(model, e));
    let momentum = angular_momentum(model, &kinematics.poses[body.0], body);
    BodyAcceleration {
        com: p_com.map(twice),
        angular_momentum_rate: momentum.map(|e| kinematics.second_rate(model, e)),
    }
}

fn wrenches_by_body(model: &Model, system: &SymbolicSystem) -> Vec<Vec<Wrench>> {
    let mut by_body = vec![Vec::new(); model.bodies.len()];
    for wrench in &system.wrenches {
        by_body[wrench.body.0].push(wrench.clone());
    }
    by_body
}
