//! Constraint rows and where they come from.

use bksim_expr::{Expr, SymbolId};
use bksim_model::{BodyId, CouplingId, DriveId, JointId, LoadId, Model, MotionKind};

use crate::force::Wrench;
use crate::joint::OF_RATES;

/// The part of the model that a constraint row comes from.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Source {
    /// A joint that was cut.
    Joint(JointId),
    /// The quaternion by which a body turns has the length one.
    Quaternion(BodyId),
    /// A condition between motions of joints, or between rates.
    Coupling(CouplingId),
    /// A prescribed motion.
    Drive(DriveId),
    /// A limit of a motion, which holds while bodies are in contact, or of a rope's way, while it is taut.
    Stop(LoadId),
    /// Dry friction, which holds while it sticks.
    Friction(LoadId),
}

impl Source {
    /// The joint that the row acts in; none of a coupling or a rope, which act in several, or of a quaternion's
    /// length, which no force keeps.
    pub fn joint(self, model: &Model) -> Option<JointId> {
        match self {
            Self::Joint(joint) => Some(joint),
            Self::Quaternion(_) | Self::Coupling(_) => None,
            Self::Drive(drive) => Some(model.drives[drive.0].joint),
            Self::Stop(load) | Self::Friction(load) => {
                model.loads[load.0].kind.joint_motion().map(|(joint, _)| joint)
            }
        }
    }

    /// True where the row lies in the coordinates themselves: that of a cut joint, of a quaternion or of a
    /// coupling, not one of a drive or of a contact.
    pub fn is_geometric(self) -> bool {
        matches!(self, Self::Joint(_) | Self::Quaternion(_) | Self::Coupling(_))
    }

    /// True if the row opens and closes.
    pub fn is_contact(self) -> bool {
        matches!(self, Self::Stop(_) | Self::Friction(_))
    }
}

/// One constraint row g(t, q) = 0 with its multiplier; of a row between rates g is zero, and only G v + r = 0 says
/// something.
#[derive(Clone, Debug)]
pub struct Constraint {
    /// g, m or rad; of a quaternion a pure number.
    pub expression: Expr,
    /// Symbol of λ.
    pub lambda: SymbolId,
    /// The joint, coupling, drive or contact it comes from.
    pub source: Source,
    /// `x`, `y`, `z`, `normal`, `angle`, `length`, `motion`, `norm`, `coupling`, `min`, `max`, `rope`, `forward`, `back` or `friction`;
    /// `rate`, `along`, `across` or `roll` of a row between rates.
    pub direction: &'static str,
    /// Translation where λ is a force, rotation where it is a moment.
    pub effort: MotionKind,
    /// Wrenches on bodies for λ = 1: of a joint, drive or contact that on the joint's successor, then its
    /// opposite on the predecessor, both at the successor's joint point.
    pub wrenches: Vec<Wrench>,
}

impl Constraint {
    /// True where the row holds between rates and leaves all positions free: its row of G is no gradient.
    pub fn is_of_rates(&self) -> bool {
        OF_RATES.contains(&self.direction)
    }
}
