//! [`assemble`]: a model becomes its symbolic equations of motion.
//!
//! ```text
//! T = ½ q̇ᵀ M q̇,  M = Σ (J_Tᵀ m J_T + J_Rᵀ A I′ Aᵀ J_R)                        (1.1)
//! d/dt ∂T/∂q̇ − ∂T/∂q = −∂Π/∂q + Q − Σ λ_j ∂f_j/∂q,   f_j(t, q) = 0             (1.3)
//! ```
//!
//! Source: Lê Hồng Lam and Đinh Văn Phong (2008), equations (1.1) to (1.3). The left side of (1.3)
//! is written out as M(q) q̈ + h(q, q̇), h by the Christoffel sums of M.

use bksim_expr::{Expr, Pool, SymbolId};

use crate::force::{self, Wrench};
use crate::joint;
use crate::kinematics::{Coordinate, Kinematics};
use crate::model::{BodyId, DriveId, JointId, Model, Vector};
use crate::spatial;
use crate::tree::Tree;

/// Where a constraint row comes from.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Source {
    /// A joint that was cut.
    Joint(JointId),
    /// A prescribed motion.
    Drive(DriveId),
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
    /// `x`, `y`, `z`, `normal`, `angle`, `length` or `motion`.
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
    /// M(q), nq × nq, row-major, symmetric.
    pub mass_matrix: Vec<Vec<Expr>>,
    /// h(q, v), nq: Coriolis and centrifugal terms.
    pub bias: Vec<Expr>,
    /// ∂V/∂q, nq.
    pub potential_gradient: Vec<Expr>,
    /// Q(t, q, v), nq: generalised forces without a potential.
    pub force: Vec<Expr>,
    /// f(t, q) with multipliers, cut joints in file order, then drives.
    pub constraints: Vec<Constraint>,
    /// G = ∂f/∂q, nc × nq.
    pub constraint_jacobian: Vec<Vec<Expr>>,
    /// ∂f/∂t, nc.
    pub constraint_rate: Vec<Expr>,
    /// Every wrench on a body: loads with and without potential.
    pub(crate) wrenches: Vec<Wrench>,
}

impl SymbolicSystem {
    /// The generalised coordinates.
    pub fn coordinates(&self) -> &[Coordinate] {
        &self.kinematics.coordinates
    }
}

/// Derives the equations of motion of `model`.
pub fn assemble(model: &Model) -> SymbolicSystem {
    let pool = &model.pool;
    let tree = Tree::of(model);
    let kinematics = Kinematics::along(model, &tree);
    let positions: Vec<SymbolId> = kinematics.coordinates.iter().map(|c| c.q).collect();

    // (1.1): the mass matrix, and T from it.
    let mass_matrix = mass_matrix(model, &kinematics);
    let kinetic_energy = quadratic_form(pool, &kinematics.coordinates, &mass_matrix);

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
    let potential_energy = pool.simplify(pool.sum(potentials));
    let force = generalised_force(model, &kinematics, &applied);
    wrenches.extend(applied);

    // Constraints, and what they are differentiated to.
    let constraints = constraints(model, &tree, &kinematics);
    let simplified_gradient = |e: Expr| -> Vec<Expr> {
        pool.gradient(e, &positions).into_iter().map(|d| pool.simplify(d)).collect()
    };
    let constraint_jacobian =
        constraints.iter().map(|c| simplified_gradient(c.expression)).collect();
    let constraint_rate =
        constraints.iter().map(|c| pool.simplify(pool.diff(c.expression, model.time))).collect();

    SymbolicSystem {
        bias: bias(pool, &kinematics.coordinates, &mass_matrix),
        potential_gradient: simplified_gradient(potential_energy),
        tree,
        kinetic_energy,
        potential_energy,
        mass_matrix,
        force,
        constraints,
        constraint_jacobian,
        constraint_rate,
        wrenches,
        kinematics,
    }
}

/// M by (1.1): J_T = ∂r_c/∂q in world axes; J_R = ∂ω/∂q̇ in body axes, where I′ is constant.
fn mass_matrix(model: &Model, kinematics: &Kinematics) -> Vec<Vec<Expr>> {
    let pool = &model.pool;
    let n = kinematics.coordinates.len();
    let mut terms = vec![vec![Vec::new(); n]; n];
    for body_idx in 1..model.bodies.len() {
        let body = BodyId(body_idx);
        let mass = model.bodies[body_idx].mass;
        let com = kinematics.place(model, body, None);
        let inertia = central_inertia(model, body);
        let pose = &kinematics.poses[body_idx];
        let omega_body = pose.rotation.apply_inverse(pool, &pose.omega);
        let j_t: Vec<Vector> = kinematics
            .coordinates
            .iter()
            .map(|c| com.map(|component| pool.diff(component, c.q)))
            .collect();
        let j_r: Vec<Vector> = kinematics
            .coordinates
            .iter()
            .map(|c| omega_body.map(|component| pool.diff(component, c.v)))
            .collect();
        for i in 0..n {
            for j in 0..=i {
                let translation = pool.mul(mass, spatial::dot(pool, &j_t[i], &j_t[j]));
                let rotation = spatial::dot(pool, &j_r[i], &multiply(pool, &inertia, &j_r[j]));
                terms[i][j].extend([translation, rotation]);
            }
        }
    }
    let mut matrix = vec![vec![pool.zero(); n]; n];
    for i in 0..n {
        for j in 0..=i {
            let entry = pool.simplify(pool.sum(std::mem::take(&mut terms[i][j])));
            matrix[i][j] = entry;
            matrix[j][i] = entry;
        }
    }
    matrix
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

/// ½ vᵀ M v, each product of velocities once.
fn quadratic_form(pool: &Pool, coordinates: &[Coordinate], matrix: &[Vec<Expr>]) -> Expr {
    let v = |i: usize| pool.symbol_expr(coordinates[i].v);
    let mut terms = Vec::new();
    for i in 0..coordinates.len() {
        terms.push(pool.product([pool.rational(1, 2), matrix[i][i], pool.powi(v(i), 2)]));
        for j in 0..i {
            terms.push(pool.product([matrix[i][j], v(i), v(j)]));
        }
    }
    pool.sum(terms)
}

/// h_i = Σ_jk (∂M_ij/∂q_k − ½ ∂M_jk/∂q_i) v_j v_k.
fn bias(pool: &Pool, coordinates: &[Coordinate], matrix: &[Vec<Expr>]) -> Vec<Expr> {
    let n = coordinates.len();
    let v = |i: usize| pool.symbol_expr(coordinates[i].v);
    let slope = |i: usize, j: usize, k: usize| pool.diff(matrix[i][j], coordinates[k].q);
    let h = |i: usize| {
        let mut terms = Vec::new();
        for j in 0..n {
            for k in 0..=j {
                // Both orders of a pair at once: the Christoffel symbol of the first kind.
                let mut symbol = vec![slope(i, j, k), slope(i, k, j), pool.neg(slope(j, k, i))];
                if j == k {
                    symbol = vec![slope(i, j, j), pool.mul(pool.rational(-1, 2), slope(j, j, i))];
                }
                terms.push(pool.product([pool.sum(symbol), v(j), v(k)]));
            }
        }
        pool.simplify(pool.sum(terms))
    };
    (0..n).map(h).collect()
}

/// Q_i = Σ F · ∂r/∂q_i + M · ∂ω/∂q̇_i.
fn generalised_force(model: &Model, kinematics: &Kinematics, wrenches: &[Wrench]) -> Vec<Expr> {
    let pool = &model.pool;
    let along = |coordinate: &Coordinate| {
        let power = wrenches.iter().map(|wrench| {
            let at = wrench.at.map(|component| pool.diff(component, coordinate.q));
            let omega = kinematics.poses[wrench.body.0].omega;
            let turn = omega.map(|component| pool.diff(component, coordinate.v));
            pool.add(
                spatial::dot(pool, &wrench.force, &at),
                spatial::dot(pool, &wrench.moment, &turn),
            )
        });
        pool.simplify(pool.sum(power.collect::<Vec<_>>()))
    };
    kinematics.coordinates.iter().map(along).collect()
}

/// Rows of the cut joints, then of the drives: motion(t) − position = 0, so that λ is the effort.
fn constraints(model: &Model, tree: &Tree, kinematics: &Kinematics) -> Vec<Constraint> {
    let pool = &model.pool;
    let mut constraints = Vec::new();
    // An author may have called a coordinate or a parameter `ld1`; the multiplier must not be it.
    let is_taken = |name: &str| {
        let of_coordinate = |rest: &str| ["", "_dot", "_ddot"].contains(&rest);
        model.parameters.iter().any(|p| p.name == name)
            || kinematics
                .coordinates
                .iter()
                .any(|c| name.strip_prefix(c.name.as_str()).is_some_and(of_coordinate))
    };
    let mut add = |expression, source, direction, force, moment| {
        let mut name = format!("ld{}", constraints.len() + 1);
        while is_taken(&name) {
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
    constraints
}

/// What each signal symbol stands for.
pub(crate) fn signal_values(model: &Model, kinematics: &Kinematics) -> Vec<(SymbolId, Expr)> {
    let value = |signal: &crate::model::Signal| {
        (signal.symbol, model.pool.simplify(kinematics.measure(model, signal.measure)))
    };
    model.signals.iter().map(value).collect()
}

fn multiply(pool: &Pool, matrix: &[Vector; 3], v: &Vector) -> Vector {
    std::array::from_fn(|i| spatial::dot(pool, &matrix[i], v))
}
