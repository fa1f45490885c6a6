//! Springs, dampers, cylinders, ropes and massless links.

use bksim_expr::Expr;
use bksim_model::{Anchor, JointId, Load, LoadKind, MotionKind};

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
            if let LoadKind::ForceBetween { a, b, .. } = load.kind {
                // A cylinder or spring there shows where it acts.
                if !self.are_spanned([a, b]) {
                    let length = self.first_distance([a, b]);
                    span(&load.name, [a, b], SpanKind::Cylinder { length });
                }
                continue;
            }
            let (ends, stiffness, length, damping) = match load.kind {
                LoadKind::Spring { a, b, stiffness, length, damping } => {
                    ([a, b], stiffness, length, damping)
                }
                LoadKind::JointSpring { joint, motion_idx, stiffness, unloaded, damping }
                    if self.slides(joint, motion_idx) =>
                {
                    let joint = &self.model().joints[joint.0];
                    ([joint.predecessor, joint.successor], stiffness, unloaded, damping)
                }
                _ => continue,
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
        let mut found = Between::Rope;
        for load in &model.loads {
            match load.kind {
                LoadKind::JointSpring { joint, .. } if joint == cylinder => return Between::Spring,
                LoadKind::Effort { joint, .. } | LoadKind::Friction { joint, .. }
                    if joint == cylinder =>
                {
                    found = Between::Piston;
                }
                // A rope cannot push.
                LoadKind::Stop { joint, min: Some(_), .. } if joint == cylinder => {
                    found = Between::Piston;
                }
                _ => (),
            }
        }
        let has_limit = model
            .loads
            .iter()
            .any(|load| matches!(load.kind, LoadKind::Stop { joint, .. } if joint == cylinder));
        let is_driven = model.drives.iter().any(|drive| drive.joint == cylinder);
        if is_driven || !has_limit { Between::Piston } else { found }
    }

    /// True where a joint or spring between two points is drawn already.
    fn are_spanned(&self, [a, b]: [Anchor; 2]) -> bool {
        let same = |from: Anchor, to: Anchor| [from, to] == [a, b] || [from, to] == [b, a];
        let model = self.model();
        let is_spring =
            |load: &Load| matches!(load.kind, LoadKind::Spring { a, b, .. } if same(a, b));
        model.joints.iter().any(|joint| same(joint.predecessor, joint.successor))
            || model.loads.iter().any(is_spring)
    }

    fn slides(&self, joint: JointId, motion_idx: usize) -> bool {
        let motions = self.model().joints[joint.0].kind.motions();
        motions[motion_idx] == MotionKind::Translation
    }

    /// Distance of two points at the start; 15 pin radii when the motion is not known.
    fn first_distance(&self, ends: [Anchor; 2]) -> f64 {
        let [a, b] = ends.map(|anchor| self.numbers.attached(anchor));
        let first = self.numbers.vectors(a, b).next().map(|[x, y, z]| x.hypot(y).hypot(z));
        first.unwrap_or(15.0 * self.pin)
    }
}
