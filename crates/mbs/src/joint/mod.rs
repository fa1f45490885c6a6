//! Mechanics of the joints: the motions that each kind allows, and its constraint rows when it is cut.
//!
//! A joint is a list of elementary motions of the successor relative to the predecessor, after a
//! fixed turn: first translations, then rotations, each about an axis that those before it have
//! turned. Axes have their components in the frames of the two joint points. In the tree, each motion is a generalised coordinate. Cut, the joint forbids every
//! other relative motion by constraint rows g = 0, *predecessor minus successor*. Each row carries
//! the wrench that a unit multiplier puts on the successor, so that −Gᵀλ and the joint reaction are
//! the same force by construction. In a plane, the rows of the third dimension fold to 0 = 0 and
//! are dropped.
//!
//! Each kind has a file with the same functions in the same order: `motions`, `fixed_turn`,
//! `constraint_rows`. The table `Mechanics::of` leads from a kind to them.

mod constant_velocity;
mod curve_on_curve;
mod cylinder;
mod cylindrical;
mod free;
mod knife_edge;
mod lifting;
mod line_on_curve;
mod link;
mod parallel_axes;
mod perpendicular_axes;
mod pin_in_slot;
mod planar;
mod point_on_curve;
mod point_on_line;
mod point_on_plane;
mod prismatic;
mod revolute;
mod rolling;
mod rows;
mod screw;
mod spherical;
mod turns;
mod universal;
mod weld;

pub(crate) use lifting::Lifted;
pub(crate) use line_on_curve::Face;

use bksim_expr::{Expr, Pool};

use crate::folding::{is_nothing, short};
use crate::pose::Pose;
use crate::spatial::{self, Rotation};
use bksim_model::{Joint, JointKind, MotionKind, Vector};

/// The directions of rows that hold between rates: of a stated condition, of the slip of a wheel, blade or contact along
/// a plane, and of the rolling of a contact.
pub(crate) const OF_RATES: [&str; 4] = ["rate", "along", "across", "roll"];

/// One elementary motion, with its axis in the frame it starts from.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// Turning or sliding.
    pub kind: MotionKind,
    /// Unit vector.
    pub axis: Vector,
    /// Translation along the axis that goes with a rotation about it, m/rad.
    pub pitch: Option<Expr>,
}

impl Motion {
    fn rotation(axis: Vector) -> Self {
        Self { kind: MotionKind::Rotation, axis, pitch: None }
    }

    fn translation(axis: Vector) -> Self {
        Self { kind: MotionKind::Translation, axis, pitch: None }
    }

    /// Turns about x, y and z, in this order.
    fn turns(pool: &Pool) -> Vec<Self> {
        spatial::axes(pool).map(Self::rotation).to_vec()
    }

    /// Translations along x, y and z.
    fn slides(pool: &Pool) -> Vec<Self> {
        spatial::axes(pool).map(Self::translation).to_vec()
    }
}

/// A force and a moment on the successor of a joint, both at its joint point.
#[derive(Clone, Copy, Debug)]
pub struct JointWrench {
    /// N, world axes.
    pub force: Vector,
    /// N m about the joint point, world axes.
    pub moment: Vector,
}

impl JointWrench {
    /// A force through the joint point.
    pub(crate) fn of_force(pool: &Pool, force: Vector) -> Self {
        Self { force, moment: spatial::zero(pool) }
    }

    /// A moment without a force.
    pub(crate) fn of_moment(pool: &Pool, moment: Vector) -> Self {
        Self { force: spatial::zero(pool), moment }
    }

    /// The wrench with the opposite sign.
    pub(crate) fn reversed(&self, pool: &Pool) -> Self {
        self.map(|part| spatial::neg(pool, part))
    }

    fn map(&self, image: impl Fn(&Vector) -> Vector) -> Self {
        Self { force: image(&self.force), moment: image(&self.moment) }
    }
}

/// One constraint row of a cut joint.
#[derive(Clone, Debug)]
pub struct Row {
    /// g, zero when the joint holds; zero throughout of a row between rates, which is that of its wrench.
    pub expression: Expr,
    /// `x`, `y`, `z` in world axes; `normal` to a slot or a curve, `tangent` to it; `angle`, `length`, `rolling`; between
    /// rates `along` the way of a wheel or `across` it.
    pub direction: &'static str,
    /// Wrench on the successor for λ = 1.
    pub wrench: JointWrench,
}

/// The two sides of a joint in the world: the poses of its bodies and the positions of its points.
///
/// The rotation of a pose is that of the frame of its point, in which a joint has its axes.
pub struct Sides {
    /// Pose of the first body.
    pub predecessor: Pose,
    /// Pose of the second body.
    pub successor: Pose,
    /// Joint point on the first body, world axes.
    pub p_world_predecessor: Vector,
    /// Joint point on the second body, world axes.
    pub p_world_successor: Vector,
    /// The place on the curve that the joint follows.
    pub on_curve: Option<OnCurve>,
    /// The place on the curve of the successor that is in contact with it.
    pub on_second: Option<OnCurve>,
}

/// A place on a curve, in the frame of the point that the curve belongs to.
pub struct OnCurve {
    /// From the point, m; that of the centre of a roller.
    pub offset: Vector,
    /// Derivative of the position by the parameter, m.
    pub tangent: Vector,
    /// The length that has come by, m, of curves that roll on each other.
    pub arc: Option<Expr>,
    /// Distance of the place to the left of the curve, m: that of the centre of a roller.
    pub left: Expr,
}

/// The functions of one kind of joint.
struct Mechanics {
    /// The motions it allows, in the order of its coordinates.
    motions: fn(&Pool, &Joint) -> Vec<Motion>,
    /// The fixed turn of the successor against the predecessor, before any motion.
    fixed_turn: fn(&Pool, &Joint) -> Rotation,
    /// Constraint rows of the joint when it is cut, those that fold to 0 = 0 among them.
    constraint_rows: fn(&Pool, &Joint, &Sides) -> Vec<Row>,
}

impl Mechanics {
    /// The table of all kinds.
    fn of(joint: &Joint) -> Self {
        /// A row of the table: the functions of one file.
        macro_rules! functions {
            ($kind:ident) => {
                Self {
                    motions: $kind::motions,
                    fixed_turn: $kind::fixed_turn,
                    constraint_rows: $kind::constraint_rows,
                }
            };
        }
        match joint.kind {
            JointKind::Revolute => functions!(revolute),
            JointKind::Prismatic { .. } => functions!(prismatic),
            JointKind::PinInSlot => functions!(pin_in_slot),
            JointKind::Weld { .. } => functions!(weld),
            JointKind::Link { .. } => functions!(link),
            JointKind::Spherical => functions!(spherical),
            JointKind::Universal { .. } => functions!(universal),
            JointKind::Cylindrical => functions!(cylindrical),
            JointKind::Planar => functions!(planar),
            JointKind::Screw { .. } => functions!(screw),
            JointKind::Free => functions!(free),
            JointKind::PointOnLine => functions!(point_on_line),
            JointKind::PointOnPlane => functions!(point_on_plane),
            JointKind::ParallelAxes => functions!(parallel_axes),
            JointKind::PerpendicularAxes { .. } => functions!(perpendicular_axes),
            JointKind::ConstantVelocity => functions!(constant_velocity),
            JointKind::PointOnCurve { .. } => functions!(point_on_curve),
            JointKind::LineOnCurve { .. } => functions!(line_on_curve),
            JointKind::Cylinder => functions!(cylinder),
            JointKind::CurveOnCurve { .. } => functions!(curve_on_curve),
            JointKind::KnifeEdge => functions!(knife_edge),
            JointKind::Rolling { .. } => functions!(rolling),
        }
    }
}

/// The motions that `joint` allows, in the order of its coordinates.
pub fn motions(pool: &Pool, joint: &Joint) -> Vec<Motion> {
    (Mechanics::of(joint).motions)(pool, joint)
}

/// The fixed turn of the successor against the predecessor, before any motion.
pub fn fixed_turn(pool: &Pool, joint: &Joint) -> Rotation {
    (Mechanics::of(joint).fixed_turn)(pool, joint)
}

/// The constraint rows of `joint` when it is cut.
pub fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let mut rows = (Mechanics::of(joint).constraint_rows)(pool, joint, sides);
    let is_of_rates = |row: &Row| OF_RATES.contains(&row.direction);
    rows.retain(|row| is_of_rates(row) || !is_nothing(pool, row.expression));
    if joint.kind.lifts().is_some() {
        // A contact presses along the normal.
        rows.retain(|row| row.direction != "normal");
    }
    rows
}

/// Cosines that are one where a joint holds that is cut: rows that ask two axes to be parallel hold
/// with the axes opposite, too.
pub fn alignments(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Expr> {
    if let Some(cosine) = curve_on_curve::alignment(pool, joint, sides) {
        return vec![cosine];
    }
    let rows = (Mechanics::of(joint).constraint_rows)(pool, joint, sides);
    let n_right_angles = rows.iter().filter(|row| row.direction == "angle").count();
    let turns = motions(pool, joint).into_iter().filter(|m| m.kind == MotionKind::Rotation);
    let axes = match (n_right_angles, turns.collect::<Vec<_>>().as_slice()) {
        (2, [turn]) => vec![turn.axis],
        (3, []) => spatial::axes(pool).to_vec(),
        _ => Vec::new(),
    };
    let relative = rotation(pool, joint, sides);
    let cosine = |axis: &Vector| {
        let square = spatial::dot(pool, axis, axis);
        pool.div(spatial::dot(pool, axis, &relative.apply(pool, axis)), square)
    };
    let cosines = axes.iter().map(|axis| short(pool, cosine(axis)));
    cosines.filter(|&cosine| cosine != pool.one()).collect()
}

/// The position of each motion of a joint as the two poses show it, whether or not it is cut.
pub fn positions(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Expr> {
    if let Some(length) = cylinder::length(pool, joint, sides) {
        return vec![length];
    }
    let offset = spatial::sub(pool, &sides.p_world_successor, &sides.p_world_predecessor);
    let relative = rotation(pool, joint, sides);
    let along = |axis: &Vector| {
        let along = sides.predecessor.rotation.apply(pool, axis);
        spatial::dot(pool, &along, &offset)
    };
    let motions = motions(pool, joint);
    // A screw has turned as far as it has travelled, in any number of turns.
    if let [Motion { axis, pitch: Some(pitch), .. }] = motions.as_slice() {
        return vec![pool.div(along(axis), *pitch)];
    }
    let is_slide = |motion: &&Motion| motion.kind == MotionKind::Translation;
    let mut positions: Vec<Expr> =
        motions.iter().filter(is_slide).map(|motion| along(&motion.axis)).collect();
    positions.extend(turns::angles(pool, &relative, &turns::axes(&motions)));
    positions
}

/// True where the angles among [`positions`] are read within ±180°, and jump there.
pub fn angles_are_within_turn(pool: &Pool, joint: &Joint, sides: &Sides) -> bool {
    let motions = motions(pool, joint);
    // A screw counts its turns by its travel.
    if matches!(motions.as_slice(), [Motion { pitch: Some(_), .. }]) {
        return false;
    }
    let relative = rotation(pool, joint, sides);
    turns::are_within_turn(pool, &relative, &turns::axes(&motions))
}

/// The angles of turns about x, y and z in sequence that make up `rotation`, the second within ±90°.
pub fn cardan_angles(pool: &Pool, rotation: &Rotation) -> Vec<Expr> {
    turns::angles(pool, rotation, &spatial::axes(pool))
}

/// Wrench on the successor of a unit effort in the given motion.
///
/// It does no work in the other motions of the joint; `positions` are those of all its motions.
pub fn effort(
    pool: &Pool,
    joint: &Joint,
    motion_idx: usize,
    positions: &[Expr],
    sides: &Sides,
) -> JointWrench {
    // An effort on the parameter of a curve enters its own equation, and the bodies by the joint's multipliers.
    if sides.on_curve.is_some() {
        return JointWrench::of_force(pool, spatial::zero(pool));
    }
    if let Some(push) = cylinder::push(pool, joint, sides) {
        return push;
    }
    let motion = motions(pool, joint)[motion_idx];
    let in_predecessor = match motion.kind {
        MotionKind::Translation => motion.axis,
        MotionKind::Rotation => turns::effort_axis(pool, joint, motion_idx, positions),
    };
    let axis_world = sides.predecessor.rotation.apply(pool, &in_predecessor);
    match motion.kind {
        MotionKind::Translation => JointWrench::of_force(pool, axis_world),
        MotionKind::Rotation => JointWrench::of_moment(pool, axis_world),
    }
}

/// The wrench that the gradient of a function of the position stands for, where the poses show this position; `None`
/// where it is that of [`effort`]. A cut screw counts its turns by its travel.
pub fn gradient(pool: &Pool, joint: &Joint, sides: &Sides) -> Option<JointWrench> {
    joint.kind.lead().map(|_| screw::thrust(pool, joint, sides))
}

/// The one wrench of a joint whose point slides and turns as a line on a curve or a blade does: a unit force at the
/// place of contact; `None` of other joints.
pub fn contact(pool: &Pool, joint: &Joint, sides: &Sides) -> Option<JointWrench> {
    if joint.kind.is_blade() {
        return Some(JointWrench::of_force(pool, knife_edge::left(pool, joint, sides)));
    }
    line_on_curve::contact(pool, joint, sides).filter(|_| joint.kind.lifts().is_none())
}

/// The place where two curves touch, or a wheel its plane, with the motions about it that they leave, in world axes;
/// `None` of other joints.
pub fn touch(pool: &Pool, joint: &Joint, sides: &Sides) -> Option<(Vector, Vec<Motion>)> {
    let wheel = rolling::place(pool, joint, sides).map(|place| (place, Motion::turns(pool)));
    let curves = || curve_on_curve::contact(pool, joint, sides);
    wheel.or_else(|| curves().filter(|_| joint.kind.lifts().is_none()))
}

/// The motions of a joint as they are now, their axes in world axes; `positions` are those of all of them.
/// Without positions the axes of turns are as before any turn, which three turns span alike.
pub fn motions_in_world(
    pool: &Pool,
    joint: &Joint,
    positions: Option<&[Expr]>,
    sides: &Sides,
) -> Vec<Motion> {
    if joint.kind.lifts().is_some() {
        return Motion::slides(pool).into_iter().chain(Motion::turns(pool)).collect();
    }
    // Along the tangent and about all axes.
    if let Some(OnCurve { tangent, .. }) = &sides.on_curve {
        let length = pool.sqrt(spatial::dot(pool, tangent, tangent));
        let along = spatial::scale(pool, pool.div(pool.one(), length), tangent);
        let mut motions = vec![Motion::translation(sides.predecessor.rotation.apply(pool, &along))];
        motions.extend(Motion::turns(pool));
        return motions;
    }
    if let Some(motions) = cylinder::motions_in_world(pool, joint, sides) {
        return motions;
    }
    let mut motions = motions(pool, joint);
    for (idx, axis) in positions.iter().flat_map(|it| turns::turned_axes(pool, joint, it)) {
        motions[idx].axis = axis;
    }
    for motion in &mut motions {
        motion.axis = sides.predecessor.rotation.apply(pool, &motion.axis);
    }
    motions
}

/// The angle about z that the file states.
fn kept_turn(pool: &Pool, joint: &Joint) -> Rotation {
    let angle = joint.kind.kept_angle().expect("the table leads slides and welds here");
    Rotation::about(pool, &spatial::z_axis(pool), angle)
}

/// The axis of the successor that stays perpendicular to that of the predecessor.
fn second_axis(joint: &Joint) -> Vector {
    joint.kind.second_axis().expect("the table leads joints with two axes here")
}

/// r_P-frame-after-the-fixed-turn from r_Q: the rotation that the motions make up.
pub fn rotation(pool: &Pool, joint: &Joint, sides: &Sides) -> Rotation {
    let undo = sides.predecessor.rotation.then(pool, &fixed_turn(pool, joint)).inverse(pool);
    undo.then(pool, &sides.successor.rotation)
}
