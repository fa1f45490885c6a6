//! [`Model`]: what the author wrote, as plain data; no state, no equations.
//!
//! Every number is an [`Expr`] of the model's [`Pool`] over the parameter symbols, in SI units and
//! radians, so that the equations keep the author's names. Loads and drives may also use *signals*:
//! symbols that stand for a [`Measure`] of the motion and are replaced when the equations are made.
//!
//! Geometry is three-dimensional throughout; a planar model has z = 0 and all axes along ±z.

pub use bksim_expr::Jit;
use bksim_expr::{Expr, Pool, SymbolId};

use crate::diagnostic::Span;
use crate::input::Inputs;

macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident),*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
        pub struct $name(pub usize);
    )*};
}

ids! {
    /// Index into [`Model::bodies`]; [`GROUND`] is the first.
    BodyId,
    /// Index into [`Model::joints`].
    JointId,
    /// Index into [`Model::loads`].
    LoadId,
    /// Index into [`Model::drives`].
    DriveId,
    /// Index into [`Body::points`] of one body.
    PointId
}

/// The body that does not move.
pub const GROUND: BodyId = BodyId(0);

/// A vector of expressions, x y z.
pub type Vector = [Expr; 3];

/// A whole mechanism as its author stated it.
#[derive(Debug)]
pub struct Model {
    /// Name of the mechanism; the file name without extension unless stated.
    pub name: String,
    /// Owns every expression of the model.
    pub pool: Pool,
    /// The time symbol `t`.
    pub time: SymbolId,
    /// In file order, except that each comes after those its definition uses.
    pub parameters: Vec<Parameter>,
    /// Planar or spatial.
    pub space: Space,
    /// Which joints are cut unless a joint says otherwise.
    pub coordinates: CoordinatePolicy,
    /// The ground first, then in file order.
    pub bodies: Vec<Body>,
    /// In file order.
    pub joints: Vec<Joint>,
    /// In file order.
    pub loads: Vec<Load>,
    /// In file order.
    pub drives: Vec<Drive>,
    /// Symbols used in expressions of loads and drives, and what they measure.
    pub signals: Vec<Signal>,
    /// Stated and guessed values of the start.
    pub initial: Vec<Initial>,
    /// How to solve.
    pub solve: SolveOptions,
    /// Parameters that are functions of the motion: none in a model that was read.
    pub inputs: Inputs,
}

/// A named number.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Name as written.
    pub name: String,
    /// Its symbol in the pool.
    pub symbol: SymbolId,
    /// Its definition: a number, or an expression of other parameters.
    pub definition: Expr,
    /// Its value, SI.
    pub value: f64,
    /// SI unit as text (`"m/s^2"`), empty when the author gave none.
    pub unit: String,
    /// Place of the value in the model text.
    pub span: Span,
}

/// Whether motion is confined to the plane z = const.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Space {
    /// All rotation axes along z, all translations in the plane.
    Planar,
    /// No restriction.
    Spatial,
}

/// Where the mechanism is cut into a tree.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum CoordinatePolicy {
    /// bksim chooses and reports.
    #[default]
    Auto,
    /// Fewest cuts: joint coordinates along a spanning tree.
    Relative,
    /// Every joint is cut: each body has its own coordinates.
    Absolute,
}

/// A rigid body.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name as written; `ground` for the first.
    pub name: String,
    /// Mass, kg; zero for a massless link.
    pub mass: Expr,
    /// Centre of mass in the body frame, m.
    pub com: Vector,
    /// Moment of inertia, kg m².
    pub inertia: Inertia,
    /// Named points in the body frame, m.
    pub points: Vec<Point>,
    /// Outlines for drawing, body frame, m; each a closed polygon.
    pub outline: Vec<Vec<[Expr; 2]>>,
    /// Names the author gave to this body's own coordinates: x, y, angle (planar).
    pub coordinate_names: Vec<String>,
    /// Place of the name.
    pub span: Span,
    /// Place of the mass, when stated.
    pub mass_span: Option<Span>,
    /// Place of the inertia, when stated.
    pub inertia_span: Option<Span>,
}

/// Moments and products of inertia in the axes of the body frame.
#[derive(Clone, Debug)]
pub struct Inertia {
    /// Ixx, Iyy, Izz.
    pub moments: Vector,
    /// Ixy, Iyz, Izx (the off-diagonal entries of the tensor itself, so −∫xy dm).
    pub products: Vector,
    /// The point they refer to; `None` for the centre of mass.
    pub about: Option<PointId>,
}

/// A named point of a body.
#[derive(Clone, Debug)]
pub struct Point {
    /// Name as written.
    pub name: String,
    /// Place in the body frame, m.
    pub position: Vector,
}

/// A body and one of its points; `None` is the origin of the body frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Anchor {
    /// The body.
    pub body: BodyId,
    /// The point.
    pub point: Option<PointId>,
}

/// A connection of two bodies, from `predecessor` to `successor`.
///
/// Joint coordinates measure the successor relative to the predecessor.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Name as written.
    pub name: String,
    /// What it allows.
    pub kind: JointKind,
    /// The first body named.
    pub predecessor: Anchor,
    /// The second body named.
    pub successor: Anchor,
    /// Unit vector in the predecessor's frame: rotation axis of a revolute (z in a plane),
    /// direction of a prismatic joint or of a slot. Unused by weld and link.
    pub axis: Vector,
    /// The author's word on cutting this joint.
    pub cut: Option<bool>,
    /// Names the author gave to its coordinates, in the order of its motion.
    pub coordinate_names: Vec<String>,
    /// Place of the name.
    pub span: Span,
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
        /// Length, m, greater than zero.
        length: Expr,
    },
}

/// A force law.
#[derive(Clone, Debug)]
pub struct Load {
    /// Name as written.
    pub name: String,
    /// What it does.
    pub kind: LoadKind,
    /// Place of the expression, or of the name when there is none.
    pub span: Span,
}

/// The kinds of load. Expressions may use time, parameters and signals.
#[derive(Clone, Debug)]
pub enum LoadKind {
    /// Uniform gravity on every body: the acceleration vector in world axes, m/s².
    Gravity {
        /// Acceleration of free fall.
        acceleration: Vector,
    },
    /// A force vector at a point, N; with `reaction`, its opposite acts on that anchor's body at
    /// the same place.
    Force {
        /// Where it acts.
        on: Anchor,
        /// Components.
        vector: Vector,
        /// Whether the components are along the axes of the body instead of the world's.
        follows_body: bool,
    },
    /// A force along the line of two points, N; positive pushes them apart.
    ForceBetween {
        /// One end.
        a: Anchor,
        /// The other end.
        b: Anchor,
        /// Magnitude.
        value: Expr,
    },
    /// A torque vector in world axes, N m, on `on` and its opposite on `from` (the ground for none).
    Torque {
        /// The body it acts on.
        on: BodyId,
        /// The body that bears the opposite torque.
        from: BodyId,
        /// Components; a planar torque is (0, 0, value).
        vector: Vector,
    },
    /// A linear spring, with a damper beside it, along the line of two points.
    Spring {
        /// One end.
        a: Anchor,
        /// The other end.
        b: Anchor,
        /// N/m.
        stiffness: Expr,
        /// Unloaded length, m.
        length: Expr,
        /// N s/m; zero for a pure spring. A damper has zero stiffness.
        damping: Expr,
    },
    /// A torsional spring, with a damper beside it, about the joint's rotation.
    Torsion {
        /// The joint whose rotation it resists.
        joint: JointId,
        /// N m/rad.
        stiffness: Expr,
        /// Unloaded angle, rad.
        angle: Expr,
        /// N m s/rad.
        damping: Expr,
    },
    /// Limits of one motion of a joint; where they are reached, bodies hit and may rest.
    Stop {
        /// The joint whose motion is limited.
        joint: JointId,
        /// Which of its motions.
        motion_idx: usize,
        /// Smallest position, rad or m.
        min: Option<Expr>,
        /// Largest position, rad or m.
        max: Option<Expr>,
        /// Speed after a blow over the speed before, in 0 ..= 1.
        restitution: Expr,
    },
    /// Dry friction in one motion of a joint.
    Friction {
        /// The joint whose motion it resists.
        joint: JointId,
        /// Which of its motions.
        motion_idx: usize,
        /// Friction while it slides, N or N m, not negative.
        sliding: Expr,
        /// Largest friction while it sticks; what is below `sliding` counts as `sliding`.
        sticking: Expr,
    },
}

/// A prescribed motion: the measure equals the function of time.
#[derive(Clone, Debug)]
pub struct Drive {
    /// Name as written.
    pub name: String,
    /// The driven joint.
    pub joint: JointId,
    /// Which of its motions: 0 unless the joint is a pin in a slot.
    pub motion_idx: usize,
    /// Prescribed position of the joint as a function of time and parameters, rad or m.
    pub motion: Expr,
    /// Place of the motion.
    pub span: Span,
}

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

/// Something of the motion that has a value at every instant.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Measure {
    /// A coordinate of a joint, rad or m; the second is its place in the joint's motion.
    JointPosition(JointId, usize),
    /// Its rate.
    JointVelocity(JointId, usize),
    /// World coordinate of a body's point, m; `None` is the centre of mass.
    PointPosition(BodyId, Option<PointId>, Axis),
    /// Its rate.
    PointVelocity(BodyId, Option<PointId>, Axis),
    /// Angle of a body against the ground about z, rad (planar).
    BodyAngle(BodyId),
    /// Its rate.
    BodyRate(BodyId),
}

/// A symbol that stands for a measure.
#[derive(Clone, Copy, Debug)]
pub struct Signal {
    /// The symbol used in expressions.
    pub symbol: SymbolId,
    /// What it measures.
    pub measure: Measure,
}

/// One stated or guessed value of the start.
#[derive(Clone, Debug)]
pub struct Initial {
    /// What is stated.
    pub measure: Measure,
    /// Its value in SI, an expression of parameters.
    pub value: Expr,
    /// Whether it may move to close the mechanism.
    pub is_guess: bool,
    /// Name as written, for messages: `A.angle`.
    pub name: String,
    /// Place of the value.
    pub span: Span,
}

/// The `[solve]` table; every field has a default, so that a model without one solves.
#[derive(Clone, Debug)]
pub struct SolveOptions {
    /// Start, s. Default 0.
    pub t_start: f64,
    /// End, s. Default 10.
    pub t_end: f64,
    /// Output interval, s, where outputs are even. Default: a five-hundredth of the span.
    pub every: Option<f64>,
    /// When samples are taken. Default: evenly.
    pub outputs: Outputs,
    /// Relative tolerance. Default 1e-6.
    pub rtol: f64,
    /// Absolute tolerance in the units of each coordinate. Default 1e-8.
    pub atol: f64,
    /// Fixed step, s; `None` for adaptive steps.
    pub step: Option<f64>,
    /// In fixed-step mode, Newton's iteration ends below this error. Default 1e-10.
    pub newton_tolerance: f64,
    /// What integrates the equations.
    pub method: Method,
    /// Which equations Radau integrates.
    pub formulation: Formulation,
    /// When the equations become machine code; no result depends on it. Default: when it pays.
    pub jit: Jit,
    /// Place of each stated key, for messages that arise later.
    pub spans: Vec<(String, Span)>,
}

impl SolveOptions {
    /// The interval of even outputs, s.
    pub fn interval(&self) -> f64 {
        self.every.unwrap_or((self.t_end - self.t_start).abs() / 500.0)
    }
}

/// When samples are taken, beside the start and the end.
#[derive(Clone, PartialEq, Debug, Default)]
pub enum Outputs {
    /// At even intervals.
    #[default]
    Even,
    /// At the end of every accepted step, and where something switches.
    Steps,
    /// At these times, s, in any order; those outside of the run are passed over.
    Times(Vec<f64>),
}

/// What integrates the equations of motion.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Method {
    /// Explicit steps as long as the motion is not stiff, then Radau IIA. Radau IIA with a fixed
    /// step.
    #[default]
    Auto,
    /// Radau IIA on the chosen formulation.
    Radau,
    /// Dormand–Prince 8(5,3) on the accelerations of the multiplier system, with projection.
    Explicit,
}

/// Which form of the equations of motion is integrated by Radau.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Formulation {
    /// Stabilised index 2 (Gear, Gupta and Leimkuhler 1985): position and velocity constraints.
    #[default]
    Ggl,
    /// Index 2: velocity constraints only.
    Index2,
    /// Index 3: position constraints only.
    Index3,
    /// Index 1: acceleration constraints only; positions and velocities are projected after every
    /// step.
    Index1,
}
