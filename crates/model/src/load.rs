//! Loads: forces, springs, gravity, stops and friction.

use bksim_expr::{Expr, Pool};

use crate::body::Anchor;
use crate::coupling::Coupling;
use crate::diagnostic::Span;
use crate::ids::{BodyId, ContactId, CouplingId, JointId, RopeId, Vector};
use crate::joint::MotionKind;
use crate::questions::data_of_kinds;

/// A force law.
#[derive(Clone, Debug)]
pub struct Load {
    /// Name as written.
    pub name: String,
    /// The kind, with its numbers.
    pub kind: LoadKind,
    /// Position of the expression, or of the name when there is none.
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
        /// The point at which it acts.
        on: Anchor,
        /// Components.
        vector: Vector,
        /// True if the components are along the axes of the body instead of the world's.
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
    /// A linear spring with a damper in parallel, along the line of two points.
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
    /// A force or torque in one motion of a joint, on its successor from its predecessor.
    Effort {
        /// The joint.
        joint: JointId,
        /// Which of its motions.
        motion_idx: usize,
        /// N along a translation, N m about the axis of a rotation.
        value: Expr,
    },
    /// A linear spring with a damper in parallel, in one motion of a joint.
    JointSpring {
        /// The joint.
        joint: JointId,
        /// Which of its motions.
        motion_idx: usize,
        /// N/m, or N m/rad of a rotation.
        stiffness: Expr,
        /// Unloaded position, m or rad.
        unloaded: Expr,
        /// N s/m, or N m s/rad of a rotation.
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
        /// Speed after an impact over the speed before, in 0 ..= 1.
        restitution: Expr,
    },
    /// A part of a rope that may become slack: where it is taut it pulls, and pulls only.
    Rope {
        /// The rope.
        rope: RopeId,
        /// Which of its parts.
        section: usize,
        /// Excess of the way over the rope's own length, m: an expression of signals.
        excess: Expr,
        /// Speed after it has become taut over the speed before, in 0 ..= 1.
        restitution: Expr,
    },
    /// A place where two bodies may touch: there they push each other apart, and only so.
    Touch {
        /// The contact.
        contact: ContactId,
        /// Which of its places.
        place: usize,
        /// Speed of parting after an impact over the speed of approach, in 0 ..= 1.
        restitution: Expr,
    },
    /// Coulomb's friction of the places of a contact that rub together, or their rolling resistance.
    Rub {
        /// The contact.
        contact: ContactId,
        /// Which of its tracks.
        track: usize,
        /// Motion that it opposes.
        opposed: Opposed,
        /// Coefficient while they slide; of rolling the arm, m: the torque over the pressing force.
        sliding: Expr,
        /// Coefficient, or arm, while they stick.
        sticking: Expr,
    },
    /// Dry friction between a rope and something that it goes around; the load is named as the part of the rope before it.
    Capstan {
        /// The rope.
        rope: RopeId,
        /// Which of its parts goes around.
        section: usize,
        /// Node of the rope that it goes around.
        node: usize,
        /// Way that the rope has slipped back over it, m: an expression of signals.
        slipped: Expr,
        /// Angle that the rope touches, rad: an expression of signals.
        wrap: Expr,
        /// Coefficients of friction while it slips and while it grips.
        mu: [Expr; 2],
    },
    /// One side of the teeth of a coupling with play: its flanks push, and push only.
    Flank {
        /// The coupling that holds where the flanks touch by which the first member drives the second forward.
        teeth: Box<Coupling>,
        /// True if these are the flanks by which the first turns backwards.
        is_back: bool,
        /// Overlap of the flanks, m or rad: an expression of signals.
        excess: Expr,
        /// Speed after an impact over the speed before, in 0 ..= 1.
        restitution: Expr,
    },
    /// Teeth that give: a force of stated size in place of the row of a coupling.
    Mesh {
        /// The coupling that would hold if they were rigid.
        teeth: Box<Coupling>,
        /// Force along the pitch circles, N, above zero where it turns the second forward: an expression of signals.
        force: Expr,
    },
    /// Dry friction in one motion of a joint.
    Friction {
        /// The joint whose motion it resists.
        joint: JointId,
        /// Which of its motions.
        motion_idx: usize,
        /// The size of the friction.
        law: FrictionLaw,
    },
}

impl Load {
    /// True if it is a coupling that holds on one side: a rope that may become slack, or flanks with play.
    pub fn is_coupling(&self) -> bool {
        self.kind.excess().is_some()
    }

    /// True if it is the friction of a rope.
    pub fn is_capstan(&self) -> bool {
        self.kind.grip().is_some()
    }

    /// The teeth of flanks with play, and of those that give.
    pub fn teeth(&self) -> Option<&Coupling> {
        match &self.kind {
            LoadKind::Flank { teeth, .. } | LoadKind::Mesh { teeth, .. } => Some(teeth),
            _ => None,
        }
    }

    /// The motion of a joint whose position its law follows: that of a spring that has a stiffness, or of a stop.
    pub fn position_it_follows(&self, pool: &Pool) -> Option<(JointId, usize)> {
        let is_elastic = self.kind.spring().is_some_and(|[stiffness, ..]| !pool.is_zero(stiffness));
        self.kind.joint_motion().filter(|_| is_elastic || self.kind.limits().is_some())
    }

    /// Translation where its force is one along a way, rotation where it is a moment.
    pub fn effort(&self) -> MotionKind {
        match self.kind {
            LoadKind::Rub { opposed: Opposed::Roll, .. } => MotionKind::Rotation,
            _ => self.teeth().map_or(MotionKind::Translation, |teeth| teeth.effort),
        }
    }

    /// The contact that it is a row of.
    pub fn contact(&self) -> Option<ContactId> {
        let of_rub = self.kind.rub().map(|(contact, ..)| contact);
        self.kind.touch().map(|(contact, _)| contact).or(of_rub)
    }
}

data_of_kinds! {
    LoadKind:
    /// The joint in whose motion it acts, and the motion.
    joint_motion -> (JointId, usize) {
        Self::Effort { joint, motion_idx, .. } | Self::JointSpring { joint, motion_idx, .. } => (joint, motion_idx),
        Self::Stop { joint, motion_idx, .. } | Self::Friction { joint, motion_idx, .. } => (joint, motion_idx)
    }
    /// The points of which it acts along the line.
    ends -> [Anchor; 2] { Self::ForceBetween { a, b, .. } | Self::Spring { a, b, .. } => [a, b] }
    /// Stiffness, unloaded length or position, and damping of a spring or damper.
    spring -> [Expr; 3] {
        Self::Spring { stiffness, length: unloaded, damping, .. }
            | Self::JointSpring { stiffness, unloaded, damping, .. } => [stiffness, unloaded, damping]
    }
    /// A stated force or torque between two points or in a motion of a joint.
    stated_effort -> Expr { Self::ForceBetween { value, .. } | Self::Effort { value, .. } => value }
    /// The acceleration of uniform gravity, m/s².
    gravity -> Vector { Self::Gravity { acceleration } => acceleration }
    /// The point of a force, its components, and true if they are along the axes of the body.
    point_force -> (Anchor, Vector, bool) { Self::Force { on, vector, follows_body } => (on, vector, follows_body) }
    /// The body on which a torque acts, the body that bears it, and its components.
    torque -> (BodyId, BodyId, Vector) { Self::Torque { on, from, vector } => (on, from, vector) }
    /// Smallest and largest position of a stop, rad or m.
    limits -> [Option<Expr>; 2] { Self::Stop { min, max, .. } => [min, max] }
    /// Speed after an impact over the speed before.
    restitution -> Expr {
        Self::Stop { restitution, .. } | Self::Rope { restitution, .. } => restitution,
        Self::Flank { restitution, .. } | Self::Touch { restitution, .. } => restitution
    }
    /// Excess of a rope over its length, or overlap of flanks, m or rad.
    excess -> Expr { Self::Rope { excess, .. } | Self::Flank { excess, .. } => excess }
    /// Of flanks with play, true if the first member turns backwards by them.
    is_back_flank -> bool { Self::Flank { is_back, .. } => is_back }
    /// The contact of bodies that may touch, and the place of it.
    touch -> (ContactId, usize) { Self::Touch { contact, place, .. } => (contact, place) }
    /// The contact of bodies that rub, the track of it, and the motion that this opposes.
    rub -> (ContactId, usize, Opposed) { Self::Rub { contact, track, opposed, .. } => (contact, track, opposed) }
    /// Where a rope rubs: the rope, its part, and the node that it goes around.
    rope_node -> (RopeId, usize, usize) { Self::Capstan { rope, section, node, .. } => (rope, section, node) }
    /// Where a rope rubs: the angle that it touches, rad, and its coefficients while it slips and while it grips.
    grip -> (Expr, [Expr; 2]) { Self::Capstan { wrap, mu, .. } => (wrap, mu) }
    /// The surfaces of a joint whose reaction presses them together.
    coulomb -> Surface { Self::Friction { law: FrictionLaw::Coulomb { surface, .. }, .. } => surface }
}

/// The motion of bodies in touch that friction opposes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Opposed {
    /// Along the line on which they rub, by a force; in space along the first of two directions.
    Slip,
    /// In space along the second direction; one limit bounds the friction in both.
    Across,
    /// Turning against each other, by a torque.
    Roll,
}

impl LoadKind {
    /// The points of bodies at which it acts.
    pub fn points(&self) -> Vec<Anchor> {
        let of_force = self.point_force().map(|(on, ..)| on);
        self.ends().into_iter().flatten().chain(of_force).collect()
    }

    /// Every expression of it.
    pub fn expressions(&self) -> Vec<Expr> {
        match *self {
            Self::Gravity { acceleration } => acceleration.to_vec(),
            Self::Force { vector, .. } | Self::Torque { vector, .. } => vector.to_vec(),
            Self::ForceBetween { value, .. } | Self::Effort { value, .. } => vec![value],
            Self::Spring { stiffness, length: unloaded, damping, .. }
            | Self::JointSpring { stiffness, unloaded, damping, .. } => {
                vec![stiffness, unloaded, damping]
            }
            Self::Stop { min, max, restitution, .. } => {
                [min, max, Some(restitution)].into_iter().flatten().collect()
            }
            Self::Rope { excess, restitution, .. } | Self::Flank { excess, restitution, .. } => {
                vec![excess, restitution]
            }
            Self::Touch { restitution, .. } => vec![restitution],
            Self::Mesh { force, .. } => vec![force],
            Self::Rub { sliding, sticking, .. } => vec![sliding, sticking],
            Self::Capstan { slipped, wrap, mu: [sliding, sticking], .. } => {
                vec![slipped, wrap, sliding, sticking]
            }
            Self::Friction { law, .. } => law.expressions(),
        }
    }
}

/// The size of dry friction.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum FrictionLaw {
    /// Stated efforts, N or N m, not negative.
    Stated {
        /// Friction while it slides.
        sliding: Expr,
        /// Largest friction while it sticks; what is below `sliding` counts as `sliding`.
        sticking: Expr,
    },
    /// Coulomb's friction of surfaces that the joint's own reaction presses together.
    Coulomb {
        /// Coefficient while they slide.
        sliding: Expr,
        /// Coefficient while they stick.
        sticking: Expr,
        /// The surfaces.
        surface: Surface,
    },
}

/// The surfaces of a joint that rub.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Surface {
    /// A guide, on which the successor bears at its joint point, or with both ends of a sleeve about it.
    Guide {
        /// Length of the sleeve, m.
        length: Option<Expr>,
    },
    /// A pin in its bearing.
    Journal {
        /// Radius of the pin, m.
        radius: Expr,
    },
    /// The thread of a screw.
    Thread {
        /// Mean radius, m.
        radius: Expr,
        /// Friction of its collar over the axial force, m; zero where it has none.
        collar: Expr,
    },
    /// A curve along which the successor's point slides, in a slot or on a wire.
    Track,
    /// Two curves, or a curve and a face, at the place where they touch.
    Touch {
        /// The lengths of the curves of predecessor and successor, m, as expressions of their parameters; zero of a
        /// face.
        arcs: [Expr; 2],
    },
    /// The teeth of two gears, or of a pinion and its rack, which slide on each other but at the pitch point.
    Teeth {
        /// The coupling that they keep.
        coupling: CouplingId,
        /// Loss factor H: friction takes μ H of the power that the teeth carry.
        loss: Expr,
    },
}

impl FrictionLaw {
    /// Every expression of it.
    pub fn expressions(&self) -> Vec<Expr> {
        match *self {
            Self::Stated { sliding, sticking } => vec![sliding, sticking],
            Self::Coulomb { sliding, sticking, surface } => {
                let sizes = match surface {
                    Surface::Guide { length } => [length, None],
                    Surface::Journal { radius } => [Some(radius), None],
                    Surface::Thread { radius, collar } => [Some(radius), Some(collar)],
                    Surface::Teeth { loss, .. } => [Some(loss), None],
                    Surface::Track | Surface::Touch { .. } => [None; 2],
                };
                [sliding, sticking].into_iter().chain(sizes.into_iter().flatten()).collect()
            }
        }
    }
}
