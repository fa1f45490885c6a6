//! The truth of reactions: which of their components are the same in every solution of the equilibrium.
//!
//! ```text
//! W R = loads and inertia of the bodies,    W N = 0,    R + N s solves it for any s
//! ```
//!
//! The columns of W are the wrenches that joints, drives, closed stops and sticking friction can put on
//! the bodies, whether or not a joint is cut; columns of N are the self-stresses, wrenches in
//! equilibrium without any load. A component of a reaction is unique when no self-stress has it. The
//! Gᵀ of the equations of motion is W along the motions that the tree leaves: it has neither the joints of
//! the tree nor rows that fold to 0 = 0.
//!
//! Self-stresses live in loops. Those of loops that share no joint have nothing to do with each
//! other, so W is taken block by block: joints whose loops share joints (the connected parts of the
//! cycle matroid; J. Oxley, *Matroid Theory*, 2nd ed. 2011, §4.1). A joint that every path passes is
//! never in one. W Wᵀ keeps the sparsity of the joint graph: nothing here is dense.
//!
//! Source: M. Wojtyra and J. Frączek, *Solvability of reactions in rigid multibody systems with
//! redundant nonholonomic constraints*, Multibody System Dynamics 30 (2013) 153.

mod block;
mod blocks;
mod conditions;
mod sharing;
mod transmissions;

use bksim_expr::{SymbolId, TapeError};
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{CouplingId, DriveId, JointId, LoadId, Model};

use crate::modes::indicators::EventIndicators;
use crate::modes::{ContactMode, Modes};

pub use self::conditions::{Condition, Direction, Keeper, RepeatedCondition};
pub(crate) use self::transmissions::Transmissions;

/// Which components of the reactions are the same in every solution of the equilibrium.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Uniqueness {
    /// By joint: fx, fy, fz, mx, my, mz as in [`Sample::reactions`](crate::run::Sample::reactions).
    pub reactions: Vec<[bool; 6]>,
    /// The forces of the couplings, in the order of the model.
    pub couplings: Vec<bool>,
    /// The efforts of the drives, in the order of the model.
    pub drives: Vec<bool>,
    /// The forces of stops and friction, by contact in the order of the system's rows.
    pub contacts: Vec<bool>,
    /// Number of independent self-stresses: of conditions that repeat others.
    pub n_self_stresses: usize,
}

/// True where the compliances of joints decide what they share.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Yields {
    /// They do.
    AsStated,
    /// All joints are rigid.
    Never,
}

/// Which components are unique from an instant on, and why others are not.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Redundancy {
    /// Uniqueness with all that is driven, closed or stuck there.
    pub(crate) uniqueness: Uniqueness,
    /// Of the joints among themselves, were all of them rigid.
    pub(crate) of_joints: Uniqueness,
    /// The conditions of joints and couplings that follow from others.
    pub(crate) repeated: Vec<RepeatedCondition>,
}

/// Where a motion stands: time, positions, velocities, accelerations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MovingInstant<'a> {
    pub(crate) t: f64,
    pub(crate) q: &'a [f64],
    pub(crate) v: &'a [f64],
    pub(crate) a: &'a [f64],
}

/// Uniqueness from an instant on.
#[derive(Clone, PartialEq, Debug)]
pub struct UniquenessChange {
    /// s.
    pub t: f64,
    /// The uniqueness from there to the next change.
    pub uniqueness: Uniqueness,
}

/// Reactions in equilibrium without any load; its largest component is about one, N.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct SelfStress {
    /// Joints that take part: force N and moment N m on the successor, world axes.
    pub reactions: Vec<(JointId, [f64; 6])>,
    /// Efforts that take part, N or N m.
    pub efforts: Vec<(Effort, f64)>,
}

/// A force along a motion of a joint that is not part of the joint's reaction.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Effort {
    /// Of a coupling.
    Coupling(CouplingId),
    /// Of a drive.
    Drive(DriveId),
    /// Of a stop or of friction that sticks: the contact of this index.
    Contact(usize, LoadId),
}

/// How far ahead of an instant the motion is looked at, part of a radian or of a metre: components
/// that vanish in one pose alone have grown beyond rounding there, and the constraints hold to it squared.
const AHEAD: f64 = 3e-5;
/// Rates below this, rad/s or m/s, have no direction.
const AT_REST: f64 = 1e-9;

impl Effort {
    /// True if it is there in these modes.
    pub(crate) fn acts_in(self, modes: &Modes) -> bool {
        match self {
            Self::Coupling(_) | Self::Drive(_) => true,
            Self::Contact(contact_idx, _) => modes.contacts[contact_idx].is_active(),
        }
    }

    /// True of the force of one of these contacts.
    pub(crate) fn is_of_contact(self, contacts: &[usize]) -> bool {
        matches!(self, Self::Contact(contact_idx, _) if contacts.contains(&contact_idx))
    }
}

impl Transmissions {
    /// Which components are unique in the motion from an instant on, with the efforts that `acts` says are
    /// there. A component that a self-stress has not in this pose alone, and a self-stress that
    /// only this pose has, do not count; nor do those that joints decide which yield.
    pub(crate) fn uniqueness(
        &self,
        parameters: &[f64],
        at: MovingInstant<'_>,
        acts: &dyn Fn(Effort) -> bool,
        yields: Yields,
    ) -> Uniqueness {
        let mut unique = self.all_unique();
        if !self.are_shared() {
            return unique;
        }
        let here = self.open_stresses(parameters, (at.t, at.q), acts, yields);
        if here.is_empty() {
            return unique;
        }
        let ahead = self.open_stresses(parameters, (at.t, &at.ahead()), acts, yields);
        let is_lasting = here.len() <= ahead.len();
        if is_lasting {
            for stress in &here {
                unique.exclude(stress);
            }
        }
        if !is_lasting || here.len() == ahead.len() {
            for stress in &ahead {
                unique.exclude(stress);
            }
        }
        unique.n_self_stresses = here.len().min(ahead.len());
        unique
    }

    /// All of these in the motion from an instant on, with the efforts that `acts` says are there.
    pub(crate) fn redundancy(
        &self,
        parameters: &[f64],
        at: MovingInstant<'_>,
        acts: &dyn Fn(Effort) -> bool,
    ) -> Redundancy {
        // Most often nothing is shared, neither then without some of the efforts.
        if self.open_stresses(parameters, (at.t, at.q), acts, Yields::Never).is_empty() {
            let unique = self.all_unique();
            return Redundancy {
                uniqueness: unique.clone(),
                of_joints: unique,
                repeated: Vec::new(),
            };
        }
        Redundancy {
            uniqueness: self.uniqueness(parameters, at, acts, Yields::AsStated),
            of_joints: self.uniqueness(parameters, at, &|_| false, Yields::Never),
            repeated: self.lasting_conditions(parameters, at),
        }
    }

    /// The conditions that follow from others in the motion from an instant on: as many as there are self-stresses of the
    /// joints alone.
    fn lasting_conditions(
        &self,
        parameters: &[f64],
        at: MovingInstant<'_>,
    ) -> Vec<RepeatedCondition> {
        let here = self.repeated_conditions(parameters, (at.t, at.q));
        if here.is_empty() {
            return here;
        }
        let ahead = self.repeated_conditions(parameters, (at.t, &at.ahead()));
        if here.len() <= ahead.len() { here } else { ahead }
    }
}

/// The conditions of the joints and couplings of `model` that follow from those before them, at the coordinates `q` of
/// `system` and these values of the parameters.
///
/// # Errors
/// [`TapeError`] when an expression cannot be compiled.
pub fn repeated_conditions(
    model: &Model,
    system: &SymbolicSystem,
    parameters: &[f64],
    at: (f64, &[f64]),
) -> Result<Vec<RepeatedCondition>, TapeError> {
    let q: Vec<SymbolId> = system.coordinates().iter().map(|c| c.q).collect();
    let symbols: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
    let transmissions = Transmissions::compile(model, system, &q, &symbols)?;
    Ok(transmissions.repeated_conditions(parameters, at))
}

/// Contacts with friction that slips in name alone: something else holds the motion, and any force up to the one
/// that it sticks with would do.
pub(crate) fn resting(
    indicators: &EventIndicators,
    parameters: &[f64],
    MovingInstant { t, q, v, a }: MovingInstant<'_>,
    modes: &Modes,
) -> Vec<usize> {
    let slips = |mode: &ContactMode| matches!(mode, ContactMode::Slip(sign) if *sign != 0.0);
    if !modes.contacts.iter().any(slips) {
        return Vec::new();
    }
    let mut evaluator = indicators.at(parameters);
    let values = evaluator.values(t, q, v).clone();
    let rates = evaluator.rates(t, q, v, a);
    let rests = |contact_idx: usize| {
        let rates = [values.contacts[contact_idx].rate(), rates.contacts[contact_idx]];
        rates.iter().all(|rate| rate.abs() <= AT_REST)
    };
    let is_held = |&contact_idx: &usize| {
        let other = indicators.contacts[contact_idx].other;
        slips(&modes.contacts[contact_idx]) && rests(contact_idx) && other.is_none_or(rests)
    };
    (0..modes.contacts.len()).filter(is_held).collect()
}

fn largest(rates: &[f64]) -> f64 {
    rates.iter().fold(0.0, |largest: f64, rate| largest.max(rate.abs()))
}

impl MovingInstant<'_> {
    /// Positions a little later; those of the instant itself where nothing moves.
    fn ahead(&self) -> Vec<f64> {
        let along = if largest(self.v) > AT_REST { self.v } else { self.a };
        let step = AHEAD / largest(along);
        let moved = |(q, rate): (&f64, &f64)| if step.is_finite() { q + step * rate } else { *q };
        self.q.iter().zip(along).map(moved).collect()
    }
}

impl Uniqueness {
    /// Everything is unique.
    pub(crate) fn all([n_joints, n_couplings, n_drives, n_contacts]: [usize; 4]) -> Self {
        Self {
            reactions: vec![[true; 6]; n_joints],
            couplings: vec![true; n_couplings],
            drives: vec![true; n_drives],
            contacts: vec![true; n_contacts],
            n_self_stresses: 0,
        }
    }

    /// True if every component is unique.
    pub fn is_complete(&self) -> bool {
        self.n_self_stresses == 0
    }

    /// The joints with a component that is not unique.
    pub fn shared_joints(&self) -> impl Iterator<Item = JointId> {
        let joints = self.reactions.iter().enumerate();
        joints.filter(|(_, six)| six.contains(&false)).map(|(joint_idx, _)| JointId(joint_idx))
    }

    /// Takes what has a part in a self-stress as not unique.
    pub(crate) fn exclude(&mut self, stress: &SelfStress) {
        for (joint, six) in &stress.reactions {
            let unique = &mut self.reactions[joint.0];
            unique.iter_mut().zip(six).for_each(|(unique, &part)| *unique &= part == 0.0);
        }
        for &(effort, part) in &stress.efforts {
            let unique = match effort {
                Effort::Coupling(coupling) => &mut self.couplings[coupling.0],
                Effort::Drive(drive) => &mut self.drives[drive.0],
                Effort::Contact(contact_idx, _) => &mut self.contacts[contact_idx],
            };
            *unique &= part == 0.0;
        }
    }
}
