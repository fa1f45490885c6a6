//! Powers of the parts of a model, each by itself: what a run's energy comes from and where it goes.
//!
//! ```text
//! d/dt (T + V) = Σ Q_k · v + Σ λ_j ∂g_j/∂t + Σ λ_f ṗ_f
//! ```
//!
//! Q_k are the generalised forces of load k without those that its potential stands for, g_j the rows that time moves,
//! λ_f the friction along the motion p_f.

use bksim_expr::{Expr, SymbolId};

use crate::assemble::generalised_force;
use crate::belt;
use crate::constraint::Source;
use crate::contact::{Contact, Law};
use crate::coordinate::Owner;
use crate::force::{self, Wrench};
use crate::mesh;
use crate::rope;
use crate::signal::signal_values;
use crate::system::SymbolicSystem;
use bksim_model::{BeltId, CouplingId, DriveId, JointId, Load, LoadId, Model, RopeId};

/// A part that gives or takes energy.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Actor {
    /// A load; friction is one.
    Load(LoadId),
    /// A belt that stretches.
    Belt(BeltId),
    /// A rope that stretches.
    Rope(RopeId),
    /// A prescribed motion.
    Drive(DriveId),
    /// A coupling whose relation time moves.
    Coupling(CouplingId),
    /// A joint whose dimensions time moves.
    Joint(JointId),
}

/// The power of a part.
#[derive(Clone, Copy, Debug)]
pub struct Power {
    /// The part.
    pub actor: Actor,
    /// Power that it gives to the bodies, W, of t, q, v and λ, without that of its potential.
    pub power: Expr,
    /// Potential of the part, J; zero of a part without one.
    pub potential: Expr,
}

impl Actor {
    /// The kind of part and its name, as a model file has them.
    pub fn named(self, model: &Model) -> (&'static str, &str) {
        match self {
            Self::Load(LoadId(k)) => ("load", &model.loads[k].name),
            Self::Belt(BeltId(k)) => ("belt", &model.belts[k].name),
            Self::Rope(RopeId(k)) => ("rope", &model.ropes[k].name),
            Self::Drive(DriveId(k)) => ("drive", &model.drives[k].name),
            Self::Coupling(CouplingId(k)) => ("coupling", &model.couplings[k].name),
            Self::Joint(JointId(k)) => ("joint", &model.joints[k].name),
        }
    }
}

/// The powers of all parts that have one or a potential, in the order of loads, belts, ropes, drives, couplings and joints.
/// They may hold the symbols of signals that are held, and are meant for states within a phase of a run.
pub fn powers(model: &Model, system: &SymbolicSystem) -> Vec<Power> {
    let pool = &model.pool;
    let signals = signal_values(model, &system.kinematics);
    let mut found = of_loads(model, system, &signals);
    let unit = |k: usize| belt::elastic_wrenches_of(model, &system.kinematics, &signals, BeltId(k));
    found.extend((0..model.belts.len()).map(|k| Power {
        actor: Actor::Belt(BeltId(k)),
        power: power_of(model, system, &unit(k)),
        potential: pool.zero(),
    }));
    let of_rope = |k: usize| rope::elastic_wrenches(model, &system.kinematics, &signals, RopeId(k));
    found.extend((0..model.ropes.len()).map(|k| Power {
        actor: Actor::Rope(RopeId(k)),
        power: power_of(model, system, &of_rope(k)),
        potential: pool.zero(),
    }));
    found.extend(of_moved_rows(model, system));

    // Signals of reactions stand for multipliers.
    let powers: Vec<Expr> = found.iter().map(|power| power.power).collect();
    let powers = pool.substitute_all(&powers, &system.reaction_values);
    found.iter_mut().zip(powers).for_each(|(found, power)| found.power = power);
    found.retain(|found| !pool.is_zero(found.power) || !pool.is_zero(found.potential));
    found
}

/// Loads: their wrenches, their efforts on the parameters of curves, and friction by its multiplier.
fn of_loads(model: &Model, system: &SymbolicSystem, signals: &[(SymbolId, Expr)]) -> Vec<Power> {
    let pool = &model.pool;
    let kinematics = &system.kinematics;
    let of_load = |(k, load): (usize, &Load)| {
        let id = LoadId(k);
        let action = force::action(model, kinematics, signals, &load.kind);
        let mesh = mesh::elastic_wrenches(model, kinematics, signals, &load.kind);
        let applied = [action.applied, mesh].concat();
        let mut terms = vec![power_of(model, system, &applied)];
        let on_curve = force::effort_on_curve(model, kinematics, signals, load);
        terms.extend(on_curve.and_then(|(joint, motion_idx, effort)| {
            let owner = Owner::Joint(joint, motion_idx);
            let coordinate = kinematics.coordinates.iter().find(|c| c.owner == owner)?;
            Some(pool.mul(effort, pool.symbol_expr(coordinate.v)))
        }));
        let rubs =
            |contact: &&Contact| contact.load == id && matches!(contact.law, Law::Friction { .. });
        terms.extend(system.contacts.iter().filter(rubs).map(|contact| {
            let lambda = pool.symbol_expr(system.constraints[contact.row].lambda);
            pool.mul(lambda, contact.rate)
        }));
        let potential = action.potential.unwrap_or(pool.zero());
        Power { actor: Actor::Load(id), power: pool.sum(terms), potential }
    };
    model.loads.iter().enumerate().map(of_load).collect()
}

/// Rows that time moves, those of one part together.
fn of_moved_rows(model: &Model, system: &SymbolicSystem) -> Vec<Power> {
    let pool = &model.pool;
    let actor = |source| match source {
        Source::Drive(id) => Some(Actor::Drive(id)),
        Source::Coupling(id) => Some(Actor::Coupling(id)),
        Source::Joint(id) => Some(Actor::Joint(id)),
        Source::Quaternion(_) | Source::Stop(_) | Source::Friction(_) => None,
    };
    let mut found: Vec<Power> = Vec::new();
    for (row, &rate) in system.constraints.iter().zip(&system.constraint_rate) {
        let Some(actor) = actor(row.source).filter(|_| !pool.is_zero(rate)) else { continue };
        let power = pool.mul(rate, pool.symbol_expr(row.lambda));
        match found.iter_mut().find(|known| known.actor == actor) {
            Some(known) => known.power = pool.add(known.power, power),
            None => found.push(Power { actor, power, potential: pool.zero() }),
        }
    }
    let rank = |actor: Actor| match actor {
        Actor::Drive(_) => 0,
        Actor::Coupling(_) => 1,
        _ => 2,
    };
    found.sort_by_key(|power| rank(power.actor));
    found
}

/// Q · v of wrenches.
fn power_of(model: &Model, system: &SymbolicSystem, wrenches: &[Wrench]) -> Expr {
    let pool = &model.pool;
    if wrenches.is_empty() {
        return pool.zero();
    }
    let forces = generalised_force(model, &system.kinematics, wrenches);
    let coordinates = system.coordinates().iter();
    let terms = coordinates.zip(forces).map(|(c, force)| pool.mul(force, pool.symbol_expr(c.v)));
    pool.sum(terms.collect::<Vec<_>>())
}
