//! Joints: what connects two bodies, and the motions that it allows.

use bksim_expr::Expr;

use crate::body::Space;
use crate::body::{Anchor, FixedTurn};
use crate::diagnostic::Span;
use crate::ids::{CurveId, Vector};
use crate::questions::{data_of_kinds, sorts_of_kinds};

mod types;

pub use types::{JOINT_TYPES, JointType};

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
        /// Where the point, or its roller, lifts off the curve: true if it does to the left as the parameter rises.
        lifts: Option<bool>,
    },
    /// A line of the successor along `axis`, in space a plane along it and z, touches a curve of the predecessor;
    /// always a constraint, with the curve's parameter at the place of contact as a coordinate of its own.
    LineOnCurve {
        /// The curve, in the frame of the predecessor's point.
        curve: CurveId,
        /// Where the line lifts off the curve: true if it does to the left as the parameter rises.
        lifts: Option<bool>,
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
        /// Where the second curve lifts off the first: true if it does to the left as the parameter of the first rises.
        lifts: Option<bool>,
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

    /// The facts that it shares with all joints of its kind.
    pub fn facts(&self) -> &'static JointType {
        &JOINT_TYPES[self.row()]
    }

    /// The word of this kind in a model file.
    pub fn word(&self) -> &'static str {
        self.facts().word
    }

    /// The elementary motions that a joint of this kind allows, in the order of its coordinates; none
    /// for a kind that is always cut, but the parameters of curves, which count as angles.
    pub fn motions(&self) -> &'static [MotionKind] {
        self.facts().motions
    }

    /// The number of freedoms that a joint of this kind takes from a body in a plane or in space.
    pub fn n_taken(&self, space: Space) -> i64 {
        let of_rolling = matches!(self, Self::CurveOnCurve { arcs: Some(_), .. });
        self.facts().n_taken(space) + i64::from(of_rolling) - i64::from(self.lifts().is_some())
    }

    /// True where no coordinates of its own describe all motions of this kind, so that it is a constraint wherever
    /// it stands.
    pub fn is_always_cut(&self) -> bool {
        self.facts().taken.is_some()
    }

    /// The number of conditions on rates among those that a joint of this kind takes: they hold between velocities
    /// and leave all positions free.
    pub fn n_rates(&self) -> i64 {
        self.facts().n_rates
    }

    /// True if all its motions are along, across or about one line.
    pub fn has_line(&self) -> bool {
        let n_turns = self.motions().iter().filter(|of| **of == MotionKind::Rotation).count();
        !self.is_always_cut() && n_turns <= 1 && (1..=3).contains(&self.motions().len())
    }

    /// True if this motion of it is a turn; false of a motion that it does not have.
    pub fn turns(&self, motion_idx: usize) -> bool {
        self.motions().get(motion_idx) == Some(&MotionKind::Rotation)
    }

    /// True if this motion of it is a translation; false of a motion that it does not have.
    pub fn slides(&self, motion_idx: usize) -> bool {
        self.motions().get(motion_idx) == Some(&MotionKind::Translation)
    }

    /// Lets two curves touch with the tangents the other way.
    pub fn turn_side(&mut self) {
        if let Self::CurveOnCurve { is_same_way, .. } = self {
            *is_same_way = !*is_same_way;
        }
    }

    /// True of a line or curve that touches a curve, other than a point on it.
    pub fn is_touch(&self) -> bool {
        self.is_face() || self.second_curve().is_some()
    }

    /// True if its bodies turn about all axes.
    pub fn turns_freely(&self) -> bool {
        self.motions().ends_with(&[MotionKind::Rotation; 3])
    }
}

data_of_kinds! {
    JointKind:
    /// The distance that a link keeps, m.
    link_length -> Expr { Self::Link { length } => length }
    /// The angle about z that the bodies of a slide or weld keep, rad.
    kept_angle -> Expr { Self::Prismatic { angle } | Self::Weld { angle } => angle }
    /// The travel of a screw in one turn, m.
    lead -> Expr { Self::Screw { lead } => lead }
    /// The axis of the successor that stays perpendicular to that of the predecessor, in the frame of its point.
    second_axis -> Vector { Self::Universal { second } | Self::PerpendicularAxes { second } => second }
    /// The radii of a wheel, m: of the circle of the middle of its rim, and of the rim across it.
    wheel -> [Expr; 2] { Self::Rolling { circle, rim } => [circle, rim] }
    /// Two curves in touch: true if their tangents point the same way.
    is_same_way -> bool { Self::CurveOnCurve { is_same_way, .. } => is_same_way }
    /// Distance of a point from its curve, m, where the file states a roller.
    roller -> Expr { Self::PointOnCurve { roller, .. } => roller? }
    /// The lengths of two curves from the points that come together, m, where they roll.
    rolled_arcs -> [Expr; 2] { Self::CurveOnCurve { arcs, .. } => arcs? }
    /// The curve that a joint of this kind follows, whose parameter is its first coordinate.
    curve -> CurveId {
        Self::PointOnCurve { curve, .. } | Self::LineOnCurve { curve, .. } => curve,
        Self::CurveOnCurve { curves: [first, _], .. } => first
    }
    /// Of what lifts off a curve true if it does to the left as the parameter of the curve rises.
    lifts -> bool {
        Self::PointOnCurve { lifts, .. } | Self::LineOnCurve { lifts, .. } => lifts?,
        Self::CurveOnCurve { lifts, .. } => lifts?
    }
    /// The curve of the successor that touches the other, whose parameter is the second coordinate.
    second_curve -> CurveId { Self::CurveOnCurve { curves: [_, second], .. } => second }
}

sorts_of_kinds! {
    JointKind:
    /// True of a pin: it turns about one axis, which has the same components in both bodies.
    is_pin { Self::Revolute }
    /// True of a slide: it moves along one axis, and the bodies keep their angle.
    is_slide { Self::Prismatic { .. } }
    /// True of a pin in a straight slot.
    is_slot { Self::PinInSlot }
    /// True if it joins two bodies into one.
    is_weld { Self::Weld { .. } }
    /// True of a ball in its socket.
    is_ball { Self::Spherical }
    /// True if it allows all motions.
    is_free { Self::Free }
    /// True of an actuator or rope without mass, whose one motion is the distance of its points.
    is_cylinder { Self::Cylinder }
    /// True of a blade, which does not move across itself.
    is_blade { Self::KnifeEdge }
    /// True of the cross of a universal joint.
    is_cross { Self::Universal { .. } }
    /// True if both bodies have one point in common.
    points_coincide {
        Self::Revolute | Self::Weld { .. } | Self::Spherical
            | Self::Universal { .. } | Self::ConstantVelocity
    }
    /// True of two curves of which the file does not state which way they touch.
    has_open_side { Self::CurveOnCurve { is_stated: false, .. } }
    /// True of a straight face that touches a curve.
    is_face { Self::LineOnCurve { .. } }
    /// True if this kind leaves so much freedom that a body is better placed without it.
    is_loose { Self::PointOnLine | Self::PointOnPlane | Self::ParallelAxes | Self::PerpendicularAxes { .. } }
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
