//! The equations of motion once more, from first principles and as long as they come.
//!
//! ```text
//! T = Σ ½ m ṙ·ṙ + ½ ω·I′ω          d/dt ∂T/∂q̇ − ∂T/∂q + ∂V/∂q − Q + Σ λ_k ∂g_k/∂q = 0
//! ```
//!
//! Nothing is shared with the equations that are solved but the positions and turning rates of the
//! bodies: no mass matrix, no Christoffel sums, no simplification. Source: Lê Hồng Lam and Đinh Văn
//! Phong (2008), equation (1.3).

use bksim_expr::{Expr, SymbolId};

use crate::assemble::has_row_of_wrenches;
use crate::constraint::{Constraint, Source};
use crate::coordinate::{Coordinate, Owner};
use crate::coupling::coupling_rows;
use crate::force::{Loads, Wrench};
use crate::inertia::central_inertia;
use crate::joint::{self, OF_RATES};
use crate::norm;
use crate::rotor;
use crate::signal::signal_values;
use crate::spatial;
use crate::system::SymbolicSystem;
use bksim_model::{BodyId, Model, StateId};

/// The equations in the form that is compared with those that are solved.
pub(super) struct UnsimplifiedEquations {
    pub(super) kinetic_energy: Expr,
    pub(super) potential_energy: Expr,
    /// Left sides of the Lagrange equations.
    pub(super) left_sides: Vec<Expr>,
    /// Left sides of the constraints that always hold, in the order of the multipliers.
    pub(super) constraints: Vec<Expr>,
}

/// Derives the equations of `model` in the coordinates of `system`.
pub(super) fn derive(model: &Model, system: &SymbolicSystem) -> UnsimplifiedEquations {
    let pool = &model.pool;
    let kinetic_energy = kinetic_energy(model, system);
    let (potential_energy, applied) = loads(model, system);
    let constraints = constraints(model, system);

    let coordinates = system.coordinates();
    let [q, v]: [Vec<SymbolId>; 2] =
        [coordinates.iter().map(|c| c.q).collect(), coordinates.iter().map(|c| c.v).collect()];
    let momenta = pool.gradient(kinetic_energy, &v);
    let inertial = pool.gradient(kinetic_energy, &q);
    let conservative = pool.gradient(potential_energy, &q);
    // Of wheels whose joints are cut, and of efforts in cut screws, the wrenches stand in the equations.
    let is_pair = |c: &Constraint| has_row_of_wrenches(model, &system.tree, c);
    let (pairs, others): (Vec<_>, Vec<_>) =
        constraints.iter().zip(&system.constraints).partition(|(_, c)| is_pair(c));
    let positions = others.iter().filter(|(_, c)| !c.is_of_rates());
    let work: Vec<Expr> =
        positions.map(|(g, c)| pool.mul(pool.symbol_expr(c.lambda), **g)).collect();
    let mut constraint_forces = pool.gradient(pool.sum(work), &q);
    // A condition between rates acts along its slopes by these.
    for (rate, c) in others.iter().filter(|(_, c)| c.is_of_rates()) {
        let slopes = pool.gradient(pool.mul(pool.symbol_expr(c.lambda), **rate), &v);
        for (force, slope) in constraint_forces.iter_mut().zip(slopes) {
            *force = pool.add(*force, slope);
        }
    }
    let pair_force = |c: &Constraint, i: usize| {
        let powers = c.wrenches.iter().map(|wrench| moving_power(model, system, wrench, i));
        pool.mul(pool.symbol_expr(c.lambda), pool.sum(powers.collect::<Vec<_>>()))
    };
    // ż − r of a state.
    let signals = signal_values(model, &system.kinematics);
    let state_rate = |i: usize| match coordinates[i].owner {
        Owner::State(StateId(state)) => {
            let rate = pool.substitute(model.states[state].rate, &signals);
            pool.sub(pool.symbol_expr(coordinates[i].a), rate)
        }
        _ => pool.zero(),
    };
    let left_side = |i: usize| {
        let force = applied.iter().map(|wrench| power(model, system, wrench, i));
        pool.sum([
            system.kinematics.second_rate(model, momenta[i]),
            pool.neg(inertial[i]),
            conservative[i],
            pool.neg(pool.sum(force.collect::<Vec<_>>())),
            constraint_forces[i],
            pool.neg(pool.sum(pairs.iter().map(|(_, c)| pair_force(c, i)).collect::<Vec<_>>())),
            state_rate(i),
        ])
    };
    let left_sides: Vec<Expr> = (0..coordinates.len()).map(left_side).collect();
    let left_sides = pool.substitute_all(&left_sides, &system.reaction_values);
    let constraints = constraints[..system.n_bilateral()].to_vec();
    UnsimplifiedEquations { kinetic_energy, potential_energy, left_sides, constraints }
}

/// m ṙ·ṙ + ω·I′ω of a body: 2 T.
pub(super) fn doubled_kinetic_energy(model: &Model, system: &SymbolicSystem, body: BodyId) -> Expr {
    let pool = &model.pool;
    let kinematics = &system.kinematics;
    let velocity =
        kinematics.position(model, body, None).map(|component| kinematics.rate(model, component));
    let pose = &kinematics.poses[body.0];
    let omega = pose.rotation.apply_inverse(pool, &pose.omega);
    let momentum = central_inertia(model, body).map(|row| spatial::dot(pool, &row, &omega));
    pool.add(
        pool.mul(model.bodies[body.0].mass, spatial::dot(pool, &velocity, &velocity)),
        spatial::dot(pool, &omega, &momentum),
    )
}

fn kinetic_energy(model: &Model, system: &SymbolicSystem) -> Expr {
    let pool = &model.pool;
    let kinematics = &system.kinematics;
    let bodies = (1..model.bodies.len()).map(BodyId);
    let doubled: Vec<Expr> =
        bodies.map(|body| doubled_kinetic_energy(model, system, body)).collect();
    let of_bodies = pool.mul(pool.rational(1, 2), pool.sum(doubled));
    let rates: Vec<Expr> = system.coordinates().iter().map(|c| pool.symbol_expr(c.v)).collect();
    let of_norms = norm::kinetic_energy(model, kinematics, &rates, &norm::unnamed);
    let of_rotors = rotor::kinetic_energy(model, kinematics, &rates);
    pool.sum([of_bodies].into_iter().chain(of_norms).chain(of_rotors))
}

/// V, and the wrenches that have none.
fn loads(model: &Model, system: &SymbolicSystem) -> (Expr, Vec<Wrench>) {
    let signals = signal_values(model, &system.kinematics);
    let Loads { potentials, applied, .. } = Loads::of(model, &system.kinematics, &signals);
    (model.pool.sum(potentials), applied)
}

/// F · ∂r/∂q_i + M · ∂ω/∂q̇_i.
fn power(model: &Model, system: &SymbolicSystem, wrench: &Wrench, i: usize) -> Expr {
    let pool = &model.pool;
    let coordinate = &system.coordinates()[i];
    let at = wrench.at.map(|component| pool.diff(component, coordinate.q));
    let omega = system.kinematics.poses[wrench.body.0].omega;
    let turn = omega.map(|component| pool.diff(component, coordinate.v));
    pool.add(spatial::dot(pool, &wrench.force, &at), spatial::dot(pool, &wrench.moment, &turn))
}

/// Power ([`power`]) of a wrench at a place that is no point of the body.
fn moving_power(model: &Model, system: &SymbolicSystem, wrench: &Wrench, i: usize) -> Expr {
    let pool = &model.pool;
    let coordinate = &system.coordinates()[i];
    let pose = &system.kinematics.poses[wrench.body.0];
    let anchor = pose.anchor_world.map(|component| pool.diff(component, coordinate.q));
    let turn = pose.omega.map(|component| pool.diff(component, coordinate.v));
    let arm = spatial::sub(pool, &wrench.at, &pose.anchor_world);
    let at = spatial::add(pool, &anchor, &spatial::cross(pool, &turn, &arm));
    pool.add(spatial::dot(pool, &wrench.force, &at), spatial::dot(pool, &wrench.moment, &turn))
}

/// The power of wrenches at places that are no points of their bodies.
fn speed_of(model: &Model, system: &SymbolicSystem, wrenches: &[Wrench]) -> Expr {
    let pool = &model.pool;
    let along = |(i, coordinate): (usize, &Coordinate)| {
        let powers = wrenches.iter().map(|wrench| moving_power(model, system, wrench, i));
        let power = pool.sum(powers.collect::<Vec<_>>());
        pool.mul(power, pool.symbol_expr(coordinate.v))
    };
    pool.sum(system.coordinates().iter().enumerate().map(along).collect::<Vec<_>>())
}

fn constraints(model: &Model, system: &SymbolicSystem) -> Vec<Expr> {
    let pool = &model.pool;
    let kinematics = &system.kinematics;
    let mut constraints = Vec::new();
    for &joint_id in &system.tree.cuts {
        let joint = &model.joints[joint_id.0];
        let rows = joint::constraint_rows(pool, joint, &kinematics.sides(model, joint));
        let slip = |row: &joint::Row| {
            let wrenches = Wrench::through_joint(model, kinematics, joint_id, &row.wrench);
            pool.neg(speed_of(model, system, &wrenches))
        };
        let is_slip = |row: &joint::Row| OF_RATES.contains(&row.direction);
        let left = |row: &joint::Row| if is_slip(row) { slip(row) } else { row.expression };
        constraints.extend(rows.iter().map(left));
    }
    constraints.extend(kinematics.turnings.iter().map(|turning| norm::row(pool, turning)));
    let couplings = coupling_rows(model, kinematics).into_iter();
    constraints.extend(couplings.map(|row| row.expression));
    for constraint in &system.constraints {
        if let Source::Drive(drive) = constraint.source {
            let drive = &model.drives[drive.0];
            let position = kinematics.joint_positions(model, drive.joint)[drive.motion_idx];
            constraints.push(pool.sub(drive.motion, position));
        }
    }
    constraints.extend(system.contacts.iter().map(|contact| contact.expression));
    constraints
}
