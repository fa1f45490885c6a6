//! Equations besides those of motion: the constraints at velocity and acceleration level, the free bodies, the effort
//! of a drive.
//!
//! ```text
//! ġ = G v + ∂g/∂t = 0        g̈ = G v̇ + γ = 0
//! m r̈_c = Σ F                d/dt L_c = Σ (M + (r − r_c) × F)
//! ```
//!
//! The effort of a drive is explicit, too: with v = K ṡ for the rate ṡ of the only drive, no other constraint does work, so that
//!
//! ```text
//! λ = Kᵀ (M v̇ + h + ∂V/∂q − Q)
//! ```
//!
//! In the equations of a body its neighbours act by the components of reactions, `A_fx` on the second body of the
//! joint A and −`A_fx` on the first, and loads, drives and contacts by their own formulas.

use bksim_expr::{Expr, Number, Pool, SymbolId};
use bksim_model::{BodyId, Model, MotionKind, Space, Vector};

use super::arrange::{Kind, to_be_read};
use super::form::ReadingForm;
use crate::constraint::Source;
use crate::force::Wrench;
use crate::inertia::central_inertia;
use crate::levels::{constraint_acceleration, constraint_velocity};
use crate::spatial;
use crate::system::SymbolicSystem;

/// A section of equations.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Level {
    /// Heading.
    pub title: &'static str,
    /// True of a step of the derivation, whose rows are `name = value`; else each row is `name: left side = 0`.
    pub is_step: bool,
    /// The name of each row, and its value or left side.
    pub rows: Vec<(RowName, Expr)>,
}

/// The name of a row.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum RowName {
    /// A symbol.
    Symbol(Expr),
    /// L = T − V.
    Lagrangian,
    /// ∂L/∂q̇ by this velocity.
    ByRate(SymbolId),
    /// d/dt ∂L/∂q̇ by this velocity.
    RateOf(SymbolId),
    /// ∂L/∂q by this coordinate.
    By(SymbolId),
    /// The generalised force Q of this coordinate.
    Load(SymbolId),
    /// Σ λ ∂g/∂q by this coordinate.
    OfConstraints(SymbolId),
}

/// Equations that are zero, by symbols.
fn zero_rows(title: &'static str, rows: impl IntoIterator<Item = (Expr, Expr)>) -> Level {
    let rows = rows.into_iter().map(|(name, left)| (RowName::Symbol(name), left)).collect();
    Level { title, is_step: false, rows }
}

/// The velocity and the acceleration equations of the rows that always hold.
pub fn levels(model: &Model, system: &SymbolicSystem) -> [Level; 2] {
    let pool = &model.pool;
    let system = &to_be_read(model, system);
    let rows = |of: &dyn Fn(usize) -> Expr| {
        let row = |k: usize| {
            let left = multiplied_out(pool, pool.simplify(of(k)));
            (pool.symbol_expr(system.constraints[k].lambda), pool.as_written(&[left])[0])
        };
        (0..system.n_bilateral()).map(row).collect::<Vec<_>>()
    };
    [
        zero_rows("velocity equations", rows(&|k| constraint_velocity(pool, system, k))),
        zero_rows("acceleration equations", rows(&|k| constraint_acceleration(model, system, k))),
    ]
}

/// A sum without the number before it.
fn multiplied_out(pool: &Pool, e: Expr) -> Expr {
    match pool.factors(e)[..] {
        [(number, 1), (sum, 1)] if pool.as_number(number).is_some() => {
            pool.sum(pool.sum_terms(sum).into_iter().map(|term| pool.mul(number, term)))
        }
        _ => e,
    }
}

/// The velocity and the acceleration equations with the numbers of a state, six digits each; `value` has the value of
/// a parameter, the time, a coordinate or a velocity.
pub fn levels_at(
    model: &Model,
    system: &SymbolicSystem,
    value: &dyn Fn(SymbolId) -> Option<f64>,
) -> [Level; 2] {
    let pool = &model.pool;
    let coordinates = system.coordinates();
    let unknowns: [Vec<SymbolId>; 2] =
        [coordinates.iter().map(|c| c.v).collect(), coordinates.iter().map(|c| c.a).collect()];
    let titles = ["velocity equations, numbers", "acceleration equations, numbers"];
    let mut found = levels(model, system);
    for ((level, unknowns), title) in found.iter_mut().zip(&unknowns).zip(titles) {
        level.title = title;
        for (_, row) in &mut level.rows {
            // Linear: its slopes, and its value where all unknowns are zero.
            let nothing = |symbol: SymbolId| {
                if unknowns.contains(&symbol) { Some(0.0) } else { value(symbol) }
            };
            let number = |e: Expr| pool.evaluate(e, &nothing).map_or(f64::NAN, rounded);
            let terms = unknowns.iter().filter_map(|&unknown| {
                let slope = number(pool.diff(*row, unknown));
                let is_there = slope != 0.0;
                is_there
                    .then(|| pool.mul(pool.number(Number::float(slope)), pool.symbol_expr(unknown)))
            });
            let constant = pool.number(Number::float(number(*row)));
            *row = pool.sum(terms.chain([constant]).collect::<Vec<_>>());
        }
    }
    found
}

/// Six digits of a number; what is far below one is rounding.
fn rounded(value: f64) -> f64 {
    if value.abs() < 1e-12 { 0.0 } else { format!("{value:.5e}").parse().unwrap_or(value) }
}

/// Coordinates up to which velocities by that of a drive are solved for.
const MOST_EXPLICIT: usize = 12;

/// The velocities by that of the only drive, and its effort by them, with the named constants of `form`; none of a
/// mechanism with other free motions, drives or constraints that change with time, stops or friction, or with
/// conditions that repeat others.
///
/// `K_phi` is the velocity of the coordinate `phi` for a drive that moves at the rate one.
pub fn drive_effort(model: &Model, system: &SymbolicSystem, form: &ReadingForm) -> Vec<Level> {
    explicit_effort(model, system, form).map_or_else(Vec::new, Vec::from)
}

fn explicit_effort(
    model: &Model,
    system: &SymbolicSystem,
    form: &ReadingForm,
) -> Option<[Level; 2]> {
    let pool = &model.pool;
    let system = &to_be_read(model, system);
    let (n, coordinates) = (system.n_bilateral(), system.coordinates());
    let is_drive = |k: &usize| matches!(system.constraints[*k].source, Source::Drive(_));
    let mut drives = (0..n).filter(is_drive);
    let (Some(drive), None) = (drives.next(), drives.next()) else { return None };
    let moves = (0..n).any(|k| k != drive && !pool.is_zero(system.constraint_rate[k]));
    let is_square = n == coordinates.len() && n <= MOST_EXPLICIT;
    if moves || !is_square || !system.contacts.is_empty() {
        return None;
    }

    // The loops, and one for the drive: its row is the motion less what it moves.
    let named: Vec<Expr> =
        coordinates.iter().map(|c| pool.symbol(&format!("K_{}", c.name))).collect();
    let unknowns: Option<Vec<SymbolId>> = named.iter().map(|&k| pool.symbol_id(k)).collect();
    let equation = |k: usize| {
        let terms = system.constraint_jacobian.row(k).iter().map(|&(i, g)| pool.mul(g, named[i]));
        let sum = pool.sum(terms.collect::<Vec<_>>());
        if k == drive { pool.add(sum, pool.one()) } else { sum }
    };
    let equations: Vec<Expr> = (0..n).map(equation).collect();
    let solution = pool.solve_linear(&equations, &unknowns?).ok()?;
    let values = pool.cancel(&solution.values).roots;

    // The power of inertia and of all forces, less what does none.
    let factor = |i: usize| if pool.as_number(values[i]).is_some() { values[i] } else { named[i] };
    let needed = |i: usize| {
        let parts = form.equations[i].iter().filter(|part| part.kind != Kind::Constraint);
        pool.mul(factor(i), pool.sum(parts.flat_map(|part| part.terms(pool)).collect::<Vec<_>>()))
    };
    let effort = pool.symbol_expr(system.constraints[drive].lambda);
    let power = pool.sum((0..n).map(needed).collect::<Vec<_>>());
    let is_formula = |i: &usize| pool.as_number(values[*i]).is_none();
    let rates = (0..n).filter(is_formula).map(|i| (named[i], pool.sub(named[i], values[i])));
    Some([
        zero_rows("velocities by that of the drive", rates),
        zero_rows("effort of the drive", [(effort, pool.sub(effort, power))]),
    ])
}

/// The balance of each body that is cut free: forces, then moments about the centre of mass.
pub fn free_bodies(model: &Model, system: &SymbolicSystem) -> Level {
    let pool = &model.pool;
    let mut wrenches: Vec<Vec<Wrench>> = vec![Vec::new(); model.bodies.len()];
    let mut add = |wrench: Wrench| wrenches[wrench.body.0].push(wrench);
    system.wrenches.iter().cloned().for_each(&mut add);
    // Drives, couplings and contacts by their multipliers, joints by the components of their reactions.
    for row in &system.constraints {
        if !matches!(row.source, Source::Joint(_) | Source::Quaternion(_)) {
            let lambda = pool.symbol_expr(row.lambda);
            row.wrenches.iter().for_each(|wrench| add(wrench.scaled(pool, lambda)));
        }
    }
    for joint in model.joints.iter().filter(|joint| !joint.kind.is_cylinder()) {
        let is_planar = model.space == Space::Planar;
        let turns = joint.kind.motions().contains(&MotionKind::Rotation);
        let component = |word: &str, is_there: bool| {
            if is_there { pool.symbol(&format!("{}_{word}", joint.name)) } else { pool.zero() }
        };
        let force = [("fx", true), ("fy", true), ("fz", !is_planar)];
        let moment = [("mx", !is_planar), ("my", !is_planar), ("mz", !(is_planar && turns))];
        let [force, moment] = [force, moment].map(|all| all.map(|(word, is)| component(word, is)));
        let at = system.kinematics.anchor(model, joint.successor);
        add(Wrench { body: joint.successor.body, force, at, moment });
        let [force, moment] = [force, moment].map(|of: Vector| of.map(|e| pool.neg(e)));
        add(Wrench { body: joint.predecessor.body, force, at, moment });
    }
    let bodies = (1..model.bodies.len()).map(BodyId);
    let rows = bodies.flat_map(|body| balance(model, system, body, &wrenches[body.0]));
    zero_rows("free bodies", rows)
}

/// The balance of forces and moments of one body.
fn balance(
    model: &Model,
    system: &SymbolicSystem,
    body: BodyId,
    wrenches: &[Wrench],
) -> Vec<(Expr, Expr)> {
    let pool = &model.pool;
    let own = &model.bodies[body.0];
    let symbol = |word: &str| pool.symbol(&format!("{}_{word}", own.name));
    let p_com = system.kinematics.position(model, body, None);
    let (mut force, mut moment) = (spatial::zero(pool), spatial::zero(pool));
    for wrench in wrenches {
        let arm = spatial::sub(pool, &wrench.at, &p_com);
        force = spatial::add(pool, &force, &wrench.force);
        moment = spatial::add(pool, &moment, &wrench.moment);
        moment = spatial::add(pool, &moment, &spatial::cross(pool, &arm, &wrench.force));
    }
    let row = |name: &str, inertia: Expr, acting: Expr| {
        (symbol(name), pool.sub(inertia, pool.simplify(acting)))
    };
    let n_axes = if model.space == Space::Planar { 2 } else { 3 };
    let axes = ["x", "y", "z"];
    let forces = (0..n_axes).map(|k| {
        let acceleration = symbol(&format!("a{}", axes[k]));
        row(axes[k], pool.mul(own.mass, acceleration), force[k])
    });
    let mut rows: Vec<(Expr, Expr)> = forces.collect();
    if model.space == Space::Planar {
        let inertia = central_inertia(model, body)[2][2];
        rows.push(row("turn", pool.mul(inertia, symbol("alz")), moment[2]));
    } else {
        // The rate of the angular momentum about the centre of mass, along the axes of the ground.
        rows.extend((0..3).map(|k| {
            row(&format!("turn_{}", axes[k]), symbol(&format!("l{}_dot", axes[k])), moment[k])
        }));
    }
    rows
}
