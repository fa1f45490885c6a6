//! `lifts` of a joint on a curve: in place of the force along the normal, which holds, a contact presses to one side.

use super::codes;
use super::play::{Form, LIFTS, Play};
use super::reader::{Fields, Reader};
use super::tree::Value;
use crate::body::Anchor;
use crate::diagnostic::Diagnostic;
use crate::joint::Joint;

/// The sides of a curve as its parameter rises, and whether each is the left.
const SIDES: [(&str, bool); 2] = [("left", true), ("right", false)];

impl Reader<'_> {
    /// The contact of a joint that lifts off a curve; `None` of one that does not, where its keys are refused.
    pub(super) fn lifting(
        &mut self,
        name: &str,
        fields: &Fields<'_>,
        ends: [Anchor; 2],
    ) -> Option<Play> {
        let id = self.names.joint(name)?;
        let (restitution, friction) = self.surfaces_of_joint(fields)?;
        let (form, span) = (Form::Curve(id), fields.entry(LIFTS)?.key_span.clone());
        Some(Play { name: name.to_owned(), ends, form, restitution, friction, span })
    }

    /// The side to which a joint lifts off its curve, true if it is the left; `Some(None)` of one that holds.
    #[expect(clippy::option_option, reason = "at fault, not lifting, or to which side")]
    pub(super) fn lifts(&mut self, fields: &Fields<'_>) -> Option<Option<bool>> {
        let lifts = match fields.get(LIFTS) {
            Some(node) => self.flag(node, &fields.what(LIFTS))?,
            None => false,
        };
        if lifts {
            if fields.conflict(self, LIFTS, "rolling") {
                return None;
            }
            let help = "write `side = \"left\"` or `\"right\"` of the curve as its parameter rises, to which it lifts off: \
                        of a curve that goes around counter-clockwise, the right is outside";
            let side = fields.require(self, "side", help)?;
            return self.choice(side, &fields.what("side"), &SIDES).map(Some);
        }
        let has_radius = fields.has("radius");
        let unused = ["side", "mu", "static", "restitution"];
        for key in unused.into_iter().filter(|&key| key != "side" || !has_radius) {
            let Some(entry) = fields.entry(key) else { continue };
            let message = format!("{} has `{key}` and does not lift off its curve", fields.owner);
            let help = match key {
                "mu" | "static" => "write `lifts = true`, or a load of type \"friction\" for it",
                _ => "remove it, or write `lifts = true`",
            };
            self.report(
                Diagnostic::error(codes::NO_LIFT, message)
                    .at(entry.key_span.clone(), "goes with `lifts = true`")
                    .help(help),
            );
            return None;
        }
        Some(None)
    }

    /// Refuses a load of friction in a joint that lifts off its curve: the contact rubs, and has its own.
    pub(super) fn check_lifting(
        &mut self,
        fields: &Fields<'_>,
        joints: &[Option<Joint>],
    ) -> Option<()> {
        let Some(node) = fields.get("joint") else { return Some(()) };
        let Value::Text(name) = &node.value else { return Some(()) };
        let joint = joints.iter().flatten().find(|joint| joint.name == *name);
        if joint.is_none_or(|joint| joint.kind.lifts().is_none()) {
            return Some(());
        }
        let message = format!("{} is friction of joint `{name}`, which lifts off", fields.owner);
        self.report(
            Diagnostic::error(codes::NO_LIFT, message)
                .at(node.span.clone(), "a contact, which presses to one side")
                .help(format!("remove this load, and write `mu` in `[joints.{name}]`")),
        );
        None
    }
}
