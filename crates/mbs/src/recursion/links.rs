//! The tree as links with one elementary motion each.

use bksim_expr::{Expr, Pool};
use bksim_model::{BodyId, GROUND, JointId, Model, MotionKind, Vector};

use super::naming::Naming;
use super::turn::LinkTurn;
use crate::coordinate::{CoordinateKind, Owner};
use crate::inertia::central_inertia;
use crate::joint;
use crate::kinematics::{Kinematics, Turning};
use crate::pose::{anchor_in_body, orientations};
use crate::quaternion::Quaternion;
use crate::spatial::{self, Rotation};
use crate::tree::{Branch, Tree};

/// Index of a link; those nearer to the ground come first.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct LinkId(pub(super) usize);

/// The motion of a link against the one before it.
#[derive(Clone, Debug)]
pub(super) enum LinkMotion {
    /// A turn that does not change.
    Fixed(LinkTurn),
    /// A turn by a coordinate about `axis`, which is the same before and after it.
    Rotation { turn: LinkTurn, axis: Vector, coordinate_idx: usize },
    /// A turn by the quaternion of four coordinates, the first of which is given; `s` is 2 / e·e. Of a
    /// joint passed backwards it is the opposite one, as are then its rates.
    Quaternion { turn: LinkTurn, quaternion: Quaternion, s: Expr, first: usize, is_reversed: bool },
    /// A slide along `axis`, whose length is the way for one unit of the coordinate `q`.
    Translation { axis: Vector, q: Expr, coordinate_idx: usize },
}

/// Mass and inertia of a body, in the frame of its link.
#[derive(Clone, Debug)]
pub(super) struct LinkBody {
    pub(super) id: BodyId,
    /// kg.
    pub(super) mass: Expr,
    /// Centre of mass from the frame's origin, m.
    pub(super) com: Vector,
    /// I′ about the centre of mass, kg m².
    pub(super) inertia: [Vector; 3],
}

/// One elementary motion after the link before, and the body that ends with it, if one does.
#[derive(Clone, Debug)]
pub(super) struct Link {
    /// The link before; `None` is the ground.
    pub(super) parent: Option<LinkId>,
    /// Origin of the frame before the motion, frame of the link before, m.
    pub(super) offset: Vector,
    pub(super) motion: LinkMotion,
    pub(super) body: Option<LinkBody>,
}

/// The direction of a motion by one coordinate, link's axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Screw {
    pub(super) kind: MotionKind,
    pub(super) axis: Vector,
    pub(super) coordinate_idx: usize,
}

impl LinkMotion {
    /// The directions of its coordinates: velocity of the link against the one before for a unit rate.
    pub(super) fn screws(&self, pool: &Pool) -> Vec<Screw> {
        let screw = |kind, axis, coordinate_idx| Screw { kind, axis, coordinate_idx };
        match self {
            Self::Fixed(_) => Vec::new(),
            Self::Rotation { axis, coordinate_idx, .. } => {
                vec![screw(MotionKind::Rotation, *axis, *coordinate_idx)]
            }
            Self::Translation { axis, coordinate_idx, .. } => {
                vec![screw(MotionKind::Translation, *axis, *coordinate_idx)]
            }
            // ω = s E ė, column by column.
            Self::Quaternion { quaternion, s, first, is_reversed, .. } => {
                let rows = quaternion.inner_rows(pool);
                let column = |part: usize| {
                    let column = spatial::scale(pool, *s, &rows.map(|row| row[part]));
                    let is_opposite = *is_reversed && part > 0;
                    let column = if is_opposite { spatial::neg(pool, &column) } else { column };
                    screw(MotionKind::Rotation, column, first + part)
                };
                (0..4).map(column).collect()
            }
        }
    }
}

/// The turning of a link by its quaternion, link's axes.
pub(super) struct Spin {
    /// s E ė, rad/s.
    pub(super) rate: Vector,
    /// s (E ë − (e·ė) ω), rad/s².
    pub(super) gain: Vector,
}

impl Link {
    /// The turning by a quaternion, if the link has one, from the rates and accelerations of all
    /// coordinates.
    pub(super) fn spin(
        &self,
        pool: &Pool,
        [rates, accelerations]: [&[Expr]; 2],
        link_idx: usize,
        naming: &Naming<'_>,
    ) -> Option<Spin> {
        let LinkMotion::Quaternion { quaternion, s, first, is_reversed, .. } = &self.motion else {
            return None;
        };
        let of = |all: &[Expr]| {
            std::array::from_fn(|part| {
                let rate = all[first + part];
                if *is_reversed && part > 0 { pool.neg(rate) } else { rate }
            })
        };
        let (rates, accelerations) = (of(rates), of(accelerations));
        let rate = spatial::scale(pool, *s, &quaternion.to_inner_rate(pool, &rates));
        // On the ground it is the whole angular velocity.
        let letter = if self.parent.is_none() { "omega" } else { "w" };
        let rate = naming.vector(letter, link_idx, &rate);
        let along = naming.scalar("d", link_idx, quaternion.dot(pool, &rates));
        let gain = quaternion.to_inner_rate(pool, &accelerations);
        let gain = spatial::sub(pool, &gain, &spatial::scale(pool, along, &rate));
        let gain = spatial::scale(pool, *s, &gain);
        Some(Spin { rate, gain })
    }
}

impl Link {
    /// Origin of the link's frame, frame of the link before, m.
    pub(super) fn origin(&self, pool: &Pool) -> Vector {
        match &self.motion {
            LinkMotion::Translation { axis, q, .. } => {
                spatial::add(pool, &self.offset, &spatial::scale(pool, *q, axis))
            }
            _ => self.offset,
        }
    }

    /// Rᵀ u: a vector of the frame before, in the link's frame.
    pub(super) fn to_link(&self, pool: &Pool, u: &Vector) -> Vector {
        self.turn().map_or(*u, |turn| turn.to_inner(pool, u))
    }

    /// R u: a vector of the link's frame, in the frame before.
    pub(super) fn to_parent(&self, pool: &Pool, u: &Vector) -> Vector {
        self.turn().map_or(*u, |turn| turn.to_outer(pool, u))
    }

    /// The turn between the frame before and the link's.
    pub(super) fn turn(&self) -> Option<&LinkTurn> {
        match &self.motion {
            LinkMotion::Fixed(turn)
            | LinkMotion::Rotation { turn, .. }
            | LinkMotion::Quaternion { turn, .. } => Some(turn),
            LinkMotion::Translation { .. } => None,
        }
    }
}

/// All links, those nearer to the ground first.
#[derive(Clone, Debug)]
pub(super) struct Links {
    pub(super) links: Vec<Link>,
    pub(super) n_coordinates: usize,
}

impl Links {
    /// The links of the bodies of `model` along `tree`, whose motions are the coordinates of `kinematics`.
    pub(super) fn of(model: &Model, tree: &Tree, kinematics: &Kinematics) -> Self {
        let ground = Frame { link: None, anchor: spatial::zero(&model.pool) };
        let mut chain = Chain {
            model,
            kinematics,
            links: Vec::new(),
            frames: vec![ground; model.bodies.len()],
        };
        debug_assert_eq!(GROUND, BodyId(0));
        for &(body, branch) in &tree.branches {
            match branch {
                Branch::Free => chain.free(body),
                Branch::Joint { joint, parent, reversed } => {
                    chain.joint(body, joint, parent, reversed);
                }
            }
        }
        Self { links: chain.links, n_coordinates: kinematics.coordinates.len() }
    }
}

impl Links {
    /// Index of the link that turns by a quaternion.
    pub(super) fn of_turning(&self, turning: &Turning) -> usize {
        let is_own = |link: &Link| matches!(link.motion, LinkMotion::Quaternion { first, .. } if first == turning.first);
        self.links.iter().position(is_own).unwrap_or_default()
    }

    /// Labels of the links: their bodies, or the coordinates of those that carry none.
    pub(super) fn labels(&self, model: &Model, kinematics: &Kinematics) -> Vec<String> {
        let label = |link: &Link| match (&link.body, &link.motion) {
            (Some(body), _) => model.bodies[body.id.0].name.clone(),
            (
                None,
                LinkMotion::Rotation { coordinate_idx, .. }
                | LinkMotion::Translation { coordinate_idx, .. },
            ) => kinematics.coordinates[*coordinate_idx].name.clone(),
            (None, LinkMotion::Quaternion { first, .. }) => {
                kinematics.coordinates[*first].name.trim_end_matches("_e0").to_owned()
            }
            (None, LinkMotion::Fixed(_)) => "turn".to_owned(),
        };
        self.links.iter().map(label).collect()
    }

    /// Links with names for the matrices of quaternions: `A_arm_xy`, and `s_arm` for 2 / e·e.
    pub(super) fn named(mut self, pool: &Pool, naming: &Naming<'_>) -> Self {
        for (link_idx, link) in self.links.iter_mut().enumerate() {
            if let LinkMotion::Quaternion { turn, quaternion, s, .. } = &mut link.motion {
                *s = naming.scalar("s", link_idx, *s);
                *turn =
                    LinkTurn::Matrix(naming.matrix("A", link_idx, &quaternion.matrix(pool, *s)));
            }
        }
        self
    }
}

/// The frame of a body.
#[derive(Clone, Debug)]
struct Frame {
    /// Link that carries the frame; `None` is the ground.
    link: Option<LinkId>,
    /// The point of the body at the origin of the link's frame, body frame, m.
    anchor: Vector,
}

struct Chain<'a> {
    model: &'a Model,
    kinematics: &'a Kinematics,
    links: Vec<Link>,
    /// By body.
    frames: Vec<Frame>,
}

impl Chain<'_> {
    /// A body that moves freely: its centre of mass along x, y (z), then its turns or its quaternion.
    fn free(&mut self, body: BodyId) {
        let pool = &self.model.pool;
        let owned = |owner| matches!(owner, Owner::Body(id, _) if id == body);
        let own: Vec<usize> = self.coordinates_where(owned);
        let n_axes = own.len().min(3);
        let quaternion = self.quaternion(body, false);
        let motions = own.iter().enumerate().map(|(motion_idx, &coordinate_idx)| {
            let is_slide =
                self.kinematics.coordinates[coordinate_idx].kind == CoordinateKind::Length;
            let kind = if is_slide { MotionKind::Translation } else { MotionKind::Rotation };
            let mut axis = spatial::zero(pool);
            // A plane has one turn, the last of three; space has three, or a quaternion.
            let axis_idx = match kind {
                MotionKind::Translation => motion_idx,
                MotionKind::Rotation if n_axes == own.len() => 2,
                MotionKind::Rotation => motion_idx - n_axes,
            };
            axis[axis_idx] = pool.one();
            self.motion(kind, axis, coordinate_idx)
        });
        let motions = motions.chain(quaternion).collect();
        let ground = Frame { link: None, anchor: spatial::zero(pool) };
        self.place(body, &ground, &spatial::zero(pool), motions, self.model.bodies[body.0].com);
    }

    /// A body on `parent`; seen from the successor, a joint's motions run backwards.
    fn joint(&mut self, body: BodyId, joint_id: JointId, parent: BodyId, reversed: bool) {
        let (model, pool) = (self.model, &self.model.pool);
        let joint = &model.joints[joint_id.0];
        let own =
            self.coordinates_where(|owner| matches!(owner, Owner::Joint(id, _) if id == joint_id));
        // Slides, the fixed turn, then turns, a screw's with the slide that goes with it.
        let mut slides = Vec::new();
        let mut turns = Vec::new();
        for (motion, &idx) in joint::motions(pool, joint).iter().zip(&own) {
            let sense = if reversed { pool.int(-1) } else { pool.one() };
            let axis = spatial::scale(pool, sense, &motion.axis);
            let of_kind = match motion.kind {
                MotionKind::Translation => &mut slides,
                MotionKind::Rotation => &mut turns,
            };
            if let Some(pitch) = motion.pitch {
                let way = spatial::scale(pool, pitch, &axis);
                of_kind.push(self.motion(MotionKind::Translation, way, idx));
            }
            of_kind.push(self.motion(motion.kind, axis, idx));
        }
        turns.extend(self.quaternion(body, reversed));
        let fixed = joint::fixed_turn(pool, joint);
        let fixed = if reversed { fixed.inverse(pool) } else { fixed };
        let mut fixed = fixed_turns(pool, &fixed);
        let [of_predecessor, of_successor] = orientations(model, joint);
        let (near, far, r_near, r_far) = if reversed {
            slides.reverse();
            turns.reverse();
            std::mem::swap(&mut slides, &mut turns);
            (joint.successor, joint.predecessor, of_successor, of_predecessor)
        } else {
            (joint.predecessor, joint.successor, of_predecessor, of_successor)
        };
        let mut motions = fixed_turns(pool, &r_near);
        motions.append(&mut slides);
        motions.append(&mut fixed);
        motions.append(&mut turns);
        motions.extend(fixed_turns(pool, &r_far.inverse(pool)));
        let frame = self.frames[parent.0].clone();
        let near = anchor_in_body(model, near);
        self.place(body, &frame, &near, motions, anchor_in_body(model, far));
    }

    fn coordinates_where(&self, owned: impl Fn(Owner) -> bool) -> Vec<usize> {
        let coordinates = self.kinematics.coordinates.iter().enumerate();
        coordinates.filter(|(_, c)| owned(c.owner)).map(|(idx, _)| idx).collect()
    }

    /// The turning by a quaternion of `body`, if it does.
    fn quaternion(&self, body: BodyId, is_reversed: bool) -> Option<LinkMotion> {
        let pool = &self.model.pool;
        let turning = self.kinematics.turnings.iter().find(|turning| turning.body == body)?;
        let own = turning.quaternion;
        let quaternion = if is_reversed { own.inverse(pool) } else { own };
        let s = quaternion.scale(pool);
        let turn = LinkTurn::Matrix(quaternion.matrix(pool, s));
        Some(LinkMotion::Quaternion { turn, quaternion, s, first: turning.first, is_reversed })
    }

    fn motion(&self, kind: MotionKind, axis: Vector, coordinate_idx: usize) -> LinkMotion {
        let pool = &self.model.pool;
        let q = pool.symbol_expr(self.kinematics.coordinates[coordinate_idx].q);
        match kind {
            MotionKind::Translation => LinkMotion::Translation { axis, q, coordinate_idx },
            MotionKind::Rotation => {
                LinkMotion::Rotation { turn: LinkTurn::about(pool, &axis, q), axis, coordinate_idx }
            }
        }
    }

    /// Adds the links of `body`, from the point `near` of the body with `frame` to its own point `far`.
    fn place(
        &mut self,
        body: BodyId,
        frame: &Frame,
        near: &Vector,
        mut motions: Vec<LinkMotion>,
        far: Vector,
    ) {
        let pool = &self.model.pool;
        if motions.is_empty() {
            motions.push(LinkMotion::Fixed(LinkTurn::none(pool)));
        }
        let mut parent = frame.link;
        let mut offset = spatial::sub(pool, near, &frame.anchor);
        for motion in motions {
            self.links.push(Link { parent, offset, motion, body: None });
            parent = Some(LinkId(self.links.len() - 1));
            offset = spatial::zero(pool);
        }
        let own = &self.model.bodies[body.0];
        let last = self.links.last_mut().expect("a link was just added");
        last.body = Some(LinkBody {
            id: body,
            mass: own.mass,
            com: spatial::sub(pool, &own.com, &far),
            inertia: central_inertia(self.model, body),
        });
        self.frames[body.0] = Frame { link: parent, anchor: far };
    }
}

fn fixed_turns(pool: &Pool, rotation: &Rotation) -> Vec<LinkMotion> {
    let turn = |turn: &spatial::Turn| match turn {
        spatial::Turn::About { axis, angle } => LinkTurn::about(pool, axis, *angle),
        spatial::Turn::By(quaternion) => {
            LinkTurn::Matrix(quaternion.matrix(pool, quaternion.scale(pool)))
        }
    };
    rotation.turns().iter().map(|it| LinkMotion::Fixed(turn(it))).collect()
}
