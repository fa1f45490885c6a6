//! Sliding of surfaces along no motion of their joint: where curves touch, and between the teeth of wheels.
//!
//! ```text
//! curves   p = L₁(s₁) ± L₂(s₂)        their lengths up to the place where they touch, − where the tangents point one way
//! face     p = (t · u) L(s) − u · x    t the tangent of the curve, u along the face, x from its point to the place
//! teeth    p = (r₁ φ₁ ± r₂ φ₂)/2      the way of the pitch circles, φ against the carrier
//! worm     p = (r₁² φ₁ + i r₂² φ₂)/√(r₁² + i² r₂²)   the way of its threads along the teeth of the wheel
//! ```
//!
//! ṗ is the speed at which the successor slides on the predecessor, but that of teeth of other gears: there it is the speed of the pitch
//! circles, and the friction along it, half on either wheel, takes the power that the teeth lose by their sliding.

use bksim_expr::Expr;

use crate::coupling::along;
use crate::folding::short;
use crate::force::Wrench;
use crate::joint::{self, JointWrench};
use crate::kinematics::Kinematics;
use crate::spatial;
use crate::worm::Worm;
use bksim_model::{CouplingId, CouplingKind, Joint, JointId, LoadKind};
use bksim_model::{Measure, Model, MotionKind, Rack, Surface, Wheels};

/// A motion along which surfaces slide.
pub(crate) struct Sliding {
    /// p, m or rad.
    pub(crate) position: Expr,
    /// On the bodies for a unit effort along it; none where curves touch, whose parameters take it.
    pub(crate) wrenches: Vec<Wrench>,
    /// Translation where it is a length.
    pub(crate) kind: MotionKind,
}

impl Sliding {
    /// The motion that friction of such surfaces is against; `None` of friction in a motion of its joint.
    pub(crate) fn of(model: &Model, kinematics: &Kinematics, load: &LoadKind) -> Option<Self> {
        let (joint, _) = load.joint_motion()?;
        match load.coulomb()? {
            Surface::Touch { arcs } => Self::of_touch(model, kinematics, joint, arcs),
            Surface::Teeth { coupling, .. } => Self::of_teeth(model, kinematics, coupling),
            Surface::Guide { .. }
            | Surface::Journal { .. }
            | Surface::Thread { .. }
            | Surface::Track => None,
        }
    }

    fn of_touch(
        model: &Model,
        kinematics: &Kinematics,
        id: JointId,
        arcs: [Expr; 2],
    ) -> Option<Self> {
        let pool = &model.pool;
        let joint = &model.joints[id.0];
        let sides = kinematics.sides(model, joint);
        let lengths = kinematics.lengths_along(model, id, arcs);
        let kind = MotionKind::Translation;
        if let Some(is_same_way) = joint.kind.is_same_way() {
            let [first, second] = lengths;
            let position =
                if is_same_way { pool.sub(first, second) } else { pool.add(first, second) };
            return Some(Self { position, wrenches: Vec::new(), kind });
        }
        let face = joint::Face::of(pool, joint, &sides)?;
        let way = spatial::dot(pool, &face.along, &face.arm);
        let turned = pool.mul(spatial::dot(pool, &face.tangent, &face.along), lengths[0]);
        let wrench = JointWrench::of_force(pool, face.along);
        let wrenches = Wrench::through_joint(model, kinematics, id, &wrench);
        Some(Self { position: pool.sub(turned, way), wrenches, kind })
    }

    fn of_teeth(model: &Model, kinematics: &Kinematics, coupling: CouplingId) -> Option<Self> {
        let pool = &model.pool;
        let coupling = &model.couplings[coupling.0];
        let parts = match coupling.kind {
            CouplingKind::Gear(pair) if pair.worm.is_some() => {
                return Self::of_worm(model, kinematics, &pair);
            }
            CouplingKind::Gear(Wheels { axes, wheels, carrier, ratio, radii, .. }) => {
                let turn = |k: usize| Measure::Turn(wheels[k].body, carrier, axes[k]);
                let [first, second] = radii.unwrap_or([ratio, pool.one()]);
                [(first, turn(0)), (second, turn(1))]
            }
            CouplingKind::Rack(rack) => Self::of_rack(model, &rack),
            _ => return None,
        };
        let mut position = pool.zero();
        let mut wrenches = Vec::new();
        for (radius, measure) in parts {
            let share = pool.mul(pool.rational(1, 2), radius);
            let measured = short(pool, kinematics.measure(model, measure));
            position = pool.add(position, pool.mul(share, measured));
            let unit = along(model, kinematics, measure);
            wrenches.extend(unit.iter().map(|wrench| wrench.scaled(pool, share)));
        }
        Some(Self { position, wrenches, kind: coupling.effort })
    }

    /// Threads along the teeth of a wheel; the friction is at the pitch point.
    fn of_worm(model: &Model, kinematics: &Kinematics, pair: &Wheels) -> Option<Self> {
        let pool = &model.pool;
        let worm = Worm::of(model, kinematics, pair)?;
        let [first, _] = pair.radii?;
        let radius = pair.worm?.radius;
        let speed = pool.sqrt(pool.add(pool.powi(radius, 2), pool.powi(first, 2)));
        let turned = |k: usize| {
            let turn = Measure::Turn(pair.wheels[k].body, pair.carrier, pair.axes[k]);
            short(pool, kinematics.measure(model, turn))
        };
        let of_wheel = pool.div(pool.powi(first, 2), pair.ratio);
        let way =
            pool.add(pool.mul(pool.powi(radius, 2), turned(0)), pool.mul(of_wheel, turned(1)));
        let along = spatial::scale(pool, pool.neg(pool.div(pool.one(), speed)), &worm.sliding);
        let wrenches = worm.push(pool, pair, along);
        let position = pool.div(way, speed);
        Some(Self { position, wrenches, kind: MotionKind::Translation })
    }

    /// The pinion against the carrier, and the rack, whose joint may count backwards.
    fn of_rack(model: &Model, rack: &Rack) -> [(Expr, Measure); 2] {
        let pool = &model.pool;
        let slide: &Joint = &model.joints[rack.joints[1].0];
        let is_first = slide.predecessor.body == rack.bodies[1];
        let carrier = if is_first { slide.successor.body } else { slide.predecessor.body };
        let sense = if is_first { pool.int(-1) } else { pool.one() };
        [
            (rack.radius, Measure::Turn(rack.bodies[0], carrier, rack.joints[0])),
            (sense, Measure::JointPosition(rack.joints[1], 0)),
        ]
    }
}
