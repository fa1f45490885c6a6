//! [`ReactionComponent`]: components of reactions by name.

use crate::ids::JointId;
use crate::model::Model;

/// A component of the reaction on the second body of a joint.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ReactionComponent {
    /// The joint.
    pub joint: JointId,
    /// The place in fx, fy, fz, mx, my, mz.
    pub component: usize,
    /// True along the axes of the joint's first point, else along those of the world.
    pub is_in_joint: bool,
}

impl ReactionComponent {
    /// The component of `reactions.A.fx` or `reactions.A.fx_joint`; none where the model has no such joint.
    pub fn named(model: &Model, name: &str) -> Option<Self> {
        let (joint, word) = name.strip_prefix("reactions.")?.rsplit_once('.')?;
        let joint = JointId(model.joints.iter().position(|of| of.name == joint)?);
        let is_in_joint = word.ends_with("_joint");
        let word = word.strip_suffix("_joint").unwrap_or(word);
        let component = ["fx", "fy", "fz", "mx", "my", "mz"].iter().position(|w| *w == word)?;
        Some(Self { joint, component, is_in_joint })
    }

    /// SI unit of the reaction component.
    pub fn unit(self) -> &'static str {
        if self.component < 3 { "N" } else { "N m" }
    }
}
