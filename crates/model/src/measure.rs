//! Measures: the one way to name something of the motion, in loads, initial values and outputs.

use bksim_expr::{Expr, SymbolId};

use crate::body::FixedTurn;
use crate::diagnostic::Span;
use crate::ids::{BodyId, ContactId, DriveId, JointId, PointId, StateId};

/// World axis.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Axis {
    /// First.
    X,
    /// Second.
    Y,
    /// Third.
    Z,
}

/// Axes in which a vector has its components.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Frame {
    /// Axes of the ground.
    World,
    /// Axes of the body, or of the point of one.
    Body,
}

/// Force or moment of a reaction as a whole.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Resultant {
    /// √(fx² + fy² + fz²), N.
    Force,
    /// √(mx² + my² + mz²), N m.
    Moment,
}

impl Resultant {
    /// Places of its components in fx, fy, fz, mx, my, mz.
    pub fn components(self) -> std::ops::Range<usize> {
        match self {
            Self::Force => 0..3,
            Self::Moment => 3..6,
        }
    }
}

/// Something of the motion that has a value at every instant.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Measure {
    /// A coordinate of a joint, rad or m; the second is its position in the joint's motion.
    JointPosition(JointId, usize),
    /// Rate of a joint's coordinate.
    JointVelocity(JointId, usize),
    /// Second rate of a joint's coordinate, in results.
    JointAcceleration(JointId, usize),
    /// World coordinate of a body's point, m; `None` is the centre of mass.
    PointPosition(BodyId, Option<PointId>, Axis),
    /// Rate of a point's coordinate.
    PointVelocity(BodyId, Option<PointId>, Axis),
    /// Angle of a body against the ground about z, rad (planar).
    BodyAngle(BodyId),
    /// Rate of a body's angle.
    BodyRate(BodyId),
    /// Angle by which the first body has turned against the second about the axis of a joint, rad, all turns
    /// counted.
    Turn(BodyId, BodyId, JointId),
    /// The given of three angles of a body against the ground, about x, y and z in sequence, rad: its own
    /// coordinates where they have names.
    CardanAngle(BodyId, usize),
    /// Rate of a Cardan angle.
    CardanRate(BodyId, usize),
    /// Roll (x), pitch (y) or yaw (z) of a body against the ground, rad: it is turned about the fixed axes x,
    /// y and z by them, in this order.
    RollPitchYaw(BodyId, Axis),
    /// Part of the unit quaternion from a body to the ground, scalar part first.
    Quaternion(BodyId, usize),
    /// Cosine of the angle between an axis of the ground and one of a body.
    DirectionCosine(BodyId, Axis, Axis),
    /// Angular velocity of a body, rad/s.
    AngularVelocity(BodyId, Frame, Axis),
    /// Angular acceleration of a body, rad/s².
    AngularAcceleration(BodyId, Frame, Axis),
    /// Second rate of a world coordinate of a body's point, m/s²; `None` is the centre of mass.
    PointAcceleration(BodyId, Option<PointId>, Axis),
    /// Momentum of a body, or of all, kg m/s, axes of the ground.
    Momentum(Option<BodyId>, Axis),
    /// Angular momentum of a body about its centre of mass, or of all about the origin, kg m²/s, axes of the
    /// ground.
    AngularMomentum(Option<BodyId>, Axis),
    /// A quantity that is integrated with the motion, SI.
    State(StateId),
    /// A component of the reaction of a joint on its successor, fx, fy, fz, mx, my, mz, N and N m: along the axes
    /// of the ground, or of the frame of its first point.
    Reaction(JointId, Frame, usize),
    /// The size of the reaction of a joint, which expressions of a model have by its components.
    Resultant(JointId, Resultant),
    /// The effort of a drive, N or N m, in results.
    Effort(DriveId),
    /// The force of a coupling or the pull of a rope, N, in results: by its place among
    /// [`Model::force_names`](crate::Model::force_names).
    Force(usize),
    /// The moment of a coupling, N m: the same.
    Moment(usize),
    /// A quantity of a contact, in results.
    Contact(ContactId, ContactPart),
    /// A quantity of a spring, damper or force between two points, in results: by its place among
    /// [`Model::line_names`](crate::Model::line_names).
    Line(usize, LinePart),
}

impl Measure {
    /// True where it depends on accelerations, or is found together with them for results alone, so that no load can
    /// use it.
    pub fn is_acceleration(self) -> bool {
        matches!(
            self,
            Self::Effort(_)
                | Self::Force(_)
                | Self::Moment(_)
                | Self::Contact(..)
                | Self::Line(..)
                | Self::JointAcceleration(..)
                | Self::AngularAcceleration(..)
                | Self::PointAcceleration(..)
        )
    }

    /// True if it follows from positions alone.
    pub fn is_position(self) -> bool {
        !self.is_velocity() && !self.is_acceleration()
    }

    /// Whether it is a force or moment, which is found together with the accelerations.
    pub fn is_reaction(self) -> bool {
        matches!(self, Self::Reaction(..) | Self::Resultant(..))
    }

    /// True if it is the rate of a position, linear in velocities, that a condition on rates may hold.
    pub fn is_rate(self) -> bool {
        matches!(
            self,
            Self::JointVelocity(..)
                | Self::PointVelocity(..)
                | Self::BodyRate(_)
                | Self::AngularVelocity(..)
        )
    }

    /// True if it depends on velocities.
    pub fn is_velocity(self) -> bool {
        match self {
            Self::JointPosition(..)
            | Self::PointPosition(..)
            | Self::BodyAngle(_)
            | Self::Turn(..)
            | Self::CardanAngle(..)
            | Self::RollPitchYaw(..)
            | Self::Quaternion(..)
            | Self::DirectionCosine(..) => false,
            Self::JointVelocity(..)
            | Self::JointAcceleration(..)
            | Self::PointVelocity(..)
            | Self::BodyRate(_)
            | Self::CardanRate(..)
            | Self::AngularVelocity(..)
            | Self::AngularAcceleration(..)
            | Self::PointAcceleration(..)
            | Self::Momentum(..)
            | Self::AngularMomentum(..)
            | Self::State(_)
            | Self::Reaction(..)
            | Self::Resultant(..)
            | Self::Effort(_)
            | Self::Force(_)
            | Self::Moment(_)
            | Self::Contact(..)
            | Self::Line(..) => true,
        }
    }
}

/// A quantity of a contact.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum ContactPart {
    /// The force with which its bodies push each other apart, N.
    Force,
    /// The friction on the second body, N: positive to the right of whoever looks from the first body to the second.
    Friction,
    /// Torque of the rolling resistance on the second body, N m, counter-clockwise.
    Rolling,
    /// The least distance between its outlines, m.
    Gap,
    /// Speed of the second body along the first where they touch, m/s, in the sense of the friction; zero while they do not.
    Slip,
}

/// A quantity of a load between two points.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum LinePart {
    /// The force with which it pulls its points together, N.
    Force,
    /// Distance of its points, m.
    Length,
    /// Speed at which they part, m/s.
    Rate,
}

/// A symbol that stands for a measure.
#[derive(Clone, Copy, Debug)]
pub struct Signal {
    /// The symbol used in expressions.
    pub symbol: SymbolId,
    /// The measure it stands for.
    pub measure: Measure,
}

/// The orientation of a body at the start, stated or guessed; among the initial values are its direction
/// cosines.
#[derive(Clone, Debug)]
pub struct Orientation {
    /// The body.
    pub body: BodyId,
    /// Turns against the ground, each about an axis that those before it have turned.
    pub turns: Vec<FixedTurn>,
}

/// One stated or guessed value of the start.
#[derive(Clone, Debug)]
pub struct Initial {
    /// The measure whose value is stated.
    pub measure: Measure,
    /// Value in SI, an expression of parameters.
    pub value: Expr,
    /// True if it may move to close the mechanism.
    pub is_guess: bool,
    /// Name as written, for messages: `A.angle`.
    pub name: String,
    /// Position of the value.
    pub span: Span,
}
