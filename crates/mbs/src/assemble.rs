//! [`assemble`]: a model becomes its symbolic equations of motion.
//!
//! ```text
//! T = ½ q̇ᵀ M q̇,  M = Σ (J_Tᵀ m J_T + J_Rᵀ A I′ Aᵀ J_R)                        (1.1)
//! d/dt ∂T/∂q̇ − ∂T/∂q = −∂V/∂q + Q − Σ λ_j ∂g_j/∂q,   g_j(t, q) = 0             (1.3)
//! ```
//!
//! Source: Lê Hồng Lam and Đinh Văn Phong (2008), equations (1.1) to (1.3). The left side of (1.3)
//! is written out as M(q) q̈ + h(q, q̇), h by the Christoffel sums of M.

use std::collections::HashSet;
use std::ops::Range;

use bksim_expr::{Expr, SymbolId};

use crate::belt;
use crate::constraint::{Constraint, Source};
use crate::contact::{self, ContactRow};
use crate::coordinate::{Coordinate, Owner};
use crate::coupling::{coupling_rows, rate_row, separating_wrenches};
use crate::folding::{MAX_TERMS, MAX_TERMS_OF_FORCE, MAX_TERMS_OF_SLOPE, folded_slope, short};
use crate::force::{AlongLine, Loads, Wrench, efforts_on_curves, powers};
use crate::joint;
use crate::kinematics::Kinematics;
use crate::kinematics::bending;
use crate::lagrange;
use crate::mesh;
use crate::modes::with_modes;
use crate::norm;
use crate::recursion;
use crate::rope;
use crate::rotor;
use crate::rubbing::measured_reactions;
use crate::signal::signal_values;
use crate::sparse::SparseMatrix;
use crate::spatial;
use crate::system::{Derivation, SymbolicSystem};
use crate::tree::Tree;
use bksim_model::{
    CouplingId, CouplingKind, DriveId, HeldSignal, Model, MotionKind, RopeId, StateId,
};

/// Derives the equations of motion of `model` by the way that makes them shorter.
pub fn assemble(model: &Model) -> SymbolicSystem {
    let tree = Tree::of(model);
    let kinematics = Kinematics::along(model, &tree);
    let derivation = shorter(model, &kinematics);
    assemble_along(model, tree, kinematics, derivation)
}

/// The way that makes the equations shorter.
fn shorter(model: &Model, kinematics: &Kinematics) -> Derivation {
    // The recursion knows rigid links alone.
    let is_rigid = !bending::are_there(model);
    if is_rigid && recursion::is_shorter(&model.pool, kinematics) {
        Derivation::Recursion
    } else {
        Derivation::Lagrange
    }
}

/// Terms of a row that is folded, and its slopes with it. What a recursion leaves in factors shares them with the rows.
fn longest_row(derivation: Derivation) -> u64 {
    match derivation {
        Derivation::Lagrange => MAX_TERMS,
        Derivation::Recursion => MAX_TERMS_OF_SLOPE,
    }
}

/// Derives the equations of motion of `model` by `derivation`; both ways give equal equations.
pub fn assemble_by(model: &Model, derivation: Derivation) -> SymbolicSystem {
    let tree = Tree::of(model);
    let kinematics = Kinematics::along(model, &tree);
    assemble_along(model, tree, kinematics, derivation)
}

/// The equations of a planar mechanism once more, in the angles of its bodies against the ground: for reading.
/// `None` in space, and where bodies bend.
pub fn in_absolute_angles(model: &Model, system: &SymbolicSystem) -> Option<SymbolicSystem> {
    let kinematics = system.kinematics.in_absolute_angles(model, &system.tree)?;
    Some(assemble_along(model, system.tree.clone(), kinematics, Derivation::Lagrange))
}

fn assemble_along(
    model: &Model,
    tree: Tree,
    kinematics: Kinematics,
    derivation: Derivation,
) -> SymbolicSystem {
    let pool = &model.pool;

    // Potentials and generalised forces.
    let signals = signal_values(model, &kinematics);
    let mut loads = Loads::of(model, &kinematics, &signals);
    loads.applied.extend(belt::elastic_wrenches(model, &kinematics, &signals));
    for load in &model.loads {
        loads.applied.extend(mesh::elastic_wrenches(model, &kinematics, &signals, &load.kind));
    }
    for rope in 0..model.ropes.len() {
        let wrenches = rope::elastic_wrenches(model, &kinematics, &signals, RopeId(rope));
        loads.applied.extend(wrenches);
    }
    let mut left = match derivation {
        Derivation::Lagrange => {
            lagrange::left_side(model, &kinematics, pool.sum(loads.potentials.iter().copied()))
        }
        Derivation::Recursion => recursion::left_side(model, &tree, &kinematics, &loads),
    };
    if !kinematics.turnings.is_empty() {
        left.add_norms(model, &kinematics);
    }
    if rotor::are_there(model) {
        left.add_rotors(model, &kinematics);
    }
    if !model.states.is_empty() {
        left.add_states(model, &kinematics);
    }
    let mut applied_force = match derivation {
        Derivation::Lagrange => folded_force(model, &kinematics, &loads.applied, &loads.lines),
        Derivation::Recursion => generalised_force(model, &kinematics, &loads.applied),
    };
    for (force, coordinate) in applied_force.iter_mut().zip(&kinematics.coordinates) {
        if let Owner::State(StateId(state)) = coordinate.owner {
            *force = pool.substitute(model.states[state].rate, &signals);
        }
    }
    for (joint, motion_idx, effort) in efforts_on_curves(model, &kinematics, &signals) {
        let mut owners = kinematics.coordinates.iter().map(|coordinate| coordinate.owner);
        if let Some(idx) = owners.position(|owner| owner == Owner::Joint(joint, motion_idx)) {
            applied_force[idx] = pool.add(applied_force[idx], effort);
        }
    }
    let wrenches = [loads.conservative, loads.applied].concat();

    // Constraints, then G and ∂g/∂t.
    let rows = contact::contact_rows(model, &kinematics, &signals);
    let longest = longest_row(derivation);
    let constraints = constraints(model, &tree, &kinematics, (&rows, longest));
    let contacts = contact::contacts(model, &kinematics, &signals, &rows, &constraints);
    let constraint_jacobian =
        constraint_jacobian(model, &tree, &kinematics, (&constraints, longest));
    let constraint_rate = constraint_rates(model, &kinematics, &constraints);

    let separating = separating_wrenches(model, &kinematics, &constraints);
    for (wrenches, is_held) in &separating {
        // Between centres at a constant distance it does no work.
        if !is_held {
            for (sum, terms) in applied_force.iter_mut().zip(powers(model, &kinematics, wrenches)) {
                *sum = pool.add(*sum, pool.simplify(pool.sum(terms)));
            }
        }
    }
    let separating = separating.into_iter().flat_map(|(wrenches, _)| wrenches);
    let wrenches = wrenches.into_iter().chain(separating).collect();

    let reaction_values = measured_reactions(model, &kinematics, &constraints);

    // The system, and once more with modes in place of everything that switches.
    let mut system = SymbolicSystem {
        derivation,
        kinetic_energy: left.kinetic_energy,
        potential_energy: left.potential_energy,
        mass_matrix: left.mass_matrix,
        bias: left.bias,
        potential_gradient: left.potential_gradient,
        resistance: left.resistance,
        inverse_dynamics: left.inverse_dynamics,
        tree,
        applied_force,
        constraints,
        constraint_jacobian,
        constraint_rate,
        wrenches,
        conditions: conditions(model, &signals),
        reaction_values,
        kinematics,
        contacts,
        switches: Vec::new(),
        integrated: None,
    };
    system.put_reactions(pool);
    if let Some(integrated) = with_modes(model, &system) {
        system.switches.clone_from(&integrated.switches);
        system.integrated = Some(Box::new(integrated));
    }
    system
}

/// The positions of `model` alone: coordinates, and the rows of joints and drives. Masses and loads take no
/// part: T, V and all forces are zero, and no contact has a row.
pub fn assemble_positions(model: &Model) -> SymbolicSystem {
    let pool = &model.pool;
    let tree = Tree::of(model);
    let kinematics = Kinematics::of_positions(model, &tree);
    let longest = longest_row(shorter(model, &kinematics));
    let constraints = constraints(model, &tree, &kinematics, (&[], longest));
    let constraint_jacobian =
        constraint_jacobian(model, &tree, &kinematics, (&constraints, longest));
    let constraint_rate = constraint_rates(model, &kinematics, &constraints);
    let nq = kinematics.coordinates.len();
    let nothing = vec![pool.zero(); nq];
    SymbolicSystem {
        derivation: Derivation::Lagrange,
        kinetic_energy: pool.zero(),
        potential_energy: pool.zero(),
        mass_matrix: SparseMatrix::new(nq, nq, Vec::new()),
        bias: nothing.clone(),
        potential_gradient: nothing.clone(),
        resistance: nothing.clone(),
        inverse_dynamics: None,
        applied_force: nothing,
        tree,
        constraints,
        constraint_jacobian,
        constraint_rate,
        wrenches: Vec::new(),
        kinematics,
        contacts: Vec::new(),
        conditions: Vec::new(),
        reaction_values: Vec::new(),
        switches: Vec::new(),
        integrated: None,
    }
}

/// The conditions of latched signals as expressions of the motion.
fn conditions(model: &Model, signals: &[(SymbolId, Expr)]) -> Vec<Expr> {
    let rows = model.held.iter().flat_map(HeldSignal::rows);
    rows.map(|row| model.pool.substitute(row.condition, signals)).collect()
}

/// Q_i = Σ F · ∂r/∂q_i + M · ∂ω/∂q̇_i, as it comes.
pub(crate) fn generalised_force(
    model: &Model,
    kinematics: &Kinematics,
    wrenches: &[Wrench],
) -> Vec<Expr> {
    let powers = powers_of_loads(model, kinematics, wrenches).into_iter();
    powers.map(|terms| model.pool.sum(terms.into_iter().map(|(_, term)| term))).collect()
}

/// Q_i, folded where that is short. A long one stays in factors, and a force along a line is value · ∂(distance)/∂q_i
/// in it.
fn folded_force(
    model: &Model,
    kinematics: &Kinematics,
    wrenches: &[Wrench],
    lines: &[(Range<usize>, AlongLine)],
) -> Vec<Expr> {
    let pool = &model.pool;
    let is_along_line = |wrench: usize| lines.iter().any(|(range, _)| range.contains(&wrench));
    let folded = |(terms, coordinate): (Vec<(usize, Expr)>, &Coordinate)| {
        let sum = pool.sum(terms.iter().map(|&(_, term)| term));
        if pool.multiplied_out(sum) <= MAX_TERMS_OF_FORCE {
            return pool.simplify(sum);
        }
        let others = terms.iter().filter(|&&(wrench, _)| !is_along_line(wrench));
        let others = pool.sum(others.map(|&(_, term)| term));
        let others = pool.simplify_up_to(others, MAX_TERMS_OF_FORCE);
        let slope = |line: &AlongLine| pool.diff(line.distance, coordinate.q);
        let along = lines.iter().map(|(_, line)| pool.mul(line.value, slope(line)));
        pool.sum(along.chain([others]).collect::<Vec<_>>())
    };
    let powers = powers_of_loads(model, kinematics, wrenches).into_iter();
    powers.zip(&kinematics.coordinates).map(folded).collect()
}

/// The terms F · ∂r/∂q_i + M · ∂ω/∂q̇_i by coordinate, each with the number of its wrench.
fn powers_of_loads(
    model: &Model,
    kinematics: &Kinematics,
    wrenches: &[Wrench],
) -> Vec<Vec<(usize, Expr)>> {
    let pool = &model.pool;
    let mut powers = vec![Vec::new(); kinematics.coordinates.len()];
    for (number, wrench) in wrenches.iter().enumerate() {
        let omega = kinematics.poses[wrench.body.0].omega;
        for i in kinematics.coordinates_in(pool, &[wrench.at, omega].concat()) {
            let coordinate = &kinematics.coordinates[i];
            let at = wrench.at.map(|component| pool.diff(component, coordinate.q));
            let turn = omega.map(|component| pool.diff(component, coordinate.v));
            let power = pool.add(
                spatial::dot(pool, &wrench.force, &at),
                spatial::dot(pool, &wrench.moment, &turn),
            );
            powers[i].push((number, power));
        }
    }
    powers
}

/// G = ∂g/∂q, folded where a row has at most `longest` terms. A row of wheels or of a rack, where joints are cut, is
/// that of their wrenches, −Gᵀ, and so is that of an effort in a cut screw, whose turns are counted by its travel: it
/// differs from the gradient by rows of cut joints, so that multipliers of these are their reactions.
pub(crate) fn constraint_jacobian(
    model: &Model,
    tree: &Tree,
    kinematics: &Kinematics,
    (constraints, longest): (&[Constraint], u64),
) -> SparseMatrix {
    let pool = &model.pool;
    let n_columns = kinematics.coordinates.len();
    let mut entries = Vec::new();
    for (row, constraint) in constraints.iter().enumerate() {
        let (columns, slopes): (Vec<usize>, Vec<Expr>) = match constraint.source {
            Source::Coupling(id) if constraint.is_of_rates() => {
                let rate = rate_row(model, kinematics, id);
                let moving = kinematics.coordinates_in(pool, &[rate]);
                let slope = |i: usize| (i, pool.diff(rate, kinematics.coordinates[i].v));
                moving.into_iter().map(slope).unzip()
            }
            _ if has_row_of_wrenches(model, tree, constraint) => {
                let powers = powers(model, kinematics, &constraint.wrenches).into_iter();
                powers.map(|terms| pool.neg(pool.sum(terms))).enumerate().unzip()
            }
            _ => {
                let moving = kinematics.coordinates_in(pool, &[constraint.expression]);
                let symbols: Vec<SymbolId> =
                    moving.iter().map(|&i| kinematics.coordinates[i].q).collect();
                let gradient = pool.gradient(constraint.expression, &symbols);
                (moving, gradient)
            }
        };
        let is_folded = pool.multiplied_out(constraint.expression) <= longest;
        let folded = |slope| if is_folded { folded_slope(pool, slope) } else { slope };
        let slopes = slopes.into_iter().map(folded);
        entries.extend(columns.into_iter().zip(slopes).map(|(i, slope)| (row, i, slope)));
    }
    entries.retain(|&(.., slope)| !pool.is_zero(slope));
    SparseMatrix::new(constraints.len(), n_columns, entries)
}

/// ∂g/∂t; of a condition between rates what it has without them.
fn constraint_rates(
    model: &Model,
    kinematics: &Kinematics,
    constraints: &[Constraint],
) -> Vec<Expr> {
    let pool = &model.pool;
    let rate = |constraint: &Constraint| match constraint.source {
        Source::Coupling(id) if constraint.is_of_rates() => {
            let at_rest: Vec<(SymbolId, Expr)> =
                kinematics.coordinates.iter().map(|c| (c.v, pool.zero())).collect();
            short(pool, pool.substitute(rate_row(model, kinematics, id), &at_rest))
        }
        _ => short(pool, pool.diff(constraint.expression, model.time)),
    };
    constraints.iter().map(rate).collect()
}

/// True where the row of G is that of the wrenches of a constraint, and not the gradient of its expression.
pub(crate) fn has_row_of_wrenches(model: &Model, tree: &Tree, constraint: &Constraint) -> bool {
    let source = constraint.source;
    match source {
        Source::Coupling(CouplingId(coupling)) => {
            model.couplings[coupling].kind.has_row_of_wrenches(!tree.cuts.is_empty())
        }
        Source::Stop(_) if ["rope", "touch"].contains(&constraint.direction) => true,
        Source::Stop(_) if ["forward", "back"].contains(&constraint.direction) => {
            !tree.cuts.is_empty()
        }
        Source::Friction(_) if constraint.is_of_rates() => true,
        Source::Drive(_) | Source::Stop(_) | Source::Friction(_) => {
            source.joint(model).is_some_and(|joint| {
                let is_screw = model.joints[joint.0].kind.lead().is_some();
                is_screw && tree.cuts.contains(&joint)
            })
        }
        Source::Joint(_) => constraint.is_of_rates(),
        Source::Quaternion(_) => false,
    }
}

/// Rows of the cut joints, then of the lengths of quaternions, of couplings, and of the drives:
/// motion(t) − position = 0, so that λ is the effort; then those of contacts. Rows of at most `longest` terms are folded.
fn constraints(
    model: &Model,
    tree: &Tree,
    kinematics: &Kinematics,
    (contacts, longest): (&[ContactRow], u64),
) -> Vec<Constraint> {
    let pool = &model.pool;
    let mut constraints = Vec::new();
    // An author may have called a coordinate or a parameter `ld1`; the multiplier must not be it.
    let of_coordinate =
        |c: &Coordinate| [&c.name, &c.rate_name, &c.second_rate_name].map(String::clone);
    let taken: HashSet<String> = model
        .parameters
        .iter()
        .map(|p| p.name.clone())
        .chain(model.held.iter().map(|signal| signal.name.clone()))
        .chain(kinematics.coordinates.iter().flat_map(of_coordinate))
        .collect();
    let mut add = |expression, source, direction, effort, wrenches: Vec<Wrench>| {
        let mut name = format!("ld{}", constraints.len() + 1);
        while taken.contains(&name) {
            name.push('_');
        }
        let lambda = pool.symbol(&name);
        let lambda = pool.symbol_id(lambda).expect("a symbol was just made");
        let expression = pool.simplify_up_to(expression, longest);
        let row = Constraint { expression, lambda, source, direction, effort, wrenches };
        constraints.push(row);
    };
    // Cut joints, quaternions, couplings, drives, contacts.
    for &joint_id in &tree.cuts {
        let joint = &model.joints[joint_id.0];
        for row in joint::constraint_rows(pool, joint, &kinematics.sides(model, joint)) {
            let is_force = row.wrench.force.iter().any(|&component| !pool.is_zero(component));
            let effort = if is_force { MotionKind::Translation } else { MotionKind::Rotation };
            let wrenches = Wrench::through_joint(model, kinematics, joint_id, &row.wrench);
            add(row.expression, Source::Joint(joint_id), row.direction, effort, wrenches);
        }
    }
    for turning in &kinematics.turnings {
        let source = Source::Quaternion(turning.body);
        add(norm::row(pool, turning), source, "norm", MotionKind::Rotation, Vec::new());
    }
    for row in coupling_rows(model, kinematics) {
        let coupling = &model.couplings[row.coupling.0];
        let (expression, direction) = match coupling.kind {
            CouplingKind::Rate => (pool.zero(), "rate"),
            _ => (row.expression, "coupling"),
        };
        let source = Source::Coupling(row.coupling);
        add(expression, source, direction, coupling.effort, row.wrenches);
    }
    for (drive_idx, drive) in model.drives.iter().enumerate() {
        let joint = &model.joints[drive.joint.0];
        let positions = kinematics.joint_positions(model, drive.joint);
        let sides = kinematics.sides(model, joint);
        let wrench = joint::effort(pool, joint, drive.motion_idx, &positions, &sides);
        let off = pool.sub(drive.motion, positions[drive.motion_idx]);
        // An angle that counts no turns is held up to whole turns.
        let expression = if kinematics.is_within_turn(model, drive.joint, drive.motion_idx) {
            pool.atan2(pool.sin(off), pool.cos(off))
        } else {
            off
        };
        let wrenches = Wrench::through_joint(model, kinematics, drive.joint, &wrench);
        let effort = joint.kind.motions()[drive.motion_idx];
        add(expression, Source::Drive(DriveId(drive_idx)), "motion", effort, wrenches);
    }
    for row in contacts {
        add(row.expression, row.source, row.direction, row.effort, row.wrenches.clone());
    }
    constraints
}
