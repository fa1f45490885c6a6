//! Springs, dampers, cylinders, ropes and massless links.

use bksim_expr::Expr;
use bksim_model::{Anchor, JointId, Load};

use super::Sketch;
use crate::{Span, SpanKind};

/// The sort of thing between the two points of a cylinder.
enum Between {
    /// A line that only pulls.
    Rope,
    /// A spring or damper, which has a symbol of its own.
    Spring,
    /// A piston in its cylinder.
    Piston,
}

impl Sketch<'_> {
    /// The springs, dampers and links between two bodies.
    pub(super) fn spans(&self) -> Vec<Span> {
        let mut spans = Vec::new();
        let mut span = |name: &str, ends: [Anchor; 2], kind| {
            let ends = ends.map(|anchor| self.numbers.attached(anchor));
            spans.push(Span { name: name.to_owned(), ends, kind });
        };
        for (joint_idx, joint) in self.model().joints.iter().enumerate() {
            let ends = [joint.predecessor, joint.successor];
            let between = match joint.kind.link_length() {
                // A rod that changes its length is one of two parts.
                Some(length) if self.changes(length) => Between::Piston,
                Some(_) => Between::Rope,
                None if joint.kind.is_cylinder() => self.between(JointId(joint_idx)),
                None => continue,
            };
            match between {
                Between::Spring => (),
                Between::Rope => span(&joint.name, ends, SpanKind::Link),
                Between::Piston => {
                    let length = self.first_distance(ends);
                    span(&joint.name, ends, SpanKind::Cylinder { length });
                }
            }
        }
        let pool = &self.model().pool;
        for load in &self.model().loads {
            let of_joint = load.kind.joint_motion().and_then(|(joint, motion_idx)| {
                let joint = &self.model().joints[joint.0];
                let ends = [joint.predecessor, joint.successor];
                joint.kind.slides(motion_idx).then_some(ends)
            });
            let Some(ends) = load.kind.ends().or(of_joint) else { continue };
            let Some([stiffness, length, damping]) = load.kind.spring() else {
                // A cylinder or spring there shows where it acts.
                if of_joint.is_none() && !self.are_spanned(ends) {
                    let length = self.first_distance(ends);
                    span(&load.name, ends, SpanKind::Cylinder { length });
                }
                continue;
            };
            let kind = if pool.is_zero(stiffness) {
                SpanKind::Damper { length: self.first_distance(ends) }
            } else {
                let length = self.numbers.value(length);
                SpanKind::Spring { length, is_damped: !pool.is_zero(damping) }
            };
            span(&load.name, ends, kind);
        }
        spans
    }

    fn changes(&self, length: Expr) -> bool {
        let model = self.model();
        model.pool.symbols_of(length).contains(&model.time)
    }

    /// The sort of thing that a cylinder is.
    fn between(&self, cylinder: JointId) -> Between {
        let model = self.model();
        let acts_in_it =
            |load: &Load| load.kind.joint_motion().is_some_and(|(joint, _)| joint == cylinder);
        let mut found = Between::Rope;
        for load in &model.loads {
            if !acts_in_it(load) {
                continue;
            }
            match load.kind.limits() {
                None if load.kind.spring().is_some() => return Between::Spring,
                // A rope cannot push.
                Some([None, _]) => (),
                _ => found = Between::Piston,
            }
        }
        let mut own = model.loads.iter().filter(|load| acts_in_it(load));
        let has_limit = own.any(|load| load.kind.limits().is_some());
        let is_driven = model.drives.iter().any(|drive| drive.joint == cylinder);
        if is_driven || !has_limit { Between::Piston } else { found }
    }

    /// True where a joint or spring between two points is drawn already.
    fn are_spanned(&self, [a, b]: [Anchor; 2]) -> bool {
        let same = |from: Anchor, to: Anchor| [from, to] == [a, b] || [from, to] == [b, a];
        let model = self.model();
        let is_spring = |load: &Load| {
            load.kind.spring().is_some() && load.kind.ends().is_some_and(|[a, b]| same(a, b))
        };
        model.joints.iter().any(|joint| same(joint.predecessor, joint.successor))
            || model.loads.iter().any(is_spring)
    }

    /// Distance of two points at the start; 15 pin radii when the motion is not known.
    fn first_distance(&self, ends: [Anchor; 2]) -> f64 {
        let [a, b] = ends.map(|anchor| self.numbers.attached(anchor));
        let first = self.numbers.vectors(a, b).next().map(|[x, y, z]| x.hypot(y).hypot(z));
        first.unwrap_or(15.0 * self.pin)
    }
}
