//! Joints: bodies and points are always stated, so that nothing has to be found by geometry.

use bksim_model::diagnostic::Diagnostic;
use bksim_model::{Anchor, GROUND, JointId};
use toml_edit::Item;

use super::texts::{all, entries, text};
use super::units::dimension;
use super::{Sketch, Unwritten, Values, kind, no_place};
use crate::codes;
use crate::kind::{GROUND_LAYER, JOINT_LAYER, Placement};

impl Sketch<'_> {
    /// Draws all joints.
    pub(super) fn joints(&mut self) -> Result<(), Unwritten> {
        for idx in 0..self.model.joints.len() {
            self.joint(JointId(idx))?;
        }
        Ok(())
    }

    fn joint(&mut self, id: JointId) -> Result<(), Unwritten> {
        let joint = &self.model.joints[id.0];
        let owner = format!("joint `{}`", joint.name);
        if joint.kind.is_blade() {
            return Err(no_place("the type", &owner).into());
        }
        if self.model.contacts.iter().any(|contact| contact.play_of == Some(id)) {
            let key = if joint.kind.lifts().is_some() { "`lifts`" } else { "`clearance`" };
            return Err(no_place(key, &owner).into());
        }
        let kind = kind(joint.kind.word());
        // In a drawing the axis of a revolute comes out of the paper.
        let is_backward = self.positions.number(joint.axis[2]).is_some_and(|z| z < 0.0);
        if joint.kind.is_pin() && is_backward {
            return Err(Diagnostic::error(
                codes::UNDRAWABLE,
                format!("{owner} turns about −z, which has no place in a drawing"),
            )
            .at(joint.span.clone(), "this joint")
            .help("swap the two bodies of `between` and take the axis z")
            .into());
        }

        // Name, bodies and points, then the keys of the file that are not geometry.
        let mut values: Values = vec![("name", joint.name.clone())];
        values.extend(self.ends(joint.predecessor, joint.successor));
        let table = entries(self.document, "joints");
        let table = table.iter().find(|(known, _)| *known == joint.name);
        let stated = table.and_then(|(_, item)| item.as_table_like()).map(all);
        for (key, item) in stated.unwrap_or_default() {
            let known = kind.keys.iter().find(|known| **known == key);
            let unwritten = || no_place(&format!("`{key}`"), &owner);
            match (key, known) {
                // The drawn angle of the bodies is the fixed one.
                ("type" | "between", _) | ("axis" | "direction" | "angle", None) => (),
                (_, Some(&known)) => {
                    let words = item.as_value().map(text).ok_or_else(unwritten)?;
                    let dimension = dimension(kind.name, key, false);
                    values.push((known, self.units.complete(words, dimension)));
                }
                (_, None) => return Err(unwritten().into()),
            }
        }

        // Where it is, and the ground under a pivot.
        let ends = match kind.placement {
            Placement::Line => {
                [self.positions.anchor(joint.predecessor)?, self.positions.anchor(joint.successor)?]
            }
            _ => self.positions.joint(id)?,
        };
        if joint.predecessor.body == GROUND && joint.kind.points_coincide() {
            let [at, _] = ends;
            let upright = [at, [at[0] + 1.0, at[1]]];
            self.insert(super::kind("ground"), GROUND_LAYER, upright, Values::new())?;
        }
        self.insert(kind, JOINT_LAYER, ends, values)
    }

    /// Bodies and points of the two ends of something.
    pub(super) fn ends(&self, a: Anchor, b: Anchor) -> Values {
        let body = |anchor: Anchor| self.model.bodies[anchor.body.0].name.clone();
        vec![
            ("body1", body(a)),
            ("point1", self.positions.point_name(a)),
            ("body2", body(b)),
            ("point2", self.positions.point_name(b)),
        ]
    }

    /// True if the motion of a joint is a translation.
    pub(super) fn slides(&self, joint: JointId, of: Option<&str>) -> bool {
        let kind = self.model.joints[joint.0].kind;
        kind.slides(0) && (!kind.is_slot() || of == Some("position"))
    }

    /// The item of a table of a section.
    pub(super) fn item(&self, section: &str, name: &str) -> Option<&Item> {
        let all = entries(self.document, section);
        all.into_iter().find(|(known, _)| *known == name).map(|(_, item)| item)
    }
}
