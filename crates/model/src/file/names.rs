//! [`Names`]: every name of the model and its meaning.

use std::collections::{BTreeMap, BTreeSet};

use bksim_expr::{Expr, Pool};

use super::units::Quantity;
use super::value::Lowered;
use crate::diagnostic::Span;
use crate::ids::{BodyId, ClockId, ContactId, DriveId, JointId, PointId};
use crate::joint::{MotionKind, motion_words};
use crate::measure::{ContactPart, LinePart, Measure, Resultant, Signal};
use crate::measure_names::{
    ACCELERATION_WORDS, BODY_WORDS, CONTACT_WORDS, CONTACTS, COUPLINGS, DRIVES, LINE_WORDS, LOADS,
    N_POINT_ACCELERATIONS, N_POINT_WORDS, REACTIONS,
};

/// The meaning of a name in an expression.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Meaning {
    /// The time.
    Time,
    /// Index into the parameters.
    Parameter(usize),
    /// Something of the motion.
    Measure(Measure),
    /// A state or a signal: index into the reader's values.
    Value(usize),
    /// A coordinate of a joint that could not be read.
    Faulty,
}

/// The quantities of a motion's value and of its rate.
pub(super) fn quantities(motion: MotionKind) -> [Quantity; 2] {
    match motion {
        MotionKind::Rotation => [Quantity::ANGLE, Quantity::RATE],
        MotionKind::Translation => [Quantity::LENGTH, Quantity::VELOCITY],
    }
}

/// The quantity of a measure of a body.
pub(super) fn quantity_of(measure: Measure) -> Quantity {
    match measure {
        Measure::BodyAngle(_)
        | Measure::Turn(..)
        | Measure::CardanAngle(..)
        | Measure::RollPitchYaw(..) => Quantity::ANGLE,
        Measure::BodyRate(_) | Measure::CardanRate(..) | Measure::AngularVelocity(..) => {
            Quantity::RATE
        }
        Measure::Quaternion(..) | Measure::DirectionCosine(..) | Measure::State(_) => {
            Quantity::NUMBER
        }
        Measure::JointAcceleration(..) | Measure::PointAcceleration(..) => Quantity::ACCELERATION,
        Measure::AngularAcceleration(..) => Quantity::ANGULAR_ACCELERATION,
        // Of a translation; that of a rotation is known where the drive is: see `Names::acceleration`.
        Measure::Reaction(_, _, ..3)
        | Measure::Resultant(_, Resultant::Force)
        | Measure::Effort(_)
        | Measure::Force(_)
        | Measure::Contact(_, ContactPart::Force | ContactPart::Friction)
        | Measure::Line(_, LinePart::Force) => Quantity::FORCE,
        Measure::Reaction(..)
        | Measure::Resultant(..)
        | Measure::Moment(_)
        | Measure::Contact(_, ContactPart::Rolling) => Quantity::TORQUE,
        Measure::Momentum(..) => Quantity::MOMENTUM,
        Measure::AngularMomentum(..) => Quantity::ANGULAR_MOMENTUM,
        Measure::JointPosition(..)
        | Measure::PointPosition(..)
        | Measure::Contact(_, ContactPart::Gap)
        | Measure::Line(_, LinePart::Length) => Quantity::LENGTH,
        Measure::JointVelocity(..)
        | Measure::PointVelocity(..)
        | Measure::Contact(_, ContactPart::Slip)
        | Measure::Line(_, LinePart::Rate) => Quantity::VELOCITY,
    }
}

/// A body's name and its points.
#[derive(Debug)]
pub(super) struct BodyName {
    pub(super) name: String,
    /// In file order.
    pub(super) points: Vec<String>,
    pub(super) span: Span,
}

/// A joint's name and its freedoms; `None` when its type could not be read.
#[derive(Debug)]
pub(super) struct JointName {
    pub(super) name: String,
    /// Type of the joint.
    pub(super) kind: Option<&'static str>,
    pub(super) freedoms: Option<&'static [MotionKind]>,
    /// A roller or a sleeve of a `radius` stands for its point.
    pub(super) has_radius: bool,
}

/// A signal with a clock, as expressions know it.
#[derive(Clone, Debug)]
pub(super) struct SampledName {
    /// Place among the values of the reader.
    pub(super) value_idx: usize,
    pub(super) name: String,
    pub(super) clock: ClockId,
    /// Value before the first tick, where one is stated.
    pub(super) start: Option<Lowered>,
    /// The value that is held, and the one before the last tick.
    pub(super) symbols: [Expr; 2],
    /// True where `previous` was used before the dimension was known.
    pub(super) was_used_early: bool,
}

/// The value of a sampled signal before the last tick of its clock.
pub(super) const PREVIOUS: &str = "previous";

/// All names of one model.
#[derive(Debug, Default)]
pub(super) struct Names {
    /// The ground first.
    pub(super) bodies: Vec<BodyName>,
    pub(super) joints: Vec<JointName>,
    body_ids: BTreeMap<String, BodyId>,
    /// Numbers of each body's points.
    point_ids: Vec<BTreeMap<String, PointId>>,
    joint_ids: BTreeMap<String, JointId>,
    /// The names of the drives with the motions that they drive, in file order; `None` where that could not be read.
    pub(super) drives: Vec<(String, Option<MotionKind>)>,
    /// The names of forces of couplings, as far as their tables say them.
    pub(super) forces: Vec<(String, MotionKind)>,
    /// The names of contacts.
    pub(super) contacts: Vec<String>,
    /// The names of springs, dampers and forces between two points.
    pub(super) lines: Vec<String>,
    /// Parameters, coordinates and the time.
    pub(super) plain: BTreeMap<String, (Meaning, Option<Span>)>,
    /// Quantities of the named coordinates.
    pub(super) quantities: BTreeMap<String, Quantity>,
    /// Signals in use.
    pub(super) signals: Vec<Signal>,
    /// Their names.
    symbols: BTreeSet<String>,
}

impl Names {
    pub(super) fn add_body(&mut self, body: BodyName) {
        self.body_ids.insert(body.name.clone(), BodyId(self.bodies.len()));
        // Backwards, so that of two equal names the first counts.
        let points = body.points.iter().enumerate().rev();
        self.point_ids.push(points.map(|(idx, name)| (name.clone(), PointId(idx))).collect());
        self.bodies.push(body);
    }

    pub(super) fn add_joint(&mut self, joint: JointName) {
        self.joint_ids.insert(joint.name.clone(), JointId(self.joints.len()));
        self.joints.push(joint);
    }

    pub(super) fn body(&self, name: &str) -> Option<BodyId> {
        self.body_ids.get(name).copied()
    }

    pub(super) fn joint(&self, name: &str) -> Option<JointId> {
        self.joint_ids.get(name).copied()
    }

    pub(super) fn point(&self, body: BodyId, name: &str) -> Option<PointId> {
        self.point_ids[body.0].get(name).copied()
    }

    pub(super) fn body_names(&self) -> Vec<&str> {
        self.bodies.iter().map(|body| body.name.as_str()).collect()
    }

    pub(super) fn joint_names(&self) -> Vec<&str> {
        self.joints.iter().map(|joint| joint.name.as_str()).collect()
    }

    /// Parameters, coordinates and the time.
    pub(super) fn plain_names(&self) -> Vec<&str> {
        self.plain.keys().map(String::as_str).collect()
    }

    /// The meaning of a name without dots.
    pub(super) fn plain(&self, name: &str) -> Option<Meaning> {
        self.plain.get(name).map(|(meaning, _)| *meaning)
    }

    /// The measure and quantity of a named coordinate.
    pub(super) fn coordinate(&self, name: &str) -> Option<(Measure, Quantity)> {
        match (self.plain(name)?, self.quantities.get(name)) {
            (Meaning::Measure(measure), Some(&quantity)) => Some((measure, quantity)),
            _ => None,
        }
    }

    /// The measure of `body.x`, `body.point.vy`, `joint.angle`.
    pub(super) fn measure(&self, owner: &str, parts: &[&str]) -> Option<(Measure, Quantity)> {
        if let ([word], Some(joint)) = (parts, self.joint(owner)) {
            let freedoms = self.joints[joint.0].freedoms?;
            return freedoms.iter().enumerate().find_map(|(idx, freedom)| {
                // Accelerations are of results alone.
                let words = &motion_words(freedoms, idx)[..2];
                let at = words.iter().position(|known| known == word)?;
                let measure =
                    [Measure::JointPosition(joint, idx), Measure::JointVelocity(joint, idx)];
                Some((measure[at], quantities(*freedom)[at]))
            });
        }
        let Some(body) = self.body(owner) else {
            if let (REACTIONS, [joint, word]) = (owner, parts) {
                let joint = self.joint(joint)?;
                // A cylinder has no rows of its own: all that acts along it is its reaction.
                let has_rows = self.joints[joint.0].kind.is_none_or(|kind| kind != "cylinder");
                let measure = has_rows.then(|| Measure::of_reaction(joint, word)).flatten()?;
                return Some((measure, quantity_of(measure)));
            }
            let [word] = parts else { return None };
            let measure = Measure::of_all(owner, word)?;
            return Some((measure, quantity_of(measure)));
        };
        let (point, word, rows) = match parts {
            [word] => (None, word, BODY_WORDS.len()),
            [point, word] => (Some(self.point(body, point)?), word, N_POINT_WORDS),
            _ => return None,
        };
        let (_, measure) = BODY_WORDS[..rows].iter().find(|(known, _)| known == word)?;
        let measure = measure(body, point);
        Some((measure, quantity_of(measure)))
    }

    /// The acceleration of `body.ax`, `body.point.ay`, `joint.acceleration`, the effort of `drives.crank`, or the
    /// force of `couplings.pair`, which results alone have.
    pub(super) fn acceleration(&self, owner: &str, parts: &[&str]) -> Option<(Measure, Quantity)> {
        if let ([word], Some(joint)) = (parts, self.joint(owner)) {
            let freedoms = self.joints[joint.0].freedoms?;
            return freedoms.iter().enumerate().find_map(|(idx, freedom)| {
                let is_it = motion_words(freedoms, idx)[2] == *word;
                let quantity = match freedom {
                    MotionKind::Rotation => Quantity::ANGULAR_ACCELERATION,
                    MotionKind::Translation => Quantity::ACCELERATION,
                };
                is_it.then_some((Measure::JointAcceleration(joint, idx), quantity))
            });
        }
        let Some(body) = self.body(owner) else {
            if let (COUPLINGS, [name]) = (owner, parts) {
                let idx = self.forces.iter().position(|(known, _)| known == name)?;
                let measure = match self.forces[idx].1 {
                    MotionKind::Translation => Measure::Force(idx),
                    MotionKind::Rotation => Measure::Moment(idx),
                };
                return Some((measure, quantity_of(measure)));
            }
            if let (CONTACTS, [name, word]) = (owner, parts) {
                let idx = self.contacts.iter().position(|known| known == name)?;
                let (_, part) = CONTACT_WORDS.iter().find(|(known, _)| known == word)?;
                let measure = Measure::Contact(ContactId(idx), *part);
                return Some((measure, quantity_of(measure)));
            }
            if let (LOADS, [name, word]) = (owner, parts) {
                let idx = self.lines.iter().position(|known| known == name)?;
                let (_, part) = LINE_WORDS.iter().find(|(known, _)| known == word)?;
                let measure = Measure::Line(idx, *part);
                return Some((measure, quantity_of(measure)));
            }
            let (DRIVES, [name]) = (owner, parts) else { return None };
            let idx = self.drives.iter().position(|(known, _)| known == name)?;
            let quantity = match self.drives[idx].1? {
                MotionKind::Rotation => Quantity::TORQUE,
                MotionKind::Translation => Quantity::FORCE,
            };
            return Some((Measure::Effort(DriveId(idx)), quantity));
        };
        let (point, word, n) = match parts {
            [word] => (None, word, ACCELERATION_WORDS.len()),
            [point, word] => (Some(self.point(body, point)?), word, N_POINT_ACCELERATIONS),
            _ => return None,
        };
        let (_, measure) = ACCELERATION_WORDS[..n].iter().find(|(known, _)| known == word)?;
        let measure = measure(body, point);
        Some((measure, quantity_of(measure)))
    }

    /// The symbol that stands for a measure, made on first use.
    pub(super) fn signal(
        &mut self,
        pool: &Pool,
        written: &str,
        measure: Measure,
    ) -> bksim_expr::Expr {
        if let Some(known) = self.signals.iter().find(|signal| signal.measure == measure) {
            return pool.symbol_expr(known.symbol);
        }
        let mut name = written.replace('.', "_");
        let own = self.coordinate(written).is_some();
        while !own && (self.plain.contains_key(&name) || self.symbols.contains(&name)) {
            name.push('_');
        }
        let expr = pool.symbol(&name);
        if let Some(symbol) = pool.symbol_id(expr) {
            self.signals.push(Signal { symbol, measure });
        }
        self.symbols.insert(name);
        expr
    }
}
