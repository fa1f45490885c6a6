//! [`assemble`]: a model becomes its symbolic equations of motion.
//!
//! ```text
//! T = ½ q̇ᵀ M q̇,  M = Σ (J_Tᵀ m J_T + J_Rᵀ A I′ Aᵀ J_R)                        (1.1)
//! d/dt ∂T/∂q̇ − ∂T/∂q = −∂Π/∂q + Q − Σ λ_j ∂f_j/∂q,   f_j(t, q) = 0             (1.3)
//! ```
//!
//! Source: Lê Hồng Lam and Đinh Văn Phong (2008), equations (1.1) to (1.3). The left side of (1.3)
//! is written out as M(q) q̈ + h(q, q̇), h by the Christoffel sums of M.

use std::collections::HashSet;

use bksim_expr::{Expr, SymbolId};

use crate::force::{self, Wrench};
use crate::joint;
use crate::kinematics::{Coordinate, Kinematics};
use crate::lagrange::left_side;
use crate::model::{BodyId, DriveId, JointId, LoadId, LoadKind, Model, Vector};
use crate::sparse::SparseMatrix;
use crate::spatial;
use crate::switch::{self, Contact, ContactRow, Law, Switch};
use crate::tree::Tree;

/// Where a constraint row comes from.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Source {
    /// A joint that was cut.
    Joint(JointId),
    /// A prescribed motion.
    Drive(DriveId),
    /// A limit of a motion, which holds while bodies are in contact.
    Stop(LoadId),
    /// Dry friction, which holds while it sticks.
    Friction(LoadId),
}

impl Source {
    /// The joint that the row acts in.
    pub fn joint(self, model: &Model) -> JointId {
        match self {
            Self::Joint(joint) => joint,
            Self::Drive(drive) => model.drives[drive.0].joint,
            Self::Stop(load) | Self::Friction(load) => match model.loads[load.0].kind {
                LoadKind::Stop { joint, .. } | LoadKind::Friction { joint, .. } => joint,
                _ => unreachable!("only stops and friction have rows"),
            },
        }
    }

    /// Whether the row opens and closes.
    pub fn is_contact(self) -> bool {
        matches!(self, Self::Stop(_) | Self::Friction(_))
    }
}

/// One constraint row f(t, q) = 0 with its multiplier.
#[derive(Clone, Debug)]
pub struct Constraint {
    /// f, m or rad.
    pub expression: Expr,
    /// Symbol of λ.
    pub lambda: SymbolId,
    /// The joint or drive it comes from.
    pub source: Source,
    /// `x`, `y`, `z`, `normal`, `angle`, `length`, `motion`, `min`, `max` or `friction`.
    pub direction: &'static str,
    /// Force on the joint's successor at its joint point for λ = 1.
    pub(crate) force: Vector,
    /// Moment on the joint's successor about its joint point for λ = 1.
    pub(crate) moment: Vector,
}

/// The equations of motion of one model, as expressions of its pool.
#[derive(Clone, Debug)]
pub struct SymbolicSystem {
    /// The spanning tree that was chosen.
    pub tree: Tree,
    /// Positions of the bodies, and the generalised coordinates q.
    pub kinematics: Kinematics,
    /// T(q, v), J.
    pub kinetic_energy: Expr,
    /// V(q), J.
    pub potential_energy: Expr,
    /// M(q), nq × nq, symmetric.
    pub mass_matrix: SparseMatrix,
    /// h(q, v), nq: Coriolis and centrifugal terms.
    pub bias: Vec<Expr>,
    /// ∂V/∂q, nq.
    pub potential_gradient: Vec<Expr>,
    /// Q(t, q, v), nq: generalised forces without a potential.
    pub force: Vec<Expr>,
    /// f(t, q) with multipliers, cut joints in file order, then drives, then contacts.
    pub constraints: Vec<Constraint>,
    /// G = ∂f/∂q, nc × nq.
    pub constraint_jacobian: SparseMatrix,
    /// ∂f/∂t, nc.
    pub constraint_rate: Vec<Expr>,
    /// Every wrench on a body: loads with and without potential.
    pub(crate) wrenches: Vec<Wrench>,
    /// Stops and friction: the rows that open and close.
    pub contacts: Vec<Contact>,
    /// Kinks of the expressions.
    pub switches: Vec<Switch>,
    /// The equations that are integrated, when they are not these.
    frozen: Option<Box<SymbolicSystem>>,
}

impl SymbolicSystem {
    /// The generalised coordinates.
    pub fn coordinates(&self) -> &[Coordinate] {
        &self.kinematics.coordinates
    }

    /// The equations that are integrated: with [modes](crate::switch) in place of what switches.
    pub fn integrated(&self) -> &Self {
        self.frozen.as_deref().unwrap_or(self)
    }

    /// Number of constraint rows that always hold; those of contacts follow.
    pub fn n_bilateral(&self) -> usize {
        self.constraints.len() - self.contacts.len()
    }

    /// Parameters of everything that is compiled: the model's own, then the modes: σ of every
    /// switch, then κ of every contact, behind κ of friction its ς and p₀.
    pub(crate) fn parameters(&self, model: &Model) -> Vec<SymbolId> {
        let own = model.parameters.iter().map(|p| p.symbol);
        let kinks = self.switches.iter().map(|switch| switch.mode);
        let of_contact = |contact: &Contact| match contact.law {
            Law::Stop { .. } => vec![contact.closed],
            Law::Friction { slip, place, .. } => vec![contact.closed, slip, place],
        };
        own.chain(kinks).chain(self.contacts.iter().flat_map(of_contact)).collect()
    }
}

/// Derives the equations of motion of `model`.
pub fn assemble(model: &Model) -> SymbolicSystem {
    let pool = &model.pool;
    let tree = Tree::of(model);
    let kinematics = Kinematics::along(model, &tree);

    // Potentials and generalised forces.
    let signals = signal_values(model, &kinematics);
    let mut potentials = Vec::new();
    let mut applied = Vec::new();
    let mut wrenches = Vec::new();
    for load in &model.loads {
        let action = force::action(model, &kinematics, &signals, &load.kind);
        potentials.extend(action.potential);
        applied.extend(action.applied);
        wrenches.extend(action.conservative);
    }
    let left = left_side(model, &kinematics, pool.sum(potentials));
    let force = generalised_force(model, &kinematics, &applied);
    wrenches.extend(applied);

    // Constraints, and what they are differentiated to.
    let rows = switch::contact_rows(model, &kinematics, &signals);
    let constraints = constraints(model, &tree, &kinematics, &rows);
    let contacts = switch::contacts(model, &rows, &constraints);
    let constraint_jacobian = constraint_jacobian(model, &kinematics, &constraints);
    let constraint_rate =
        constraints.iter().map(|c| pool.simplify(pool.diff(c.expression, model.time))).collect();

    let mut system = SymbolicSystem {
        kinetic_energy: left.kinetic_energy,
        potential_energy: left.potential_energy,
        mass_matrix: left.mass_matrix,
        bias: left.bias,
        potential_gradient: left.potential_gradient,
        tree,
        force,
        constraints,
        constraint_jacobian,
        constraint_rate,
        wrenches,
        kinematics,
        contacts,
        switches: Vec::new(),
        frozen: None,
    };
    if let Some(frozen) = switch::freeze(model, &system) {
        system.switches.clone_from(&frozen.switches);
        system.frozen = Some(Box::new(frozen));
    }
    system
}

/// I′ about the centre of mass: by Steiner, I_c = I_P − m (d·d 1 − d dᵀ), d from P to the centre.
pub(crate) fn central_inertia(model: &Model, body: BodyId) -> [Vector; 3] {
    let pool = &model.pool;
    let body = &model.bodies[body.0];
    let [ixx, iyy, izz] = body.inertia.moments;
    let [ixy, iyz, izx] = body.inertia.products;
    let stated = [[ixx, ixy, izx], [ixy, iyy, iyz], [izx, iyz, izz]];
    let Some(about) = body.inertia.about else {
        return stated;
    };
    let d = spatial::sub(pool, &body.com, &body.points[about.0].position);
    let d_squared = spatial::dot(pool, &d, &d);
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let diagonal = if i == j { d_squared } else { pool.zero() };
            let shift = pool.sub(diagonal, pool.mul(d[i], d[j]));
            pool.sub(stated[i][j], pool.mul(body.mass, shift))
        })
    })
}

/// Q_i = Σ F · ∂r/∂q_i + M · ∂ω/∂q̇_i.
fn generalised_force(model: &Model, kinematics: &Kinematics, wrenches: &[Wrench]) -> Vec<Expr> {
    let pool = &model.pool;
    let mut powers = vec![Vec::new(); kinematics.coordinates.len()];
    for wrench in wrenches {
        let omega = kinematics.poses[wrench.body.0].omega;
        for i in kinematics.coordinates_in(pool, &[wrench.at, omega].concat()) {
            let coordinate = &kinematics.coordinates[i];
            let at = wrench.at.map(|component| pool.diff(component, coordinate.q));
            let turn = omega.map(|component| pool.diff(component, coordinate.v));
            powers[i].push(pool.add(
                spatial::dot(pool, &wrench.force, &at),
                spatial::dot(pool, &wrench.moment, &turn),
            ));
        }
    }
    powers.into_iter().map(|power| pool.simplify(pool.sum(power))).collect()
}

/// ∂f/∂q.
fn constraint_jacobian(
    model: &Model,
    kinematics: &Kinematics,
    constraints: &[Constraint],
) -> SparseMatrix {
    let pool = &model.pool;
    let n_columns = kinematics.coordinates.len();
    let mut entries = Vec::new();
    for (row, constraint) in constraints.iter().enumerate() {
        let moving = kinematics.coordinates_in(pool, &[constraint.expression]);
        let symbols: Vec<SymbolId> = moving.iter().map(|&i| kinematics.coordinates[i].q).collect();
        let gradient = pool.gradient(constraint.expression, &symbols).into_iter();
        let gradient = moving.into_iter().zip(gradient.map(|slope| pool.simplify(slope)));
        entries.extend(gradient.map(|(i, slope)| (row, i, slope)));
    }
    entries.retain(|&(.., slope)| !pool.is_zero(slope));
    SparseMatrix::new(constraints.len(), n_columns, entries)
}

/// Rows of the cut joints, then of the drives: motion(t) − position = 0, so that λ is the effort;
/// then those of contacts.
fn constraints(
    model: &Model,
    tree: &Tree,
    kinematics: &Kinematics,
    contacts: &[ContactRow],
) -> Vec<Constraint> {
    let pool = &model.pool;
    let mut constraints = Vec::new();
    // An author may have called a coordinate or a parameter `ld1`; the multiplier must not be it.
    let of_coordinate = |c: &Coordinate| ["", "_dot", "_ddot"].map(|rest| c.name.clone() + rest);
    let taken: HashSet<String> = model
        .parameters
        .iter()
        .map(|p| p.name.clone())
        .chain(kinematics.coordinates.iter().flat_map(of_coordinate))
        .collect();
    let mut add = |expression, source, direction, force, moment| {
        let mut name = format!("ld{}", constraints.len() + 1);
        while taken.contains(&name) {
            name.push('_');
        }
        let lambda = pool.symbol(&name);
        let lambda = pool.symbol_id(lambda).expect("a symbol was just made");
        let expression = pool.simplify(expression);
        constraints.push(Constraint { expression, lambda, source, direction, force, moment });
    };
    for &joint_id in &tree.cuts {
        let joint = &model.joints[joint_id.0];
        for row in joint::constraints(pool, joint, &kinematics.sides(model, joint)) {
            add(row.constraint, Source::Joint(joint_id), row.direction, row.force, row.moment);
        }
    }
    for (drive_idx, drive) in model.drives.iter().enumerate() {
        let joint = &model.joints[drive.joint.0];
        let motion = joint::motions(pool, joint)[drive.motion_idx];
        let position = kinematics.joint_positions(model, drive.joint)[drive.motion_idx];
        let (force, moment) = joint::effort(pool, motion, &kinematics.sides(model, joint));
        let expression = pool.sub(drive.motion, position);
        add(expression, Source::Drive(DriveId(drive_idx)), "motion", force, moment);
    }
    for row in contacts {
        add(row.expression, row.source, row.direction, row.force, row.moment);
    }
    constraints
}

/// What each signal symbol stands for.
pub(crate) fn signal_values(model: &Model, kinematics: &Kinematics) -> Vec<(SymbolId, Expr)> {
    let value = |signal: &crate::model::Signal| {
        (signal.symbol, model.pool.simplify(kinematics.measure(model, signal.measure)))
    };
    model.signals.iter().map(value).collect()
}
