//! Joints: what connects two bodies, and the motions that it allows.

use bksim_expr::Expr;

use crate::body::{Anchor, FixedTurn};
use crate::diagnostic::Span;
use crate::ids::{CurveId, Vector};

/// A connection of two bodies, from `predecessor` to `successor`.
///
/// Joint coordinates measure the successor relative to the predecessor.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Name as written.
    pub name: String,
    /// The kind, which fixes its motions.
    pub kind: JointKind,
    /// The first body named.
    pub predecessor: Anchor,
    /// The second body named.
    pub successor: Anchor,
    /// Unit vector in the frame of the predecessor's point: rotation axis of a revolute (z in a plane),
    /// direction of a prismatic joint, slot or line, normal of a plane; the line on a curve has it in the frame of
    /// the successor's point, and so have blades and wheels. Unused by weld, link, spherical, free and points on curves.
    pub axis: Vector,
    /// Turns of the joint's frame on the successor against that of its point, each about an axis that those before
    /// it have turned; none where the axis has the same components in both.
    pub alignment: Vec<FixedTurn>,
    /// Inertia of a rotor that turns with the joint's one motion: kg m² where it turns, kg where it slides; else zero.
    pub armature: Expr,
    /// The author's word on cutting this joint.
    pub cut: Option<bool>,
    /// Names the author gave to its coordinates, in the order of its motion.
    pub coordinate_names: Vec<String>,
    /// Position of the name.
    pub span: Span,
}

impl Joint {
    /// The identifier of one of its coordinates: the author's, else the joint's name and `angle` or `position`.
    ///
    /// # Panics
    /// If the joint has no such motion.
    pub fn coordinate_name(&self, motion_idx: usize) -> String {
        let stated = self.coordinate_names.get(motion_idx).cloned();
        stated.unwrap_or_else(|| {
            format!("{}_{}", self.name, motion_words(self.kind.motions(), motion_idx)[0])
        })
    }
}

/// The kinds of joint.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum JointKind {
    /// One rotation about `axis`.
    Revolute,
    /// One translation along `axis`; the frames keep the angle (rad, about z).
    Prismatic {
        /// Fixed angle of the successor relative to the predecessor.
        angle: Expr,
    },
    /// No motion; the frames keep the angle (rad, about z).
    Weld {
        /// Fixed angle of the successor relative to the predecessor.
        angle: Expr,
    },
    /// A pin of the successor in a straight slot of the predecessor: translation along `axis`,
    /// then rotation about the normal of the plane.
    PinInSlot,
    /// Rigid massless link of the given length between the two points; always a constraint.
    Link {
        /// Length, m, greater than zero; an expression of time and parameters.
        length: Expr,
    },
    /// The points coincide; the bodies turn as they like.
    Spherical,
    /// The points coincide; `axis` of the predecessor stays perpendicular to an axis of the successor.
    Universal {
        /// Unit vector in the frame of the successor's point.
        second: Vector,
    },
    /// One translation along `axis` and one rotation about it.
    Cylindrical,
    /// Two translations across `axis` and one rotation about it.
    Planar,
    /// A rotation about `axis`, and with each turn a translation along it.
    Screw {
        /// Translation of one turn, m; negative for a left-handed thread, never zero.
        lead: Expr,
    },
    /// All motions.
    Free,
    /// The point of the successor stays on a line of the predecessor along `axis`.
    PointOnLine,
    /// The point of the successor stays in a plane of the predecessor across `axis`.
    PointOnPlane,
    /// `axis` of the predecessor and the same axis of the successor stay parallel.
    ParallelAxes,
    /// `axis` of the predecessor stays perpendicular to an axis of the successor.
    PerpendicularAxes {
        /// Unit vector in the frame of the successor's point.
        second: Vector,
    },
    /// The points coincide, and both bodies turn about their `axis` by the same angle; always a
    /// constraint.
    ConstantVelocity,
    /// The point of the successor stays on a curve of the predecessor; always a constraint, with the curve's
    /// parameter as a coordinate of its own.
    PointOnCurve {
        /// The curve, in the frame of the predecessor's point.
        curve: CurveId,
        /// Distance of the point from the curve in the plane of x and y, m: the radius of a roller to the left of
        /// the curve as its parameter rises, below zero to the right.
        roller: Option<Expr>,
    },
    /// A line of the successor along `axis`, in space a plane along it and z, touches a curve of the predecessor;
    /// always a constraint, with the curve's parameter at the place of contact as a coordinate of its own.
    LineOnCurve {
        /// The curve, in the frame of the predecessor's point.
        curve: CurveId,
    },
    /// A curve of the successor touches one of the predecessor, in space as prisms along z do; always a constraint,
    /// with the parameters of both at the place of contact as coordinates of their own.
    CurveOnCurve {
        /// The curve of the predecessor, then that of the successor, each in the frame of its point.
        curves: [CurveId; 2],
        /// The tangents point the same way as both parameters rise, as those of a wheel in a ring do.
        is_same_way: bool,
        /// True if the file states which way; else the initial values tell.
        is_stated: bool,
        /// Where the curves roll: the lengths of both from two points that come together, m, as expressions of the
        /// parameters of the curves. `None` where they slide.
        arcs: Option<[Expr; 2]>,
    },
    /// An actuator or rope without mass between the two points, whose one motion is their distance; always a
    /// constraint, though without rows.
    Cylinder,
    /// The point of the successor moves along `axis`, which is fixed in the successor, and not across it in the
    /// plane of x and y of the predecessor's point: a condition on rates; always a constraint.
    KnifeEdge,
    /// A disc, wheel or ball about the point of the successor rolls without slip on the plane of x and y of the
    /// predecessor's point, on the side of z; always a constraint.
    Rolling {
        /// Radius of the circle about `axis`, which is fixed in the successor, along which the middle of the rim
        /// goes, m; zero of a ball.
        circle: Expr,
        /// Radius of the rim across that circle, m: that of a ball, zero of a sharp edge.
        rim: Expr,
    },
}

/// Turning or sliding.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum MotionKind {
    /// About the axis, rad.
    Rotation,
    /// Along the axis, m.
    Translation,
}

/// The words of a joint type in a model file, and its motions in the order of their coordinates:
/// first translations, then rotations, each about an axis that those before it have turned.
pub const JOINT_TYPES: [(&str, &[MotionKind]); 22] = {
    use MotionKind::{Rotation, Translation};
    [
        ("revolute", &[Rotation]),
        ("prismatic", &[Translation]),
        ("weld", &[]),
        ("slot", &[Translation, Rotation]),
        ("link", &[]),
        ("spherical", &[Rotation, Rotation, Rotation]),
        ("universal", &[Rotation, Rotation]),
        ("cylindrical", &[Translation, Rotation]),
        ("planar", &[Translation, Translation, Rotation]),
        ("screw", &[Rotation]),
        ("free", &[Translation, Translation, Translation, Rotation, Rotation, Rotation]),
        ("point-on-line", &[Translation, Rotation, Rotation, Rotation]),
        ("point-on-plane", &[Translation, Translation, Rotation, Rotation, Rotation]),
        ("parallel-axes", &[Translation, Translation, Translation, Rotation]),
        ("perpendicular-axes", &[Translation, Translation, Translation, Rotation, Rotation]),
        ("constant-velocity", &[]),
        ("point-on-curve", &[Rotation]),
        ("line-on-curve", &[Rotation]),
        ("cylinder", &[Translation]),
        ("curve-on-curve", &[Rotation, Rotation]),
        ("knife-edge", &[]),
        ("rolling", &[]),
    ]
};

impl JointKind {
    /// The place of this kind in [`JOINT_TYPES`].
    fn row(&self) -> usize {
        match self {
            Self::Revolute => 0,
            Self::Prismatic { .. } => 1,
            Self::Weld { .. } => 2,
            Self::PinInSlot => 3,
            Self::Link { .. } => 4,
            Self::Spherical => 5,
            Self::Universal { .. } => 6,
            Self::Cylindrical => 7,
            Self::Planar => 8,
            Self::Screw { .. } => 9,
            Self::Free => 10,
            Self::PointOnLine => 11,
            Self::PointOnPlane => 12,
            Self::ParallelAxes => 13,
            Self::PerpendicularAxes { .. } => 14,
            Self::ConstantVelocity => 15,
            Self::PointOnCurve { .. } => 16,
            Self::LineOnCurve { .. } => 17,
            Self::Cylinder => 18,
            Self::CurveOnCurve { .. } => 19,
            Self::KnifeEdge => 20,
            Self::Rolling { .. } => 21,
        }
    }

    /// The word of this kind in a model file.
    pub fn word(&self) -> &'static str {
        JOINT_TYPES[self.row()].0
    }

    /// The elementary motions that a joint of this kind allows, in the order of its coordinates; none
    /// for a kind that is always cut, but the parameters of curves, which count as angles.
    pub fn motions(&self) -> &'static [MotionKind] {
        JOINT_TYPES[self.row()].1
    }

    /// The number of freedoms that a joint of this kind takes from a body in space.
    pub fn n_taken(&self) -> i64 {
        match self {
            Self::Cylinder => 0,
            Self::Rolling { .. } => 3,
            Self::KnifeEdge
            | Self::Link { .. }
            | Self::LineOnCurve { .. }
            | Self::CurveOnCurve { arcs: None, .. } => 1,
            Self::PointOnCurve { .. } | Self::CurveOnCurve { arcs: Some(_), .. } => 2,
            Self::ConstantVelocity => 4,
            _ => self.motions().iter().fold(6, |left, _| left - 1),
        }
    }

    /// True where no coordinates of its own describe all motions of this kind, so that it is a constraint wherever
    /// it stands.
    pub fn is_always_cut(&self) -> bool {
        matches!(self, Self::Link { .. } | Self::ConstantVelocity | Self::Cylinder)
            || self.n_rates() > 0
            || self.curve().is_some()
    }

    /// The number of conditions on rates among those that a joint of this kind takes: they hold between velocities
    /// and leave all positions free.
    pub fn n_rates(&self) -> i64 {
        match self {
            Self::KnifeEdge => 1,
            Self::Rolling { .. } => 2,
            _ => 0,
        }
    }

    /// The curve that a joint of this kind follows, whose parameter is its first coordinate.
    pub fn curve(&self) -> Option<CurveId> {
        match *self {
            Self::PointOnCurve { curve, .. } | Self::LineOnCurve { curve } => Some(curve),
            Self::CurveOnCurve { curves: [first, _], .. } => Some(first),
            _ => None,
        }
    }

    /// The curve of the successor that touches the other, whose parameter is the second coordinate.
    pub fn second_curve(&self) -> Option<CurveId> {
        match *self {
            Self::CurveOnCurve { curves: [_, second], .. } => Some(second),
            _ => None,
        }
    }

    /// True if its bodies turn about all axes.
    pub fn turns_freely(&self) -> bool {
        self.motions().ends_with(&[MotionKind::Rotation; 3])
    }

    /// True if this kind leaves so much freedom that a body is better placed without it.
    pub fn is_loose(&self) -> bool {
        matches!(
            self,
            Self::PointOnLine
                | Self::PointOnPlane
                | Self::ParallelAxes
                | Self::PerpendicularAxes { .. }
        )
    }
}

/// The words of a motion among all of its joint, for its value, its rate and its acceleration: `angle`, `rate`,
/// `acceleration`, or `position`, `velocity`, `acceleration`; with a number where the joint has several of one sort, and
/// `angular_acceleration` where it has both sorts.
pub fn motion_words(motions: &[MotionKind], motion_idx: usize) -> [&'static str; 3] {
    const TURNS: [[&str; 3]; 4] = [
        ["angle", "rate", "acceleration"],
        ["angle1", "rate1", "acceleration1"],
        ["angle2", "rate2", "acceleration2"],
        ["angle3", "rate3", "acceleration3"],
    ];
    const TURNS_BESIDE_SLIDES: [[&str; 3]; 4] = [
        ["angle", "rate", "angular_acceleration"],
        ["angle1", "rate1", "angular_acceleration1"],
        ["angle2", "rate2", "angular_acceleration2"],
        ["angle3", "rate3", "angular_acceleration3"],
    ];
    const SLIDES: [[&str; 3]; 4] = [
        ["position", "velocity", "acceleration"],
        ["position1", "velocity1", "acceleration1"],
        ["position2", "velocity2", "acceleration2"],
        ["position3", "velocity3", "acceleration3"],
    ];
    let kind = motions[motion_idx];
    let n_same = |of: &[MotionKind]| of.iter().filter(|&&other| other == kind).count();
    let number = if n_same(motions) == 1 { 0 } else { n_same(&motions[..=motion_idx]) };
    match kind {
        MotionKind::Rotation if motions.contains(&MotionKind::Translation) => {
            TURNS_BESIDE_SLIDES[number]
        }
        MotionKind::Rotation => TURNS[number],
        MotionKind::Translation => SLIDES[number],
    }
}
