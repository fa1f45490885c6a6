//! Couplings: conditions between the motions of several joints, each kept by one force, and conditions on rates.

use bksim_expr::Expr;

use crate::body::Anchor;
use crate::diagnostic::Span;
use crate::ids::{BeltId, BodyId, JointId, RopeId};
use crate::joint::MotionKind;

/// A condition between motions of joints.
#[derive(Clone, Debug)]
pub struct Coupling {
    /// Name as written.
    pub name: String,
    /// The machine element that keeps the condition.
    pub kind: CouplingKind,
    /// Zero where the condition holds, m or rad: an expression of time, parameters and signals of positions; of a
    /// condition on rates m/s or rad/s, linear in signals of rates.
    pub relation: Expr,
    /// Translation where the relation is a length or speed, so that a force keeps it; rotation where it is an angle or
    /// its rate and a moment keeps it.
    pub effort: MotionKind,
    /// Position of the relation, or of the name when there is none.
    pub span: Span,
}

/// The elements that couple joints.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum CouplingKind {
    /// The relation as the author wrote it; the joints bear its force in their own motions.
    Relation,
    /// A condition on rates alone, linear in them.
    Rate,
    /// A nut on a spindle: a turn and a slide, with forces as those of a relation.
    Screw,
    /// Two gears whose teeth mesh.
    Gear(Wheels),
    /// A belt or chain around two wheels.
    Belt(Wheels),
    /// A pinion on a rack.
    Rack(Rack),
    /// The strand of this number of a belt, from the wheel of this number to the next.
    Strand(BeltId, usize),
    /// The part of this number of a rope, which stays taut.
    Rope(RopeId, usize),
}

impl CouplingKind {
    /// Directions of the force between teeth, where the author stated them.
    pub fn flanks(&self) -> Option<Flanks> {
        match self {
            Self::Gear(wheels) => wheels.flanks,
            Self::Rack(rack) => rack.flanks,
            _ => None,
        }
    }

    /// True if a positive motion of the first member drives the second backwards.
    pub fn is_reversed(&self) -> bool {
        match self {
            Self::Gear(wheels) | Self::Belt(wheels) => !wheels.is_same,
            Self::Rack(rack) => rack.is_reversed,
            _ => false,
        }
    }

    /// True where the equations have its wrenches in place of its slopes: of pairs of forces at one place in a
    /// mechanism with cut joints, whose reactions then are their multipliers, and of strands and ropes, whose slopes are
    /// these wrenches, but written at length.
    pub fn has_row_of_wrenches(&self, has_cuts: bool) -> bool {
        match self {
            Self::Gear(_) | Self::Belt(_) | Self::Rack(_) => has_cuts,
            Self::Strand(..) | Self::Rope(..) => true,
            Self::Relation | Self::Rate | Self::Screw => false,
        }
    }
}

/// Directions of the force between teeth, each as a part of the force along the pitch circles.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Flanks {
    /// Force on the second along the line from the centre of the first, whichever flank bears: tan α/cos β, below zero
    /// in a ring.
    pub radial: Expr,
    /// Force on the second along the axis of the second wheel, or of the pinion.
    pub axial: Expr,
}

/// Two wheels that drive each other.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Wheels {
    /// The joints about whose axes they turn; that of the other for a wheel that has none.
    pub axes: [JointId; 2],
    /// The wheels with their centres.
    pub wheels: [Anchor; 2],
    /// The body against which their angles count.
    pub carrier: BodyId,
    /// Rate of the second over that of the first, both against the carrier.
    pub ratio: Expr,
    /// Pitch radii, m, where the author stated them; the first below zero where the wheels turn in opposite
    /// senses.
    pub radii: Option<[Expr; 2]>,
    /// Numbers of teeth, where the author stated them.
    pub teeth: Option<[Expr; 2]>,
    /// Angle of the second where that of the first is zero, rad.
    pub phase: Expr,
    /// True if both turn in one sense against the carrier.
    pub is_same: bool,
    /// Directions of the tooth force; `None` of one along the pitch circles alone.
    pub flanks: Option<Flanks>,
    /// Of a worm and its wheel, whose axes cross at right angles; the first of `radii` is then that of its travel, m z/2.
    pub worm: Option<WormSize>,
}

/// Size of a worm, the first of two wheels.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct WormSize {
    /// Pitch radius, m.
    pub radius: Expr,
    /// Normal force over its part along the pitch circle of the wheel, without friction: 1/(cos α cos γ).
    pub normal: Expr,
}

/// A pinion and a rack.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Rack {
    /// The joint about which the pinion turns, and that along which the rack slides.
    pub joints: [JointId; 2],
    /// Pinion and rack.
    pub bodies: [BodyId; 2],
    /// Travel of the rack along its axis over the angle of the pinion, m; negative where a positive turn moves
    /// it backwards.
    pub radius: Expr,
    /// Number of teeth of the pinion, where the author stated it.
    pub teeth: Option<Expr>,
    /// True if a positive turn moves the rack backwards.
    pub is_reversed: bool,
    /// Directions of the tooth force, away from the pinion and along its axis; `None` of one along the rack alone.
    pub flanks: Option<Flanks>,
}
