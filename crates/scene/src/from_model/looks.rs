//! [`Look`]: which symbols stand for a joint of each kind.

use bksim_model::JointKind;

/// Symbols of the joints of one kind.
#[derive(Clone, Copy, Default)]
pub(super) struct Look {
    /// Pins: none, one at the second point, or one at each point.
    pub(super) n_pins: usize,
    /// Symbol of the ground where it holds the joint.
    pub(super) on_ground: Option<Symbol>,
    /// The part that slides on a rail of the first body.
    pub(super) rail: Option<OnRail>,
    /// True if its pin has the direction of an axis, which both bodies have.
    pub(super) has_axle: bool,
    /// True if the cross of two axles takes the place of its pin.
    pub(super) is_cross: bool,
}

/// Symbol of a point that the ground holds.
#[derive(Clone, Copy)]
pub(super) enum Symbol {
    /// A triangle under a pin.
    Support,
    /// A wall that holds fast.
    Wall,
}

/// A part that slides on a rail.
#[derive(Clone, Copy)]
pub(super) enum OnRail {
    Block,
    Shaft,
    Pin,
}

impl Look {
    /// The row of a kind.
    pub(super) fn of(kind: JointKind) -> Self {
        let pinned = |n_pins| Self { n_pins, ..Self::default() };
        let supported = |n_pins| Self { on_ground: Some(Symbol::Support), ..pinned(n_pins) };
        let axle = Self { has_axle: true, ..supported(1) };
        match kind {
            JointKind::Revolute | JointKind::Screw { .. } => axle,
            JointKind::Cylindrical => Self { rail: Some(OnRail::Shaft), ..axle },
            JointKind::Prismatic { .. } => Self { rail: Some(OnRail::Block), ..pinned(0) },
            JointKind::PinInSlot => Self { rail: Some(OnRail::Pin), ..pinned(1) },
            JointKind::Weld { .. } => Self { on_ground: Some(Symbol::Wall), ..pinned(0) },
            JointKind::Universal { .. } => Self { is_cross: true, ..supported(1) },
            JointKind::Link { .. } | JointKind::Cylinder => supported(2),
            JointKind::Spherical | JointKind::ConstantVelocity => supported(1),
            JointKind::Free | JointKind::ParallelAxes | JointKind::PerpendicularAxes { .. } => {
                pinned(0)
            }
            JointKind::Planar
            | JointKind::PointOnLine
            | JointKind::PointOnPlane
            | JointKind::PointOnCurve { .. }
            | JointKind::LineOnCurve { .. }
            | JointKind::CurveOnCurve { .. }
            | JointKind::KnifeEdge
            | JointKind::Rolling { .. } => pinned(1),
        }
    }
}
