//! Places on bodies that bend, in the frame at the root, as functions of the parts of their shapes.
//!
//! ```text
//! x = X + Σ a_j S_j(ξ) − ½ L ∫ (Σ q_k S_k)² + (Σ r_k S_k)² dξ        ξ = X/L, integral from 0
//! y = L Σ q_k W_k(ξ),   z = L Σ r_k W_k(ξ)
//! ```
//!
//! The cross-section turns by Σ q_k S_k about z and by Σ r_k S_k about −y. The integral is the shortening of the chord to
//! the second order of the slopes, by which forces along the beam stiffen it or make it buckle. Sources: T. R. Kane, R. R.
//! Ryan and A. K. Banerjee, *Dynamics of a cantilever beam attached to a moving base*, J. Guidance 10 (1987); A. A.
//! Shabana, *Dynamics of Multibody Systems*, ch. 5 (floating frames).

use bksim_expr::{Expr, Pool};
use bksim_model::flexible::{Flexible, deflections, short_fraction, shortenings, slopes};
use bksim_model::{Anchor, BodyId, Joint, JointId, Model, Vector};

use crate::coordinate::{Coordinate, Owner};
use crate::kinematics::Kinematics;
use crate::pose::{anchor_in_body, orientation};
use crate::spatial::{self, Rotation};

/// A place of a beam: how far along it is, and the beam.
struct Place<'m> {
    flexible: &'m Flexible,
    xi: f64,
}

impl Kinematics {
    /// An anchor in the frame of its body, bent with it.
    pub(crate) fn in_body(&self, model: &Model, anchor: Anchor) -> Vector {
        let pool = &model.pool;
        let still = anchor_in_body(model, anchor);
        let Some(Place { flexible, xi }) = place(model, anchor) else { return still };
        let sum = |joints: &[JointId], values: &[f64]| self.sum(pool, joints, values);
        let along = sum(&flexible.axial, &slopes(flexible.axial.len(), xi));
        let [y, z] = [&flexible.bending, &flexible.across]
            .map(|joints| pool.mul(flexible.length, sum(joints, &deflections(joints.len(), xi))));
        let mut x = pool.add(still[0], along);
        if flexible.is_stiffened {
            let shorter = [&flexible.bending, &flexible.across]
                .map(|joints| self.square(pool, joints, &shortenings(joints.len(), xi)));
            let half = pool.mul(pool.rational(1, 2), flexible.length);
            x = pool.sub(x, pool.mul(half, pool.sum(shorter)));
        }
        // What is off the axis turns with the cross-section.
        let arm = [pool.zero(), still[1], still[2]];
        let arm = self.section(model, anchor).0.apply(pool, &arm);
        spatial::add(pool, &[x, y, z], &arm)
    }

    /// The rotation r_body_from_frame of the frame of an anchor, bent with its body.
    pub(crate) fn turned(&self, model: &Model, anchor: Anchor) -> Rotation {
        let still = orientation(model, anchor);
        let (section, _) = self.section(model, anchor);
        section.then(&model.pool, &still)
    }

    /// The rotation of the cross-section at an anchor and its angular velocity, both in the frame of its body.
    pub(crate) fn section(&self, model: &Model, anchor: Anchor) -> (Rotation, Vector) {
        let pool = &model.pool;
        let none = (Rotation::default(), spatial::zero(pool));
        let Some(Place { flexible, xi }) = place(model, anchor) else { return none };
        // Places of mass are points.
        let n_masses = flexible.masses.len();
        let is_mass = |at: usize| (flexible.n_points..flexible.n_points + n_masses).contains(&at);
        if anchor.point.is_some_and(|point| is_mass(point.0)) {
            return none;
        }
        let [_, y, z] = spatial::axes(pool);
        let planes = [(&flexible.bending, z), (&flexible.across, spatial::neg(pool, &y))];
        let (mut rotation, mut omega) = none;
        for (joints, axis) in planes.iter().filter(|(joints, _)| !joints.is_empty()) {
            let slopes = slopes(joints.len(), xi);
            let turned = rotation.apply(pool, axis);
            let rate = self.sum_of(pool, joints, &slopes, |c| pool.symbol_expr(c.v));
            omega = spatial::add(pool, &omega, &spatial::scale(pool, rate, &turned));
            let angle = self.sum(pool, joints, &slopes);
            rotation = rotation.then(pool, &Rotation::about(pool, axis, angle));
        }
        (rotation, omega)
    }

    /// The angular velocity of the cross-section at an anchor against its body, world axes.
    pub(crate) fn turning(&self, model: &Model, anchor: Anchor, r_world: &Rotation) -> Vector {
        r_world.apply(&model.pool, &self.section(model, anchor).1)
    }

    fn sum(&self, pool: &Pool, joints: &[JointId], values: &[f64]) -> Expr {
        self.sum_of(pool, joints, values, |c| pool.symbol_expr(c.q))
    }

    fn sum_of(
        &self,
        pool: &Pool,
        joints: &[JointId],
        values: &[f64],
        part: impl Fn(&Coordinate) -> Expr,
    ) -> Expr {
        let terms = joints.iter().zip(values).filter_map(|(&joint, &value)| {
            let factor = exact(pool, value);
            (!pool.is_zero(factor)).then(|| pool.mul(factor, part(self.shape(joint))))
        });
        pool.sum(terms.collect::<Vec<_>>())
    }

    fn square(&self, pool: &Pool, joints: &[JointId], values: &[Vec<f64>]) -> Expr {
        let mut terms = Vec::new();
        for (k, row) in values.iter().enumerate() {
            for (l, &value) in row.iter().enumerate().take(k + 1) {
                let factor = exact(pool, if k == l { value } else { 2.0 * value });
                if !pool.is_zero(factor) {
                    let parts = [joints[k], joints[l]].map(|id| pool.symbol_expr(self.shape(id).q));
                    terms.push(pool.product([factor, parts[0], parts[1]]));
                }
            }
        }
        pool.sum(terms)
    }

    /// The coordinate of a shape.
    fn shape(&self, joint: JointId) -> &Coordinate {
        let owner = Owner::Joint(joint, 0);
        let own = self.coordinates.iter().find(|c| c.owner == owner);
        own.expect("shapes have coordinates before their beam is placed")
    }
}

/// The place of an anchor on a beam; `None` of one on a rigid body or at the root.
fn place(model: &Model, anchor: Anchor) -> Option<Place<'_>> {
    let flexible = model.bodies[anchor.body.0].flexible.as_ref()?;
    let xi = flexible.places[anchor.point?.0];
    (xi != 0.0).then_some(Place { flexible, xi })
}

/// A number, exact where it is a short fraction.
fn exact(pool: &Pool, value: f64) -> Expr {
    match short_fraction(value) {
        Some((numerator, denominator)) => pool.rational(numerator, denominator),
        None => pool.float(value),
    }
}

/// The body on which something acts at an anchor: on a beam that which turns with the cross-section there.
pub(crate) fn bearer(model: &Model, anchor: Anchor) -> BodyId {
    let flexible = model.bodies[anchor.body.0].flexible.as_ref();
    let section = flexible.zip(anchor.point).and_then(|(beam, at)| beam.sections.get(at.0));
    section.copied().unwrap_or(anchor.body)
}

/// The bodies on which the two sides of a joint act, predecessor first; a weld of a section acts on the beam itself.
pub(crate) fn bearers(model: &Model, joint: &Joint) -> [BodyId; 2] {
    let [predecessor, successor] =
        [joint.predecessor, joint.successor].map(|anchor| bearer(model, anchor));
    let is_own = predecessor == joint.successor.body;
    [if is_own { joint.predecessor.body } else { predecessor }, successor]
}

/// True where a model has bodies that bend.
pub(crate) fn are_there(model: &Model) -> bool {
    model.bodies.iter().any(|body| body.flexible.is_some())
}

/// The joints that stand for shapes of a body.
pub(crate) fn shapes(model: &Model, body: BodyId) -> Vec<JointId> {
    model.bodies[body.0].flexible.iter().flat_map(Flexible::shapes).collect()
}
