//! `[loads.…]` of type `stop`: limits of one motion of a joint.

use bksim_expr::Expr;

use super::codes;
use super::gather::sub_tables;
use super::names::quantities;
use super::reader::{Fields, Reader};
use super::replay::Constant;
use super::tree::{Node, Table};
use super::units::Quantity;
use super::value::{Scalar, Scope};
use crate::diagnostic::Diagnostic;
use crate::ids::JointId;
use crate::joint::MotionKind;
use crate::load::{Load, LoadKind};
use crate::message::short;

impl Reader<'_> {
    /// Limits of a motion.
    pub(super) fn read_stop(&mut self, fields: &Fields<'_>) -> Option<LoadKind> {
        let help = "write `joint = \"A\"` with the name of the joint that is stopped";
        let target = self.motion_of(fields, help).map(|(joint, idx, _)| (joint, idx));
        self.limits(fields, target)
    }

    /// The limits that joints between two points have among their own keys, as stops of the same names.
    pub(super) fn read_joint_limits(&mut self, root: &Table, loads: &mut Vec<Load>) {
        for (idx, (name, span, table)) in sub_tables(root, "joints").into_iter().enumerate() {
            let joint = JointId(idx);
            let is_cylinder = self.names.joints[idx].kind == Some("cylinder");
            let Some(table) = table.filter(|_| is_cylinder) else { continue };
            // Other keys were judged with the joint.
            let keys: Vec<&str> = table.entries.iter().map(|entry| entry.key.as_str()).collect();
            let fields = Fields::open(self, table, format!("joint `{name}`"), span.clone(), &keys);
            if !fields.has("min") && !fields.has("max") {
                continue;
            }
            let Some(kind) = self.limits(&fields, Some((joint, 0))) else { continue };
            let mut name = name.to_owned();
            while loads.iter().any(|load| load.name == name) {
                name.push('_');
            }
            loads.push(Load { name, kind, span });
        }
    }

    /// The limits of a motion, which `fields` state.
    fn limits(
        &mut self,
        fields: &Fields<'_>,
        target: Option<(JointId, usize)>,
    ) -> Option<LoadKind> {
        let freedom = target.as_ref().and_then(|(joint, idx)| self.freedom(*joint, *idx));
        let quantity = freedom.map_or(Quantity::LENGTH, |freedom| quantities(freedom)[0]);
        let mut limit = |key| {
            // Without the joint nobody knows what its limits measure.
            let node = fields.get(key).filter(|_| freedom.is_some())?;
            self.scalar(node, quantity, &fields.what(key), Scope::Position)
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
            Some(node) => self.restitution(node, &fields.what("restitution"))?,
        };
        let (joint, motion_idx) = target?;
        // A limit that could not be read was reported.
        if fields.has("min") && min.is_none() || fields.has("max") && max.is_none() {
            return None;
        }
        let [min, max] = [min, max].map(|limit| limit.map(|scalar| scalar.expr));
        Some(LoadKind::Stop { joint, motion_idx, min, max, restitution })
    }

    /// Speed after an impact over the speed before.
    pub(super) fn restitution(&mut self, node: &Node, what: &str) -> Option<Expr> {
        let value = self.scalar(node, Quantity::NUMBER, what, Scope::Constant)?;
        self.check_restitution(what, &value);
        Some(value.expr)
    }

    pub(super) fn freedom(&self, joint: JointId, motion_idx: usize) -> Option<MotionKind> {
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
