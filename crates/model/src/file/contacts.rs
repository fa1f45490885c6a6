//! `[loads.…]` of type `stop` and `friction`: what happens in one motion of a joint.

use super::codes;
use super::names::quantities;
use super::reader::{Fields, Reader};
use super::replay::Constant;
use super::units::Quantity;
use super::value::{Scalar, Scope};
use crate::diagnostic::Diagnostic;
use crate::ids::JointId;
use crate::joint::MotionKind;
use crate::load::LoadKind;
use crate::message::short;

impl Reader<'_> {
    /// Limits of a motion.
    pub(super) fn read_stop(&mut self, fields: &Fields<'_>) -> Option<LoadKind> {
        let help = "write `joint = \"A\"` with the name of the joint that is stopped";
        let target = self.motion_of(fields, help);
        let freedom = target.as_ref().and_then(|(joint, idx, _)| self.freedom(*joint, *idx));
        let quantity = freedom.map_or(Quantity::LENGTH, |freedom| quantities(freedom)[0]);
        let mut limit = |key| {
            // Without the joint nobody knows what its limits measure.
            let node = fields.get(key).filter(|_| freedom.is_some())?;
            self.scalar(node, quantity, &fields.what(key), Scope::Constant)
        };
        let [min, max] = [limit("min"), limit("max")];
        if !fields.has("min") && !fields.has("max") {
            let help = format!("write `min = \"{0}\"`, `max = \"{0}\"` or both", quantity.example);
            fields.require(self, "min", &help);
            return None;
        }
        self.check_room(fields, min.as_ref(), max.as_ref());
        let restitution = match fields.get("restitution") {
            None => self.pool.zero(),
            Some(node) => {
                let what = fields.what("restitution");
                let value = self.scalar(node, Quantity::NUMBER, &what, Scope::Constant)?;
                self.check_restitution(&what, &value);
                value.expr
            }
        };
        let (joint, motion_idx, _) = target?;
        // A limit that could not be read was reported.
        if fields.has("min") && min.is_none() || fields.has("max") && max.is_none() {
            return None;
        }
        let [min, max] = [min, max].map(|limit| limit.map(|scalar| scalar.expr));
        Some(LoadKind::Stop { joint, motion_idx, min, max, restitution })
    }

    /// Friction of a motion: `force` where it slides, `torque` where it turns.
    pub(super) fn read_friction(&mut self, fields: &Fields<'_>) -> Option<LoadKind> {
        let help = "write `joint = \"A\"` with the name of the joint that rubs";
        let target = self.motion_of(fields, help);
        let freedom = target.as_ref().and_then(|(joint, idx, _)| self.freedom(*joint, *idx));
        let turns = match freedom {
            Some(freedom) => freedom == MotionKind::Rotation,
            None => fields.has("torque"),
        };
        let (key, quantity) =
            if turns { ("torque", Quantity::TORQUE) } else { ("force", Quantity::FORCE) };
        if fields.conflict(self, "force", "torque") {
            return None;
        }
        let motion = if turns { "turns" } else { "slides" };
        let help =
            format!("the joint {motion}: write for example `{key} = \"{}\"`", quantity.example);
        let node = fields.require(self, key, &help);
        let (joint, motion_idx, _) = target?;
        let sliding = node.and_then(|node| self.friction(fields, key, node, quantity));
        let sticking = match fields.get("static") {
            Some(node) => self.friction(fields, "static", node, quantity),
            None => sliding.clone(),
        };
        let (sliding, sticking) = (sliding?, sticking?);
        self.check_static_friction(fields, [&sliding, &sticking], quantity);
        let (sliding, sticking) = (sliding.expr, sticking.expr);
        Some(LoadKind::Friction { joint, motion_idx, sliding, sticking })
    }

    fn friction(
        &mut self,
        fields: &Fields<'_>,
        key: &str,
        node: &super::tree::Node,
        quantity: Quantity,
    ) -> Option<Scalar> {
        let what = fields.what(key);
        let friction = self.scalar(node, quantity, &what, Scope::Motion)?;
        let zero = Constant::written(0.0);
        let below = |value: &Constant| !self.constants.is_not_below(*value, zero);
        if let Some(value) = friction.value.filter(below) {
            let value = value.look();
            let unit = quantity.dimension();
            self.report(
                Diagnostic::error(codes::NEGATIVE_FRICTION, format!("{what} is {value} {unit}"))
                    .at(friction.span.clone(), "must not be negative")
                    .help(format!("write \"{} {unit}\"", -value)),
            );
        }
        Some(friction)
    }

    fn freedom(&self, joint: JointId, motion_idx: usize) -> Option<MotionKind> {
        self.names.joints[joint.0].freedoms?.get(motion_idx).copied()
    }

    /// Between two limits there must be room.
    fn check_room(&mut self, fields: &Fields<'_>, min: Option<&Scalar>, max: Option<&Scalar>) {
        let (Some(min), Some(max)) = (min, max) else { return };
        let (Some(low), Some(high)) = (min.value, max.value) else { return };
        if self.constants.is_above(high, low) {
            return;
        }
        let (low, high) = (low.look(), high.look());
        let message = format!(
            "{} leaves no room: `min` is {}, `max` {}",
            fields.owner,
            short(low),
            short(high)
        );
        self.report(
            Diagnostic::error(codes::NO_ROOM, message)
                .at(max.span.clone(), "must be greater than `min`")
                .at(min.span.clone(), "the other limit")
                .help("exchange the two, or use a weld or `[drives]` to hold the joint"),
        );
    }

    fn check_restitution(&mut self, what: &str, restitution: &Scalar) {
        let Some(value) = restitution.value else { return };
        let [zero, one] = [0.0, 1.0].map(Constant::written);
        let is_good = self.constants.is_not_below(value, zero);
        if self.constants.is_not_below(one, value) && is_good {
            return;
        }
        let value = value.look();
        self.report(
            Diagnostic::error(codes::BAD_RESTITUTION, format!("{what} is {value}"))
                .at(restitution.span.clone(), "must lie between 0 and 1")
                .help("write 0 for bodies that stay together, 1 for an impact without loss"),
        );
    }
}
