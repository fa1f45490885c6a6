//! `[loads.…]` of type `spring`, `damper` and `torsion`: between two points, or in one motion of a joint.

use bksim_expr::Expr;

use super::codes;
use super::reader::{Fields, Reader};
use super::replay::Constant;
use super::units::Quantity;
use super::value::Scope;
use crate::diagnostic::Diagnostic;
use crate::joint::MotionKind;
use crate::load::LoadKind;

impl Reader<'_> {
    /// Springs, and dampers as springs without stiffness.
    pub(super) fn read_spring(&mut self, word: &str, fields: &Fields<'_>) -> Option<LoadKind> {
        if fields.conflict(self, "between", "joint") {
            return None;
        }
        let on_joint = fields.has("joint");
        let target = on_joint.then(|| self.motion_of_kind(fields, MotionKind::Translation));
        let ends = if on_joint { None } else { self.between(fields) };
        let zero = self.pool.zero();
        let (stiffness, length) = if word == "spring" {
            let help = "write for example `length = \"25 mm\"`";
            let length = fields.require(self, "length", help).and_then(|node| {
                let what = fields.what("length");
                let length = self.scalar(node, Quantity::LENGTH, &what, Scope::Motion)?;
                // The position of a joint may be below zero.
                if !on_joint {
                    self.check_free_length(&what, &length);
                }
                Some(length.expr)
            });
            (self.stiffness(fields, Quantity::STIFFNESS), length)
        } else {
            (Some(zero), Some(zero))
        };
        let damping = if word == "spring" && !fields.has("damping") {
            Some(zero)
        } else {
            self.damping(fields, Quantity::DAMPING)
        };
        if let Some(target) = target {
            let (joint, motion_idx) = target?;
            let (stiffness, unloaded, damping) = (stiffness?, length?, damping?);
            return Some(LoadKind::JointSpring { joint, motion_idx, stiffness, unloaded, damping });
        }
        let [a, b] = ends?;
        if a.body == b.body {
            let label = "both points are on one body: their distance never changes";
            self.without_effect(fields, "between", label, "name points of two bodies");
        }
        Some(LoadKind::Spring { a, b, stiffness: stiffness?, length: length?, damping: damping? })
    }

    /// Springs and dampers about an axis of a joint.
    pub(super) fn read_torsion(&mut self, fields: &Fields<'_>) -> Option<LoadKind> {
        let target = self.motion_of_kind(fields, MotionKind::Rotation);
        let is_damper = fields.has("damping") && !fields.has("stiffness");
        let stiffness = if is_damper {
            Some(self.pool.zero())
        } else {
            self.stiffness(fields, Quantity::TORSION)
        };
        let unloaded = self.load_or_zero(fields, "angle", Quantity::ANGLE);
        let damping = if fields.has("damping") {
            self.damping(fields, Quantity::TORSION_DAMPING)
        } else {
            Some(self.pool.zero())
        };
        let (joint, motion_idx) = target?;
        let (stiffness, unloaded, damping) = (stiffness?, unloaded?, damping?);
        Some(LoadKind::JointSpring { joint, motion_idx, stiffness, unloaded, damping })
    }

    /// Stiffness, which draws back unless it is negative.
    fn stiffness(&mut self, fields: &Fields<'_>, quantity: Quantity) -> Option<Expr> {
        let help = format!("write for example `stiffness = \"{}\"`", quantity.example);
        let node = fields.require(self, "stiffness", &help)?;
        let what = fields.what("stiffness");
        let stiffness = self.scalar(node, quantity, &what, Scope::Motion)?;
        self.check_stiffness(&what, &stiffness, quantity);
        Some(stiffness.expr)
    }

    /// Damping, which takes energy out unless it is negative.
    fn damping(&mut self, fields: &Fields<'_>, quantity: Quantity) -> Option<Expr> {
        let help = format!("write for example `damping = \"{}\"`", quantity.example);
        let node = fields.require(self, "damping", &help)?;
        let damping = self.scalar(node, quantity, &fields.what("damping"), Scope::Motion)?;
        if let Some(value) = damping.value.map(Constant::look).filter(|value| *value < 0.0) {
            let unit = quantity.dimension();
            let message = format!("`damping` of {} is {value} {unit}", fields.owner);
            self.report(
                Diagnostic::warning(codes::ADDS_ENERGY, message)
                    .at(damping.span, "a negative damping adds energy to the motion")
                    .help(format!("write \"{} {unit}\" if it should take energy out", -value)),
            );
        }
        Some(damping.expr)
    }
}
