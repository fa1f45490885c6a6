//! Constraint rows and where they come from.

use bksim_expr::{Expr, SymbolId};
use bksim_model::{DriveId, JointId, LoadId, LoadKind, Model};

use crate::joint::JointWrench;

/// The part of the model that a constraint row comes from.
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

/// One constraint row g(t, q) = 0 with its multiplier.
#[derive(Clone, Debug)]
pub struct Constraint {
    /// g, m or rad.
    pub expression: Expr,
    /// Symbol of λ.
    pub lambda: SymbolId,
    /// The joint, drive or contact it comes from.
    pub source: Source,
    /// `x`, `y`, `z`, `normal`, `angle`, `length`, `motion`, `min`, `max` or `friction`.
    pub direction: &'static str,
    /// Wrench on the joint's successor for λ = 1.
    pub wrench: JointWrench,
}
