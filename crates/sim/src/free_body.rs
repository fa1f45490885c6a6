//! [`FreeBody`]: a body that is cut free, with every wrench on it by the part of the model that it comes from.

use bksim_expr::TapeError;
use bksim_mbs::acting::{self, Acting};
use bksim_mbs::force::Wrench;
use bksim_mbs::power::Actor;
use bksim_model::{BodyId, ContactId, JointId, Model};

use crate::Mechanism;
use crate::run::Sample;
use crate::wrenches::{WrenchAt, Wrenches};

/// The part of a model that a wrench on a body comes from.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Origin {
    /// The reaction of a joint.
    Joint(JointId),
    /// All places of a contact, with their friction.
    Contact(ContactId),
    /// A load, belt, rope, drive or coupling.
    Actor(Actor),
    /// The inertia of the body, by d'Alembert.
    Inertia,
}

/// The wrenches of one origin.
#[derive(Clone, Debug)]
struct Part {
    origin: Origin,
    /// Wrenches, first the ones that decide where the sum acts.
    wrenches: Vec<Wrench>,
    n_places: usize,
    /// The sign of the reaction on this body.
    sign: f64,
}

/// All that acts on one body, compiled. With its inertia it is in balance.
#[derive(Clone, Debug)]
pub struct FreeBody {
    parts: Vec<Part>,
    wrenches: Wrenches,
}

impl Origin {
    /// The kind of part and its name, as a model file has them; the inertia has neither.
    pub fn named(self, model: &Model) -> (&'static str, &str) {
        match self {
            Self::Joint(JointId(k)) => ("joint", &model.joints[k].name),
            Self::Contact(ContactId(k)) => ("contact", &model.contacts[k].name),
            Self::Actor(actor) => actor.named(model),
            Self::Inertia => ("", ""),
        }
    }

    /// True of a load that is gravity.
    pub fn is_gravity(self, model: &Model) -> bool {
        matches!(self, Self::Actor(Actor::Load(load)) if model.loads[load.0].kind.gravity().is_some())
    }
}

impl FreeBody {
    /// Compiles all wrenches on a body: joints first, in file order, then its inertia, then all else.
    ///
    /// # Errors
    /// [`TapeError`] as of [`Wrenches::compile`].
    pub fn compile(mechanism: &Mechanism, body: BodyId) -> Result<Self, TapeError> {
        let Mechanism { model, system, .. } = mechanism;
        let mut parts: Vec<Part> = Vec::new();
        for (idx, joint) in model.joints.iter().enumerate() {
            let sign = if joint.successor.body == body { 1.0 } else { -1.0 };
            if sign > 0.0 || joint.predecessor.body == body {
                let wrenches = vec![acting::point_of(model, system, JointId(idx))];
                parts.push(Part {
                    origin: Origin::Joint(JointId(idx)),
                    wrenches,
                    n_places: 1,
                    sign,
                });
            }
        }
        let inertia = vec![acting::inertia(model, system, body)];
        parts.push(Part { origin: Origin::Inertia, wrenches: inertia, n_places: 1, sign: 1.0 });
        for Acting { actor, wrench } in acting::acting(model, system) {
            if wrench.body != body {
                continue;
            }
            let (origin, is_place) = origin_of(model, actor);
            if let Some(part) = parts.iter_mut().find(|part| part.origin == origin) {
                let at = if is_place { part.n_places } else { part.wrenches.len() };
                part.wrenches.insert(at, wrench);
                part.n_places += usize::from(is_place);
            } else {
                let (wrenches, n_places) = (vec![wrench], usize::from(is_place));
                parts.push(Part { origin, wrenches, n_places, sign: 1.0 });
            }
        }
        let all: Vec<Wrench> = parts.iter().flat_map(|part| part.wrenches.clone()).collect();
        Ok(Self { parts, wrenches: Wrenches::compile(mechanism, &all)? })
    }

    /// The parts that act on the body, in the order of [`FreeBody::at`].
    pub fn origins(&self) -> impl Iterator<Item = Origin> + '_ {
        self.parts.iter().map(|part| part.origin)
    }

    /// The wrench of each part on the body, world axes, at a sample with the modes that hold there.
    ///
    /// # Panics
    /// If the sample or the modes are those of another mechanism.
    pub fn at(&mut self, sample: &Sample, modes: &[f64]) -> Vec<WrenchAt> {
        let all = self.wrenches.at(sample, modes);
        let mut rest = &all[..];
        let of_part = |part: &Part| {
            let (own, others) = rest.split_at(part.wrenches.len());
            rest = others;
            let mut sum = WrenchAt::sum(own, part.n_places);
            if let Origin::Joint(joint) = part.origin {
                let [fx, fy, fz, mx, my, mz] = sample.reactions[joint.0].map(|x| part.sign * x);
                (sum.force, sum.moment) = ([fx, fy, fz], [mx, my, mz]);
            }
            sum
        };
        self.parts.iter().map(of_part).collect()
    }
}

/// The part that an actor is shown as, and true if its wrenches have the place where they act: friction of a contact may be
/// stated at any point of its line.
fn origin_of(model: &Model, actor: Actor) -> (Origin, bool) {
    if let Actor::Load(load) = actor {
        let load = &model.loads[load.0];
        if let Some(contact) = load.contact() {
            return (Origin::Contact(contact), load.kind.touch().is_some());
        }
    }
    (Origin::Actor(actor), true)
}
